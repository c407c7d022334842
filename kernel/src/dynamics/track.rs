//! `track`: follows the equilibrium as fast as the guard allows; conjugate directions, and a
//! coarse level where the model has one.
//!
//! With y the point of a pass, r its residual, W the cells' weights, and P, B the hats with their
//! inverse ([`hats`](crate::hats)), the preconditioned residual is
//!
//! ```text
//! z = r / W + P B P' r
//! ```
//!
//! The published point is x = y + z. The next pass is at y' = y + alpha z + beta s with s the way
//! from the last y to this one, both factors from the local quadratic model ([`conjugate`]).
//!
//! **The guard.** Half the squared distance to a set curves upwards by at most one, so for every
//! move d of the cells E(y + d) <= E(y) - r . d + d' L d / 2, L the Laplacian of weight w / 2. Let
//! a = r . r / W and b = r . P B P' r. For the two parts of z: `d1' L d1` <= a and `d2' L d2` <= b
//! (the largest eigenvalue of L / W is at most 1; B is at most the inverse of P' L P). By the
//! triangle inequality z' L z <= (sqrt a + sqrt b)^2, hence
//!
//! ```text
//! E(x) <= U' = E(y) - (a + b) + (sqrt a + sqrt b)^2 / 2 = E(y) - (sqrt a - sqrt b)^2 / 2
//! ```
//!
//! which without hats is E(y) - a / 2. Where E(y) > U + tol, U the level of the last x, the pass is
//! discarded and the next one starts at x itself, accepted without comparison. What is published
//! is x, never y, and its energy never exceeds U (within tol = 4 eps (E + sqrt(w E)), w the
//! smallest weight: at most the rounding 4 eps (E + sum of w u d / 2) that the sum may have in the
//! worst case, and about what it has, since the links' errors add up like a random walk).
//!
//! A state beyond K is handled by plain steps from x, whose clamped moves D obey
//! E falls by at least sum of r . D - `W_i` |D|^2 / 2; the leak per step is min(1, 1 / (`W_i` `R_x`)).
//!
//! Cost: one link pass, one pass over the cells, two arrays besides state and residual; with hats
//! their restriction, product and prolongation.

use super::conjugate::{Last, Products};
use super::guard::tolerance;
use super::scheme::Scheme;
use super::{Body, Dynamics};
use crate::awake::Awake;
use crate::cell::{Cell, add, dot, output, peak, scale, sub};
use crate::contact::Contact;
use crate::hats::{self, Eight, Solve, hats_room};
use crate::model::Model;
use crate::pass::{Reduce, totals};
use crate::simd::coarse::{CoarseStep, Restrict};
use crate::simd::octet::Octet;
use crate::simd::{Work, run};
use crate::slice::{Moved, copy, eight, eight_values, put_pairs};
use crate::sqrt::sqrt;
use crate::two_float::{Lanes, TwoFloat};

/// State of the scheme; `ROOM` octets of memory for the model's hats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Track<const ROOM: usize = 0> {
    last: Last,
    /// The next pass starts at the published point and is accepted.
    restart: bool,
    /// Some state is beyond K.
    saturated: bool,
}

impl<const ROOM: usize> Dynamics for Track<ROOM> {
    const NAME: &'static str = "track";
    const REST: Self = Self { last: Last::None, restart: true, saturated: false };
    const ARRAYS: usize = 2;
    type Residual<const CELLS: usize> = [[Cell; CELLS]; 1];
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; 2];
    type Room = [Eight; ROOM];
}

/// The sums of a pass: sum of w d^2, r . r / W, r . s, r . `z_last`.
struct Sums<'a, 'm> {
    model: &'a Model<'m>,
    published: &'a [Cell],
    before: &'a [Cell],
    lanes: [Lanes; 4],
}

impl Reduce for Sums<'_, '_> {
    #[inline(always)]
    fn slice<V: Octet>(&mut self, slice: usize, at: [V; 3], [x, y, z, wd2]: [V; 4]) {
        let (mut here, mut there) = ([Cell::ZERO; 8], [Cell::ZERO; 8]);
        let published = V::transposed(eight(self.published, slice, &mut here));
        let before = V::transposed(eight(self.before, slice, &mut there));
        let m = V::load(&eight_values(self.model.mobility, slice));
        let squared = x.times(x.times(m)).plus(y.times(y.times(m))).plus(z.times(z.times(m)));
        let way = x
            .times(at[0].minus(before[0]))
            .plus(y.times(at[1].minus(before[1])))
            .plus(z.times(at[2].minus(before[2])));
        let direction = x
            .times(published[0].minus(before[0]))
            .plus(y.times(published[1].minus(before[1])))
            .plus(z.times(published[2].minus(before[2])));
        self.lanes[0].add(wd2);
        self.lanes[1].add(squared);
        self.lanes[2].add(way);
        self.lanes[3].add(direction);
    }
}

