//! Loops cell by cell, for any number: the same sums in the same order as over slices.

pub(crate) mod euler;
pub(crate) mod pass;
pub(crate) mod track;

use core::ops::Range;

use crate::two_float::LANES;

/// The cells of a slice, as far as there are any.
#[inline(always)]
fn cells_of(slice: usize, cells: usize) -> Range<usize> {
    slice * LANES..cells.min((slice + 1) * LANES)
}

/// Part of an array, empty where it is shorter.
#[inline(always)]
fn part<'a, T>(array: &'a [T], range: &Range<usize>) -> core::slice::Iter<'a, T> {
    array.get(range.clone()).unwrap_or(&[]).iter()
}

/// Part of an array, empty where it is shorter.
#[inline(always)]
fn part_mut<'a, T>(array: &'a mut [T], range: &Range<usize>) -> core::slice::IterMut<'a, T> {
    array.get_mut(range.clone()).unwrap_or(&mut []).iter_mut()
}
