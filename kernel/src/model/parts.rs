//! The parts of a large body: threads share them, and each has its own sums.
//!
//! A body of fewer than [`CELLS_SHARED`] cells is one part, any other is [`PARTS`] parts of
//! consecutive cells, in whole blocks of 512 cells. A pass of `track` and `predict` sums up each part
//! by itself and adds the parts in ascending order. So parts belong to the definition of the bits.

use core::ops::Range;

use crate::number::two_float::LANES;

/// Parts of a body that has several.
pub const PARTS: usize = 8;
/// Cells from which a body has several parts.
pub const CELLS_SHARED: usize = 16_384;

/// Slices in a block: as many as a word of a set of slices has bits.
const BLOCK: usize = 64;

/// Number of parts of a body of this number of cells: 1 below [`CELLS_SHARED`], else [`PARTS`].
///
/// ```
/// use chaincell_kernel::parts;
///
/// assert_eq!((parts::count(5_773), parts::count(59_753)), (1, 8));
/// ```
#[must_use]
pub const fn count(cells: usize) -> usize {
    if cells < CELLS_SHARED { 1 } else { PARTS }
}

/// Returns the part that a cell belongs to in a body of `all` cells.
#[must_use]
pub fn of_cell(all: usize, cell: usize) -> usize {
    (1..count(all)).rfind(|&part| cells(all, part).start <= cell).unwrap_or(0)
}

/// The slices of a part of a body.
pub(crate) fn slices(cells: usize, part: usize) -> Range<usize> {
    let slices = cells.div_ceil(LANES);
    let parts = count(cells);
    let start = |part: usize| slices.min(slices.div_ceil(BLOCK) * part / parts * BLOCK);
    start(part)..start(part + 1)
}

/// The cells of a part of a body.
pub(crate) fn cells(cells: usize, part: usize) -> Range<usize> {
    let slices = slices(cells, part);
    cells.min(slices.start * LANES)..cells.min(slices.end * LANES)
}

/// Cuts an array over the cells into the body's parts.
pub(crate) fn split<T>(array: &[T]) -> [&[T]; PARTS] {
    let mut part = 0;
    [(); PARTS].map(|()| {
        let of = array.get(cells(array.len(), part)).unwrap_or(&[]);
        part += 1;
        of
    })
}

/// As `split`, for writing.
pub(crate) fn split_mut<T>(array: &mut [T]) -> [&mut [T]; PARTS] {
    let (all, mut part, mut rest) = (array.len(), 0, array);
    [(); PARTS].map(|()| {
        let length = cells(all, part).len();
        part += 1;
        let (of, behind) =
            core::mem::take(&mut rest).split_at_mut_checked(length).unwrap_or_default();
        rest = behind;
        of
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    // REQ-BIT-08
    #[test]
    fn parts_are_consecutive_and_take_in_every_cell_once() {
        for all in [1, 8, 511, 16_383, 16_384, 16_385, 40_001, 65_535] {
            let parts = count(all);
            assert_eq!(parts == 1, all < 16_384);
            let ranges: Vec<_> = (0..parts).map(|part| cells(all, part)).collect();
            assert_eq!((ranges[0].start, ranges[parts - 1].end), (0, all));
            for cell in (0..all).step_by(97) {
                assert!(ranges[of_cell(all, cell)].contains(&cell), "{cell} of {all}");
            }
            for pair in ranges.windows(2) {
                assert!(pair[0].end == pair[1].start && pair[1].start % 512 == 0);
                assert!(pair[0].len() >= all / PARTS - 512 && !pair[1].is_empty());
            }
        }
    }

    #[test]
    fn arrays_are_cut_as_the_cells_are() {
        let mut array: Vec<usize> = (0..20_003).collect();
        let starts = split(&array).map(|part| (part[0], part.len()));
        let writable = split_mut(&mut array).map(|part| (part[0], part.len()));
        assert_eq!(starts, writable);
        assert_eq!(starts.map(|(start, _)| start)[1..3], [2_560, 5_120]);
        assert_eq!(starts.iter().map(|(_, length)| length).sum::<usize>(), 20_003);
    }
}
