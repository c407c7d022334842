//! The terms' state of each cell from one pass to the next.
//!
//! The state of a cell covers all terms in the list, and takes no memory if none of them keeps a state. It
//! lasts from pass to pass, in rows of eight numbers, one of each cell of a slice. It exists in two banks, the
//! present one and that of the published positions, for a pass that the guard discards: two flags per slice
//! say which bank is which, so that saving and restoring copy nothing. Besides, each cell has its displacement
//! and its force in the pass: its neighbours read the first and add to the second. In a body of several
//! [`parts`](crate::parts) it has a force of each part's cells.

#![allow(unsafe_code)]

use core::cell::Cell;

use crate::backend::slice_set::SliceSet;
use crate::model::others::Others;
use crate::model::parts::{Division, Parts, SHAPES_SHARED};
use crate::model::terms::Keeps;
use crate::number::cell;
use crate::number::kept::kept;
use crate::number::two_float::LANES;

/// A number of each cell of a slice.
pub(crate) type Row = [f32; LANES];
/// Displacement or force of a cell.
pub(crate) type Quad = Cell<cell::Cell>;

/// Rows of what lasts, of all terms.
pub(crate) const LASTING: usize = <Others<'static> as Keeps>::LASTING;

/// 0 if no term keeps a state, so that arrays of this length have no size.
const IS_KEPT: usize = (LASTING != 0) as usize;
/// Rows of a slice: both banks and their flags; an even number.
const ROWS: usize = (2 * LASTING + 1).next_multiple_of(2);
/// Lines of the displacements of a slice, and of its forces.
const QUADS: usize = LANES * size_of::<cell::Cell>() / 64;
/// Lines of the rows of a slice.
const ROW_LINES: usize = IS_KEPT * (ROWS / 2);

/// Lines of the displacements of `cells` cells and of all their forces.
const fn quad_lines(cells: usize) -> usize {
    cells.div_ceil(LANES) * IS_KEPT * QUADS * (1 + Parts::of_shapes(cells).count())
}

kept! {
    /// Memory for the terms' states: a line of 64 bytes. [`term_states`] is the number that a body needs.
    #[derive(Debug, Clone, Copy, PartialEq)]
    #[cfg_attr(any(test, feature = "nodal"), repr(C, align(64)))]
    pub struct TermState(pub(crate) [[f32; 4]; 4 * IS_KEPT]);
}

const _: () = assert!(size_of::<TermState>() == IS_KEPT * 2 * size_of::<Row>());

impl TermState {
    /// Memory before a reset, which puts all cells to rest.
    pub const ZERO: Self = Self([[0.0; 4]; 4 * IS_KEPT]);
}

/// Number of [`TermState`] for the states of `cells` cells, of a model
/// [`kept_states`](crate::Model::kept_states).
///
/// ```
/// use chaincell_kernel::{Tissue, Track, term_states};
///
/// // A body of up to 160 cells with nodal shapes.
/// type Body = Tissue<160, Track, 4, { term_states(160) }>;
/// # let _ = Body::new();
/// ```
#[must_use]
pub const fn term_states(cells: usize) -> usize {
    quad_lines(cells) + cells.div_ceil(LANES) * ROW_LINES
}

/// Displacements and forces of all cells in a pass, the padding of the last slice included; at most one term
/// of the list uses them.
#[derive(Clone, Copy)]
pub(crate) struct Quads<'a> {
    pub displacements: &'a [Quad],
    /// Forces by the cells of each part, one part after the other; the fourth lane is a share of the cell's
    /// sum of w d^2.
    pub forces: &'a [Quad],
    division: Division,
}

#[cfg_attr(not(feature = "nodal"), expect(dead_code, reason = "no term has displacements"))]
impl<'a> Quads<'a> {
    const NONE: Self = Self { displacements: &[], forces: &[], division: Division::of_shapes(0) };

