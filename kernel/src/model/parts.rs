//! The parts of a large body: threads share them, and each has its own sums.
//!
//! A small body is one part, any other several parts of consecutive cells, in whole blocks of 512 cells. A
//! pass of `track` and `predict` sums up each part by itself and adds the parts in ascending order; the cells
//! of a part of nodal shapes push their neighbours in forces of their own, which are added in that order too.
//! Passes around tools are divided by the slices in them instead.
//! So parts belong to the definition of the bits.

use core::ops::Range;

use crate::number::two_float::LANES;

/// Most parts of a body.
pub const PARTS: usize = 8;
/// Parts of a large body of nodal shapes.
pub const SHAPE_PARTS: usize = 4;
/// Cells from which a body of links has several parts.
pub const LINKS_SHARED: usize = 16_384;
/// Cells from which a body of nodal shapes has several parts.
pub const SHAPES_SHARED: usize = 4_096;

/// Slices in a block: as many as a word of a set of slices has bits.
const BLOCK: usize = 64;

/// The division of a body into parts.
///
/// ```
/// use chaincell_kernel::parts::Parts;
///
/// assert_eq!((Parts::of_links(5_773).count(), Parts::of_links(59_753).count()), (1, 8));
/// assert_eq!((Parts::of_shapes(995).count(), Parts::of_shapes(5_773).count()), (1, 4));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parts {
    cells: usize,
    count: usize,
}

impl Parts {
    /// Parts of a body of links with `cells` cells: [`PARTS`] from [`LINKS_SHARED`] cells on.
    #[must_use]
    pub const fn of_links(cells: usize) -> Self {
        Self { cells, count: if cells < LINKS_SHARED { 1 } else { PARTS } }
    }

    /// Parts of a body of nodal shapes with `cells` cells: [`SHAPE_PARTS`] from [`SHAPES_SHARED`] cells on.
    #[must_use]
    pub const fn of_shapes(cells: usize) -> Self {
        Self { cells, count: if cells < SHAPES_SHARED { 1 } else { SHAPE_PARTS } }
    }

    /// Number of parts.
    #[must_use]
    #[inline(always)]
    pub const fn count(self) -> usize {
        self.count
    }

    /// Returns the part that a cell belongs to.
    #[must_use]
    pub fn of_cell(self, cell: usize) -> usize {
        (1..self.count).rfind(|&part| self.cells(part).start <= cell).unwrap_or(0)
    }

    /// The first slice of a part.
    #[inline(always)]
    const fn start(self, part: usize) -> usize {
        let slices = self.cells.div_ceil(LANES);
        let start = slices.div_ceil(BLOCK) * part / self.count * BLOCK;
        if start < slices { start } else { slices }
    }

    /// The slices of a part; none beyond the last one.
    #[inline(always)]
    pub(crate) fn slices(self, part: usize) -> Range<usize> {
        self.start(part)..self.start(part + 1)
    }

    /// The cells of a part.
    pub(crate) fn cells(self, part: usize) -> Range<usize> {
        let slices = self.slices(part);
        self.cells.min(slices.start * LANES)..self.cells.min(slices.end * LANES)
    }

    /// The works of the parts, each over its slices.
    #[inline(always)]
    pub(crate) fn each<W>(self, mut work: impl FnMut(Range<usize>) -> W) -> [Option<W>; PARTS] {
        let mut parts = 0..self.count;
        [(); PARTS].map(|()| Some(work(self.slices(parts.next()?))))
    }

    /// Cuts an array over the cells into the parts.
    pub(crate) fn split<T>(self, array: &[T]) -> [&[T]; PARTS] {
        let mut part = 0;
        [(); PARTS].map(|()| {
            let of = array.get(self.cells(part)).unwrap_or(&[]);
            part += 1;
            of
        })
    }

    /// As `split`, for writing.
    pub(crate) fn split_mut<T>(self, array: &mut [T]) -> [&mut [T]; PARTS] {
        let (mut part, mut rest) = (0, array);
        [(); PARTS].map(|()| {
            let length = self.cells(part).len();
            part += 1;
            let (of, behind) =
                core::mem::take(&mut rest).split_at_mut_checked(length).unwrap_or_default();
            rest = behind;
            of
        })
    }
}

/// The division of a loop over slices of nodal shapes: by the parts of the body, or of a set of slices.
#[derive(Clone, Copy)]
pub(crate) struct Division {
    /// The first slice of each part; [`Self::NO_SLICE`] for those that do not exist.
    starts: [u16; SHAPE_PARTS],
    slices: usize,
}

impl Division {
    const NO_SLICE: u16 = u16::MAX;

    /// Division by the parts of a body of shapes.
    pub const fn of_shapes(cells: usize) -> Self {
        let parts = Parts::of_shapes(cells);
        let starts = [
            Self::first(parts, 0),
            Self::first(parts, 1),
            Self::first(parts, 2),
            Self::first(parts, 3),
        ];
        Self { starts, slices: cells.div_ceil(LANES) }
    }

    const fn first(parts: Parts, part: usize) -> u16 {
        if part < parts.count { parts.start(part) as u16 } else { Self::NO_SLICE }
    }

