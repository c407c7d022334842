//! `track`: follows the equilibrium as fast as the guard allows, by conjugate directions, and with a coarse
//! level if the model has one.
//!
//! With y the point of a pass, r its residual, W the cells' weights, and P, B the coarse basis with its
//! inverse ([`coarse`](crate::solver::coarse)), the preconditioned residual is
//!
//! ```text
//! z = r / W + P B P' r
//! ```
//!
//! The published point is x = y + z. The next pass is at y' = y + alpha z + beta s with s the step from the
//! last y to this one, both factors from the local quadratic model ([`conjugate`]).
//!
//! **The guard.** Half the squared distance to a set curves upwards by at most one, so for every displacement
//! d of the cells E(y + d) <= E(y) - r . d + d' L d / 2, L the Laplacian of weight w / 2. Let a = r . r / W
//! and b = r . P B P' r. For the two parts of z: `d1' L d1` <= a and `d2' L d2` <= b (the largest eigenvalue
//! of L / W is at most 1; B is at most the inverse of P' L P). By the triangle inequality z' L z <= (sqrt a +
//! sqrt b)^2, hence
//!
//! ```text
//! E(x) <= U' = E(y) - (a + b) + (sqrt a + sqrt b)^2 / 2 = E(y) - (sqrt a - sqrt b)^2 / 2
//! ```
//!
//! which without a coarse level is E(y) - a / 2. If E(y) > U + tol, with U the level of the last x, the pass
//! is discarded and the next one starts at x itself, accepted without comparison. Only x is published, never
//! y, and its energy never exceeds U but for rounding; tol is half of the allowance for it
//! ([`Rounding`](crate::Rounding)).
//!
//! **An elastic level** ([`elastic`](crate::solver::coarse::elastic)), for nodal shapes, gives a direction z
//! without a proven bound. The pass at y' is judged like any other; the published point is x = y + r / W, U'
//! = E(y) - a / 2.
//!
//! A state beyond K is handled by plain steps from x. Their clamped displacements D lower E by at least the
//! sum of r . D - `W_i` |D|^2 / 2; the leak per step is min(1, 1 / (`W_i` `R_x`)).
//!
//! Cost: one link pass, one pass over the cells, two arrays besides state and residual; with a
//! coarse level its restriction, product and prolongation.

use core::marker::PhantomData;

use super::Dynamics;
use super::coarse::elastic::elastic_room;
use super::coarse::elastic_held::{self, elastic_held_room, is_corrected};
use super::coarse::held::{self, coarse_room};
use super::coarse::resistance::{resist, tool_room};
use super::coarse::{Coarse, CoarseTouch};
use super::conjugate::{BOUNDED, Guess, Last, OF_SPHERE, PUSHED, PUSHED_BY_SPHERE, Products};
use super::guard::{Pass, discards};
use super::loops::{Loops, Moved, Points, coarse_basis};
use super::scheme::{Body, Memory, Scheme, UNKNOWN};
use crate::backend::slices::copy;
use crate::energy::held::Contact;
use crate::energy::residual::Terms;
use crate::model::Model;
use crate::model::coarse_basis::ElasticLevel;
use crate::number::Sum;
use crate::number::cell::{Cell, add, output, peak, scale, sub};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::number::two_float::{Eight, LANES, TwoFloat};

