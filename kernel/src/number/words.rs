//! Arrays and double-precision numbers in words of the caller.

use bytemuck::{AnyBitPattern, NoUninit};

/// Takes an array of `words` words from the rest of the memory; `None` if there are too few.
pub(crate) fn take<'a, T: AnyBitPattern + NoUninit>(
    rest: &mut &'a mut [u32],
    words: usize,
) -> Option<&'a mut [T]> {
    let (first, after) = core::mem::take(rest).split_at_mut_checked(words)?;
    *rest = after;
    bytemuck::try_cast_slice_mut(first).ok()
}

/// A double-precision number in two words, the low one first.
pub(crate) type Double = [u32; 2];

/// The number of two words.
pub(crate) fn number(words: Double) -> f64 {
    let [low, high] = words;
    f64::from_bits(u64::from(high) << 32 | u64::from(low))
}

/// The words of a number; never -0.0.
pub(crate) fn words(number: f64) -> Double {
    let bits = (number + 0.0).to_bits();
    [bits as u32, (bits >> 32) as u32]
}
