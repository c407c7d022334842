//! One pass over slices: eight cells side by side.

use core::ops::Range;

use super::held::Contact;
use super::residual::{Terms, places};
use super::state::{States, StatesOf};
use super::surface::Pulled;
use super::term::{Here, Term, change_lane};
use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{Chunks, ChunksMut};
use crate::backend::{Work, run};
use crate::model::parts::{self, PARTS};
use crate::number::cell::Cell;
use crate::number::two_float::{LANES, Lanes, TwoFloat};

/// Sums that a pass computes in addition to the residuals, eight cells at a time.
pub(crate) trait Reduce {
    /// Adds the terms of a slice: its cells' positions, and their residuals with contact cells driven.
    fn slice<V: F32x8>(&mut self, slice: usize, at: [V; 3], residual: [V; 4]);
}

/// Only the energy.
#[derive(Default)]
pub(crate) struct Energy(Lanes);

impl Reduce for Energy {
    #[inline(always)]
    fn slice<V: F32x8>(&mut self, _slice: usize, _at: [V; 3], [_, _, _, wd2]: [V; 4]) {
        self.0.add(wd2);
    }
}

impl Energy {
    /// E in internal units.
    pub fn total(&self) -> TwoFloat {
        self.0.total().times_power_of_two(0.125)
    }
}

/// The pass over slices, after an update of the terms' states in the slices `changed`. Returns false if unit
/// or model do not support it. The states must be within K.
pub(crate) fn residual(
    terms: Terms<'_, '_>,
    changed: &SliceSet,
    awake: &SliceSet,
    at: &[Cell],
    residual: &mut [Cell],
    reduce: &mut impl Reduce,
) -> bool {
    if !takes_slices(terms, at) {
        return false;
    }
    update(terms, changed, at);
    let (slices, list) = (0..terms.model.slice_count(), || (terms.list(), terms.states));
    let held = terms.held();
    run(terms.vectors, SlicedResidual { awake, slices, at, residual, held, list, reduce });
    true
}

/// The same part by part, each with its own sums, for a body of several parts. If terms keep states, the
/// calling thread does all the work.
pub(crate) fn residual_in_parts(
    terms: Terms<'_, '_>,
    awake: &SliceSet,
    at: &[Cell],
    residual: &mut [Cell],
    sums: &mut [impl Reduce + Send; PARTS],
) -> bool {
    if !takes_slices(terms, at) {
        return false;
    }
    update(terms, awake, at);
    let (vectors, held, cells) = (terms.vectors, terms.held(), at.len());
    // Terms with states: the calling thread runs the parts in turn.
    if terms.states.any() {
        let list = || (terms.list(), terms.states);
        for (part, (residual, reduce)) in
            parts::split_mut(residual).into_iter().zip(sums).enumerate()
        {
            let slices = parts::slices(cells, part);
            run(vectors, SlicedResidual { awake, slices, at, residual, held, list, reduce });
        }
        return true;
    }
    // Otherwise the team runs the parts, and finds the tools' contribution in the residuals: threads share no
    // other memory.
    let list = terms.list_with(Pulled::put(terms.touch, awake, residual));
    let list = || (list, States::NONE);
    let mut each = parts::split_mut(residual).into_iter().zip(sums).enumerate();
    let passes = [(); PARTS].map(|()| {
        let (part, (residual, reduce)) = each.next()?;
        let slices = parts::slices(cells, part);
        Some(SlicedResidual { awake, slices, at, residual, held, list, reduce })
    });
    terms.team.run(vectors, passes);
    true
}

/// Stores the displacements of all cells at states within K.
pub(crate) fn displace(terms: Terms<'_, '_>, at: &[Cell]) {
    if takes_slices(terms, at) {
        run(terms.vectors, Displace { terms, at });
    } else {
        terms.displace(0..terms.model.slice_count(), at);
    }
}

/// Stores the displacements of all cells, slice by slice where they are.
struct Displace<'a, 'm> {
    terms: Terms<'a, 'm>,
    at: &'a [Cell],
}

impl Work for Displace<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let (list, cells) = (self.terms.list(), Chunks::new(self.at, Cell::ZERO));
        for slice in (0..self.terms.model.slice_count()).filter(|_| self.terms.states.any()) {
            list.displace(slice, cells.at(slice), self.terms.states.all());
        }
    }
}

/// Returns true if unit and model support slices of these cells.
fn takes_slices(terms: Terms<'_, '_>, at: &[Cell]) -> bool {
    terms.vectors.is_some() && terms.model.slices.is_some() && at.len() == terms.model.cells()
}

/// Prepares the terms for a pass, and updates their states of the cells in awake slices.
fn update(terms: Terms<'_, '_>, awake: &SliceSet, at: &[Cell]) {
    terms.list().prepare(&places(terms.model, at));
    if terms.states.any() {
        run(terms.vectors, Update { terms, awake, at });
    }
}

/// Updates the terms' states of the cells in awake slices to their positions.
struct Update<'a, 'm> {
    terms: Terms<'a, 'm>,
    awake: &'a SliceSet,
    at: &'a [Cell],
}

impl Work for Update<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let (list, cells) = (self.terms.list(), Chunks::new(self.at, Cell::ZERO));
        let (slices, states) = (self.terms.model.slice_count(), self.terms.states);
        for slice in self.awake.iter(slices) {
            list.displace(slice, cells.at(slice), states.all());
        }
        for slice in self.awake.iter(slices) {
            if let Some([from, to]) = states.step(slice) {
                list.update_slice::<V>(slice, self.at, from, to);
            }
        }
    }
}

/// A pass over the awake slices of a range, with its sums.
pub(crate) struct SlicedResidual<'a, R, L> {
    pub awake: &'a SliceSet,
    /// A part of the body.
    pub slices: Range<usize>,
    pub at: &'a [Cell],
    /// Residuals of the cells in these slices.
    pub residual: &'a mut [Cell],
    /// Cells that do not move, in ascending order.
    pub held: &'a [Contact],
    /// Returns the terms and their states. A function, since threads share no states.
    pub list: L,
    pub reduce: &'a mut R,
}

impl<'a, R: Reduce, T: Term<f32>, L: Fn() -> (T, States<'a>)> Work for SlicedResidual<'a, R, L> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Self { at, reduce, .. } = self;
        let (list, states) = (self.list)();
        let states: StatesOf<'_> = states.all();
        let (cells, mut residual) = (Chunks::repeated(at), ChunksMut::new(self.residual));
        let (first, mut held) = (self.slices.start, self.held);
        for slice in self.awake.iter_in(self.slices) {
            let [x, y, z, _] = V::transposed(cells.at(slice));
            let (cells, mut sum) = ([x, y, z], [V::splat(0.0); 4]);
            let before = || *residual.seen(slice - first);
            list.slice(Here { slice, cells, at }, &before, &mut sum, states);
            while let [contact, others @ ..] = held
                && contact.cell() < (slice + 1) * LANES
            {
                held = others;
                // Cells of slices that sleep are passed over.
                if let Some(lane) = contact.cell().checked_sub(slice * LANES) {
                    change_lane(&mut sum, lane, |r| Cell([0.0, 0.0, 0.0, r.w()]));
                }
            }
            reduce.slice(slice, cells, sum);
            V::put_transposed(sum, residual.at(slice - first));
        }
        residual.finish();
    }
}
