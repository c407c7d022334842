//! `rkl2`: the network's trajectory in time, second order, at a fraction of Euler's passes.
//!
//! The dynamics within K is the gradient flow dP/dt = R(P) / C of `euler`. An explicit method that only has
//! to be stable on the real axis can cover with s stages about s^2 / 4 times as much time as one Euler step:
//! its stability polynomial is a shifted Legendre polynomial of degree s, bounded by 1 where Euler's (1 - h
//! lambda)^s would have to stay. With h the super-step,
//!
//! ```text
//! Y_1 = Y_0 + b_1 w h R_0 / C                         w = 4 / (s^2 + s - 2)
//! Y_j = mu_j Y_j-1 + nu_j Y_j-2 + (1 - mu_j - nu_j) Y_0 + mu_j w h R_j-1 / C + g_j h R_0 / C
//! mu_j = (2 j - 1) / j  b_j / b_j-1,  nu_j = -(j - 1) / j  b_j / b_j-2,  g_j = -(1 - b_j-1) mu_j w
//! b_0 = b_1 = b_2 = 1/3,  b_j = (j^2 + j - 2) / (2 j (j + 1))
//! ```
//!
//! is of second order and stable for h <= dt (s^2 + s - 2) / 4. dt is the bound of an Euler step, here 2 C /
//! b, with b the largest mean weight of two linked cells: the largest curvature in any state of the body, so
//! no safety factor is needed. Every stage point is a mean of earlier ones (the weights are positive), and
//! the energy of a quadratic well falls. The curvature of the links changes from stage to stage: occasionally
//! a super-step ends above the level, and the guard undoes it ([`super_step`](super)).
//!
//! Use: stress relaxation as in the paper's Fig. 5c if h is above Euler's bound, and any motion that must be
//! right in time. Error on the paper's plane: below 1e-3 of the depth at t = 1, 10, 100 in 13, 45, 140 passes
//! with 8 neighbours, for which Euler takes 64, 100, 400.
//!
//! Cost: one link pass and one pass over the cells per stage, three arrays besides state and residual.
//!
//! Source: C. D. Meyer, D. S. Balsara, T. D. Aslam, A stabilized Runge-Kutta-Legendre method for
//! explicit super-time-stepping of parabolic and mixed equations, J. Comput. Phys. 257, 2014.

use super::Dynamics;
use super::super_step::{Factors, Formula, SuperSteps};
use crate::model::Model;
use crate::number::cell::Cell;
use crate::number::kept::kept;
use crate::number::two_float::Eight;

kept! {
    /// The formulas of second order.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Second {}
}

/// The scheme `rkl2`.
///
/// ```
/// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, include_model};
/// use chaincell_kernel::{Rkl2, Scheme};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// let network = Network::new(model, Scheme::Rkl2.settings(&model, 8))?; // the time of 8 sweeps
/// let mut tissue = Tissue::<128, Rkl2>::new();
/// # tissue.reset(&network)?;
/// # tissue.choose_contacts(&network, &[47])?;
/// # tissue.tick(&network, &[ToolPose::at([0.0; 3].into(), 1)], Budget::All);
/// let pose = [ToolPose::at([0.002, 0.0, 0.0].into(), 1)];
/// let first_n = tissue.tick(&network, &pose, Budget::All).force_n.x;
/// let later_n = (0..50).fold(0.0, |_, _| tissue.tick(&network, &pose, Budget::All).force_n.x);
/// assert!(first_n < -0.11 && (later_n + 0.0879).abs() < 2e-4); // [N], in the time of many small steps
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type Rkl2 = SuperSteps<Second>;

impl Dynamics for Rkl2 {
    const NAME: &'static str = "rkl2";
    const REST: Self = Self::REST;
    const ARRAYS: usize = 3;
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; 3];
    type Room = [Eight; 0];

    fn tick_time(model: &Model<'_>, sweeps: u16) -> f32 {
        Self::tick_time_max(model, sweeps)
    }
}

/// `b_j`.
fn b(stage: u16) -> f32 {
    let j = f32::from(stage);
    if stage <= 2 { 1.0 / 3.0 } else { (j * j + j - 2.0) / (2.0 * j * (j + 1.0)) }
}

impl Formula for Second {
    const STAGES_MIN: u16 = 3;

    fn reach(stages: u16) -> f32 {
        let s = f32::from(stages);
        0.25 * (s * s + s - 2.0)
    }

    fn factors(stage: u16, stages: u16) -> Factors {
        let w = 1.0 / Self::reach(stages);
        if stage <= 1 {
            return Factors { mu: 0.0, nu: 0.0, m: b(1) * w, g: 0.0 };
        }
        let j = f32::from(stage);
        let mu = (2.0 * j - 1.0) / j * (b(stage) / b(stage - 1));
        let nu = -((j - 1.0) / j) * (b(stage) / b(stage - 2));
        let m = mu * w;
        Factors { mu, nu, m, g: -(1.0 - b(stage - 1)) * m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stability polynomial at h lambda = x: the recursion on a single mode.
    fn polynomial(stages: u16, x: f32) -> f32 {
        let (mut before, mut at) = (0.0, 0.0);
        for stage in 1..=stages {
            let Factors { mu, nu, m, g } = Second::factors(stage, stages);
            let next = mu * at + nu * before - x * (m * (1.0 + at) + g);
            (before, at) = (at, next);
        }
        1.0 + at
    }

    #[test]
    fn second_order_and_stable_up_to_its_reach() {
        for stages in 3..40 {
            let reach = 2.0 * Second::reach(stages);
            for at in 0..=200_u16 {
                let x = reach * f32::from(at) / 200.0;
                assert!(polynomial(stages, x).abs() < 1.0001, "{stages} stages at {x}");
            }
            // exp(-x) up to its third power; the second power to half of that.
            let x = 0.1;
            let off = polynomial(stages, x) - (-x).exp();
            assert!(off.abs() < 0.5 * x * x * x, "{stages} stages: {off:e}");
        }
        assert!(polynomial(5, 2.2 * Second::reach(5)).abs() > 1.1);
    }
}