kept! {
    /// State of the scheme; `ROOM` blocks of eight `f32` of memory for the model's coarse level, `N`
    /// the numbers of cells and links.
    ///
    /// ```
    /// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, include_model};
    /// use chaincell_kernel::{I8F24, Track};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// # let network = Network::new(model, Settings::for_model(&model))?;
    /// let mut float = Tissue::<128, Track>::new();
    /// let mut fixed = Tissue::<128, Track<0, I8F24>>::new(); // for targets without an FPU
    /// float.reset(&network)?;
    /// fixed.reset(&network)?;
    /// # (float.choose_contacts(&network, &[47])?, fixed.choose_contacts(&network, &[47])?);
    /// # let mut forces_n = [0.0; 2];
    /// for depth_m in [0.0, 0.002, 0.004] {
    ///     let pose = [ToolPose::at([0.0, 0.0, -depth_m].into(), 1)];
    ///     let a = float.tick(&network, &pose, Budget::All);
    ///     let b = fixed.tick(&network, &pose, Budget::All);
    /// #     forces_n = [a.force_n.z, b.force_n.z];
    ///     assert!((a.force_n.z - b.force_n.z).abs() < 1e-6); // [N]
    /// }
    /// # assert!(forces_n[0] > 0.01, "{forces_n:?}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Track<const ROOM: usize = 0, N = f32> {
        last: Last,
        /// Curvature estimate of an elastic level's direction.
        guess: Guess,
        /// True while extrapolating; otherwise the next pass starts at the published point and is accepted.
        going: bool,
        /// True if some state is beyond K.
        saturated: bool,
        /// Number of corrections of an elastic level for the chosen cells, stored in the coarse memory.
        corrections: u32,
        number: PhantomData<N>,
    }
}

impl<const ROOM: usize, N: Loops> Dynamics for Track<ROOM, N> {
    const NAME: &'static str = "track";
    const REST: Self = Self {
        last: Last::None,
        guess: Guess::REST,
        going: false,
        saturated: false,
        corrections: 0,
        number: PhantomData,
    };
    const IS_ANYTIME: bool = true;
    const TAKES_SHAPES: bool = N::TAKES_SHAPES;
    const TAKES_SURFACES: bool = N::TAKES_SHAPES;
    const ARRAYS: usize = 2;
    type Arrays<const CELLS: usize> = [[Cell<N>; CELLS]; 2];
    type Room = [Eight; ROOM];

    fn stilled(self) -> Self {
        Self { corrections: self.corrections, ..Self::REST }
    }
}

impl<const ROOM: usize, N: Loops> Track<ROOM, N> {
    /// Returns true if the next pass is at an extrapolated point.
    pub(super) fn is_going(&self) -> bool {
        self.going && !self.saturated
    }

    /// Number of corrections of an elastic level for the chosen cells.
    pub(super) fn corrections(&self) -> usize {
        self.corrections as usize
    }

    /// Restarts from the published point, copied to the scheme's arrays: the guard judges the next pass. Does
    /// nothing if some state is beyond K.
    pub(super) fn go_from(&mut self, state: &[Cell<N>], own: &mut [Cell<N>]) {
        if !self.saturated {
            own.chunks_mut(state.len().max(1)).take(2).for_each(|array| copy(array, state));
            (self.going, self.last) = (true, Last::None);
        }
    }