/// The update of awake slices without hats.
struct Step<'a, 'm> {
    model: &'a Model<'m>,
    awake: &'a Awake,
    published: &'a mut [Cell],
    at: &'a mut [Cell],
    before: &'a mut [Cell],
    residual: &'a [Cell],
    alpha: f32,
    beta: f32,
}

impl Work for Step<'_, '_> {
    type Output = Moved;

    #[inline(always)]
    fn run<V: Octet>(self) -> Moved {
        let mut moved = Moved::NOTHING;
        let (alpha, beta) = (V::splat(self.alpha), V::splat(self.beta));
        let (zero, least) = (V::splat(0.0), V::splat(f32::from_bits(1)));
        let mut peak = zero;
        for slice in self.awake.set.iter(self.model.slice_count()) {
            let mut buffers = [[Cell::ZERO; 8]; 3];
            let [here, there, other] = &mut buffers;
            let residual = eight(self.residual, slice, here);
            let at = eight(self.at, slice, there);
            let before = eight(self.before, slice, other);
            let mobility = eight_values(self.model.mobility, slice);
            let (mut last, mut next, mut ahead) = ([zero; 4], [zero; 4], [zero; 4]);
            let mut started = zero;
            let slots = last.iter_mut().zip(&mut next).zip(&mut ahead);
            for (pair, ((last, next), ahead)) in slots.enumerate() {
                let z = V::pair(residual, pair).times(V::spread(&mobility, pair)).positions();
                let y = V::pair(at, pair);
                let way = y.minus(V::pair(before, pair));
                *last = y;
                *next = y.plus(z);
                *ahead = y.plus(alpha.times(z)).plus(beta.times(way));
                // Whoever was under way has woken his neighbours.
                let still = zero.larger_magnitude(way).below(least);
                let moves = zero.larger_magnitude(ahead.minus(y)).larger_magnitude(next.minus(y));
                started = started.larger_magnitude(moves.keep(still));
                peak = peak.larger_magnitude(*next).larger_magnitude(*ahead);
            }
            put_pairs(self.published, slice, next);
            put_pairs(self.before, slice, last);
            put_pairs(self.at, slice, ahead);
            if V::any(started.above(zero)) && !self.awake.spread.contains(slice) {
                moved.slices.insert(slice);
            }
        }
        moved.reach(peak);
        moved
    }
}

impl<const ROOM: usize> Track<ROOM> {
    /// A pass at the extrapolated point. Whether the guard discarded it.
    fn extrapolated(&mut self, body: &mut Body<'_, '_>) -> bool {
        let (model, vectors) = (body.links.model, body.links.vectors);
        let cells = body.state.len();
        let Some((at, before)) = body.own.split_at_mut_checked(cells) else { return false };
        let published = &mut *body.state;
        if self.restart {
            copy(at, published);
            copy(before, published);
            self.last = Last::None;
        }
        let mut sums = Sums { model, published, before, lanes: [Lanes::ZERO; 4] };
        body.links.pass(&body.awake.set, at, body.residual, body.held, &mut sums);
        let [energy, fine, way, direction] = sums.lanes.map(|lanes| lanes.total());
        let energy = energy.times_power_of_two(0.125);
        let tolerance = tolerance(body.level.leading(), model.weight_min);
        let allowed = body.level.value().plus(tolerance.into());
        if !self.restart && energy.exceeds(allowed) {
            self.restart = true;
            return true;
        }
        self.restart = false;
        let hats = model.hats.filter(|_| !body.awake.set.is_empty(model.slice_count()));
        let coarse = hats.map_or(TwoFloat::ZERO, |hats| {
            run(vectors, Restrict { hats, residual: body.residual, room: body.room });
            run(vectors, Solve { hats, room: body.room, held: body.held.len() })
        });
        // Only a product that bounds its move is worth that move.
        let hats = hats.filter(|_| coarse.hi > 0.0 && coarse.hi.is_finite());
        let coarse = if hats.is_some() { coarse } else { TwoFloat::ZERO };
        let level = *body.level;
        body.level.certify(energy.minus(decrease(fine, coarse)));
        let products = Products { rz: fine.plus(coarse).hi, rs: way.hi, rz_last: direction.hi };
        let [alpha, beta] = self.last.choose(products);
        let (awake, residual) = (&*body.awake, &*body.residual);
        let highest = if let Some(hats) = hats {
            let (mobility, room) = (model.mobility, &*body.room);
            #[rustfmt::skip]
            let step =
                CoarseStep { hats, mobility, room, published, at, before, residual, alpha, beta };
            let highest = run(vectors, step);
            body.awake.wake_all(model);
            highest.into_iter().fold(0.0, |peak, lane| if lane > peak { lane } else { peak })
        } else {
            let step = Step { model, awake, published, at, before, residual, alpha, beta };
            let moved = run(vectors, step);
            let has_moved = |cell: usize| {
                let last = before.get(cell);
                at.get(cell) != last || (last.is_some() && published.get(cell) != last)
            };
            body.awake.wake_neighbours(model, &moved.slices, has_moved);
            moved.peak
        };
        self.restore_held(body);
        if highest <= model.saturation() {
            return false;
        }
        *body.level = level;
        body.level.certify(energy);
        self.stay(body);
        true
    }

