//! A term besides the links: its part in a tick, in a pass, and at the cells that the tool moves.
//!
//! **State.** A term may keep a state of each cell. The energy is then a function of positions and states. A
//! tick changes states in two places, each cell's from the positions of any cells and from its own state
//! only:
//!
//! - [`Term::begin_tick`], once before anything else: a correction, such as a linear part of residual and
//!   energy, that is constant through all sweeps. It may change the energy, which must stay at least 0, and
//!   returns the change.
//! - [`Term::update`], before each pass over the residuals, after [`Term::displace`]. It must never raise the energy, nor change a
//!   state where the term's energy is 0: such a cell may sleep.
//!
//! So for fixed states the bound L holds as for any term, and the energy falls in every sweep. If the guard
//! discards a pass, its updates are discarded too: the states are then those of the published positions.
//!
//! The list of the terms is that of `model::others`. All of it is resolved when the kernel is
//! compiled: a term that is not in the list costs nothing.

use core::ops::Range;

use super::held::{Contact, Touched};
use super::number::TermNumber;
use super::state::{CellState, Nothing, Quads, SliceMemory, StatesOf};
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::model::terms::NoTerm;
use crate::number::cell::Cell;

/// A term besides the links. Positions are given as states v with a function for their outputs; `states` are
/// the term's states of the cells.
pub(crate) trait Term: Copy {
    /// The term's state of a cell; [`Nothing`] if it has none.
    type State: CellState;

    /// Returns true if [`Self::begin_tick`] may change a state of this body.
    #[inline(always)]
    fn corrects(self) -> bool {
        false
    }
    /// The state of a cell at the start of a tick at the outputs `at`, and the change of the energy, in
    /// internal units.
    fn begin_tick(
        self,
        cell: usize,
        state: Self::State,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> (Self::State, f64);
    /// Stores the displacements of the cells of a slice, which are at `here`, and clears their forces. A pass
    /// does so for all its slices before the first update; the displacements of other slices stay.
    #[inline(always)]
    fn displace(self, _slice: usize, _here: &Chunk, _quads: Quads<'_>) {}
    /// Stores the states of the cells of a slice for a pass at the outputs `at`.
    #[inline(always)]
    fn update(
        self,
        _cells: Range<usize>,
        _at: &impl Fn(usize) -> [f32; 3],
        _from: SliceMemory<'_>,
        _to: SliceMemory<'_>,
    ) {
    }
    /// The same eight cells side by side, at v within K; the same bits.
    #[inline(always)]
    fn update_slice<V: F32x8>(
        self,
        slice: usize,
        at: &[Cell],
        from: SliceMemory<'_>,
        to: SliceMemory<'_>,
    ) {
        let place = |cell: usize| at.get(cell).map_or([0.0; 3], |cell| cell.xyz());
        self.update(cells_of(slice, at.len()), &place, from, to);
    }
    /// Adds the term to the residuals of awake slices, cell by cell.
    fn accumulate<N: TermNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        output: &impl Fn([N; 3]) -> [N; 3],
        states: StatesOf<'_, Self::State>,
    );
    /// Adds the term to the residuals of a slice whose states v are within K; the same bits.
    fn slice<V: F32x8>(
        self,
        slice: usize,
        at: &[Cell],
        sum: &mut [V; 4],
        states: StatesOf<'_, Self::State>,
    );
    /// Adds the residual of the term at a cell, at the outputs `at`, in single precision.
    fn cell<N: TermNumber>(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_, Self::State>,
        add: &mut impl FnMut([f32; 3]),
    );
    /// Adds the term's energy at the held cells.
    fn touched<N: TermNumber>(
        self,
        held: &[Contact<N>],
        output: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_, Self::State>,
        sums: &mut Touched,
    );
    /// Adds the second derivative of the energy at rest times a small displacement of the cells; nothing for a
    /// term that does not replace the links.
    fn resist(self, _field: &[Cell], _product: &mut [Cell]) {}
    /// The rotation of a cell as a unit quaternion, real part first; `None` if its state has none.
    #[inline(always)]
    fn turn(self, _cell: usize, _states: StatesOf<'_, Self::State>) -> Option<[f32; 4]> {
        None
    }
    /// Adds w |D|^2, `squared` = |D|^2, for a cell that moves by D: the root of the energy rises by at most
    /// half the root of that sum over all moving cells.
    fn add_move(self, cell: usize, squared: f32, sum: f32) -> f32;
}

impl Term for NoTerm {
    type State = Nothing;

