//! How deep the stack has been: painted before the run, looked at after it.
#![allow(unsafe_code)]

use core::ptr::addr_of;

const PAINT: u32 = 0x57ac_4e55;
/// Room below the caller's frame that is left as it is [bytes].
const MARGIN: usize = 256;

unsafe extern "C" {
    /// End of all statics: the lowest address that the stack may reach.
    static __sheap: u32;
    /// Where the stack starts, downwards.
    static _stack_start: u32;
}

/// Paints what the stack has not reached yet.
pub fn paint() {
    let here = 0_u32;
    let end = addr_of!(here) as usize - MARGIN;
    let mut at = addr_of!(__sheap) as usize;
    while at < end {
        // SAFETY: the linker gives the addresses from the end of the statics up to the stack to
        // nobody else.
        unsafe { (at as *mut u32).write_volatile(PAINT) };
        at += 4;
    }
}

/// Bytes of the stack that were in use at the deepest moment since.
pub fn deepest() -> u32 {
    let end = addr_of!(_stack_start) as usize;
    let mut at = addr_of!(__sheap) as usize;
    // SAFETY: as above; the addresses are read whole words.
    while at < end && unsafe { (at as *const u32).read_volatile() } == PAINT {
        at += 4;
    }
    (end - at) as u32
}
