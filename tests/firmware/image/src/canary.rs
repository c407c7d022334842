//! What the gates must refuse.
#![allow(unsafe_code)]

use core::hint::black_box;

#[cfg(feature = "canary-alloc")]
extern crate alloc;

/// Reaches a panic or an allocator.
pub fn sing() {
    #[cfg(feature = "canary-panic")]
    {
        let thousandths = [1_u32, 2, 3];
        let at = black_box(1);
        black_box(thousandths[at]);
    }
    #[cfg(feature = "canary-alloc")]
    {
        let layout = core::alloc::Layout::new::<u32>();
        // SAFETY: the layout's size is not zero.
        black_box(unsafe { alloc::alloc::alloc(black_box(layout)) });
    }
}
