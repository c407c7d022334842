//! The bodies on which the methods are compared: lattices, so that every method runs on them.

use chaincell_kernel::Model;

use crate::reference::vectors::{norm, plus};
use crate::reference::{Links, Minimum, minimum};
use chaincell_host::bake::{BakeOptions, ImageBytes, bake};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{Mesh, MeshOptions, load};

/// Ticks in which the contact cell is brought to its place.
pub const PRESS_TICKS: usize = 30;
/// Ticks in which it is held there.
pub const HOLD_TICKS: usize = 100;
/// Stiffness of a link [N/m].
pub const STIFFNESS_N_PER_M: f64 = 20.0;
/// Residual of the exact minimum \[spacings\].
const RESIDUAL: f64 = 1e-10;
/// Stages in which the exact minimum follows the press, so that it stays in the same valley.
const STAGES: usize = 10;

/// A body with the node that is moved. Links pull at any change of length (alpha 0).
pub struct Body {
    /// Its name in `paper.json`.
    pub name: &'static str,
    /// What it is and what is done to it.
    pub source: &'static str,
    /// Nodes and links, in input order.
    pub mesh: Mesh,
    /// Nodes along the axes.
    pub nodes: [usize; 3],
    /// Input id of the node that is moved.
    pub contact: usize,
    /// Where it is moved to from rest \[m\].
    pub travel_m: [f64; 3],
    /// Slack of the chains: the move then just reaches the fixed nodes on the shortest way.
    pub alpha: f64,
    /// The links in input order \[m\].
    pub links: Links,
    image: ImageBytes,
}

impl Body {
    /// The paper's plane, 21 x 21 nodes 10 mm apart with 8 neighbours, its centre 30 mm up.
    ///
    /// # Errors
    /// As the bake.
    pub fn plane() -> Result<Self> {
        let mesh =
            load("plane:21x21x0.01", &MeshOptions { diagonals: true, ..MeshOptions::default() })?;
        let source = "plane of 21 x 21 nodes 10 mm apart, 8 neighbours, border fixed, centre \
                      moved by 30 mm across the plane";
        Self::new("plane", source, mesh, [21, 21, 1], 220, [0.0, 0.0, 0.03], 0.03 / 0.1)
    }

    /// A box of 11 x 11 x 6 nodes 10 mm apart, the middle of its top 5 mm down.
    ///
    /// # Errors
    /// As the bake.
    pub fn cuboid() -> Result<Self> {
        let mesh = load("box:11x11x6x0.01", &MeshOptions::default())?;
        let source = "box of 11 x 11 x 6 nodes 10 mm apart, links of its tetrahedra, bottom fixed, \
                      middle of the top moved by 5 mm inwards";
        let contact = (5 * 11 + 5) * 6 + 5;
        Self::new("box", source, mesh, [11, 11, 6], contact, [0.0, 0.0, -0.005], 0.005 / 0.05)
    }

    fn new(
        name: &'static str,
        source: &'static str,
        mesh: Mesh,
        nodes: [usize; 3],
        contact: usize,
        travel_m: [f64; 3],
        alpha: f64,
    ) -> Result<Self> {
        let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default())?;
        let links = Links::from_edges(&mesh.nodes_m, &mesh.links, 0.0, &mesh.default_fixed)?;
        Ok(Self { name, source, mesh, nodes, contact, travel_m, alpha, links, image })
    }

    /// The same body and move, turned about z.
    ///
    /// # Errors
    /// As the bake.
    pub fn turned(&self, degrees: f64) -> Result<Self> {
        let mut mesh = self.mesh.clone();
        mesh.nodes_m.iter_mut().for_each(|p| *p = turned(*p, degrees));
        let travel_m = turned(self.travel_m, degrees);
        let Self { name, source, nodes, contact, alpha, .. } = *self;
        Self::new(name, source, mesh, nodes, contact, travel_m, alpha)
    }

    /// The baked model.
    ///
    /// # Errors
    /// None for a body that was made here.
    pub fn model(&self) -> Result<Model<'_>> {
        Model::from_bytes(self.image.as_bytes()).map_err(Error::check)
    }

    /// How far the contact node has been moved after some ticks of a press of `ticks` \[m\].
    #[must_use]
    pub fn way_m(&self, after: usize, ticks: usize) -> [f64; 3] {
        let part = after as f64 / ticks as f64;
        self.travel_m.map(|x| part * x)
    }

    /// Length of the move \[m\].
    #[must_use]
    pub fn depth_m(&self) -> f64 {
        norm(self.travel_m)
    }

    /// Where the contact node stands when it has been moved by `way_m` \[m\].
    #[must_use]
    pub fn contact_m(&self, way_m: [f64; 3]) -> [f64; 3] {
        plus(self.mesh.nodes_m[self.contact], 1.0, way_m)
    }

    /// Force of the links on the contact node at given positions \[N\].
    #[must_use]
    pub fn force_n(&self, positions_m: &[[f64; 3]]) -> f64 {
        // The residual of a link is half its excess.
        2.0 * STIFFNESS_N_PER_M * norm(self.links.force(positions_m, &[self.contact]))
    }

    /// The minimum of the links' energy with the contact node in its place, followed from rest.
    ///
    /// # Errors
    /// A minimum that is not reached.
    pub fn minimum(&self) -> Result<Minimum> {
        let spacing_m = self.links.rest_lengths().iter().copied().fold(f64::INFINITY, f64::min);
        let tolerance = RESIDUAL * spacing_m;
        let mut at = self.links.rest().to_vec();
        let mut found = None;
        for stage in 1..=STAGES {
            let way_m = self.travel_m.map(|x| x * stage as f64 / STAGES as f64);
            let held = [(self.contact, self.contact_m(way_m))];
            let next = minimum(&self.links, &held, &at, tolerance);
            at.clone_from(&next.positions);
            found = Some(next);
        }
        found.filter(|found| found.residual_max <= tolerance).ok_or_else(|| {
            Error::check(format!("the {} has no exact minimum to compare with", self.name))
        })
    }
}

/// A vector turned about z.
#[must_use]
pub fn turned(p: [f64; 3], degrees: f64) -> [f64; 3] {
    let (sin, cos) = (libm::sin(degrees.to_radians()), libm::cos(degrees.to_radians()));
    [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1], p[2]]
}
