//! Bodies of the reference data with what finite elements say about their presses.

use std::collections::BTreeMap;
use std::path::Path;

use crate::reference::Npz;
use crate::reference::nodal::volume_m3;
use crate::reference::vectors::{dot, minus, unit};
use chaincell_host::error::{Error, Result};

/// Young's modulus of the data \[Pa\].
pub const YOUNG_PA: f64 = 5000.0;
/// Depth where the data give none: small strain, which scales \[m\].
const SMALL_M: f64 = 0.001;

/// The elastic law of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Data {
    /// Neo-Hookean, to 10 mm.
    Large,
    /// Linear elasticity, 1 mm.
    Small,
    /// The same, a node and its neighbours on the surface pressed instead of a patch.
    SmallRing,
}

impl Data {
    const fn file(self) -> &'static str {
        match self {
            Self::Large => "patch_nu{}_nh",
            Self::Small => "patch_nu{}_lin",
            Self::SmallRing => "ring_nu{}_lin",
        }
    }

    /// The elements in words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Large => "quadratic, neo-Hookean",
            Self::Small | Self::SmallRing => "quadratic, linear elasticity",
        }
    }
}

/// A body of the comparison.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Name of its mesh.
    pub mesh: &'static str,
    /// Poisson's ratio in percent.
    pub poisson_percent: u8,
    /// What it is compared with.
    pub data: Data,
}

impl Case {
    /// Poisson's ratio.
    #[must_use]
    pub fn poisson(self) -> f64 {
        f64::from(self.poisson_percent) / 100.0
    }
}

/// Finite elements at a depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Press {
    /// How far the held nodes are pressed \[m\].
    pub depth_m: f64,
    /// Displacement of every node \[m\].
    pub displacement_m: Vec<[f64; 3]>,
    /// Force that presses, along the press \[N\].
    pub force_n: f64,
}

/// A mesh with its presses.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Which one.
    pub case: Case,
    /// Nodes at rest \[m\].
    pub rest_m: Vec<[f64; 3]>,
    /// Tetrahedra of positive volume.
    pub tetrahedra: Vec<[u32; 4]>,
    /// Nodes held at rest.
    pub fixed: Vec<u32>,
    /// Nodes held at the depth of the press.
    pub pressed: Vec<usize>,
    /// Unit vector of the press.
    pub direction: [f64; 3],
    /// Quadratic elements on this mesh, by depth.
    pub quadratic: Vec<Press>,
    /// Linear elements, likewise; none where there are no data.
    pub linear: Vec<Press>,
}

impl Body {
    /// Reads a body.
    ///
    /// # Errors
    /// Reference data that cannot be read or do not fit together.
    pub fn read(reference: &Path, case: Case) -> Result<Self> {
        let path = reference.join(format!("meshes/{}.npz", case.mesh));
        let mut mesh = Npz::open(&path)?;
        let (rest_m, fixed) = (mesh.vectors("X")?, mesh.ids("fixed")?);
        let mut pressed = match case.data {
            Data::SmallRing => ring(&mesh.ids("node")?, &mesh.rows("F")?),
            _ => mesh.ids("patch")?,
        };
        pressed.retain(|node| !fixed.contains(node));
        let file = case.data.file().replace("{}", &case.poisson_percent.to_string());
        let elements = |order| reference.join(format!("fem/{}_{file}_{order}.npz", case.mesh));
        let quadratic = elements("P2");
        let direction = Npz::open(&quadratic)?.vectors("dirn")?.first().copied();
        let direction = unit(direction.ok_or_else(|| {
            Error::file("read", &quadratic, "array dirn: give the direction of the press")
        })?);
        let presses = |path: &Path| presses(path, case.data, rest_m.len(), direction);
        let linear = elements("P1");
        Ok(Self {
            case,
            tetrahedra: mesh.rows("T")?,
            fixed,
            pressed: pressed.into_iter().map(|node| node as usize).collect(),
            quadratic: presses(&quadratic)?,
            linear: if linear.is_file() { presses(&linear)? } else { Vec::new() },
            direction,
            rest_m,
        })
    }

    /// The stiffness of links that are all alike with the mean modulus of the data: the same sum of
    /// k l^2 as [`Self::links`].
    #[must_use]
    pub fn even_stiffness_n_per_m(&self) -> f64 {
        let (mut moduli, mut squares) = (0.0, 0.0);
        for ([i, j], per_young) in self.links() {
            let d = minus(self.rest_m[i as usize], self.rest_m[j as usize]);
            moduli += YOUNG_PA * per_young * dot(d, d);
            squares += dot(d, d);
        }
        moduli / squares
    }

    /// Links along the edges, each with the volume of the tetrahedra around it over its length
    /// squared \[m\]: E times that is its stiffness (van Gelder 1998).
    #[must_use]
    pub fn links(&self) -> BTreeMap<[u32; 2], f64> {
        let mut links = BTreeMap::new();
        for nodes in &self.tetrahedra {
            let volume = volume_m3(&self.rest_m, *nodes);
            for (a, &i) in nodes.iter().enumerate() {
                for &j in nodes.iter().skip(a + 1) {
                    let [i, j] = [i.min(j), i.max(j)];
                    let d = minus(self.rest_m[i as usize], self.rest_m[j as usize]);
                    *links.entry([i, j]).or_insert(0.0) += volume / dot(d, d);
                }
            }
        }
        links
    }

    /// Tetrahedra that are turned inside out.
    #[must_use]
    pub fn inverted(&self, positions_m: &[[f64; 3]]) -> usize {
        let volumes = self.tetrahedra.iter().map(|nodes| volume_m3(positions_m, *nodes));
        volumes.filter(|volume| *volume <= 0.0).count()
    }
}

/// A node and its neighbours on the surface.
fn ring(node: &[u32], surface: &[[u32; 3]]) -> Vec<u32> {
    let around = surface.iter().filter(|corners| corners.iter().any(|id| node.contains(id)));
    let mut ring: Vec<u32> = around.flatten().copied().collect();
    ring.sort_unstable();
    ring.dedup();
    ring
}

fn presses(path: &Path, data: Data, nodes: usize, direction: [f64; 3]) -> Result<Vec<Press>> {
    let mut file = Npz::open(path)?;
    let depths_m = match data {
        Data::SmallRing => vec![SMALL_M],
        _ => file.reals("d")?,
    };
    let (displacements, forces) = (file.vectors("u")?, file.vectors("R")?);
    if displacements.len() != nodes * depths_m.len() || forces.len() < depths_m.len() {
        let why = format!("array u: {nodes} nodes at each of {} depths", depths_m.len());
        return Err(Error::file("read", path, why));
    }
    let each = depths_m.into_iter().zip(displacements.chunks(nodes)).zip(forces);
    let press = |((depth_m, u), force): ((f64, &[[f64; 3]]), [f64; 3])| Press {
        depth_m,
        displacement_m: u.to_vec(),
        force_n: dot(force, direction),
    };
    Ok(each.map(press).collect())
}