    /// As many parts, each with as many slices of a set of `count` slices.
    pub fn of_set(self, set: impl Iterator<Item = usize> + Clone, count: usize) -> Self {
        let (mut next, parts) = (0, self.count());
        let starts = self.starts.map(|start| {
            let part = next;
            next += 1;
            if part == 0 || start == Self::NO_SLICE {
                return start;
            }
            let at = (count * part).checked_div(parts).unwrap_or(0);
            set.clone().nth(at).unwrap_or(self.slices) as u16
        });
        Self { starts, ..self }
    }

    /// Number of parts.
    #[inline(always)]
    pub fn count(self) -> usize {
        self.starts.iter().take_while(|&&start| start != Self::NO_SLICE).count()
    }

    /// Returns the part that a slice belongs to.
    #[inline(always)]
    pub fn of_slice(self, slice: usize) -> usize {
        self.starts.iter().skip(1).take_while(|&&start| usize::from(start) <= slice).count()
    }

    /// The works of the parts, each over its slices.
    #[inline(always)]
    pub fn each<W>(self, mut work: impl FnMut(Range<usize>) -> W) -> [Option<W>; PARTS] {
        let start = |part: usize| {
            self.starts.get(part).map_or(self.slices, |&start| self.slices.min(usize::from(start)))
        };
        let mut parts = 0..self.count();
        [(); PARTS].map(|()| {
            let part = parts.next()?;
            Some(work(start(part)..start(part + 1)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// Divisions of bodies of several sizes.
    fn divisions() -> impl Iterator<Item = (usize, Parts)> {
        [1, 8, 511, 4_095, 4_096, 4_609, 16_383, 16_384, 16_385, 40_001, 65_535]
            .into_iter()
            .flat_map(|all| [(all, Parts::of_links(all)), (all, Parts::of_shapes(all))])
    }

    // REQ-BIT-08
    #[test]
    fn parts_are_consecutive_and_take_in_every_cell_once() {
        for (all, parts) in divisions() {
            let count = parts.count();
            let is_small = parts == Parts::of_links(all) && all < LINKS_SHARED;
            assert_eq!(count == 1, is_small || all < SHAPES_SHARED);
            let ranges: Vec<_> = (0..count).map(|part| parts.cells(part)).collect();
            assert_eq!((ranges[0].start, ranges[count - 1].end), (0, all));
            assert!((count..PARTS).all(|part| parts.cells(part).is_empty()));
            for cell in (0..all).step_by(97) {
                assert!(ranges[parts.of_cell(cell)].contains(&cell), "{cell} of {all}");
            }
            for pair in ranges.windows(2) {
                assert!(pair[0].end == pair[1].start && pair[1].start % 512 == 0);
                assert!(pair[0].len() >= all / count - 512 && !pair[1].is_empty());
            }
        }
    }

    /// The slices of the parts.
    fn ranges(division: Division) -> Vec<Range<usize>> {
        division.each(|slices| slices).into_iter().flatten().collect()
    }

    // REQ-BIT-08
    #[test]
    fn a_division_has_the_parts_of_the_body_or_as_many_slices_of_a_set_each() {
        for cells in [8, 511, 4_095, 4_096, 4_609, 16_385, 65_535] {
            let (division, parts) = (Division::of_shapes(cells), Parts::of_shapes(cells));
            let expected: Vec<_> = (0..parts.count()).map(|part| parts.slices(part)).collect();
            assert_eq!(ranges(division), expected);
            let of_slice = |slice| expected.iter().position(|part| part.contains(&slice)).unwrap();
            for slice in 0..cells.div_ceil(LANES) {
                assert_eq!(division.of_slice(slice), of_slice(slice), "{slice} of {cells}");
            }
        }
        let large = Division::of_shapes(8_000);
        let set = (100..900).step_by(7);
        let of_set = ranges(large.of_set(set.clone(), set.len()));
        assert_eq!((of_set[0].start, of_set[3].end), (0, 1_000));
        let within = |part: &Range<usize>| set.clone().filter(|at| part.contains(at)).count();
        assert!(of_set.iter().all(|part| within(part).abs_diff(set.len() / 4) < 2), "{of_set:?}");
        assert!(
            ranges(large.of_set([5, 9].into_iter(), 2)).iter().map(Range::len).sum::<usize>()
                == 1_000
        );
        let small = Division::of_shapes(800);
        assert_eq!(ranges(small.of_set(0..50, 50)), ranges(small));
    }

    #[test]
    fn arrays_are_cut_as_the_cells_are() {
        for (parts, expected) in
            [(Parts::of_links(20_003), [2_560, 5_120]), (Parts::of_shapes(20_003), [5_120, 10_240])]
        {
            let mut array: Vec<usize> = (0..20_003).collect();
            let starts = parts.split(&array).map(|part| (part.first().copied(), part.len()));
            let writable =
                parts.split_mut(&mut array).map(|part| (part.first().copied(), part.len()));
            assert_eq!(starts, writable);
            assert_eq!(starts.map(|(start, _)| start)[1..3], expected.map(Some));
            assert_eq!(starts.iter().map(|(_, length)| length).sum::<usize>(), 20_003);
        }
    }
}