    /// Puts the held cells back where the tool has them, in all arrays.
    fn restore_held(&mut self, body: &mut Body<'_, '_>) {
        body.restore_held();
        for contact in body.held {
            let cell = contact.cell();
            if let Some(&position) = body.state.get(cell) {
                self.place(body.own, cell, position, body.links.model.saturation());
            }
        }
    }

    /// Some cell went beyond K: back to the point of this pass, whose energy was found to be
    /// within the level, and on with a step that saturates.
    fn stay(&mut self, body: &mut Body<'_, '_>) {
        let cells = body.state.len();
        if let Some((_, before)) = body.own.split_at_checked(cells) {
            copy(body.state, before);
        }
        self.saturated = true;
    }

    /// A plain step from the published point, saturating.
    fn plain(&mut self, body: &mut Body<'_, '_>) {
        let model = body.links.model;
        let k = model.saturation();
        body.awake.wake_all(model);
        body.awake.postpone_sleep();
        body.links.saturated_pass(&body.awake.set, body.state, body.residual, body.held);
        let next = |v: [f32; 3], r: Cell, mobility: f32| {
            let leak = mobility / model.resistance();
            let leak = if leak < 1.0 { leak } else { 1.0 };
            sub(add(v, scale(mobility, r.xyz())), scale(leak, sub(v, output(v, k))))
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
        self.saturated = highest > k || held > k;
        self.restart = true;
    }
}

/// What a step with these two inner products is certified to lower the energy by.
fn decrease(fine: TwoFloat, coarse: TwoFloat) -> TwoFloat {
    /// Room for the rounding of both products.
    const SURE: f32 = 0.5 - 1.0 / 1024.0;
    if coarse.hi > 0.0 {
        let way = sqrt(if fine.hi > 0.0 { fine.hi } else { 0.0 }) - sqrt(coarse.hi);
        TwoFloat::from(SURE * way * way)
    } else {
        fine.times_power_of_two(0.5)
    }
}

impl<const ROOM: usize> Scheme for Track<ROOM> {
    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_>) -> bool {
        if self.saturated {
            self.plain(body);
            false
        } else {
            self.extrapolated(body)
        }
    }

    fn place(&mut self, own: &mut [Cell], cell: usize, position: Cell, k: f32) {
        let cells = own.len() / 2;
        for at in [cell, cells + cell] {
            if let Some(slot) = own.get_mut(at) {
                *slot = position;
            }
        }
        self.saturated |= peak(position.xyz()) > k;
    }

    fn pushed(&mut self) {
        if self.last != Last::None {
            self.last = Last::Pushed;
        }
    }

    fn interrupt(&mut self) {
        self.restart = true;
    }

    fn has_moved(state: &[Cell], own: &[Cell], _residual: &[Cell], cell: usize) -> bool {
        let here = state.get(cell);
        here != own.get(cell) || (here.is_some() && here != own.get(state.len() + cell))
    }

    fn room(model: &Model<'_>, held: usize) -> usize {
        hats_room(model.hats(), held)
    }

    #[allow(private_interfaces)]
    fn hold(model: &Model<'_>, room: &mut [Eight], held: &[Contact]) {
        if let Some(hats) = &model.hats {
            hats::hold(model, hats, room, held);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_certified_decrease_is_that_of_the_better_part() {
        let certified = |fine: f32, coarse: f32| decrease(fine.into(), coarse.into()).hi;
        assert_eq!(certified(3.0, 0.0), 1.5);
        assert!(certified(0.0, 3.0) > 1.49 && certified(0.0, 3.0) < 1.5);
        assert_eq!(certified(2.0, 2.0), 0.0);
        assert!((certified(9.0, 1.0) - 2.0).abs() < 0.01);
    }
}
