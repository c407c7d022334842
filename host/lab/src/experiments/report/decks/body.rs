//! The decks' bodies: regular grids of tetrahedra, with loads and supports.

use crate::reference::nodal::volume_m3;
use crate::reference::vectors::{dot, minus};
use crate::reference::{Elastic, Links, Loaded, Minimum, Nodal, Tetrahedra, minimum};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{Mesh, MeshOptions, load};

use super::law::Moduli;

/// Residual at which a search ends, as a share of a force of the body's own size.
const TOLERANCE: f64 = 1e-9;
/// The largest share that counts as rest where a search ended early.
const ACCEPTED: f64 = 1e-5;

/// A grid of cubes, bent to a deck's form.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Nodes, tetrahedra and surface; z runs along the body from 0.
    pub mesh: Mesh,
    /// Length along z \[m\].
    pub length_m: f64,
    /// Mean edge \[m\].
    pub edge_m: f64,
}

/// Loads and supports of a body's nodes.
#[derive(Debug, Clone)]
pub struct Load {
    /// Force on each node \[N\].
    pub force_n: Vec<[f64; 3]>,
    /// Coordinates that are kept.
    pub kept: Vec<[bool; 3]>,
}

/// The elements of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Elements {
    /// Nodal shapes with their band.
    Shapes,
    /// Links of stiffness E V / l^2, V the volume of the tetrahedra around one; Poisson's ratio 1/4.
    Links,
    /// Linear tetrahedra of Hooke's material: SOFA's element at small displacements, by our own code.
    Tetrahedra,
}

/// Positions at rest in a load, and the forces of the supports.
#[derive(Debug, Clone)]
pub struct Rest {
    /// Positions \[m\].
    pub at_m: Vec<[f64; 3]>,
    /// Force of the body on each node \[N\].
    pub body_n: Vec<[f64; 3]>,
}

impl Grid {
    /// A block of `nodes` along x, y and z, the centre of its lower end in the origin.
    pub fn block(nodes: [usize; 3], size_m: [f64; 3]) -> Result<Self> {
        Self::bent(nodes, size_m[2], |[x, y, z]| {
            [0.5 * size_m[0] * x, 0.5 * size_m[1] * y, size_m[2] * z]
        })
    }

    /// A cylinder around the z axis, of the square grid moved to the circle.
    pub fn cylinder(nodes: [usize; 3], radius_m: f64, height_m: f64) -> Result<Self> {
        Self::bent(nodes, height_m, |[x, y, z]| {
            let (square, round) = (x.abs().max(y.abs()), x.hypot(y));
            let scale = if round > 0.0 { radius_m * square / round } else { 0.0 };
            [scale * x, scale * y, height_m * z]
        })
    }

