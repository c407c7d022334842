//! The terms' state of each cell from one pass to the next.
//!
//! The state of a cell covers all terms in the list, and has no size if none of them keeps a state. A tissue
//! holds it twice: the present one, and the one at the published positions while a scheme evaluates others,
//! for a pass that the guard discards.

use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::model::others::Others;
use crate::number::kept::{Kept, kept};
use crate::terms::term::Term;

/// A term's state of one cell. Never -0.0, so that equal states have equal words.
pub(crate) trait CellState: Kept + PartialEq + 'static {
    /// The state in the rest shape.
    const REST: Self;
    /// All zeros: memory before a reset, so that a static needs no initial values.
    const ZERO: Self;
    /// 32-bit words of a state.
    type Words: Iterator<Item = u32>;
    /// The words for the state hash and a saved state; their number is constant.
    fn words(self) -> Self::Words;
    /// The state from the next of these words; `None` if they are no state.
    fn from_words(words: &mut impl Iterator<Item = u32>) -> Option<Self>;
}

/// The state of a term without one.
pub(crate) type Nothing = [u32; 0];

impl CellState for Nothing {
    const REST: Self = [];
    const ZERO: Self = [];
    type Words = core::iter::Empty<u32>;

    fn words(self) -> Self::Words {
        core::iter::empty()
    }

    fn from_words(_: &mut impl Iterator<Item = u32>) -> Option<Self> {
        Some([])
    }
}

impl<A: CellState, B: CellState> CellState for (A, B) {
    const REST: Self = (A::REST, B::REST);
    const ZERO: Self = (A::ZERO, B::ZERO);
    type Words = core::iter::Chain<A::Words, B::Words>;

    fn words(self) -> Self::Words {
        self.0.words().chain(self.1.words())
    }

    fn from_words(words: &mut impl Iterator<Item = u32>) -> Option<Self> {
        Some((A::from_words(words)?, B::from_words(words)?))
    }
}

/// The state of a cell under all terms.
pub(crate) type State = <Others<'static> as Term>::State;

kept! {
    /// Memory for what the terms keep of one cell.
    #[derive(Clone, Copy)]
    pub struct TermState {
        pub(crate) now: State,
        /// The state at the published position.
        pub(crate) saved: State,
    }
}

impl TermState {
    /// In the rest shape.
    pub const REST: Self = Self::published(State::REST);
    /// Before a reset: all zeros.
    pub const ZERO: Self = Self::published(State::ZERO);

    /// A state at a published position.
    pub(crate) const fn published(state: State) -> Self {
        Self { now: state, saved: state }
    }
}

/// 0 if no term keeps a state, so that arrays of this length have no size.
const KEPT: usize = (size_of::<TermState>() > 0) as usize;

/// The words of the states in `cells` for the state hash and a saved state, cell by cell.
pub(crate) fn words(cells: &[TermState]) -> impl Iterator<Item = u32> {
    let kept = cells.iter().take(cells.len() * KEPT);
    kept.flat_map(|cell| cell.now.words())
}

/// The terms' states of all cells, in memory of the caller; without size where no term has any.
pub struct TermStates<'a>([&'a mut [TermState]; KEPT]);

impl<'a> TermStates<'a> {
    /// States in this memory, one per cell.
    #[must_use]
    #[inline(always)]
    pub fn new(cells: &'a mut [TermState]) -> Self {
        let mut cells = Some(cells);
        Self([(); KEPT].map(|()| cells.take().unwrap_or_default()))
    }