    /// The forces of all cells by the cells of a part.
    #[inline(always)]
    pub fn of_part(self, part: usize) -> &'a [Quad] {
        let cells = self.displacements.len();
        self.forces.get(part * cells..(part + 1) * cells).unwrap_or(&[])
    }

    /// The forces of all cells by the cells of a slice's part.
    #[inline(always)]
    pub fn by_slice(self, slice: usize) -> &'a [Quad] {
        self.of_part(self.division.of_slice(slice))
    }

    /// The forces of a slice's cells, by part.
    #[inline(always)]
    pub fn on_slice(self, slice: usize) -> impl Iterator<Item = &'a [Quad; LANES]> + Clone {
        // A part's forces are as many whole slices as there are displacements.
        let (forces, slices) = (self.forces.as_chunks().0, self.displacements.len() / LANES);
        let parts = if slice < slices { self.division.count() } else { 0 };
        (0..parts).filter_map(move |part| forces.get(part * slices + slice))
    }

    /// The whole force on each cell of a slice, its parts added in ascending order.
    #[inline(always)]
    pub fn force(self, slice: usize) -> Option<[cell::Cell; LANES]> {
        let mut each = self.on_slice(slice);
        let mut sums = each.next()?.each_ref().map(Cell::get);
        for more in each {
            for (sum, more) in sums.iter_mut().zip(more) {
                *sum = sum.plus(more.get());
            }
        }
        Some(sums)
    }
}

/// Memory of the states of a slice, in one bank; of one term and those after it in the list.
#[derive(Clone, Copy)]
pub(crate) struct SliceMemory<'a> {
    /// Rows of what lasts.
    pub lasting: &'a [Cell<Row>],
    #[cfg_attr(not(feature = "nodal"), expect(dead_code, reason = "no term has displacements"))]
    pub quads: Quads<'a>,
}

impl SliceMemory<'_> {
    /// Memory after these rows.
    #[inline(always)]
    fn skip(self, lasting: usize) -> Self {
        Self { lasting: self.lasting.get(lasting..).unwrap_or(&[]), ..self }
    }

    /// Memory of the terms after the first one.
    #[inline(always)]
    pub fn after<A: Keeps>(self) -> Self {
        self.skip(A::LASTING)
    }
}

/// A number of a lane; 0 beyond the last row.
#[inline(always)]
#[cfg(test)]
pub(crate) fn number(rows: &[Cell<Row>], row: usize, lane: usize) -> f32 {
    let lanes = rows.get(row).map(Cell::as_array_of_cells);
    lanes.and_then(|lanes| lanes.get(lane)).map_or(0.0, Cell::get)
}

/// Sets the numbers of a lane, row by row.
#[inline(always)]
pub(crate) fn put(rows: &[Cell<Row>], lane: usize, numbers: impl IntoIterator<Item = f32>) {
    for (row, number) in rows.iter().zip(numbers) {
        if let Some(slot) = row.as_array_of_cells().get(lane) {
            slot.set(number);
        }
    }
}

/// The terms' states of all cells, in memory of the caller; without size where no term has any.
pub struct TermStates<'a>([&'a mut [TermState]; IS_KEPT]);

impl<'a> TermStates<'a> {
    /// States in this memory.
    #[must_use]
    #[inline(always)]
    pub fn new(memory: &'a mut [TermState]) -> Self {
        let mut memory = Some(memory);
        Self([(); IS_KEPT].map(|()| memory.take().unwrap_or_default()))
    }

    /// The same memory, for a shorter lifetime.
    #[must_use]
    #[inline(always)]
    pub fn reborrow(&mut self) -> TermStates<'_> {
        TermStates(self.0.each_mut().map(|memory| &mut **memory))
    }

    /// Number of cells that the memory holds.
    pub(crate) fn capacity(&self) -> usize {
        let size = self.0.first().map_or(0, |memory| memory.len());
        // By the memory of a slice of such a body.
        let cells_as =
            |of: usize| size.checked_div(term_states(of) / of.div_ceil(LANES)).unwrap_or(0) * LANES;
        let (few, many) = (cells_as(LANES), cells_as(SHAPES_SHARED));
        if many < SHAPES_SHARED { few.min(SHAPES_SHARED - 1) } else { many }
    }

    /// The memory of `cells` cells; empty if it is too small.
    pub(crate) fn cells(&self, cells: usize) -> &[TermState] {
        self.0.first().and_then(|memory| memory.get(..term_states(cells))).unwrap_or(&[])
    }

    /// The whole memory.
    pub(crate) fn memory(&mut self) -> &mut [TermState] {
        self.0.first_mut().map_or(&mut [], |memory| memory)
    }

    /// Sets `cells` cells to the rest state.
    pub(crate) fn reset(&mut self, cells: usize) {
        self.memory().fill(TermState::ZERO);
        let states = self.shared(cells);
        for cell in 0..states.slices() * LANES {
            states.publish(cell, Others::at_rest);
        }
    }

    /// Shares the memory of `cells` cells for a tick.
    #[inline(always)]
    pub(crate) fn shared(&mut self, cells: usize) -> States<'_> {
        States(self.0.each_mut().map(|memory| {
            let memory = Cell::from_mut(memory.get_mut(..term_states(cells)).unwrap_or_default());
            Arrays::of(memory.as_slice_of_cells(), cells)
        }))
    }
}