    /// Makes a pass at the extrapolated point. Returns true if the guard discarded it.
    fn extrapolated(&mut self, body: &mut Body<'_, '_, N>) -> bool {
        let model = body.terms.model;
        let cells = body.state.len();
        let Some((at, before)) = body.own.split_at_mut_checked(cells) else { return false };
        let (published, residual) = (&mut *body.state, &mut *body.residual);
        // Start at the published point, or save the terms' states for a rollback.
        if !self.going {
            copy(at, published);
            copy(before, published);
            self.last = Last::None;
        } else {
            body.terms.states.save(&body.awake.set, model.slice_count());
        }
        // Compute residual, energy and inner products.
        let points = &mut Points { published, at, before, residual };
        let (terms, awake) = (body.terms, &body.awake.set);
        let [energy, sums @ ..] = if elastic_level::<N>(model).is_some() {
            N::elastic_residual(terms, awake, points)
        } else {
            let pass = N::track_residual(terms, awake, points);
            let [energy, fine, way, direction] = pass;
            [energy, fine, way, direction, fine]
        };
        // Discard a pass above the level, and adjust the curvature estimate.
        let potential = body.terms.potential(energy, points.at);
        let pass = Pass { at: points.at, residual: points.residual, energy, potential };
        if self.going && discards(body.terms, body.level, &pass) {
            self.going = false;
            // After a tool push the pass says less about the stiffness.
            match self.last == Last::Pushed && body.terms.touch.get().is_some() {
                true => self.guess.judge_pushed(),
                false => self.guess.judge(true),
            }
            body.terms.states.restore(&body.awake.set, model.slice_count());
            return true;
        }
        // Choose the step, certify the level and update the points.
        self.going = true;
        let coarse = body.coarse.filter(|_| !body.awake.set.is_empty(model.slice_count()));
        let step =
            self.choose(terms, sums, points.residual, (&mut *body.room, coarse, body.coarse_touch));
        let level = *body.level;
        body.level.certify(potential.minus(step.certain));
        let beyond = if step.is_coarse {
            body.awake.wake_all(model);
            N::coarse_step(body.terms, body.room, points, step.factors)
        } else {
            let mut moved = Moved::NOTHING;
            N::track_step(body.terms, body.awake, points, step.factors, &mut moved);
            let Points { published, at, before, .. } = points;
            let has_moved = |cell: usize| {
                let last = before.get(cell);
                at.get(cell) != last || (last.is_some() && published.get(cell) != last)
            };
            body.awake.wake_neighbours(model, &moved.slices, has_moved);
            moved.beyond
        };
        // Beyond K: return to the point of this pass.
        self.restore_held(body);
        *body.off_balance = if beyond { UNKNOWN } else { step.off_balance };
        if !beyond {
            return false;
        }
        *body.level = level;
        body.level.certify(potential);
        self.stay(body);
        true
    }

    /// Chooses the step, and leaves the coarse part of the direction in the coarse memory; `sums` are r . r /
    /// W, r . s, r . `z_last` and r . (local part of the direction).
    #[inline(always)]
    fn choose(
        &mut self,
        terms: Terms<'_, '_, N>,
        [fine, way, direction, own]: [TwoFloat; 4],
        residual: &[Cell<N>],
        (room, coarse, touch): (&mut [Eight], Option<Coarse>, Option<&CoarseTouch>),
    ) -> Chosen {
        let (model, rs) = (terms.model, way.hi);
        // An elastic level: the direction has no certificate.
        if coarse.is_some() && elastic_level::<N>(model).is_some() {
            let corrections = match coarse {
                Some(Coarse::Corrected(held)) if held > 0 => self.corrections(),
                _ => 0,
            };
            let [product, mixed] = N::elastic(terms, residual, room, corrections, touch);
            let is_finite = product.hi.is_finite() && mixed.hi.is_finite();
            let [product, mixed] = if is_finite { [product, mixed] } else { [TwoFloat::ZERO; 2] };
            if !is_finite {
                room.fill([0.0; LANES]);
            }
            // A body at rest gives no information on its stiffness; asleep it makes no such pass.
            if fine.hi > 0.0 {
                match terms.touch.get() {
                    Some(_) => self.guess.fall_back(),
                    None => self.guess.judge(false),
                }
            }
            let (rz, rz_last) = (own.plus(product).hi, direction.plus(mixed).hi);
            let products = Products { rz, rs, rz_last };
            let guess = self.guess.value();
            let factors = match terms.touch.get() {
                Some(_) => self.last.choose(products, guess + OF_SPHERE, PUSHED_BY_SPHERE),
                None => self.last.choose(products, guess, PUSHED),
            };
            let certain = decrease(fine, TwoFloat::ZERO);
            let off_balance = if is_finite && rz >= 0.0 { rz } else { UNKNOWN };
            return Chosen { certain, factors, is_coarse: rz > 0.0, off_balance };
        }
        // A coarse level of links, or none: the direction is certified.
        let coarse = match coarse {
            Some(coarse) if coarse_basis::<N>(model).is_some() => {
                N::coarse(terms, residual, room, coarse)
            }
            _ => TwoFloat::ZERO,
        };
        // A product that is not finite bounds no step: that part is left out.
        let coarse = if coarse.hi.is_finite() { coarse } else { TwoFloat::ZERO };
        let products = Products { rz: fine.plus(coarse).hi, rs, rz_last: direction.hi };
        let factors = self.last.choose(products, BOUNDED, PUSHED);
        // A sleeping body is in balance.
        let off_balance = if fine.hi > 0.0 { UNKNOWN } else { 0.0 };
        let certain = decrease(fine, coarse);
        Chosen { certain, factors, is_coarse: coarse.hi > 0.0, off_balance }
    }

