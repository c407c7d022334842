//! A term of the energy: its part in a tick, in a pass, and at the cells that the tool moves.
//!
//! **State.** A term may keep a state of each cell. The energy is then a function of positions and states. A
//! tick changes states in two places, each cell's from the positions of any cells and from its own state
//! only:
//!
//! - [`Term::begin_tick`], once before anything else: a correction, such as a linear part of residual and
//!   energy, that is constant through all sweeps. It may change the energy, which must stay at least 0, and
//!   returns the change.
//! - [`Term::update`], before each pass over the residuals. It must never raise the energy, nor change a
//!   state where the term's energy is 0: such a cell may sleep.
//!
//! So for fixed states the bound L holds as for any term, and the energy falls in every sweep. If the guard
//! discards a pass, its updates are discarded too: the states are then those of the published positions.
//!
//! A method that a term leaves out adds nothing. The list of the terms is a nested pair, which is a term
//! itself; it is resolved when the kernel is compiled: a term that is not in the list costs nothing.

use core::ops::Range;

use super::held::{Contact, Touched};
use super::links::number::LinkNumber;
use super::state::{SliceMemory, StatesOf};
use super::stress::Stress;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::model::terms::{Keeps, NoTerm};
use crate::number::cell::{Cell, output};
use crate::number::two_float::{LANES, TwoFloat};

/// A pass cell by cell, at states within K or, `CLAMPED`, at the outputs of all states.
pub(crate) struct Pass<'a, N, const CLAMPED: bool> {
    pub awake: &'a SliceSet,
    pub v: &'a [Cell<N>],
    /// K.
    pub saturation: N,
}

#[cfg_attr(not(any(test, feature = "nodal")), expect(dead_code, reason = "only links"))]
impl<N: LinkNumber, const CLAMPED: bool> Pass<'_, N, CLAMPED> {
    /// The output of a state.
    #[inline(always)]
    pub fn output(&self, v: [N; 3]) -> [N; 3] {
        if CLAMPED { output(v, self.saturation) } else { v }
    }

    /// The output of a cell; zeros beyond the last one.
    #[inline(always)]
    pub fn at(&self, cell: usize) -> [N; 3] {
        self.v.get(cell).map_or([N::ZERO; 3], |v| self.output(v.xyz()))
    }

    /// The awake slices.
    #[inline(always)]
    pub fn slices(&self) -> impl Iterator<Item = usize> {
        self.awake.iter(self.v.len().div_ceil(LANES))
    }

    /// The cells of awake slices.
    #[inline(always)]
    pub fn cells(&self) -> impl Iterator<Item = usize> {
        let cells = self.v.len();
        self.slices().flat_map(move |slice| cells_of(slice, cells))
    }
}

/// A slice in a pass over eight cells side by side.
#[derive(Clone, Copy)]
pub(crate) struct Here<'a, V> {
    pub slice: usize,
    /// Positions of its cells, the last one of the body repeated.
    pub cells: [V; 3],
    /// Positions of all cells.
    pub at: &'a [Cell],
}

/// A term of the energy of a body in the number `N`. Positions are outputs of the cells' states v; `states`
/// are the term's states of the cells.
pub(crate) trait Term<N: LinkNumber>: Keeps {
    /// Corrects states at the start of a tick and calls `changed` for each cell whose state changed. Returns
    /// the change of the energy, in internal units.
    #[inline(always)]
    fn begin_tick(
        self,
        _at: &impl Fn(usize) -> [f32; 3],
        _states: StatesOf<'_>,
        _changed: &mut impl FnMut(usize),
    ) -> f64 {
        0.0
    }
    /// Computes what a pass needs from the positions of any cells.
    #[inline(always)]
    fn prepare(self, _at: &impl Fn(usize) -> [f32; 3]) {}
    /// Stores the displacements of the cells of a slice, which are at `here`, and clears their forces. A pass
    /// does so for all its slices before the first update; the displacements of other slices stay.
    #[inline(always)]
    fn displace(self, _slice: usize, _here: &Chunk, _states: StatesOf<'_>) {}
    /// Stores the states of a slice's cells for a pass.
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
    #[inline(always)]
    fn accumulate<const CLAMPED: bool>(
        self,
        _pass: &Pass<'_, N, CLAMPED>,
        _residual: &mut [Cell<N>],
        _tally: &mut N::Tally,
        _states: StatesOf<'_>,
    ) {
    }
    /// Adds the term to the residuals of a slice whose states v are within K; the same bits. `before` returns
    /// the residuals of the last pass.
    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        _here: Here<'_, V>,
        _before: &impl Fn() -> Chunk,
        _sum: &mut [V; 4],
        _states: StatesOf<'_>,
    ) {
    }
    /// Adds the energy that no residual carries, to that of all terms.
    #[inline(always)]
    fn potential(self, energy: TwoFloat, _at: &impl Fn(usize) -> [N; 3]) -> TwoFloat {
        energy
    }
    /// Adds the term's force on a held cell, unless [`Self::touched`] has it.
    #[inline(always)]
    fn cell(
        self,
        _cell: usize,
        _held: &[Contact<N>],
        _at: &impl Fn(usize) -> [N; 3],
        _states: StatesOf<'_>,
        sum: [f32; 3],
    ) -> [f32; 3] {
        sum
    }
    /// Adds the term's energy at the held cells, of nodal shapes the force on them too.
    #[inline(always)]
    fn touched(
        self,
        _held: &[Contact<N>],
        _at: &impl Fn(usize) -> [N; 3],
        _states: StatesOf<'_>,
        _sums: &mut Touched,
    ) {
    }
    /// Adds the second derivative of the energy at rest times a small displacement of the cells. A term may
    /// leave it out: it only shortens the way to the equilibrium.
    #[inline(always)]
    fn resist(self, _field: &[Cell], _product: &mut [Cell]) {}
    /// The rotation of a cell as a unit quaternion, real part first, for the coarse level; `None` if its
    /// state has none.
    #[inline(always)]
    fn turn(self, _cell: usize, _states: StatesOf<'_>) -> Option<[f32; 4]> {
        None
    }

