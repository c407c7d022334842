//! Sets of slices of eight consecutive cells.

use core::ops::Range;

use crate::model::image::CELLS_MAX;
use crate::number::kept::kept;
use crate::number::two_float::LANES;

const WORDS: usize = CELLS_MAX.div_ceil(LANES * 64);

kept! {
    /// A set of slices.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub(crate) struct SliceSet([u64; WORDS]);
}

impl SliceSet {
    pub const EMPTY: Self = Self([0; WORDS]);

    #[inline(always)]
    pub fn insert(&mut self, slice: usize) {
        if let Some(word) = self.0.get_mut(slice / 64) {
            *word |= 1 << (slice % 64);
        }
    }

    #[inline(always)]
    pub fn contains(&self, slice: usize) -> bool {
        self.0.get(slice / 64).is_some_and(|word| word >> (slice % 64) & 1 != 0)
    }

    /// Sets it to the first `slices` slices.
    pub fn fill(&mut self, slices: usize) {
        let mut left = slices;
        for word in &mut self.0 {
            *word = if left >= 64 { u64::MAX } else { (1 << left) - 1 };
            left = left.saturating_sub(64);
        }
    }

    #[inline(always)]
    pub fn is_empty(&self, slices: usize) -> bool {
        self.0.iter().take(slices.div_ceil(64)).all(|&word| word == 0)
    }

    /// Returns the slices of the set among the first `slices`, ascending.
    #[inline(always)]
    pub fn iter(&self, slices: usize) -> Iter<'_> {
        self.iter_in(0..slices)
    }

    /// As [`Self::iter`], for a range. It must start at a multiple of 64, and end at one or at the end of all
    /// slices.
    #[inline(always)]
    pub fn iter_in(&self, slices: Range<usize>) -> Iter<'_> {
        let words = self.0.get(..slices.end.div_ceil(64)).unwrap_or(&self.0);
        let at = slices.start / 64;
        Iter { words, at, left: words.get(at).copied().unwrap_or(0) }
    }

    /// As [`Self::iter_in`], for any range.
    #[inline(always)]
    pub fn between(&self, slices: Range<usize>) -> impl Iterator<Item = usize> {
        let Range { start, end } = slices;
        let whole = self.iter_in(start / 64 * 64..end);
        whole.skip_while(move |&slice| slice < start).take_while(move |&slice| slice < end)
    }

    /// Adds the slices of another set.
    pub fn unite(&mut self, other: &Self) {
        for (word, more) in self.0.iter_mut().zip(other.0) {
            *word |= more;
        }
    }
}

/// Slices of a set, ascending.
#[derive(Clone)]
pub(crate) struct Iter<'a> {
    words: &'a [u64],
    at: usize,
    /// Remaining bits of the word `at`.
    left: u64,
}

impl Iterator for Iter<'_> {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        while self.left == 0 {
            self.at += 1;
            self.left = *self.words.get(self.at)?;
        }
        let slice = self.at * 64 + self.left.trailing_zeros() as usize;
        self.left &= self.left - 1;
        Some(slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn sets_hold_what_was_put_in_ascending() {
        let mut set = SliceSet::EMPTY;
        for slice in [130, 3, 64, 8191] {
            set.insert(slice);
        }
        assert_eq!(set.iter(8192).collect::<Vec<_>>(), [3, 64, 130, 8191]);
        let parts = [0..64, 64..128, 128..8192].map(|part| set.iter_in(part).collect::<Vec<_>>());
        assert_eq!(parts, [vec![3], vec![64], vec![130, 8191]]);
        let any = [0..64, 4..65, 65..131, 131..131].map(|any| set.between(any).collect::<Vec<_>>());
        assert_eq!(any, [vec![3], vec![64], vec![130], vec![]]);
        let mut both = SliceSet::EMPTY;
        both.insert(5);
        both.unite(&set);
        assert_eq!(both.iter(8192).collect::<Vec<_>>(), [3, 5, 64, 130, 8191]);
        assert!(set.contains(64) && !set.contains(65) && !set.is_empty(1000));
        for slices in [0, 1, 63, 64, 65, 8192] {
            set.fill(slices);
            assert!(set.iter(8192).eq(0..slices));
            assert_eq!(set.is_empty(8192), slices == 0);
        }
    }
}
