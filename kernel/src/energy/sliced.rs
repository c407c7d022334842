//! One pass over slices: eight cells side by side.

#[cfg(feature = "relax")]
use core::marker::PhantomData;
use core::ops::Range;

use super::held::Contact;
#[cfg(feature = "relax")]
use super::links::number::LinkNumber;
use super::residual::{Terms, places};
use super::state::{States, StatesOf};
use super::surface::Pulled;
use super::term::{Here, Term, change_lane};
use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{Chunks, ChunksMut};
use crate::backend::{Work, run};
use crate::model::parts::PARTS;
use crate::model::terms::NoTerm;
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
    terms.list().prepare(&places(terms.model, at));
    update(terms, changed, at);
    let (slices, list) = (0..terms.model.slice_count(), || (terms.list(), terms.states));
    let held = terms.held();
    run(terms.vectors, SlicedResidual { awake, slices, at, residual, held, list, reduce });
    true
}

/// The same part by part, each with its own sums, for a body of several parts: the team runs them.
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
    terms.list().prepare(&places(terms.model, at));
    update(terms, awake, at);
    let (held, parts) = (terms.held(), terms.model.thread_parts());
    // Threads find the tools' contribution in the residuals.
    let list = terms.list_with(Pulled::put(terms.touch, awake, residual));
    let states = terms.states.shared();
    let list = move || (list, states.get());
    let mut arrays = parts.split_mut(residual).into_iter().zip(sums);
    let passes = parts.each(|slices| {
        let (residual, reduce) = arrays.next()?;
        Some(SlicedResidual { awake, slices, at, residual, held, list, reduce })
    });
    terms.team.run(terms.vectors, passes.map(Option::flatten));
    true
}

/// Updates the terms' states in the slices `changed`, part by part: the team runs several.
fn update(terms: Terms<'_, '_>, changed: &SliceSet, at: &[Cell]) {
    if !terms.states.any() {
        return;
    }
    let (team, vectors, division) = (terms.team, terms.vectors, terms.states.division());
    let (list, states) = (terms.list_with(NoTerm), terms.states.shared());
    let list = move || (list, states.get());
    if division.count() == 1 {
        let slices = terms.model.slice_count();
        run(vectors, Displace { slices: changed.iter(slices), cells: at, list });
        run(vectors, Update { slices: changed.iter(slices), at, list });
    } else {
        let displace = |slices| Displace { slices: changed.between(slices), cells: at, list };
        team.run(vectors, division.each(displace));
        let update = |slices| Update { slices: changed.between(slices), at, list };
        team.run(vectors, division.each(update));
    }
}

/// Stores the displacements of all cells at states within K, part by part: the team runs several.
pub(crate) fn displace(terms: Terms<'_, '_>, cells: &[Cell]) {
    if !takes_slices(terms, cells) {
        return terms.displace(0..terms.model.slice_count(), cells);
    }
    if terms.states.any() {
        let (list, states) = (terms.list_with(NoTerm), terms.states.shared());
        let list = move || (list, states.get());
        let works = terms.states.division().each(|slices| Displace { slices, cells, list });
        terms.team.run(terms.vectors, works);
    }
}

/// Stores the displacements of the cells in slices at the outputs of all states, as [`Terms::displace`] does.
#[cfg(feature = "relax")]
pub(crate) fn displace_outputs<N: LinkNumber>(
    terms: Terms<'_, '_, N>,
    slices: impl Iterator<Item = usize>,
    v: &[Cell<N>],
) {
    let Some(cells) = N::singles(v).filter(|_| terms.vectors.is_some()) else {
        return terms.displace(slices, v);
    };
    if terms.states.any() {
        let (list, states) = (terms.list(), terms.states);
        let saturation = terms.model.saturation();
        run(
            terms.vectors,
            DisplaceOutputs { slices, cells, saturation, list, states, numbers: PhantomData::<N> },
        );
    }
}

/// Returns true if unit and model support slices of these cells.
fn takes_slices(terms: Terms<'_, '_>, at: &[Cell]) -> bool {
    terms.vectors.is_some() && terms.model.slices.is_some() && at.len() == terms.model.cells()
}

/// Stores the displacements of the cells in slices.
struct Displace<'a, S, L> {
    slices: S,
    cells: &'a [Cell],
    list: L,
}

impl<'a, S: Iterator<Item = usize>, T: Term<f32>, L: Fn() -> (T, States<'a>)> Work
    for Displace<'a, S, L>
{
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let ((list, states), cells) = ((self.list)(), Chunks::new(self.cells, Cell::ZERO));
        for slice in self.slices {
            list.displace(slice, cells.at(slice), states.all());
        }
    }
}

/// Stores the displacements of the cells in slices, at the outputs of their states.
#[cfg(feature = "relax")]
struct DisplaceOutputs<'a, S, T, N> {
    slices: S,
    cells: &'a [Cell],
    saturation: f32,
    list: T,
    states: States<'a>,
    numbers: PhantomData<N>,
}

#[cfg(feature = "relax")]
impl<S: Iterator<Item = usize>, N: LinkNumber, T: Term<N>> Work for DisplaceOutputs<'_, S, T, N> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let (high, low) = (V::splat(self.saturation), V::splat(-self.saturation));
        let cells = Chunks::new(self.cells, Cell::ZERO);
        for slice in self.slices {
            let mut here = *cells.at(slice);
            for pair in 0..LANES / 2 {
                let lanes = V::pair(&here, pair);
                let lanes = V::select(lanes.below(low), low, lanes);
                V::select(lanes.above(high), high, lanes).put_pair(&mut here, pair);
            }
            self.list.displace(slice, &here, self.states.all());
        }
    }
}

/// Updates the terms' states of the cells in slices, to the displacements of all cells.
struct Update<'a, S, L> {
    slices: S,
    at: &'a [Cell],
    list: L,
}

impl<'a, S: Iterator<Item = usize>, T: Term<f32>, L: Fn() -> (T, States<'a>)> Work
    for Update<'a, S, L>
{
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let (list, states) = (self.list)();
        for slice in self.slices {
            V::apart(UpdateSlice { slice, at: self.at, list: &list, states: &states });
        }
    }
}

/// Updates the terms' states of the cells in a slice: some loops with many sums, which need all registers.
struct UpdateSlice<'s, 'a, T> {
    slice: usize,
    at: &'a [Cell],
    list: &'s T,
    states: &'s States<'a>,
}

impl<T: Term<f32>> Work for UpdateSlice<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        if let Some([from, to]) = self.states.step(self.slice) {
            self.list.update_slice::<V>(self.slice, self.at, from, to);
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
    /// Returns the terms and their states. A function, since a thread gets the states by it.
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
