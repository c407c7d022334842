//! `rkl1`: relaxation in time of first order, the robust form: no stage overshoots.
//!
//! Deprecated: take [`rkl2`](super::Rkl2) for the trajectory and [`track`](super::Track) for its
//! end.
//!
//! As [`rkl2`](super::Rkl2), with the Legendre polynomials `P_s` themselves as stability
//! polynomials:
//!
//! ```text
//! Y_j = mu_j Y_j-1 + nu_j Y_j-2 + mu_j w h R_j-1 / C      mu_j = (2 j - 1) / j,  nu_j = (1 - j) / j
//!                                                         w = 2 / (s^2 + s)
//! ```
//!
//! which is the three-term recursion of `P_s`(1 - w h lambda). |`P_s`| <= 1 on [-1, 1], so it is
//! stable for h <= dt (s^2 + s) / 2, twice as far as second order in as many passes; and its
//! monotonicity makes it raise the energy of a state far from equilibrium far more rarely. What it
//! gives up is accuracy: on the paper's plane 1e-2 of the depth at t = 1, 10, 100 takes 13, 35, 100
//! passes with 8 neighbours, and 1e-3 far more. The guard and the lengths are those of
//! [`super_step`](super).
//!
//! Cost: one link pass and one pass over the cells a stage, two arrays besides state and residual.
//!
//! Source: C. D. Meyer, D. S. Balsara, T. D. Aslam, A stabilized Runge-Kutta-Legendre method for
//! explicit super-time-stepping of parabolic and mixed equations, J. Comput. Phys. 257, 2014.

use super::Dynamics;
use super::super_step::{Factors, Formula, SuperSteps};
use crate::model::Model;
use crate::number::cell::Cell;
use crate::number::two_float::Eight;

/// The formulas of first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct First;

/// The scheme `rkl1`.
pub type Rkl1 = SuperSteps<First>;

impl Dynamics for Rkl1 {
    const NAME: &'static str = "rkl1";
    const REST: Self = Self::REST;
    const ARRAYS: usize = 2;
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; 2];
    type Room = [Eight; 0];

    fn tick_time(model: &Model<'_>, sweeps: u16) -> f32 {
        Self::tick_time_max(model, sweeps)
    }
}

impl Formula for First {
    const STAGES_MIN: u16 = 3;
    const KEEPS_FIRST: bool = false;

    fn reach(stages: u16) -> f32 {
        let s = f32::from(stages);
        0.5 * (s * s + s)
    }

    fn factors(stage: u16, stages: u16) -> Factors {
        let j = f32::from(stage);
        let mu = (2.0 * j - 1.0) / j;
        Factors { mu, nu: (1.0 - j) / j, m: mu / Self::reach(stages), g: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stages_are_legendre_polynomials() {
        for stages in 2..40 {
            let reach = 2.0 * First::reach(stages);
            for at in 0..=100_u16 {
                let x = reach * f32::from(at) / 100.0;
                let (mut before, mut now) = (0.0, 0.0);
                for stage in 1..=stages {
                    let Factors { mu, nu, m, .. } = First::factors(stage, stages);
                    (before, now) = (now, mu * now + nu * before - x * m * (1.0 + now));
                }
                // P_s by its own recursion.
                let (z, mut last, mut legendre) =
                    (1.0 - 2.0 * x / reach, 1.0, 1.0 - 2.0 * x / reach);
                for j in 2..=stages {
                    let j = f32::from(j);
                    (last, legendre) =
                        (legendre, ((2.0 * j - 1.0) * z * legendre - (j - 1.0) * last) / j);
                }
                let off = 1.0 + now - legendre;
                assert!(off.abs() < 2e-4, "{stages} stages at {x}: {off:e}");
            }
        }
    }
}