    #[inline(always)]
    fn begin_tick(
        self,
        _: usize,
        state: Nothing,
        _: &impl Fn(usize) -> [f32; 3],
    ) -> (Nothing, f64) {
        (state, 0.0)
    }

    #[inline(always)]
    fn accumulate<N: TermNumber>(
        self,
        _: &SliceSet,
        _: &[Cell<N>],
        _: &mut [Cell<N>],
        _: &mut N::Tally,
        _: &impl Fn([N; 3]) -> [N; 3],
        _: StatesOf<'_, Nothing>,
    ) {
    }

    #[inline(always)]
    fn slice<V: F32x8>(self, _: usize, _: &[Cell], _: &mut [V; 4], _: StatesOf<'_, Nothing>) {}

    #[inline(always)]
    fn cell<N: TermNumber>(
        self,
        _: usize,
        _: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_, Nothing>,
        _: &mut impl FnMut([f32; 3]),
    ) {
    }

    #[inline(always)]
    fn touched<N: TermNumber>(
        self,
        _: &[Contact<N>],
        _: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_, Nothing>,
        _: &mut Touched,
    ) {
    }

    #[inline(always)]
    fn add_move(self, _: usize, _: f32, sum: f32) -> f32 {
        sum
    }
}

impl<A: Term, B: Term> Term for (A, B) {
    type State = (A::State, B::State);

    #[inline(always)]
    fn corrects(self) -> bool {
        self.0.corrects() || self.1.corrects()
    }

    #[inline(always)]
    fn begin_tick(
        self,
        cell: usize,
        state: Self::State,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> (Self::State, f64) {
        let (a, rise_a) = self.0.begin_tick(cell, state.0, at);
        let (b, rise_b) = self.1.begin_tick(cell, state.1, at);
        ((a, b), rise_a + rise_b)
    }

    #[inline(always)]
    fn displace(self, slice: usize, here: &Chunk, quads: Quads<'_>) {
        self.0.displace(slice, here, quads);
        self.1.displace(slice, here, quads);
    }

    #[inline(always)]
    fn update(
        self,
        cells: Range<usize>,
        at: &impl Fn(usize) -> [f32; 3],
        from: SliceMemory<'_>,
        to: SliceMemory<'_>,
    ) {
        self.0.update(cells.clone(), at, from, to);
        self.1.update(cells, at, from.after::<A::State>(), to.after::<A::State>());
    }

    #[inline(always)]
    fn update_slice<V: F32x8>(
        self,
        slice: usize,
        at: &[Cell],
        from: SliceMemory<'_>,
        to: SliceMemory<'_>,
    ) {
        self.0.update_slice::<V>(slice, at, from, to);
        let (from, to) = (from.after::<A::State>(), to.after::<A::State>());
        self.1.update_slice::<V>(slice, at, from, to);
    }

    #[inline(always)]
    fn accumulate<N: TermNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        output: &impl Fn([N; 3]) -> [N; 3],
        states: StatesOf<'_, Self::State>,
    ) {
        self.0.accumulate(awake, v, residual, tally, output, states.first());
        self.1.accumulate(awake, v, residual, tally, output, states.others());
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        slice: usize,
        at: &[Cell],
        sum: &mut [V; 4],
        states: StatesOf<'_, Self::State>,
    ) {
        self.0.slice(slice, at, sum, states.first());
        self.1.slice(slice, at, sum, states.others());
    }

    #[inline(always)]
    fn cell<N: TermNumber>(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_, Self::State>,
        add: &mut impl FnMut([f32; 3]),
    ) {
        self.0.cell(cell, at, states.first(), add);
        self.1.cell(cell, at, states.others(), add);
    }

    #[inline(always)]
    fn touched<N: TermNumber>(
        self,
        held: &[Contact<N>],
        output: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_, Self::State>,
        sums: &mut Touched,
    ) {
        self.0.touched(held, output, states.first(), sums);
        self.1.touched(held, output, states.others(), sums);
    }

    fn resist(self, field: &[Cell], product: &mut [Cell]) {
        self.0.resist(field, product);
        self.1.resist(field, product);
    }

    #[inline(always)]
    fn turn(self, cell: usize, states: StatesOf<'_, Self::State>) -> Option<[f32; 4]> {
        self.0.turn(cell, states.first()).or_else(|| self.1.turn(cell, states.others()))
    }

    #[inline(always)]
    fn add_move(self, cell: usize, squared: f32, sum: f32) -> f32 {
        self.1.add_move(cell, squared, self.0.add_move(cell, squared, sum))
    }
}
