//! Loops cell by cell, for any number: the same sums in the same order as over slices.

pub(crate) mod euler;
pub(crate) mod track;

use core::ops;

use crate::number::Number;
use crate::number::cell::peak;

/// The linear range, |coordinate| at most K.
pub(crate) struct Range<N: Number> {
    k: N,
    /// Points with a smaller sum of squared coordinates are within the range.
    pub near: N::Product,
}

impl<N: Number> Range<N> {
    pub fn new(k: f32) -> Self {
        // Margin for the rounding of the sum of squares.
        const INWARD: f32 = 1.0 - 1.0 / 65_536.0;
        let [k, inner] = [k, INWARD * k].map(N::from_single);
        Self { k, near: N::inner([inner, N::ZERO, N::ZERO], [inner, N::ZERO, N::ZERO]) }
    }

    /// Returns true if one of two points has a coordinate beyond K.
    #[inline(always)]
    pub fn is_left(&self, a: [N; 3], b: [N; 3]) -> bool {
        let inside = |point: [N; 3]| N::inner(point, point) < self.near;
        !(inside(a) && inside(b)) && (peak(a) > self.k || peak(b) > self.k)
    }
}

/// A part of an array; empty if the array is shorter.
#[inline(always)]
fn part<'a, T>(array: &'a [T], range: &ops::Range<usize>) -> core::slice::Iter<'a, T> {
    array.get(range.clone()).unwrap_or(&[]).iter()
}

/// A part of an array; empty if the array is shorter.
#[inline(always)]
fn part_mut<'a, T>(array: &'a mut [T], range: &ops::Range<usize>) -> core::slice::IterMut<'a, T> {
    array.get_mut(range.clone()).unwrap_or(&mut []).iter_mut()
}
