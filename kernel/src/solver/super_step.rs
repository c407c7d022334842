//! The super-steps of `rkl2`: their lengths, the guard, and the update.
//!
//! **Time.** A tick covers `tick_time` of network time in super-steps of s stages, one link pass each; s is
//! the least number that covers the super-step's length. A disturbance by a move of the tool or of the bands
//! spreads like heat, fast modes first. So super-steps have equal length at first, and from [`EVEN`] on a
//! fixed fraction of the time since the disturbance, so that they grow by a constant factor. They are as
//! short as the tick's sweeps allow, but not below [`SHORTEST`] at first, and are cut evenly to end exactly
//! at the tick's time. If no such sequence fits the sweeps, one super-step takes all of them; time that it
//! cannot cover stays due at the next tick (the lag). Unused sweeps cost nothing, and neither does a sleeping
//! body, for which nothing changes with time.
//!
//! **The guard.** The pass at the first stage of the next super-step gives the energy of the last one's end
//! Y. Only then, if E(Y) <= U + tol with U the certified level, Y is published and U becomes min(U, E(Y)).
//! Otherwise the published state stays (flag 64), and the same time is covered by Euler steps below the
//! proven bound, which cannot raise the energy ([`euler`](super::Euler)). A super-step starts only if one
//! more sweep of its tick is left to judge it, so every tick ends with a published state, and the tool never
//! moves during a super-step. With too few sweeps for that, or with a state beyond K, Euler steps advance the
//! tick.
//!
//! All lengths here are in units of the proven bound of an Euler step.
//!
//! Rounding: a stage is computed as Y = `Y_0` + displacement, so that a body at rest keeps its bits.

use core::marker::PhantomData;

use super::euler::{linear_step, saturated_step};
use super::guard::{Pass, discards};
use super::scheme::{Body, Scheme};
use crate::backend::f32x8::F32x8;
use crate::backend::slices::{Chunks, ChunksMut, copy_slice};
use crate::backend::{Work, run};
use crate::model::Model;
use crate::number::cell::{Cell, peak};
use crate::number::kept::{Kept, kept};
use crate::number::two_float::TwoFloat;
use crate::solver::awake::Awake;
use crate::solver::loops::{Loops, Moved};

/// Time after a disturbance from which on super-steps grow in proportion to it.
const EVEN: f32 = 3.0;
/// Shortest first super-step, and the factor that lengthens it until the sequence fits the sweeps.
const SHORTEST: f32 = 0.3;
const LONGER: f32 = 1.25;
/// Length of an Euler step: below 1, so that it also damps the fastest mode.
const EULER: f32 = 0.9;

/// Factors of one stage; `Y_j` - `Y_0` = `mu` (`Y_j-1` - `Y_0`) + `nu` (`Y_j-2` - `Y_0`)
/// + h (`m` `R_j-1` + `g` `R_0`), h = the super-step's length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors {
    pub(super) mu: f32,
    pub(super) nu: f32,
    pub(super) m: f32,
    pub(super) g: f32,
}

/// The formulas of a super-step.
pub trait Formula: Kept {
    /// Fewest stages of a super-step.
    const STAGES_MIN: u16;
    /// Longest stable super-step of `stages` stages.
    fn reach(stages: u16) -> f32;
    /// The factors of a stage; the first stage is 1.
    fn factors(stage: u16, stages: u16) -> Factors;
}

kept! {
    /// State of a scheme that advances by super-steps.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct SuperSteps<F> {
        /// Time still to cover.
        due: f32,
        /// Time to cover by Euler steps after a rollback.
        careful: f32,
        /// Length of the first super-step after a disturbance, in this tick; 0 until it is chosen.
        first: f32,
        /// Time since the last disturbance.
        since: f32,
        /// Length of the running super-step.
        length: f32,
        /// Stages of the running super-step, and the number done; 0 between two.
        stages: u16,
        done: u16,
        /// Remaining sweeps of this tick.
        left: u16,
        /// Number of cells that the tool acted on in the last sweep: it may release without a move.
        contacts: usize,
        /// True if some state is beyond K.
        saturated: bool,
        formula: PhantomData<F>,
    }
}

/// One stage, in awake slices: `at` moves to `before`, and the new point to `at`.
struct Stage<'a, 'm> {
    model: &'a Model<'m>,
    awake: &'a Awake,
    published: &'a [Cell],
    at: &'a mut [Cell],
    before: &'a mut [Cell],
    residual: &'a [Cell],
    /// Residual of the first stage.
    first: &'a [Cell],
    factors: Factors,
}

impl Work for Stage<'_, '_> {
    type Output = Moved;

