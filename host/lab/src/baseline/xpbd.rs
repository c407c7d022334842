//! Position-based dynamics with compliance (M. Macklin, M. Müller, N. Chentanez, XPBD, 2016), in
//! its usual link order: every link at once moves both ends, one iteration a small step of 1 ms
//! (Macklin et al., Small steps in physics simulation, 2019), compliance 1 / k.
//!
//! Velocities lose a tenth a step, a common choice; tuned to a scene it may settle sooner.

use chaincell_kernel::Model;

use super::{Baseline, Springs, difference, dot, excess, plus, rest};

/// Step \[s\].
const STEP_S: f32 = 1e-3;
/// What a step leaves of a velocity.
const KEPT: f32 = 0.9;

/// Positions with their velocities.
pub struct Xpbd {
    springs: Springs,
    /// 1 / (k dt^2) of every link [1/kg].
    compliance: Vec<f32>,
    position: Vec<[f32; 3]>,
    last: Vec<[f32; 3]>,
}

impl Baseline for Xpbd {
    const NAME: &'static str = "position-based dynamics (XPBD)";

    fn new(model: &Model<'_>) -> Self {
        let springs = Springs::of_model(model);
        let compliance = springs.stiffness_n_per_m.iter().map(|k| 1.0 / (k * STEP_S * STEP_S));
        Self { compliance: compliance.collect(), position: rest(model), last: rest(model), springs }
    }

    fn hold(&mut self, cell: usize, position: [f32; 3]) {
        self.position[cell] = position;
        self.last[cell] = position;
        self.springs.inverse_mass_per_kg[cell] = 0.0;
    }

    fn step(&mut self) {
        for (p, last) in self.position.iter_mut().zip(&mut self.last) {
            let predicted = std::array::from_fn(|axis| p[axis] + KEPT * (p[axis] - last[axis]));
            *last = *p;
            *p = predicted;
        }
        let inverse_mass = &self.springs.inverse_mass_per_kg;
        let links = self.springs.ends.iter().zip(&self.springs.band).zip(&self.compliance);
        for ((ends, &band), compliance) in links {
            let [i, j] = ends.map(|end| end as usize);
            let way = difference(self.position[i], self.position[j]);
            let length = dot(way, way).sqrt();
            let outside = excess(length, band);
            let (wi, wj) = (inverse_mass[i], inverse_mass[j]);
            if outside == 0.0 || length == 0.0 || wi + wj == 0.0 {
                continue;
            }
            let correction = outside / ((wi + wj + compliance) * length);
            self.position[i] = plus(self.position[i], wi * correction, way);
            self.position[j] = plus(self.position[j], -wj * correction, way);
        }
    }

    fn positions(&self) -> &[[f32; 3]] {
        &self.position
    }
}
