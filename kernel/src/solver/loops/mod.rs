//! The loops over the cells, in the shape that suits number and machine.
//!
//! - `scalar`: cell by cell, for any number.
//! - `sliced`: eight cells side by side, `f32` on a vector unit.
//! - `vfp`: `f32` on the floating-point unit of Armv7E-M.
//! - `single`: the choice among them for `f32`.
//!
//! All give the same bits.

pub(crate) mod scalar;
mod single;
pub(crate) mod sliced;
#[cfg(test)]
mod tests;
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
mod vfp;

use fixed::types::I8F24;

use super::awake::Awake;
use super::coarse::{Coarse, CoarseTouch};
use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::energy::links::number::LinkNumber;
use crate::energy::residual::Terms;
use crate::model::Model;
use crate::model::coarse_basis::CoarseBasis;
use crate::model::parts::{PARTS, Parts};
use crate::number::cell::Cell;
use crate::number::two_float::{Eight, TwoFloat};

/// The arrays of `track`.
pub struct Points<'a, N> {
    /// The published point x.
    pub published: &'a mut [Cell<N>],
    /// The point y of this pass.
    pub at: &'a mut [Cell<N>],
    /// The point of the pass before.
    pub before: &'a mut [Cell<N>],
    /// The residual at y.
    pub residual: &'a mut [Cell<N>],
}

impl<N> Points<'_, N> {
    /// The same arrays, for a shorter lifetime.
    #[inline(always)]
    pub(crate) fn reborrow(&mut self) -> Points<'_, N> {
        let Points { published, at, before, residual } = self;
        Points { published, at, before, residual }
    }

    /// The arrays of the body's parts, with their numbers.
    pub(crate) fn parts(&mut self, parts: Parts) -> [Option<(usize, Points<'_, N>)>; PARTS] {
        let others = [&mut *self.at, &mut *self.before, &mut *self.residual];
        let [mut at, mut before, mut residual] =
            others.map(|array| parts.split_mut(array).into_iter().enumerate());
        parts.split_mut(self.published).map(|published| {
            let (part, at) = at.next().filter(|(part, _)| *part < parts.count())?;
            let (before, residual) = (before.next()?.1, residual.next()?.1);
            Some((part, Points { published, at, before, residual }))
        })
    }
}

/// Result of an update. It is a kilobyte, so updates write it in place.
pub(crate) struct Moved {
    /// Slices whose cells moved and whose neighbours may be asleep.
    pub slices: SliceSet,
    /// True if some coordinate is beyond K.
    pub beyond: bool,
}

impl Moved {
    pub const NOTHING: Self = Self { slices: SliceSet::EMPTY, beyond: false };

    /// Adds the result of another update.
    pub fn unite(&mut self, other: &Self) {
        self.slices.unite(&other.slices);
        self.beyond |= other.beyond;
    }

    /// Compares the largest magnitudes by lane with K.
    #[inline(always)]
    pub fn reach<V: F32x8>(&mut self, peak: V, k: f32) {
        self.beyond |= V::any(peak.above(V::splat(k)));
    }
}

/// The loops over links and cells, in the shape that suits number and machine; sealed.
#[allow(private_interfaces)]
pub trait Loops: LinkNumber {
    /// True if the coarse level of a model is used; without it `track` uses only the residuals of the cells.
    const COARSE: bool;

    /// One pass at the states `v`: updates the terms' states in the slices `changed`, then computes the
    /// residuals of awake slices, those of held cells 0. Returns the energy in internal units.
    fn residual(
        terms: Terms<'_, '_, Self>,
        changed: &SliceSet,
        awake: &SliceSet,
        v: &[Cell<Self>],
        residual: &mut [Cell<Self>],
    ) -> TwoFloat {
        terms.update(changed, v);
        terms.energy(awake, v, residual)
    }

    /// One pass of `track` at y: energy, r . r / W, r . s and r . `z_last`.
    fn track_residual(
        terms: Terms<'_, '_, Self>,
        awake: &SliceSet,
        points: &mut Points<'_, Self>,
    ) -> [TwoFloat; 4] {
        scalar::track::residual(terms, awake, points)
    }

    /// The same with an elastic level: `z_last` is the local part of the last direction, and the fifth sum is
    /// r . (local part of the direction).
    fn elastic_residual(
        terms: Terms<'_, '_, Self>,
        awake: &SliceSet,
        points: &mut Points<'_, Self>,
    ) -> [TwoFloat; 5] {
        scalar::track::residual(terms, awake, points)
    }

    /// The update of `track` without a coarse level; writes the result to `moved`.
    fn track_step(
        terms: Terms<'_, '_, Self>,
        awake: &Awake,
        points: &mut Points<'_, Self>,
        factors: [f32; 2],
        moved: &mut Moved,
    ) {
        scalar::track::step(terms, awake, points, factors, moved);
    }

    /// Computes the coarse part of the direction in the coarse memory. Returns its inner product with the
    /// residual.
    fn coarse(
        terms: Terms<'_, '_, Self>,
        residual: &[Cell<Self>],
        room: &mut [Eight],
        coarse: Coarse,
    ) -> TwoFloat {
        let _ = (terms, residual, room, coarse);
        TwoFloat::ZERO
    }

    /// The update of `track` with the coarse part from the coarse memory. Returns true if some coordinate is
    /// beyond K.
    fn coarse_step(
        terms: Terms<'_, '_, Self>,
        room: &[Eight],
        points: &mut Points<'_, Self>,
        factors: [f32; 2],
    ) -> bool {
        let _ = (terms, room, points, factors);
        false
    }

    /// Computes the direction of an elastic level in the coarse memory, with `corrections` corrections for
    /// held cells and with tools, if any. Returns its inner products with the residual and with the last one.
    fn elastic(
        terms: Terms<'_, '_, Self>,
        residual: &[Cell<Self>],
        room: &mut [Eight],
        corrections: usize,
        touch: Option<&CoarseTouch>,
    ) -> [TwoFloat; 2] {
        let _ = (terms, residual, room, corrections, touch);
        [TwoFloat::ZERO; 2]
    }

    /// v += step r of the free cells in awake slices; writes the result to `moved`.
    fn euler_step(
        terms: Terms<'_, '_, Self>,
        awake: &Awake,
        state: &mut [Cell<Self>],
        residual: &[Cell<Self>],
        step: f32,
        moved: &mut Moved,
    ) {
        scalar::euler::step(terms.model, awake, state, residual, step, moved);
    }
}

impl Loops for I8F24 {
    const COARSE: bool = false;
}

/// The coarse basis of the model, if the number type uses it.
pub(crate) fn coarse_basis<'m, N: Loops>(model: &Model<'m>) -> Option<CoarseBasis<'m>> {
    model.coarse_basis.filter(|_| N::COARSE)
}