    #[inline(always)]
    fn run<V: F32x8>(self) -> Moved {
        let Factors { mu, nu, m, g } = self.factors;
        let (mu, nu, m, g) = (V::splat(mu), V::splat(nu), V::splat(m), V::splat(g));
        let mut moved = Moved::NOTHING;
        let zero = V::splat(0.0);
        let mut peak = zero;
        let mobility = Chunks::new(self.model.mobility, 0.0);
        let arrays = [self.published, self.residual, self.first];
        let [published, residual, first] = arrays.map(|cells| Chunks::new(cells, Cell::ZERO));
        let (mut at, mut before) = (ChunksMut::new(self.at), ChunksMut::new(self.before));
        for slice in self.awake.set.iter(self.model.slice_count()) {
            let (mobility, published) = (mobility.at(slice), published.at(slice));
            let (residual, first) = (residual.at(slice), first.at(slice));
            let (at, before) = (at.at(slice), before.at(slice));
            let mut changed = zero;
            for pair in 0..4 {
                let start = V::pair(published, pair);
                let free = V::spread(mobility, pair).above(zero);
                let driven = V::pair(residual, pair).times(m).plus(V::pair(first, pair).times(g));
                let last = V::pair(at, pair);
                let (one, two) = (last.minus(start), V::pair(before, pair).minus(start));
                let way = one.times(mu).plus(two.times(nu)).plus(driven.keep(free)).positions();
                let next = start.plus(way);
                changed = changed.larger_magnitude(next.minus(last));
                peak = peak.larger_magnitude(next);
                next.put_pair(at, pair);
                last.put_pair(before, pair);
            }
            if !self.awake.spread.contains(slice) && V::any(changed.above(zero)) {
                moved.slices.insert(slice);
            }
        }
        at.finish();
        before.finish();
        moved.reach(peak, self.model.saturation());
        moved
    }
}

impl<F: Formula> SuperSteps<F> {
    pub(super) const REST: Self = Self {
        due: 0.0,
        careful: 0.0,
        first: 0.0,
        since: 0.0,
        length: 0.0,
        stages: 0,
        done: 0,
        left: 0,
        contacts: 0,
        saturated: false,
        formula: PhantomData,
    };

    /// The time that a number of sweeps per tick certainly covers [dimensionless time].
    pub(super) fn tick_time_max(model: &Model<'_>, sweeps: u16) -> f32 {
        let stages = sweeps.saturating_sub(1);
        let steps = EULER * f32::from(sweeps);
        let length = if stages < F::STAGES_MIN { steps } else { F::reach(stages) };
        length * model.step_max()
    }

    /// Stages and length of a super-step that starts `since` after a disturbance with the time `due` ahead;
    /// `None` if it needs more than `most` stages.
    fn row(first: f32, since: f32, due: f32, most: u16) -> Option<(u16, f32)> {
        let wished = if since > EVEN { first * (since / EVEN) } else { first };
        let whole = (due / wished) as u32 as f32;
        let steps = if whole * wished < due { whole + 1.0 } else { whole };
        let length = if steps > 1.0 { due / steps } else { due };
        (F::STAGES_MIN..=most)
            .find(|&stages| F::reach(stages) >= length)
            .map(|stages| (stages, length))
    }

    /// Returns true if a sequence with this first length fits the running sweep and the remaining ones, the
    /// last of which judges.
    fn fits(&self, first: f32) -> bool {
        let (mut since, mut due, mut left) = (self.since, self.due, self.left);
        while due > 0.0 {
            let Some((stages, length)) = Self::row(first, since, due, left) else { return false };
            (since, due, left) = (since + length, due - length, left - stages);
        }
        true
    }

    /// The shortest first length that fits; if none does, one that takes all in one super-step.
    fn beginning(&self) -> f32 {
        let mut first = SHORTEST;
        while first < self.due && !self.fits(first) {
            first *= LONGER;
        }
        first
    }

    /// Stages and length of the super-step that starts now; `None` for an Euler step.
    fn plan(&self) -> Option<(u16, f32)> {
        if self.saturated || self.careful > 0.0 || self.left < F::STAGES_MIN {
            return None;
        }
        let all = (self.left, F::reach(self.left));
        Some(Self::row(self.first, self.since, self.due, self.left).unwrap_or(all))
    }

    /// Undoes the super-step; Euler steps will cover the same time.
    fn roll_back(&mut self) -> bool {
        self.done = 0;
        self.careful = self.length;
        true
    }