    /// Strain and stress of a cell for a report, with the unit of the moduli \[Pa\]: those of the terms before, `sum`,
    /// with this term's part. `means_pa` is as of [`TissueMut::stress_with`](crate::TissueMut::stress_with).
    fn stress(
        self,
        _cell: usize,
        _at: &impl Fn(usize) -> [N; 3],
        _states: StatesOf<'_>,
        _unit_pa: f32,
        _means_pa: &mut [f32],
        sum: Option<Stress>,
    ) -> Option<Stress> {
        sum
    }
}

impl<N: LinkNumber> Term<N> for NoTerm {}

impl<N: LinkNumber, A: Term<N>, B: Term<N>> Term<N> for (A, B) {
    #[inline(always)]
    fn begin_tick(
        self,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
        changed: &mut impl FnMut(usize),
    ) -> f64 {
        let rise = self.0.begin_tick(at, states, changed);
        rise + self.1.begin_tick(at, states.after::<A>(), changed)
    }

    #[inline(always)]
    fn prepare(self, at: &impl Fn(usize) -> [f32; 3]) {
        self.0.prepare(at);
        self.1.prepare(at);
    }

    #[inline(always)]
    fn displace(self, slice: usize, here: &Chunk, states: StatesOf<'_>) {
        self.0.displace(slice, here, states);
        self.1.displace(slice, here, states.after::<A>());
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
        self.1.update(cells, at, from.after::<A>(), to.after::<A>());
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
        self.1.update_slice::<V>(slice, at, from.after::<A>(), to.after::<A>());
    }

    #[inline(always)]
    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        states: StatesOf<'_>,
    ) {
        self.0.accumulate(pass, residual, tally, states);
        self.1.accumulate(pass, residual, tally, states.after::<A>());
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        before: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        states: StatesOf<'_>,
    ) {
        self.0.slice(here, before, sum, states);
        self.1.slice(here, before, sum, states.after::<A>());
    }

    #[inline(always)]
    fn potential(self, energy: TwoFloat, at: &impl Fn(usize) -> [N; 3]) -> TwoFloat {
        self.1.potential(self.0.potential(energy, at), at)
    }

    #[inline(always)]
    fn cell(
        self,
        cell: usize,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_>,
        sum: [f32; 3],
    ) -> [f32; 3] {
        let sum = self.0.cell(cell, held, at, states, sum);
        self.1.cell(cell, held, at, states.after::<A>(), sum)
    }

    #[inline(always)]
    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        self.0.touched(held, at, states, sums);
        self.1.touched(held, at, states.after::<A>(), sums);
    }

    #[inline(always)]
    fn resist(self, field: &[Cell], product: &mut [Cell]) {
        self.0.resist(field, product);
        self.1.resist(field, product);
    }

    #[inline(always)]
    fn turn(self, cell: usize, states: StatesOf<'_>) -> Option<[f32; 4]> {
        self.0.turn(cell, states).or_else(|| self.1.turn(cell, states.after::<A>()))
    }

    fn stress(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_>,
        unit_pa: f32,
        means_pa: &mut [f32],
        sum: Option<Stress>,
    ) -> Option<Stress> {
        let sum = self.0.stress(cell, at, states, unit_pa, means_pa, sum);
        self.1.stress(cell, at, states.after::<A>(), unit_pa, means_pa, sum)
    }
}

/// Changes the residual of one lane of a slice.
#[inline(always)]
pub(crate) fn change_lane<V: F32x8>(
    sum: &mut [V; 4],
    lane: usize,
    change: impl FnOnce(Cell) -> Cell,
) {
    let (mut lanes, mut cell) = ([[0.0; LANES]; 4], Cell::ZERO);
    for ((sum, lanes), value) in sum.iter().zip(&mut lanes).zip(&mut cell.0) {
        sum.store(lanes);
        *value = lanes.get(lane).copied().unwrap_or(0.0);
    }
    for ((sum, lanes), value) in sum.iter_mut().zip(&mut lanes).zip(change(cell).0) {
        if let Some(slot) = lanes.get_mut(lane) {
            *slot = value;
        }
        *sum = V::load(lanes);
    }
}
