//! `track`: follows the equilibrium as fast as the guard allows; momentum with restart.
//!
//! Nesterov's scheme on E with the step 1 / `W_i` of each cell. With x the published point, y the
//! extrapolated one, r the residual at y:
//!
//! ```text
//! x' = y + r / W,   y' = x' + beta (x' - x),   beta = (t - 1) / t',   t' = (1 + sqrt(1 + 4 t^2)) / 2
//! ```
//!
//! t = 1 where r . (x' - x) <= 0 (restart; O'Donoghue and Candes 2015). The guard: half the squared
//! distance to a set curves upwards by at most one, so for every move d of the cells
//! E(y + d) <= E(y) - r . d + sum of `W_i` |`d_i`|^2 / 2. Hence x' is certified at
//! U' = E(y) - sum of |`r_i`|^2 / (2 `W_i`). Where E(y) > U + tol the pass is discarded and the next one
//! starts at x itself, accepted without comparison. What is published is x, never y, and its
//! energy never exceeds U (within tol = 4 eps (E + sqrt(w E)), w the smallest weight: at most the
//! rounding 4 eps (E + sum of w u d / 2) that the sum may have in the worst case, and about what it
//! has, since the links' errors add up like a random walk).
//!
//! A state beyond K is handled by plain steps from x, whose clamped moves D obey
//! E falls by at least sum of r . D - `W_i` |D|^2 / 2; the leak per step is min(1, 1 / (`W_i` `R_x`)).
//!
//! Cost: one link pass, two passes over the cells, one array besides state and residual.

use super::scheme::Scheme;
use super::{Body, Dynamics};
use crate::cell::{Cell, add, dot, output, peak, scale, sub};
use crate::pass::{mask, totals};
use crate::sqrt::sqrt;

/// State of the scheme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Track {
    /// Nesterov's t, at least 1.
    momentum: f32,
    /// The next pass starts at the published point and takes a plain step.
    plain: bool,
}

impl Dynamics for Track {
    const NAME: &'static str = "track";
    const REST: Self = Self { momentum: 1.0, plain: true };
    const ARRAYS: usize = 1;
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; 1];
}

/// r / W for a free cell, nothing for a fixed one; the fourth lane means nothing.
#[inline(always)]
fn damped(r: Cell, mobility: f32) -> Cell {
    if mobility > 0.0 { r.times(mobility) } else { Cell::ZERO }
}

/// Rounding allowance of an energy.
fn tolerance(energy: f32, weight_min: f32) -> f32 {
    let energy = if energy > 0.0 { energy } else { 0.0 };
    4.0 * f32::EPSILON * (energy + sqrt(weight_min * energy))
}

impl Track {
    /// Momentum factor of the next extrapolation; a restart makes it zero.
    fn advance(&mut self, restart: bool) -> f32 {
        let t = if restart { 1.0 } else { self.momentum };
        self.momentum = 0.5 * (1.0 + sqrt(1.0 + 4.0 * t * t));
        (t - 1.0) / self.momentum
    }

    /// A pass at the extrapolated point. Whether the guard discarded it.
    fn extrapolated(&mut self, body: &mut Body<'_, '_>) -> bool {
        let model = body.links.model;
        body.links.pass::<false>(body.own, body.residual);
        mask(body.residual, body.held);
        let mut highest = Cell::ZERO;
        let cells = body.own.iter().zip(&*body.state).zip(&*body.residual).zip(model.mobility);
        let [energy, decrease, product] = totals(cells.map(|(((y, x), &r), &mobility)| {
            let step = damped(r, mobility);
            let next = y.plus(step);
            highest = highest.larger_magnitude(next);
            [r.w(), dot(r.xyz(), step.xyz()), dot(r.xyz(), next.minus(*x).xyz())]
        }));
        let energy = energy.times_power_of_two(0.125);
        let tolerance = tolerance(body.level.leading(), model.weight_min);
        let allowed = body.level.value().plus(tolerance.into());
        if energy.exceeds(allowed) || peak(highest.xyz()) > model.saturation() {
            self.plain = true;
            return true;
        }
        body.level.certify(energy.minus(decrease.times_power_of_two(0.5)));
        let beta = self.advance(product.hi <= 0.0);
        let cells = body.own.iter_mut().zip(body.state.iter_mut()).zip(&*body.residual);
        for (((y, x), &r), &mobility) in cells.zip(model.mobility) {
            let next = y.plus(damped(r, mobility)).position();
            *y = next.plus(next.minus(*x).times(beta));
            *x = next;
        }
        false
    }

    /// A plain step from the published point, saturating.
    fn plain(&mut self, body: &mut Body<'_, '_>) {
        let model = body.links.model;
        let k = model.saturation();
        body.links.pass::<true>(body.state, body.residual);
        mask(body.residual, body.held);
        let next = |v: [f32; 3], r: Cell, mobility: f32| {
            let leak = mobility / model.resistance();
            let leak = if leak < 1.0 { leak } else { 1.0 };
            sub(add(v, damped(r, mobility).xyz()), scale(leak, sub(v, output(v, k))))
        };
        let cells = body.state.iter().zip(&*body.residual).zip(model.mobility);
        let [energy, decrease] = totals(cells.map(|((v, &r), &mobility)| {
            if mobility > 0.0 && r.xyz() != [0.0; 3] {
                let way = sub(output(next(v.xyz(), r, mobility), k), output(v.xyz(), k));
                [r.w(), dot(r.xyz(), way) - 0.5 * dot(way, way) / mobility]
            } else {
                [r.w(), 0.0]
            }
        }));
        body.level.certify(energy.times_power_of_two(0.125).minus(decrease));
        let mut highest = 0.0;
        for ((v, &r), &mobility) in body.state.iter_mut().zip(&*body.residual).zip(model.mobility) {
            if mobility > 0.0 {
                *v = Cell::at(next(v.xyz(), r, mobility));
            }
            let here = peak(v.xyz());
            highest = if here > highest { here } else { highest };
        }
        let held = body.restore_held();
        for (y, v) in body.own.iter_mut().zip(&*body.state) {
            *y = *v;
        }
        let _ = self.advance(true);
        self.plain = highest > k || held > k;
    }
}

impl Scheme for Track {
    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_>) -> bool {
        if self.plain {
            self.plain(body);
            false
        } else {
            self.extrapolated(body)
        }
    }

    fn place(&mut self, own: &mut [Cell], cell: usize, position: Cell, k: f32) {
        if let Some(y) = own.get_mut(cell) {
            *y = position;
        }
        self.plain |= peak(position.xyz()) > k;
    }

    fn interrupt(&mut self) {
        self.plain = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::two_float::TwoFloat;

    #[test]
    fn momentum_grows_from_a_restart() {
        let mut track = Track::REST;
        assert_eq!(track.advance(true), 0.0);
        let betas: [f32; 3] = core::array::from_fn(|_| track.advance(false));
        assert!(betas[0] > 0.25 && betas[0] < betas[1] && betas[1] < betas[2] && betas[2] < 1.0);
        assert_eq!(track.advance(true), 0.0);
    }

    #[test]
    fn two_float_tolerance_is_far_below_the_energy() {
        assert!(tolerance(1.0, 1.0) < 1e-6 && tolerance(0.0, 1.0) == 0.0);
        assert!(TwoFloat::from(1.0).exceeds(TwoFloat::from(1.0 - 1e-6)));
    }
}
