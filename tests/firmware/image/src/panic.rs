//! No panic may be left: its handler calls a function that does not exist, so the link fails
//! wherever the optimised image can still reach it.
#![allow(unsafe_code)]

use core::panic::PanicInfo;

unsafe extern "C" {
    fn a_panic_is_left_in_the_image() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: never linked, so never called.
    unsafe { a_panic_is_left_in_the_image() }
}