    /// A grid whose nodes, at -1 to 1 in x and y and at 0 to 1 in z, are moved.
    fn bent(
        nodes: [usize; 3],
        length_m: f64,
        place_m: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<Self> {
        let [nx, ny, nz] = nodes;
        let mut mesh = load(&format!("box:{nx}x{ny}x{nz}x1"), &MeshOptions::default())?;
        let half = [nx, ny].map(|count| 0.5 * (count - 1) as f64);
        for x in &mut mesh.nodes_m {
            *x = place_m([x[0] / half[0], x[1] / half[1], x[2] / (nz - 1) as f64]);
        }
        let lengths = mesh.links.iter().map(|&link| edge_m(&mesh.nodes_m, link));
        let edge_m = lengths.sum::<f64>() / mesh.links.len() as f64;
        Ok(Self { mesh, length_m, edge_m })
    }

    /// Nodes at a height \[m\].
    pub fn at_height(&self, z_m: f64) -> Vec<usize> {
        let near = |x: &[f64; 3]| (x[2] - z_m).abs() < 1e-9 * self.length_m;
        (0..).zip(&self.mesh.nodes_m).filter(|(_, x)| near(x)).map(|(node, _)| node).collect()
    }

    /// No load; x and y kept in the planes of symmetry, z at the lower end and, `both`, at the upper one.
    pub fn guided(&self, both: bool) -> Load {
        let tiny_m = 1e-9 * self.length_m;
        let end = |z_m: f64| z_m < tiny_m || both && z_m > self.length_m - tiny_m;
        let kept = |x: &[f64; 3]| [x[0].abs() < tiny_m, x[1].abs() < tiny_m, end(x[2])];
        let force_n = vec![[0.0; 3]; self.mesh.nodes_m.len()];
        Load { force_n, kept: self.mesh.nodes_m.iter().map(kept).collect() }
    }

    /// The lower end held in all axes, and a weight by volume \[N/m^3\].
    pub fn clamped(&self, weight_n_per_m3: [f64; 3]) -> Load {
        let mut force_n = vec![[0.0; 3]; self.mesh.nodes_m.len()];
        for &nodes in &self.mesh.tetrahedra {
            let quarter_m3 = 0.25 * volume_m3(&self.mesh.nodes_m, nodes);
            for node in nodes {
                let force_n = &mut force_n[node as usize];
                *force_n =
                    std::array::from_fn(|axis| force_n[axis] + quarter_m3 * weight_n_per_m3[axis]);
            }
        }
        let held = |x: &[f64; 3]| [x[2] < 1e-9 * self.length_m; 3];
        Load { force_n, kept: self.mesh.nodes_m.iter().map(held).collect() }
    }

    /// Area of the upper end \[m^2\], and its share at each node.
    fn upper_m2(&self) -> Vec<(usize, f64)> {
        let near = |node: u32| {
            (self.mesh.nodes_m[node as usize][2] - self.length_m).abs() < 1e-9 * self.length_m
        };
        let faces = self.mesh.triangles.iter().filter(|face| face.iter().all(|&node| near(node)));
        faces
            .flat_map(|face| {
                let [a, b, c] = face.map(|node| self.mesh.nodes_m[node as usize]);
                let (p, q) = (minus(b, a), minus(c, a));
                let third_m2 = (p[0] * q[1] - p[1] * q[0]).abs() / 6.0;
                face.map(|node| (node as usize, third_m2))
            })
            .collect()
    }

    /// Area of the upper end \[m^2\].
    pub fn end_m2(&self) -> f64 {
        self.upper_m2().iter().map(|(_, area_m2)| area_m2).sum()
    }

    /// Adds a traction along z on the upper end, force by area at rest \[Pa\].
    pub fn draw(&self, load: &mut Load, stress_pa: f64) {
        for (node, area_m2) in self.upper_m2() {
            load.force_n[node][2] += stress_pa * area_m2;
        }
    }

    /// The body under a load, from a start whose kept coordinates stay.
    pub fn settle(
        &self,
        elements: Elements,
        of: Moduli,
        load: &Load,
        start_m: &[[f64; 3]],
    ) -> Result<Rest> {
        settle(&self.mesh, elements, of, load, start_m)
    }
}

/// A mesh's body under a load, from a start whose kept coordinates stay.
pub fn settle(
    mesh: &Mesh,
    elements: Elements,
    of: Moduli,
    load: &Load,
    start_m: &[[f64; 3]],
) -> Result<Rest> {
    match elements {
        Elements::Shapes => {
            let body = Nodal::new(&mesh.nodes_m, &mesh.tetrahedra, &[], of.law())?;
            rest(&body, load, start_m)
        }
        Elements::Links => rest(&links(mesh, of.young_pa)?, load, start_m),
        Elements::Tetrahedra => {
            let body = Tetrahedra::new(&mesh.nodes_m, &mesh.tetrahedra, of.young_pa, of.poisson)?;
            rest(&body, load, start_m)
        }
    }
}

fn rest<B: Elastic>(body: &B, load: &Load, start_m: &[[f64; 3]]) -> Result<Rest> {
    let loaded = Loaded { body, force: load.force_n.clone(), kept: load.kept.clone() };
    let unit_n = body.residual_unit();
    let Minimum { positions: at_m, residual_max, .. } =
        minimum(&loaded, &[], start_m, TOLERANCE * unit_n);
    if residual_max > ACCEPTED * unit_n {
        return Err(Error::check(format!("a deck did not come to rest: {residual_max:e} N")));
    }
    let mut body_n = vec![[0.0; 3]; at_m.len()];
    body.residual(&at_m, &mut body_n);
    Ok(Rest { at_m, body_n })
}

/// Links of stiffness E V / l^2. The energy of a link of weight w is w d^2 / 4.
fn links(mesh: &Mesh, young_pa: f64) -> Result<Links> {
    let mut weights = vec![0.0; mesh.links.len()];
    for nodes in &mesh.tetrahedra {
        let volume_m3 = volume_m3(&mesh.nodes_m, *nodes);
        for (a, &i) in nodes.iter().enumerate() {
            for &j in &nodes[a + 1..] {
                if let Ok(link) = mesh.links.binary_search(&[i.min(j), i.max(j)]) {
                    weights[link] += volume_m3;
                }
            }
        }
    }
    for (weight, &link) in weights.iter_mut().zip(&mesh.links) {
        *weight *= 2.0 * young_pa / edge_m(&mesh.nodes_m, link).powi(2);
    }
    Links::from_edges(&mesh.nodes_m, &mesh.links, 0.0, &[])?.with_weights(weights)
}

fn edge_m(nodes_m: &[[f64; 3]], [i, j]: [u32; 2]) -> f64 {
    let d = minus(nodes_m[j as usize], nodes_m[i as usize]);
    dot(d, d).sqrt()
}