/// The present rows of what lasts of `cells` cells, slice by slice.
#[inline(always)]
pub(crate) fn lasting(memory: &[TermState], cells: usize) -> impl Iterator<Item = &[Row; LASTING]> {
    let rows = memory.get(quad_lines(cells)..).unwrap_or(&[]);
    // SAFETY: a line is two rows of plain numbers, with a larger alignment; the lines stay borrowed.
    let rows: &[Row] =
        unsafe { core::slice::from_raw_parts(rows.as_ptr().cast(), rows.len() * (2 * IS_KEPT)) };
    rows.as_chunks::<ROWS>().0.iter().filter_map(|rows| {
        let [.., flags] = rows;
        let [now, ..] = flags;
        let first = if *now == 0.0 { 0 } else { LASTING };
        rows.get(first..)?.first_chunk()
    })
}

/// The memory of a body's states: displacements, forces, then the rows of each slice.
#[derive(Clone, Copy)]
struct Arrays<'a> {
    quads: Quads<'a>,
    rows: &'a [[Cell<Row>; ROWS]],
}

impl<'a> Arrays<'a> {
    #[inline(always)]
    fn of(memory: &'a [Cell<TermState>], cells: usize) -> Self {
        let division = Division::of_shapes(cells);
        let (quads, rows) = memory.split_at_checked(quad_lines(cells)).unwrap_or_default();
        let (displacements, forces) = quads.split_at(quads.len() / (1 + division.count()));
        // SAFETY: a line is two rows or four quadruples of plain numbers, with a larger alignment, and a
        // `Cell` is laid out as its content; the lines stay borrowed.
        let (rows, displacements, forces) = unsafe {
            (
                core::slice::from_raw_parts(rows.as_ptr().cast(), rows.len() * (2 * IS_KEPT)),
                core::slice::from_raw_parts(displacements.as_ptr().cast(), 4 * displacements.len()),
                core::slice::from_raw_parts(forces.as_ptr().cast(), 4 * forces.len()),
            )
        };
        Self { quads: Quads { displacements, forces, division }, rows: rows.as_chunks().0 }
    }

    /// The states of a slice.
    #[inline(always)]
    fn slice(self, slice: usize) -> Option<Slice<'a>> {
        Some(Slice { rows: self.rows.get(slice)?, quads: self.quads })
    }
}

/// The states of a slice.
#[derive(Clone, Copy)]
struct Slice<'a> {
    rows: &'a [Cell<Row>; ROWS],
    quads: Quads<'a>,
}

impl<'a> Slice<'a> {
    /// Flags of the present bank and of the published one: 0 for the first, 1 for the second.
    #[inline(always)]
    fn flags(self) -> [&'a Cell<f32>; 2] {
        let [.., flags] = self.rows;
        let [now, published, ..] = flags.as_array_of_cells();
        [now, published]
    }

    #[inline(always)]
    fn bank(self, flag: f32) -> SliceMemory<'a> {
        let (first, rest) = self.rows.split_at(LASTING);
        let (second, _) = rest.split_at(LASTING);
        let lasting = if flag == 0.0 { first } else { second };
        SliceMemory { lasting, quads: self.quads }
    }

    /// The present bank.
    #[inline(always)]
    fn present(self) -> SliceMemory<'a> {
        self.bank(self.flags()[0].get())
    }

    /// The present bank, and the one for the next states, which becomes the present one: never that of the
    /// published states.
    #[inline(always)]
    fn step(self) -> [SliceMemory<'a>; 2] {
        let ([now, published], from) = (self.flags(), self.present());
        now.set(if published.get() == 0.0 { 1.0 } else { 0.0 });
        [from, self.bank(now.get())]
    }
}

/// The terms' states during a tick.
#[derive(Clone, Copy)]
pub(crate) struct States<'a>([Arrays<'a>; IS_KEPT]);

impl<'a> States<'a> {
    /// No memory: every cell is at rest.
    pub const NONE: Self = Self([Arrays { quads: Quads::NONE, rows: &[] }; IS_KEPT]);

    /// Number of slices.
    #[inline(always)]
    fn slices(&self) -> usize {
        self.0.first().map_or(0, |arrays| arrays.rows.len())
    }

    /// Returns true if some term keeps states of this body.
    #[inline(always)]
    pub fn any(&self) -> bool {
        self.slices() > 0
    }

