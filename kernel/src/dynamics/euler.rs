//! `euler`: the paper's own dynamics (Eq. 2, 12, 15), one explicit step of common size a sweep.
//!
//! ```text
//! C dv_i/dt = -(v_i - y_i) / R_x + sum of w mu (y_j - y_i),   y = clamp(v, -K, K)
//! ```
//!
//! which is Eq. 2 with the templates of Eq. 15: inside the linear range the state is the position
//! and the leak vanishes. With h <= 2 C / b and h <= `R_x` C no step raises the energy of y, from
//! any state. Time is physical: choose h = 1 ms / time constant for stress relaxation.

use super::scheme::Scheme;
use super::{Body, Dynamics};
use crate::cell::{Cell, add, output, peak, scale, sub};
use crate::pass::{mask, totals};

/// State of the scheme: whether any state is beyond K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Euler {
    saturated: bool,
}

impl Dynamics for Euler {
    const NAME: &'static str = "euler";
    const REST: Self = Self { saturated: false };
    const ARRAYS: usize = 0;
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; 0];
}

impl Scheme for Euler {
    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_>) -> bool {
        if self.saturated {
            body.links.pass::<true>(body.state, body.residual);
        } else {
            body.links.pass::<false>(body.state, body.residual);
        }
        mask(body.residual, body.held);
        let [sum] = totals(body.residual.iter().map(|r| [r.w()]));
        body.level.set(sum.times_power_of_two(0.125));
        let model = body.links.model;
        let step = body.settings.step / model.capacitance();
        let leak = if self.saturated { step / model.resistance() } else { 0.0 };
        let k = model.saturation();
        let mut highest = 0.0;
        for ((v, r), &mobility) in body.state.iter_mut().zip(&*body.residual).zip(model.mobility) {
            if mobility > 0.0 {
                let mut next = add(v.xyz(), scale(step, r.xyz()));
                if leak > 0.0 {
                    next = sub(next, scale(leak, sub(v.xyz(), output(v.xyz(), k))));
                }
                *v = Cell::at(next);
            }
            let here = peak(v.xyz());
            highest = if here > highest { here } else { highest };
        }
        let held = body.restore_held();
        self.saturated = highest > k || held > k;
        false
    }

    fn place(&mut self, _own: &mut [Cell], _cell: usize, position: Cell, k: f32) {
        self.saturated |= peak(position.xyz()) > k;
    }

    fn interrupt(&mut self) {}
}
