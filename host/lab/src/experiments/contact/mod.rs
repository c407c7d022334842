//! The force of a sphere on a surface beside quadratic finite elements.
//!
//! Round slabs of nodal shapes with three lengths of edges; spheres from half an edge to several
//! edges in radius; over nodes, edges and triangles.
//!
//! - `moving`: the force of a tool that moves, at few sweeps a tick beside many.

mod engine;
mod moving;
mod slab;
#[cfg(test)]
mod tests;
mod write;

use chaincell_host::error::Result;

use crate::reference::indentation::{self, Law, Press};
pub use engine::forces;
pub use moving::{Moving, MovingRow};
pub use slab::Slab;
pub use write::{bars, markdown};

/// Young's modulus of a liver \[Pa\], and its Poisson's ratio.
pub const YOUNG_PA: f64 = 5000.0;
/// Poisson's ratio.
pub const POISSON: f64 = 0.45;
/// Radius of the slab \[m\].
pub const RADIUS_M: f64 = 0.05;
/// Height of the slab \[m\].
pub const HEIGHT_M: f64 = 0.04;
/// Lengths of the surface's edges, about \[m\].
pub const EDGES_M: [f64; 3] = [0.008, 0.005, 0.0035];
/// Radii of the spheres \[m\].
pub const SPHERES_M: [f64; 7] = [0.002, 0.003, 0.004, 0.006, 0.008, 0.012, 0.016];
/// Depths \[radii\].
pub const DEPTHS: [f64; 4] = [0.1, 0.25, 0.4, 0.5];
/// Elements of the reference \[m\]; smaller under a sphere of less than `ELEMENTS` of them.
pub const ELEMENT_M: f64 = 0.00125;
/// Elements in a radius, at least.
const ELEMENTS: f64 = 8.0;
/// Seed of the meshes.
pub const SEED: u64 = 1;

/// Finite elements under a sphere at each of [`DEPTHS`].
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Radius of the sphere \[m\].
    pub sphere_m: f64,
    /// Neo-Hookean, the judge.
    pub press: Vec<Press>,
    /// With elements of [`ELEMENT_M`] under every sphere.
    pub coarse: Vec<Press>,
    /// With elements half as long as those of the judge.
    pub fine: Vec<Press>,
    /// By the law of small strain.
    pub linear: Vec<Press>,
    /// By the law of nodal shapes.
    pub nodal: Vec<Press>,
}

impl Reference {
    /// Cost: some seconds.
    ///
    /// # Errors
    /// As [`indentation::press`].
    pub fn new(sphere_m: f64) -> Result<Self> {
        let element_m = ELEMENT_M.min(sphere_m / ELEMENTS);
        let of = |law, element_m| {
            let depths = DEPTHS.map(|depth| depth * sphere_m);
            indentation::press(&slab(law), sphere_m, element_m, &depths)
        };
        Ok(Self {
            sphere_m,
            press: of(Law::NeoHooke, element_m)?,
            coarse: of(Law::NeoHooke, ELEMENT_M)?,
            fine: of(Law::NeoHooke, 0.5 * element_m)?,
            linear: of(Law::Hooke, element_m)?,
            nodal: of(Law::Nodal, element_m)?,
        })
    }
}

/// The slab of the reference.
fn slab(law: Law) -> indentation::Slab {
    let (radius_m, height_m) = (RADIUS_M, HEIGHT_M);
    indentation::Slab { radius_m, height_m, young_pa: YOUNG_PA, poisson: POISSON, law }
}

/// The engine's force over the reference's, under a sphere on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Radius of the sphere \[m\].
    pub sphere_m: f64,
    /// Mean edge of the top \[m\].
    pub edge_m: f64,
    /// At each of [`DEPTHS`] the ratios at the slab's places.
    pub ratios: Vec<Vec<f64>>,
}

impl Row {
    /// Presses a sphere into a body at each of its places.
    ///
    /// # Errors
    /// As [`forces`].
    pub fn new(slab: &Slab, reference: &Reference) -> Result<Self> {
        let sphere_m = reference.sphere_m;
        let depths = DEPTHS.map(|depth| depth * sphere_m);
        let found: Vec<Vec<f64>> = (slab.places_m.iter())
            .map(|&place| forces(slab, sphere_m, place, &depths))
            .collect::<Result<_>>()?;
        let at = |(depth, press): (usize, &Press)| {
            found.iter().map(|forces| forces[depth] / press.force_n).collect()
        };
        let ratios = reference.press.iter().enumerate().map(at).collect();
        Ok(Self { sphere_m, edge_m: slab.edge_m, ratios })
    }

    /// Radius over edge.
    #[must_use]
    pub fn edges(&self) -> f64 {
        self.sphere_m / self.edge_m
    }
}