    #[inline(always)]
    fn slice(&self, slice: usize) -> Option<Slice<'a>> {
        self.0.first()?.slice(slice)
    }

    /// The states for a thread that goes over a part of the body.
    #[inline(always)]
    pub fn shared(self) -> Shared<'a> {
        Shared(self)
    }

    /// The division of loops over the states.
    #[inline(always)]
    pub fn division(self) -> Division {
        self.all().quads().division
    }

    /// The states for loops over a set of `count` slices: the parts of a large body then have as many slices
    /// of the set each.
    pub fn divided(self, set: impl Iterator<Item = usize> + Clone, count: usize) -> Self {
        Self(self.0.map(|mut arrays| {
            arrays.quads.division = arrays.quads.division.of_set(set.clone(), count);
            arrays
        }))
    }

    /// The states of all terms.
    #[inline(always)]
    pub fn all(self) -> StatesOf<'a> {
        StatesOf { states: self, lasting: 0 }
    }

    /// The memory of a slice's states, and that for the next ones, which become the present ones.
    #[inline(always)]
    pub fn step(&self, slice: usize) -> Option<[SliceMemory<'a>; 2]> {
        Some(self.slice(slice)?.step())
    }

    /// Sets what lasts of a cell at its published position, by row.
    fn publish(&self, cell: usize, number: impl Fn(usize) -> f32) {
        let Some(slice) = self.slice(cell / LANES) else { return };
        for bank in [slice.bank(0.0), slice.bank(1.0)] {
            put(bank.lasting, cell % LANES, (0..LASTING).map(&number));
        }
    }

    /// Gives a cell the present state of another one, also as its published state.
    #[cfg(feature = "cut")]
    pub fn inherit(&self, from: usize, to: usize) {
        let Some(memory) = self.slice(from / LANES).map(Slice::present) else { return };
        let lane = from % LANES;
        self.publish(to, |row| {
            let numbers = memory.lasting.get(row).map(Cell::as_array_of_cells);
            numbers.and_then(|lanes| lanes.get(lane)).map_or(0.0, Cell::get)
        });
    }

    /// Saves the states of a slice whose cells are at their published positions.
    #[inline(always)]
    pub fn save_slice(&self, slice: usize) {
        if let Some(slice) = self.slice(slice) {
            let [now, published] = slice.flags();
            published.set(now.get());
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
            for slice in set.iter(slices).filter_map(|slice| self.slice(slice)) {
                let [now, published] = slice.flags();
                now.set(published.get());
            }
        }
    }
}

/// The terms' states for a thread that goes over the slices of a part, while others go over the other parts.
///
/// In such a loop a thread writes displacements, flags and rows of its part's slices, and forces either of
/// its part's slices or by its part's cells; it reads what no thread writes in this loop, or what is its own.
#[derive(Clone, Copy)]
pub(crate) struct Shared<'a>(States<'a>);

// SAFETY: the loops over parts keep the rule above, so no thread reads or writes what another one writes.
unsafe impl Send for Shared<'_> {}

impl<'a> Shared<'a> {
    #[inline(always)]
    pub fn get(self) -> States<'a> {
        self.0
    }
}

/// The states of one term and of those after it in the list.
#[derive(Clone, Copy)]
pub(crate) struct StatesOf<'a> {
    states: States<'a>,
    /// Rows of the terms before.
    lasting: usize,
}

#[cfg_attr(not(any(test, feature = "nodal")), expect(dead_code, reason = "no term has a state"))]
impl<'a> StatesOf<'a> {
    /// The states of the terms after the first one.
    #[inline(always)]
    pub fn after<A: Keeps>(self) -> Self {
        Self { lasting: self.lasting + A::LASTING, ..self }
    }

    /// The present states of a slice.
    #[inline(always)]
    pub fn slice(&self, slice: usize) -> Option<SliceMemory<'a>> {
        Some(self.states.slice(slice)?.present().skip(self.lasting))
    }

    /// The present states of a slice, to be changed between passes; the published ones stay.
    #[cfg(test)]
    pub fn change(&self, slice: usize) -> Option<SliceMemory<'a>> {
        let [from, to] = self.states.step(slice)?;
        for (from, to) in from.lasting.iter().zip(to.lasting) {
            to.set(from.get());
        }
        self.slice(slice)
    }

    /// Displacements and forces of all cells.
    #[inline(always)]
    pub fn quads(&self) -> Quads<'a> {
        self.states.0.first().map_or(Quads::NONE, |arrays| arrays.quads)
    }
}
