//! Sets of slices of eight consecutive cells that a sweep must update.
//!
//! A slice sleeps while all links of its cells are slack, none of its cells moves, and no cell linked to them
//! has moved since the last check. Then its residuals and energies are exactly zero and stay so: skipping it
//! changes no bit. Motion wakes a slice's neighbours at once, before the next pass; slices are checked for
//! sleep every [`SETTLE_TICKS`] ticks, in the order of the cells.
//!
//! The threshold is zero: a slice that still moves by one unit in the last place stays awake, so skipping
//! sleeping slices has no error. A sleeping body costs a look at its sets. The worst case is still the full
//! sweep; a tick that checks for sleep costs up to half a sweep more. A coarse level moves every free cell a
//! little in every sweep: with slack (alpha above 0) nothing sleeps while a tool presses.

use crate::backend::slice_set::SliceSet;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::Cell;
use crate::number::kept::kept;
use crate::number::two_float::LANES;

/// Ticks between two checks for sleep.
pub(crate) const SETTLE_TICKS: u32 = 16;

kept! {
    /// Awake slices, and those among them whose neighbours are known to be awake.
    #[derive(Debug, Clone, Copy)]
    pub(crate) struct Awake {
        pub set: SliceSet,
        pub spread: SliceSet,
        ticks: u32,
        /// No slice is put to sleep.
        sleepless: bool,
    }
}

/// Inserts the slice of a cell and those of the cells linked to it.
pub(super) fn insert_around(set: &mut SliceSet, model: &Model<'_>, cell: usize) {
    set.insert(cell / LANES);
    for (_, other) in model.neighbours(cell) {
        set.insert(other / LANES);
    }
}

impl Awake {
    /// All slices sleep.
    pub const NONE: Self =
        Self { set: SliceSet::EMPTY, spread: SliceSet::EMPTY, ticks: 0, sleepless: false };

    /// Wakes all slices and keeps them awake.
    pub fn forbid_sleep(&mut self, model: &Model<'_>) {
        self.sleepless = true;
        self.wake_all(model);
    }

    /// Wakes all slices.
    pub fn wake_all(&mut self, model: &Model<'_>) {
        self.set.fill(model.slice_count());
        self.spread = self.set;
    }

    /// Keeps slices from falling asleep for [`SETTLE_TICKS`] ticks.
    pub fn postpone_sleep(&mut self) {
        self.ticks = 0;
    }

    /// Returns true if sleep is forbidden.
    pub fn is_sleepless(&self) -> bool {
        self.sleepless
    }

    /// Wakes the slice of a moved cell and those of the cells linked to it.
    pub fn wake_around(&mut self, model: &Model<'_>, cell: usize) {
        if model.reaches_beyond_links() {
            // The effect of a motion reaches the neighbours' neighbours, and the other side of a cut.
            return self.wake_all(model);
        }
        insert_around(&mut self.set, model, cell);
    }

    /// Wakes the neighbours of moved cells, those in `slices` for which `has_moved` is true.
    pub fn wake_neighbours(
        &mut self,
        model: &Model<'_>,
        slices: &SliceSet,
        has_moved: impl Fn(usize) -> bool,
    ) {
        if model.reaches_beyond_links() {
            let mut cells = slices
                .iter(model.slice_count())
                .flat_map(|slice| slice * LANES..(slice + 1) * LANES);
            if cells.any(has_moved) {
                self.wake_all(model);
            }
            return;
        }
        for slice in slices.iter(model.slice_count()) {
            let mut all = true;
            for cell in slice * LANES..(slice + 1) * LANES {
                if has_moved(cell) {
                    self.wake_around(model, cell);
                } else {
                    // A cell that cannot move wakes no other.
                    all &= model.mobility.get(cell).is_none_or(|&mobility| mobility <= 0.0);
                }
            }
            if all {
                self.spread.insert(slice);
            }
        }
    }

    /// Every [`SETTLE_TICKS`] calls: puts to sleep the slices with slack links only, whose cells and
    /// neighbours do not move.
    pub fn settle<N: Number>(
        &mut self,
        model: &Model<'_>,
        residual: &[Cell<N>],
        has_moved: impl Fn(usize) -> bool,
    ) {
        self.ticks = (self.ticks + 1) % SETTLE_TICKS;
        if self.ticks != 0 || self.sleepless {
            return;
        }
        let taut = |cell: usize| residual.get(cell).is_some_and(|r| *r != Cell::ZERO);
        let mut busy = SliceSet::EMPTY;
        let mut sleepers = false;
        for slice in self.set.iter(model.slice_count()) {
            if (slice * LANES..(slice + 1) * LANES).any(|cell| taut(cell) || has_moved(cell)) {
                busy.insert(slice);
            } else {
                sleepers = true;
            }
        }
        if sleepers {
            self.set = busy;
            self.spread = SliceSet::EMPTY;
            self.wake_neighbours(model, &busy, has_moved);
        }
    }
}
