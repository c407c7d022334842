//! `euler`: the paper's own dynamics (Eq. 2, 12, 15), one explicit step of common size a sweep.
//!
//! ```text
//! C dv_i/dt = -(v_i - y_i) / R_x + sum of w mu (y_j - y_i),   y = clamp(v, -K, K)
//! ```
//!
//! which is Eq. 2 with the templates of Eq. 15: inside the linear range the state is the position
//! and the leak vanishes. With h <= 2 C / b and h <= `R_x` C no step raises the energy of y, from
//! any state. Time is physical: choose h = 1 ms / time constant for stress relaxation.
//!
//! Cost: one link pass and one pass over the cells, no array besides state and residual.

use super::scheme::Scheme;
use super::{Body, Dynamics};
use crate::awake::Awake;
use crate::cell::{Cell, add, output, peak, scale, sub};
use crate::hats::Eight;
use crate::model::Model;
use crate::pass::{Energy, totals};
use crate::simd::octet::Octet;
use crate::simd::{Work, run};
use crate::slice::{Moved, eight, eight_values, put_pairs};
use crate::two_float::TwoFloat;

/// State of the scheme: whether any state is beyond K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Euler {
    saturated: bool,
}

impl Dynamics for Euler {
    const NAME: &'static str = "euler";
    const REST: Self = Self { saturated: false };
    const ARRAYS: usize = 0;
    type Residual<const CELLS: usize> = [[Cell; CELLS]; 1];
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; 0];
    type Room = [Eight; 0];
}

/// v += step r of the free cells in awake slices.
struct Step<'a, 'm> {
    model: &'a Model<'m>,
    awake: &'a Awake,
    state: &'a mut [Cell],
    residual: &'a [Cell],
    step: f32,
}

impl Work for Step<'_, '_> {
    type Output = Moved;

    #[inline(always)]
    fn run<V: Octet>(self) -> Moved {
        let mut moved = Moved::NOTHING;
        let (step, zero) = (V::splat(self.step), V::splat(0.0));
        let mut peak = zero;
        for slice in self.awake.set.iter(self.model.slice_count()) {
            let (mut here, mut there) = ([Cell::ZERO; 8], [Cell::ZERO; 8]);
            let residual = eight(self.residual, slice, &mut here);
            let state = eight(self.state, slice, &mut there);
            let mobility = eight_values(self.model.mobility, slice);
            let mut pairs = [zero; 4];
            let mut changed = zero;
            for (pair, slot) in pairs.iter_mut().enumerate() {
                let v = V::pair(state, pair);
                let free = V::spread(&mobility, pair).above(zero);
                let way = V::pair(residual, pair).times(step).keep(free).positions();
                *slot = v.plus(way);
                changed = changed.larger_magnitude(slot.minus(v));
                peak = peak.larger_magnitude(*slot);
            }
            put_pairs(self.state, slice, pairs);
            if !self.awake.spread.contains(slice) && V::any(changed.above(zero)) {
                moved.slices.insert(slice);
            }
        }
        moved.reach(peak);
        moved
    }
}

/// A step of the outputs, with the leak of states beyond K: the energy before it, in internal
/// units, and the largest magnitude of a state after it. Held cells go back to where the tool has
/// them.
pub(super) fn saturated_step(body: &mut Body<'_, '_>, step: f32) -> (TwoFloat, f32) {
    let model = body.links.model;
    body.awake.wake_all(model);
    // The leak moves cells that no link pulls.
    body.awake.postpone_sleep();
    body.links.saturated_pass(&body.awake.set, body.state, body.residual, body.held);
    let [sum] = totals(body.residual.iter().map(|r| [r.w()]));
    let step = step / model.capacitance();
    let (leak, k) = (step / model.resistance(), model.saturation());
    let mut highest = 0.0;
    for ((v, r), &mobility) in body.state.iter_mut().zip(&*body.residual).zip(model.mobility) {
        if mobility > 0.0 {
            let next = add(v.xyz(), scale(step, r.xyz()));
            *v = Cell::at(sub(next, scale(leak, sub(v.xyz(), output(v.xyz(), k)))));
        }
        let here = peak(v.xyz());
        highest = if here > highest { here } else { highest };
    }
    let held = body.restore_held();
    (sum.times_power_of_two(0.125), if held > highest { held } else { highest })
}

/// A step within K from residuals that are there; the largest magnitude of a state after it.
pub(super) fn linear_step(body: &mut Body<'_, '_>, step: f32) -> f32 {
    let model = body.links.model;
    let step = step / model.capacitance();
    let (awake, residual) = (&*body.awake, &*body.residual);
    let moved = run(body.links.vectors, Step { model, awake, state: body.state, residual, step });
    let has_moved = |cell: usize| residual.get(cell).is_some_and(|r| r.xyz() != [0.0; 3]);
    body.awake.wake_neighbours(model, &moved.slices, has_moved);
    let held = body.restore_held();
    if held > moved.peak { held } else { moved.peak }
}

impl Scheme for Euler {
    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_>) -> bool {
        let step = body.settings.step;
        let highest = if self.saturated {
            let (energy, highest) = saturated_step(body, step);
            body.level.set(energy);
            highest
        } else {
            let mut energy = Energy::default();
            body.links.pass(&body.awake.set, body.state, body.residual, body.held, &mut energy);
            body.level.set(energy.total());
            linear_step(body, step)
        };
        self.saturated = highest > body.links.model.saturation();
        false
    }

    fn place(&mut self, _own: &mut [Cell], _cell: usize, position: Cell, k: f32) {
        self.saturated |= peak(position.xyz()) > k;
    }

    fn interrupt(&mut self) {}
}
