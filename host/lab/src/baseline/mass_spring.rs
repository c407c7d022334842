//! Explicit mass-spring dynamics: symplectic Euler at its largest stable step, 2 / omega with
//! omega the highest frequency of the links' Laplacian bound (power iteration), less 5 %.
//!
//! In that step masses and stiffness drop out; what is chosen is the damping: a velocity keeps
//! nine tenths a step.

use chaincell_kernel::Model;

use super::{Baseline, Springs, difference, dot, excess, plus, rest};

/// Fraction of the stability limit.
const MARGIN: f32 = 0.95;
/// What a step leaves of a velocity.
const KEPT: f32 = 0.9;
/// Rounds of the power iteration; the limit is then known to about a percent, from above the step.
const ROUNDS: usize = 100;

/// Positions with velocities.
pub struct MassSpring {
    springs: Springs,
    step_s: f32,
    position: Vec<[f32; 3]>,
    velocity: Vec<[f32; 3]>,
    force: Vec<[f32; 3]>,
}

impl Baseline for MassSpring {
    const NAME: &'static str = "explicit mass-spring";

    fn new(model: &Model<'_>) -> Self {
        let springs = Springs::of_model(model);
        let cells = model.cells();
        Self {
            step_s: MARGIN * 2.0 / highest_frequency(&springs, cells),
            springs,
            position: rest(model),
            velocity: vec![[0.0; 3]; cells],
            force: vec![[0.0; 3]; cells],
        }
    }

    fn hold(&mut self, cell: usize, position: [f32; 3]) {
        self.position[cell] = position;
        self.velocity[cell] = [0.0; 3];
        self.springs.inverse_mass_per_kg[cell] = 0.0;
    }

    fn step(&mut self) {
        self.force.fill([0.0; 3]);
        let springs = &self.springs;
        let links = springs.ends.iter().zip(&springs.band).zip(&springs.stiffness_n_per_m);
        for ((ends, &band), stiffness) in links {
            let [i, j] = ends.map(|end| end as usize);
            let way = difference(self.position[i], self.position[j]);
            let length = dot(way, way).sqrt();
            let outside = excess(length, band);
            if outside == 0.0 || length == 0.0 {
                continue;
            }
            let force = stiffness * outside / length;
            self.force[i] = plus(self.force[i], force, way);
            self.force[j] = plus(self.force[j], -force, way);
        }
        let h = self.step_s;
        let cells = self.position.iter_mut().zip(&mut self.velocity);
        for (((p, v), f), w) in cells.zip(&self.force).zip(&springs.inverse_mass_per_kg) {
            *v = plus(v.map(|v| KEPT * v), h * w, *f);
            *p = plus(*p, h, *v);
        }
    }

    fn positions(&self) -> &[[f32; 3]] {
        &self.position
    }
}

/// Highest frequency of the links' Laplacian over the masses [1/s].
fn highest_frequency(springs: &Springs, cells: usize) -> f32 {
    // Neighbours of unlike sign are what the highest mode looks like.
    let mut v: Vec<f32> = (0..cells).map(|cell| (cell as f32 * 2.4).sin()).collect();
    let mut largest = 0.0;
    for _ in 0..ROUNDS {
        let mut next = vec![0.0; cells];
        for (ends, stiffness) in springs.ends.iter().zip(&springs.stiffness_n_per_m) {
            let [i, j] = ends.map(|end| end as usize);
            next[i] += stiffness * (v[i] - v[j]);
            next[j] -= stiffness * (v[i] - v[j]);
        }
        for (next, w) in next.iter_mut().zip(&springs.inverse_mass_per_kg) {
            *next *= w;
        }
        let norm = next.iter().map(|x| x * x).sum::<f32>().sqrt();
        largest = norm;
        v = next.into_iter().map(|x| x / norm).collect();
    }
    largest.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of equal masses with free ends: the highest frequency tends to 2 sqrt(k / m).
    #[test]
    fn the_highest_frequency_of_a_row() {
        let cells = 40;
        let springs = Springs {
            ends: (0..cells - 1).map(|i| [i, i + 1]).collect(),
            band: vec![[1.0; 2]; 39],
            stiffness_n_per_m: vec![20.0; 39],
            inverse_mass_per_kg: vec![0.5; 40],
        };
        let found = highest_frequency(&springs, 40);
        let exact = 2.0 * 10.0_f32.sqrt();
        assert!(found < exact && found > 0.98 * exact, "{found} {exact}");
    }
}
