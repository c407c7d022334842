//! The check of the floating-point environment sees what other libraries leave behind.
#![cfg(target_arch = "x86_64")]
#![allow(deprecated, unsafe_code)]

use std::arch::x86_64::{_mm_getcsr, _mm_setcsr};

use chaincell_kernel::float_env::FloatEnvironmentError::{FlushToZero, Rounding};
use chaincell_kernel::float_env::check;

#[test]
fn flushing_and_directed_rounding_are_seen() {
    let flush_to_zero = 0x8000;
    let denormals_are_zero = 0x0040;
    let [down, up, towards_zero] = [0x2000, 0x4000, 0x6000];
    let modes = [flush_to_zero, denormals_are_zero, down, up, towards_zero];
    let seen = modes.map(|bits| {
        // SAFETY: the register is restored before anything else runs on this thread.
        unsafe {
            let before = _mm_getcsr();
            _mm_setcsr(before | bits);
            let seen = check();
            _mm_setcsr(before);
            seen
        }
    });
    assert_eq!(seen, [FlushToZero, FlushToZero, Rounding, Rounding, Rounding].map(Err));
}