    /// The same memory, for a shorter lifetime.
    #[must_use]
    #[inline(always)]
    pub fn reborrow(&mut self) -> TermStates<'_> {
        TermStates(self.0.each_mut().map(|cells| &mut **cells))
    }

    /// Number of cells that the memory holds.
    pub(crate) fn capacity(&self) -> usize {
        self.0.first().map_or(0, |cells| cells.len())
    }

    /// The memory of the first `count` cells; empty if it is too small.
    pub(crate) fn cells(&self, count: usize) -> &[TermState] {
        self.0.first().and_then(|cells| cells.get(..count)).unwrap_or(&[])
    }

    /// The whole memory.
    pub(crate) fn memory(&mut self) -> &mut [TermState] {
        self.0.first_mut().map_or(&mut [], |cells| cells)
    }

    /// Sets all cells to the rest state.
    pub(crate) fn reset(&mut self) {
        for cells in &mut self.0 {
            cells.fill(TermState::REST);
        }
    }

    /// Reads the words of `count` cells. Returns false and changes nothing if they are not valid states.
    pub(crate) fn read(&mut self, count: usize, words: &[u32]) -> bool {
        let count = if self.capacity() < count { 0 } else { count };
        let cells = self.0.iter_mut().flat_map(|cells| cells.iter_mut().take(count));
        let (mut ahead, mut words) = (words.iter().copied(), words.iter().copied());
        let mut state = || State::from_words(&mut ahead);
        let is_whole = (0..count * KEPT).all(|_| state().is_some()) && ahead.next().is_none();
        if is_whole {
            for cell in cells {
                *cell = State::from_words(&mut words).map_or(*cell, TermState::published);
            }
        }
        is_whole
    }

    /// Shares the memory of the first `count` cells for a tick.
    #[inline(always)]
    pub(crate) fn shared(&mut self, count: usize) -> States<'_> {
        let shared = |cells| core::cell::Cell::from_mut(cells).as_slice_of_cells();
        States(self.0.each_mut().map(|cells| shared(cells.get_mut(..count).unwrap_or_default())))
    }
}

/// The terms' states during a tick.
#[derive(Clone, Copy)]
pub(crate) struct States<'a>([&'a [core::cell::Cell<TermState>]; KEPT]);

impl States<'_> {
    /// No memory: every cell is at rest.
    #[cfg(test)]
    pub const NONE: Self = Self([&[]; KEPT]);

    /// Returns true if some term keeps states of this body.
    #[inline(always)]
    pub fn any(&self) -> bool {
        self.0.first().is_some_and(|cells| !cells.is_empty())
    }

    #[inline(always)]
    fn slot(&self, cell: usize) -> Option<&core::cell::Cell<TermState>> {
        self.0.first()?.get(cell)
    }

    /// The state of a cell.
    #[inline(always)]
    pub fn at(&self, cell: usize) -> State {
        self.slot(cell).map_or(TermState::REST, core::cell::Cell::get).now
    }

    /// Sets the state of a cell.
    #[inline(always)]
    pub fn put(&self, cell: usize, state: State) {
        if let Some(slot) = self.slot(cell) {
            slot.set(TermState { now: state, ..slot.get() });
        }
    }

    /// Saves the states of a slice whose cells are at their published positions.
    #[inline(always)]
    pub fn save_slice(&self, slice: usize) {
        for slot in self.slice(slice) {
            slot.set(TermState::published(slot.get().now));
        }
    }

    /// Saves the states of the slices in `set`, among `slices` in all.
    #[inline(always)]
    pub fn save(&self, set: &SliceSet, slices: usize) {
        if self.any() {
            set.iter(slices).for_each(|slice| self.save_slice(slice));
        }
    }

    /// Restores the saved states of the slices in `set`, among `slices` in all.
    #[inline(always)]
    pub fn restore(&self, set: &SliceSet, slices: usize) {
        if self.any() {
            for slot in set.iter(slices).flat_map(|slice| self.slice(slice)) {
                slot.set(TermState::published(slot.get().saved));
            }
        }
    }

    #[inline(always)]
    fn slice(&self, slice: usize) -> &[core::cell::Cell<TermState>] {
        let cells = self.0.first().copied().unwrap_or(&[]);
        cells.get(cells_of(slice, cells.len())).unwrap_or(&[])
    }
}
