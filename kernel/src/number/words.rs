//! Arrays in words of the caller.

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