    /// Makes one Euler step from the published state, whose residual is known within K.
    fn euler(&mut self, body: &mut Body<'_, '_>) {
        let model = body.terms.model;
        let length = if self.due < EULER { self.due } else { EULER };
        let step = length * model.step_max();
        self.saturated = if self.saturated {
            Self::note(body);
            let (potential, beyond) = saturated_step(body, step);
            body.level.certify(potential);
            beyond
        } else {
            linear_step(body, step)
        };
        self.due -= length;
        self.since += length;
        let careful = self.careful - length;
        self.careful = if careful > 0.0 { careful } else { 0.0 };
    }

    /// Starts a super-step at the published state, whose residual is known.
    fn start(&mut self, body: &mut Body<'_, '_>, (stages, length): (u16, f32)) {
        (self.stages, self.length, self.done) = (stages, length, 0);
        let cells = body.state.len();
        let first = body.own.get_mut(2 * cells..).unwrap_or(&mut []);
        for slice in body.awake.set.iter(body.terms.model.slice_count()) {
            copy_slice(first, body.residual, slice);
            body.terms.states.save_slice(slice);
        }
    }

    /// Computes the next stage. Returns true if the super-step was undone because a cell went beyond K.
    fn stage(&mut self, body: &mut Body<'_, '_>) -> bool {
        let model = body.terms.model;
        let cells = body.state.len();
        let Some((at, rest)) = body.own.split_at_mut_checked(cells) else { return false };
        let Some((before, first)) = rest.split_at_mut_checked(cells) else { return false };
        // Update the point with the stage's factors.
        self.done += 1;
        let mut factors = F::factors(self.done, self.stages);
        let step = self.length * model.step_max() / model.capacitance();
        (factors.m, factors.g) = (factors.m * step, factors.g * step);
        let (awake, published, residual) = (&*body.awake, &*body.state, &*body.residual);
        let (before, first) = (before, &mut *first);
        let stage = Stage { model, awake, published, at, before, residual, first, factors };
        let moved = run(body.terms.vectors, stage);
        // Wake neighbours, and undo a super-step that ends beyond K.
        if moved.slices != crate::backend::slice_set::SliceSet::EMPTY {
            Self::wake(body, &moved);
        }
        if self.done < self.stages || !moved.beyond {
            return false;
        }
        body.terms.states.restore(&body.awake.set, model.slice_count());
        self.roll_back()
    }

    /// Wakes the neighbours of slices that moved: they are still at their initial positions. Not inlined:
    /// rare and large.
    #[inline(never)]
    fn wake(body: &mut Body<'_, '_>, moved: &Moved) {
        let (model, before) = (body.terms.model, body.awake.set);
        let cells = body.state.len();
        let Some((at, rest)) = body.own.split_at_mut_checked(cells) else { return };
        let Some((last, first)) = rest.split_at_mut_checked(cells) else { return };
        let has_moved = |cell: usize| at.get(cell) != last.get(cell);
        body.awake.wake_neighbours(model, &moved.slices, has_moved);
        for slice in body.awake.set.iter(model.slice_count()) {
            if !before.contains(slice) {
                copy_slice(at, body.state, slice);
                copy_slice(last, body.state, slice);
                body.terms.states.save_slice(slice);
                for r in first.iter_mut().skip(8 * slice).take(8) {
                    *r = Cell::ZERO;
                }
            }
        }
    }

    /// Copies the published state to the next point. Not inlined: called from two places.
    #[inline(never)]
    fn note(body: &mut Body<'_, '_>) {
        let Some(at) = body.own.get_mut(..body.state.len()) else { return };
        for slice in body.awake.set.iter(body.terms.model.slice_count()) {
            copy_slice(at, body.state, slice);
        }
    }

    /// Makes a pass; at the end of a super-step it publishes the point or undoes the super-step. Returns true
    /// if it was undone.
    fn pass(&mut self, body: &mut Body<'_, '_>) -> bool {
        if self.done == 0 {
            Self::note(body);
        }
        let at = body.own.get(..body.state.len()).unwrap_or(&[]);
        let awake = &body.awake.set;
        let energy = f32::residual(body.terms, awake, awake, at, body.residual);
        if self.done == 0 {
            let potential = body.terms.potential(energy, at);
            body.level.certify(potential);
        } else if self.done == self.stages && self.judge(body, energy) {
            return true;
        }
        // Without a force nothing changes with time.
        if self.done == 0 && energy.hi <= 0.0 && !body.terms.is_loaded() {
            (self.due, self.careful) = (0.0, 0.0);
        }
        false
    }

