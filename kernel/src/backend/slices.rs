//! Slices of eight consecutive cells in the arrays: reading and writing them, the last one too.

use core::ops::Range;

use crate::backend::f32x8::Chunk;
use crate::number::Number;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// Returns the cells of a slice in a body of `cells` cells.
#[inline(always)]
pub(crate) fn cells_of(slice: usize, cells: usize) -> Range<usize> {
    slice * LANES..cells.min((slice + 1) * LANES)
}

/// Sets the cells of these slices to +0.0.
#[inline(always)]
pub(crate) fn clear<N: Number>(cells: &mut [Cell<N>], slices: impl Iterator<Item = usize>) {
    for slice in slices {
        for cell in cells.iter_mut().skip(slice * LANES).take(LANES) {
            *cell = Cell::ZERO;
        }
    }
}

/// An array by slices: whole slices in place, and a padded copy of the remainder.
pub(crate) struct Chunks<'a, T> {
    whole: &'a [[T; LANES]],
    last: [T; LANES],
}

impl<'a, T: Copy> Chunks<'a, T> {
    /// The padding is `beyond`.
    #[inline(always)]
    pub fn new(values: &'a [T], beyond: T) -> Self {
        let (whole, rest) = values.as_chunks();
        Self { whole, last: padded(rest, beyond) }
    }

    #[inline(always)]
    pub fn at(&self, slice: usize) -> &[T; LANES] {
        match self.whole.get(slice) {
            Some(chunk) => chunk,
            None => last(&self.last),
        }
    }
}

impl<'a> Chunks<'a, Cell> {
    /// The padding is the last cell.
    #[inline(always)]
    pub fn repeated(cells: &'a [Cell]) -> Self {
        Self::new(cells, cells.last().copied().unwrap_or(Cell::ZERO))
    }
}

/// [`Chunks`] of cells to be written, then to be ended by [`Self::finish`].
pub(crate) struct ChunksMut<'a> {
    whole: &'a mut [Chunk],
    rest: &'a mut [Cell],
    last: Chunk,
}

impl<'a> ChunksMut<'a> {
    /// The padding is +0.0.
    #[inline(always)]
    pub fn new(cells: &'a mut [Cell]) -> Self {
        let (whole, rest) = cells.as_chunks_mut();
        let last = padded(rest, Cell::ZERO);
        Self { whole, rest, last }
    }

    #[inline(always)]
    pub fn at(&mut self, slice: usize) -> &mut Chunk {
        match self.whole.get_mut(slice) {
            Some(chunk) => chunk,
            None => last(&mut self.last),
        }
    }

    #[inline(always)]
    pub fn seen(&self, slice: usize) -> &Chunk {
        match self.whole.get(slice) {
            Some(chunk) => chunk,
            None => last(&self.last),
        }
    }

    /// Writes the remainder back and drops the padding.
    #[inline(always)]
    pub fn finish(self) {
        copy(self.rest, &self.last);
    }
}

/// Returns the remainder. It is not inlined: else the compiler selects every cell of a slice separately.
#[cold]
#[inline(never)]
fn last<T>(chunk: T) -> T {
    chunk
}

#[inline(always)]
fn padded<T: Copy>(rest: &[T], beyond: T) -> [T; LANES] {
    let mut last = [beyond; LANES];
    for (slot, value) in last.iter_mut().zip(rest) {
        *slot = *value;
    }
    last
}

/// Copies a slice between arrays of the same length; copies nothing if they are too short.
#[inline(always)]
pub(crate) fn copy_slice(to: &mut [Cell], from: &[Cell], slice: usize) {
    let cells = cells_of(slice, from.len());
    if let (Some(to), Some(from)) = (to.get_mut(cells.clone()), from.get(cells)) {
        copy(to, from);
    }
}

/// Copies cells, as many as both have: `copy_from_slice` would panic on other lengths.
#[inline(always)]
pub(crate) fn copy<N: Number>(to: &mut [Cell<N>], from: &[Cell<N>]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}
