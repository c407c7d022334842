//! Slices of eight consecutive cells in the arrays: reading and writing them, the last one too.

use core::ops::Range;

use crate::backend::f32x8::{Chunk, F32x8};
use crate::number::Number;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// The cells of a slice, of so many in all.
#[inline(always)]
pub(crate) fn cells_of(slice: usize, cells: usize) -> Range<usize> {
    slice * LANES..cells.min((slice + 1) * LANES)
}

/// +0.0 in the cells of these slices.
#[inline(always)]
pub(crate) fn clear<N: Number>(cells: &mut [Cell<N>], slices: impl Iterator<Item = usize>) {
    for slice in slices {
        for cell in cells.iter_mut().skip(slice * LANES).take(LANES) {
            *cell = Cell::ZERO;
        }
    }
}

/// A slice of `cells`; beyond the end the last cell repeats, in `buffer`.
#[inline(always)]
pub(crate) fn eight<'a>(cells: &'a [Cell], slice: usize, buffer: &'a mut Chunk) -> &'a Chunk {
    match cells.get(slice * LANES..).and_then(|left| left.first_chunk()) {
        Some(chunk) => chunk,
        None => {
            let mut left = cells.get(slice * LANES..).unwrap_or(&[]).iter();
            for slot in &mut *buffer {
                *slot = left.next().or(cells.last()).copied().unwrap_or(Cell::ZERO);
            }
            buffer
        }
    }
}

/// A slice of `cells`; beyond the end 0, in `buffer`.
#[inline(always)]
pub(crate) fn eight_or_zero<'a>(
    cells: &'a [Cell],
    slice: usize,
    buffer: &'a mut Chunk,
) -> &'a Chunk {
    match cells.get(slice * LANES..).and_then(|left| left.first_chunk()) {
        Some(chunk) => chunk,
        None => {
            let left = cells.get(slice * LANES..).unwrap_or(&[]);
            for (slot, cell) in buffer.iter_mut().zip(left) {
                *slot = *cell;
            }
            buffer
        }
    }
}

/// A slice of values a cell; beyond the end 0.
#[inline(always)]
pub(crate) fn eight_values(values: &[f32], slice: usize) -> [f32; LANES] {
    match values.get(slice * LANES..).and_then(|left| left.first_chunk()) {
        Some(values) => *values,
        None => {
            let mut left = values.get(slice * LANES..).unwrap_or(&[]).iter();
            [0.0; LANES].map(|zero| left.next().copied().unwrap_or(zero))
        }
    }
}

/// Copies a slice between arrays of the same length; nothing where they are shorter.
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

/// Writes a slice as pairs of cells; what lies beyond the end is dropped.
#[inline(always)]
pub(crate) fn put_pairs<V: F32x8>(cells: &mut [Cell], slice: usize, pairs: [V; 4]) {
    let [a, b, c, d] = pairs;
    let mut buffer = [Cell::ZERO; LANES];
    let whole = cells.get_mut(slice * LANES..).and_then(|left| left.first_chunk_mut());
    let is_whole = whole.is_some();
    let chunk = whole.unwrap_or(&mut buffer);
    a.put_pair(chunk, 0);
    b.put_pair(chunk, 1);
    c.put_pair(chunk, 2);
    d.put_pair(chunk, 3);
    if !is_whole {
        put_last(cells, slice, &buffer);
    }
}

/// Writes a slice from its lanes; what lies beyond the end is dropped.
#[inline(always)]
pub(crate) fn put_lanes<V: F32x8>(cells: &mut [Cell], slice: usize, lanes: [V; 4]) {
    match cells.get_mut(slice * LANES..).and_then(|left| left.first_chunk_mut()) {
        Some(chunk) => V::put_transposed(lanes, chunk),
        None => {
            let mut buffer = [Cell::ZERO; LANES];
            V::put_transposed(lanes, &mut buffer);
            put_last(cells, slice, &buffer);
        }
    }
}

#[cold]
fn put_last(cells: &mut [Cell], slice: usize, chunk: &Chunk) {
    let last = cells.get_mut(slice * LANES..).unwrap_or(&mut []);
    for (cell, value) in last.iter_mut().zip(chunk) {
        *cell = *value;
    }
}
