//! What others run, on the same links: single precision, one thread, plain loops; and, in double
//! precision, traditional `ChainMail`.
//!
//! They are measured with the kernel by `chaincell paper` and by the benches and serve nothing else.

pub(crate) mod chainmail;
mod mass_spring;
mod xpbd;

pub use mass_spring::MassSpring;
pub use xpbd::Xpbd;

use crate::reference::Links;
use chaincell_kernel::Model;

/// Density that the masses of the dynamic baselines stand for: that of water [kg/m3].
pub const DENSITY_KG_PER_M3: f32 = 1000.0;

/// A method that moves the cells of a body, some of them held.
pub trait Baseline {
    /// Name in tables.
    const NAME: &'static str;

    /// A body at rest.
    fn new(model: &Model<'_>) -> Self;

    /// Puts a cell at a position, where it stays until it is put elsewhere
    /// \[mean link lengths from the centre\].
    fn hold(&mut self, cell: usize, position: [f32; 3]);

    /// One step: one pass over the links.
    fn step(&mut self);

    /// Positions \[mean link lengths from the centre\].
    fn positions(&self) -> &[[f32; 3]];
}

/// Ends, rest lengths, stiffness and inverse masses as position-based and mass-spring codes keep
/// them.
struct Springs {
    ends: Vec<[u32; 2]>,
    /// Shortest and longest length at which the link exerts no force \[mean link lengths\].
    band: Vec<[f32; 2]>,
    stiffness_n_per_m: Vec<f32>,
    /// 0 for fixed and held cells [1/kg].
    inverse_mass_per_kg: Vec<f32>,
}

impl Springs {
    /// A cell weighs what a cube of the mean link length does at [`DENSITY_KG_PER_M3`].
    fn of_model(model: &Model<'_>) -> Self {
        let links = 0..model.links();
        let cells = 0..model.cells();
        let band = links.clone().map(|link| {
            let (l0, alpha) = (model.rest_lengths()[link], model.link_alpha(link));
            [(1.0 - alpha) * l0, (1.0 + alpha) * l0]
        });
        let inverse = 1.0 / (DENSITY_KG_PER_M3 * model.unit_m().powi(3));
        let stiffness = links.map(|link| model.stiffness_n_per_m() * model.link_weight(link));
        Self {
            ends: Links::of_model(model).ends().to_vec(),
            band: band.collect(),
            stiffness_n_per_m: stiffness.collect(),
            inverse_mass_per_kg: cells
                .map(|cell| if model.is_fixed(cell as u16) { 0.0 } else { inverse })
                .collect(),
        }
    }
}

/// Rest positions of all cells.
fn rest(model: &Model<'_>) -> Vec<[f32; 3]> {
    (0..model.cells()).map(|cell| model.rest_position(cell)).collect()
}

fn difference(from: [f32; 3], to: [f32; 3]) -> [f32; 3] {
    [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
}

/// `a + factor b`.
fn plus(a: [f32; 3], factor: f32, b: [f32; 3]) -> [f32; 3] {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// How far a length is outside a band, negative where it is too short.
fn excess(length: f32, [low, high]: [f32; 2]) -> f32 {
    if length > high {
        length - high
    } else if length < low {
        length - low
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::minimum;
    use chaincell_host::bake::{BakeOptions, bake};
    use chaincell_host::mesh::{MeshOptions, load};

    /// A small box whose top corner is displaced by half a link: every method must find the
    /// minimum of the same energy.
    fn settles<B: Baseline>(steps: usize, tolerance: f64) {
        let mesh = load("box:4x4x4x0.004", &MeshOptions::default()).unwrap();
        let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let links = Links::of_model(&model);
        let corner = model.input_id().iter().position(|&id| id == 63).unwrap();
        let mut body = B::new(&model);
        let mut to = model.rest_position(corner);
        let still: Vec<[f32; 3]> = body.positions().to_vec();
        body.step();
        assert_eq!(body.positions(), still, "{}: rest is rest", B::NAME);
        to[2] += 0.5;
        body.hold(corner, to);
        for _ in 0..steps {
            body.step();
        }
        let exact = minimum(&links, &[(corner, to.map(f64::from))], links.rest(), 1e-10);
        assert!(exact.residual_max <= 1e-10 && exact.energy > 1e-3);
        let found = body.positions().iter().map(|p| p.map(f64::from)).collect::<Vec<_>>();
        let farthest = (found.iter().zip(&exact.positions))
            .flat_map(|(a, b)| (0..3).map(move |axis| (a[axis] - b[axis]).abs()))
            .fold(0.0, f64::max);
        assert!(farthest < tolerance, "{}: {farthest}", B::NAME);
        let moved = (found.iter().zip(links.rest()).zip(links.fixed()))
            .any(|((p, rest), fixed)| *fixed && p != rest);
        assert!(!moved, "{}: a fixed cell moved", B::NAME);
        assert_eq!(body.positions()[corner], to, "{}: the held cell moved", B::NAME);
    }

    #[test]
    fn mass_spring_settles() {
        settles::<MassSpring>(2000, 1e-4);
    }

    /// One iteration a step settles a little off the minimum: the links move a cell one after
    /// the other, so their corrections do not belong to one state.
    #[test]
    fn position_based_dynamics_settles_nearby() {
        settles::<Xpbd>(4000, 2e-2);
    }
}