    /// Restores the held cells to the tool's displacement, in all arrays.
    fn restore_held(&mut self, body: &mut Body<'_, '_, N>) {
        body.restore_held();
        for contact in body.terms.held() {
            let cell = contact.cell();
            if let Some(&position) = body.state.get(cell) {
                self.place(body.own, cell, position, body.terms.model.saturation());
            }
        }
    }

    /// Some cell went beyond K: returns to the point of this pass, whose energy is within the level; the next
    /// step saturates.
    fn stay(&mut self, body: &mut Body<'_, '_, N>) {
        let cells = body.state.len();
        if let Some((_, before)) = body.own.split_at_checked(cells) {
            copy(body.state, before);
        }
        self.saturated = true;
    }

    /// A plain step from the published point, with saturation.
    fn plain(&mut self, body: &mut Body<'_, '_, N>) {
        let model = body.terms.model;
        let k = N::from_single(model.saturation());
        body.awake.wake_all(model);
        body.awake.postpone_sleep();
        // Energy and residual at the outputs.
        let energy = body.terms.saturated_energy(&body.awake.set, body.state, body.residual);
        let potential = body.terms.potential(energy, body.state);
        let next = |v: [N; 3], r: Cell<N>, mobility: f32| {
            let leak = mobility / model.resistance();
            let leak = N::from_single(if leak < 1.0 { leak } else { 1.0 });
            let moved = add(v, scale(N::from_single(mobility), r.xyz()));
            sub(moved, scale(leak, sub(v, output(v, k))))
        };
        // Update the cells, and sum the certain decrease of the energy.
        let mut falls = N::Sum::default();
        let (mut highest, still) = (N::ZERO, [N::ZERO; 3]);
        let cells =
            body.state.iter_mut().zip(&*body.residual).zip(body.terms.mobility()).enumerate();
        for (cell, ((v, &r), &mobility)) in cells {
            if mobility > 0.0 {
                let to = next(v.xyz(), r, mobility);
                if r.xyz() != still {
                    // r . D - W |D|^2 / 2, D the clamped displacement.
                    let way = sub(output(to, k), output(v.xyz(), k));
                    let half = scale(N::from_single(0.5 / mobility), way);
                    falls.add(cell % LANES, N::inner(way, sub(r.xyz(), half)));
                }
                *v = Cell::at(to);
            }
            let here = peak(v.xyz());
            highest = if here > highest { here } else { highest };
        }
        body.level.certify(potential.minus(sure(falls.total())));
        self.saturated = body.restore_held() | (highest > k);
        self.going = false;
    }
}

/// The step after a pass.
struct Chosen {
    /// Certified decrease of the energy at the published point.
    certain: TwoFloat,
    /// alpha and beta.
    factors: [f32; 2],
    /// True if the direction has a coarse part, stored in the coarse memory.
    is_coarse: bool,
    /// r . z, see [`Body::off_balance`].
    off_balance: f32,
}

/// The elastic level of a model, if the number type uses it.
#[inline(always)]
fn elastic_level<'m, N: Loops>(model: &Model<'m>) -> Option<ElasticLevel<'m>> {
    coarse_basis::<N>(model)?.elastic()
}

/// Margin for the rounding of a sum of products: the certain share of it.
const SURE: f32 = 1.0 - 1.0 / 512.0;

