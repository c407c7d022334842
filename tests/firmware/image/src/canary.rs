//! What the gates must refuse.
#![allow(unsafe_code)]

use core::hint::black_box;

/// Reaches a panic or an allocator.
pub fn sing() {
    #[cfg(feature = "canary-panic")]
    {
        let thousandths = [1_u32, 2, 3];
        let at = black_box(1);
        black_box(thousandths[at]);
    }
    #[cfg(feature = "canary-alloc")]
    allocating::sing();
}

#[cfg(feature = "canary-alloc")]
mod allocating {
    extern crate alloc;

    use alloc::alloc::alloc;
    use core::alloc::{GlobalAlloc, Layout};
    use core::hint::black_box;

    /// Has nothing to give.
    struct Empty;

    // SAFETY: a null pointer is what an allocator without memory gives.
    unsafe impl GlobalAlloc for Empty {
        unsafe fn alloc(&self, _: Layout) -> *mut u8 {
            black_box(core::ptr::null_mut())
        }

        unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
    }

    #[global_allocator]
    static EMPTY: Empty = Empty;

    pub fn sing() {
        // SAFETY: the layout's size is not zero.
        black_box(unsafe { alloc(black_box(Layout::new::<u32>())) });
    }
}