    /// Publishes the end of a super-step, or undoes it. Returns true if it was undone.
    fn judge(&mut self, body: &mut Body<'_, '_>, energy: TwoFloat) -> bool {
        let model = body.terms.model;
        let at = body.own.get(..body.state.len()).unwrap_or(&[]);
        let potential = body.terms.potential(energy, at);
        let pass = Pass { at, residual: &*body.residual, energy, potential };
        if discards(body.terms, body.level, &pass) {
            body.terms.states.restore(&body.awake.set, model.slice_count());
            return self.roll_back();
        }
        body.level.certify(potential);
        for slice in body.awake.set.iter(model.slice_count()) {
            copy_slice(body.state, at, slice);
        }
        self.due -= self.length;
        self.since += self.length;
        self.done = 0;
        false
    }
}

impl<F: Formula> Scheme for SuperSteps<F> {
    type Number = f32;

    #[allow(private_interfaces)]
    fn begin(&mut self, body: &mut Body<'_, '_>) {
        self.left = body.pace.sweeps;
        self.due += body.pace.tick_time / body.terms.model.step_max();
        self.done = 0;
        self.first = 0.0;
    }

    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_>) -> bool {
        let model = body.terms.model;
        self.left = self.left.saturating_sub(1);
        if body.awake.set.is_empty(model.slice_count()) {
            (self.due, self.careful) = (0.0, 0.0);
            return false;
        }
        if self.contacts != body.terms.contacts.len() {
            (self.contacts, self.since) = (body.terms.contacts.len(), 0.0);
        }
        if (self.done > 0 || self.due > 0.0 && !self.saturated) && self.pass(body) {
            return true;
        }
        if self.done == 0 {
            if self.due <= 0.0 {
                return false;
            }
            if self.first <= 0.0 {
                self.first = self.beginning();
            }
            let Some(plan) = self.plan() else {
                self.euler(body);
                return false;
            };
            self.start(body, plan);
        }
        self.stage(body)
    }

    fn place(&mut self, own: &mut [Cell], cell: usize, position: Cell, k: f32) {
        let cells = own.len() / 3;
        for at in [cell, cells + cell] {
            if let Some(slot) = own.get_mut(at) {
                *slot = position;
            }
        }
        self.saturated |= peak(position.xyz()) > k;
    }

    fn pushed(&mut self) {
        self.since = 0.0;
    }

    fn interrupt(&mut self) {
        self.since = 0.0;
    }

    /// The last pass was at the first of the scheme's arrays.
    fn has_moved(state: &[Cell], own: &[Cell], _residual: &[Cell], cell: usize) -> bool {
        state.get(cell).is_some_and(|here| Some(here) != own.get(cell))
    }
}

#[cfg(test)]
mod tests {
    use super::super::rkl2::Second;
    use super::*;

    /// Lengths and stages of the super-steps of a tick.
    fn row<F: Formula>(due: f32, sweeps: u16) -> std::vec::Vec<(u16, f32)> {
        let mut scheme = SuperSteps::<F> { due, left: sweeps, ..SuperSteps::REST };
        scheme.left -= 1;
        scheme.first = scheme.beginning();
        let mut row = std::vec::Vec::new();
        while scheme.due > 0.0 {
            let Some((stages, length)) = scheme.plan() else { break };
            row.push((stages, length));
            (scheme.due, scheme.since) = (scheme.due - length, scheme.since + length);
            scheme.left -= stages;
        }
        row
    }

    // REQ-TCK-03
    #[test]
    fn a_tick_ends_at_its_time_in_its_sweeps() {
        for sweeps in 4..300_u16 {
            for due in [0.1, 1.0, 4.0, 40.0, 400.0] {
                let row = row::<Second>(due, sweeps);
                let stages: u16 = row.iter().map(|step| step.0).sum();
                let time: f32 = row.iter().map(|step| step.1).sum();
                assert!(stages < sweeps, "{due} in {sweeps}: {row:?}");
                let all = Second::reach(sweeps - 1);
                let expected = if due < all { due } else { all };
                assert!((time - expected).abs() < 1e-4 * due, "{due} in {sweeps}: {row:?}");
                for (stages, length) in row {
                    assert!(length <= Second::reach(stages));
                }
            }
        }
    }

    #[test]
    fn what_was_undone_is_taken_in_euler_steps() {
        let mut scheme = SuperSteps::<Second> { due: 7.0, left: 40, ..SuperSteps::REST };
        scheme.first = scheme.beginning();
        let (_, length) = scheme.plan().unwrap();
        scheme.length = length;
        assert!(scheme.roll_back() && scheme.plan().is_none());
        assert_eq!((scheme.careful, scheme.done, scheme.due), (length, 0, 7.0));
        scheme.careful = 0.0;
        assert!(scheme.plan().is_some());
    }

    // REQ-TCK-03
    #[test]
    fn few_sweeps_are_euler_steps() {
        assert!(row::<Second>(1.0, 3).is_empty());
    }
}