/// The certain part of a decrease.
fn sure(fall: TwoFloat) -> TwoFloat {
    let fall = if fall.hi > 0.0 { SURE * fall.hi } else { fall.hi / SURE };
    fall.into()
}

/// Certified decrease of the energy for a step with these two inner products.
fn decrease(fine: TwoFloat, coarse: TwoFloat) -> TwoFloat {
    let fine = if fine.hi > 0.0 { fine.hi } else { 0.0 };
    if coarse.hi > 0.0 {
        let way = sqrt(fine) - sqrt(coarse.hi);
        TwoFloat::from(0.5 * SURE * way * way)
    } else {
        TwoFloat::from(0.5 * SURE * fine)
    }
}

impl<const ROOM: usize, N: Loops> Scheme for Track<ROOM, N> {
    type Number = N;

    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_, N>) -> bool {
        if self.saturated {
            *body.off_balance = UNKNOWN;
            self.plain(body);
            false
        } else {
            self.extrapolated(body)
        }
    }

    fn place(&mut self, own: &mut [Cell<N>], cell: usize, position: Cell<N>, k: f32) {
        let cells = own.len() / 2;
        for at in [cell, cells + cell] {
            if let Some(slot) = own.get_mut(at) {
                *slot = position;
            }
        }
        self.saturated |= peak(position.xyz()) > N::from_single(k);
    }

    fn pushed(&mut self) {
        if self.last != Last::None {
            self.last = Last::Pushed;
        }
    }

    fn interrupt(&mut self) {
        self.going = false;
    }

    fn next_points<'a>(&self, own: &'a [Cell<N>], cells: usize) -> Option<&'a [Cell<N>]> {
        own.get(..cells).filter(|_| self.is_going())
    }

    fn has_moved(state: &[Cell<N>], own: &[Cell<N>], _residual: &[Cell<N>], cell: usize) -> bool {
        let here = state.get(cell);
        here != own.get(cell) || (here.is_some() && here != own.get(state.len() + cell))
    }

    fn room(model: &Model<'_>, held: usize) -> usize {
        coarse_basis::<N>(model).map_or(0, |basis| match basis.elastic() {
            None => coarse_room(basis.count, held),
            Some(_) if is_corrected(model, &basis, held) => {
                elastic_held_room(basis.count, held) + 3 * basis.side_blocks()
            }
            Some(_) => Self::tool_room(model),
        })
    }

    fn tool_room(model: &Model<'_>) -> usize {
        coarse_basis::<N>(model).map_or(0, |basis| match basis.elastic() {
            None => tool_room(basis.count),
            Some(_) => elastic_room(basis.count) + 3 * basis.side_blocks(),
        })
    }

    fn resist(
        model: &Model<'_>,
        room: &mut [Eight],
        cells: impl Iterator<Item = (usize, f32)>,
    ) -> Option<u16> {
        let basis = coarse_basis::<N>(model).filter(|basis| basis.elastic().is_none());
        basis.map_or(Some(0), |basis| resist(&basis, room, cells))
    }

    #[allow(private_interfaces)]
    fn hold(&mut self, model: &Model<'_>, memory: Memory<'_, N>, held: &[Contact<N>]) {
        let Some(basis) = &coarse_basis::<N>(model) else { return };
        if basis.elastic().is_none() {
            held::hold(model, basis, memory.room, held);
        } else {
            self.corrections = elastic_held::hold(model, basis, memory.room, held) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_certified_decrease_is_that_of_the_better_part() {
        let certified = |fine: f32, coarse: f32| decrease(fine.into(), coarse.into()).hi;
        assert!(certified(3.0, 0.0) > 1.49 && certified(3.0, 0.0) < 1.5);
        assert!(certified(0.0, 3.0) > 1.49 && certified(0.0, 3.0) < 1.5);
        assert_eq!(certified(2.0, 2.0), 0.0);
        assert!((certified(9.0, 1.0) - 2.0).abs() < 0.01);
    }
}
