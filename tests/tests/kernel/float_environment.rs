//! The check of the floating-point environment sees what other libraries leave behind.
#![cfg(target_arch = "x86_64")]
#![allow(deprecated, unsafe_code)]

use std::arch::x86_64::{_mm_getcsr, _mm_setcsr};

use chaincell_kernel::float_env::FloatEnvironmentError::{self, FlushToZero, Rounding, Trap};
use chaincell_kernel::float_env::check;
use chaincell_kernel::{Model, ModelError, include_model};

static PLANE9: &[u8] = include_model!("../../data/plane9.chaincell");

/// What `look` sees with these bits of the control register set, and those cleared.
fn with<T>([set, cleared]: [u32; 2], look: impl Fn() -> T) -> T {
    // SAFETY: the register is restored before anything else runs on this thread.
    unsafe {
        let before = _mm_getcsr();
        _mm_setcsr((before | set) & !cleared);
        let seen = look();
        _mm_setcsr(before);
        seen
    }
}

/// Bits to be set and cleared, and what is to be seen then.
fn changes() -> Vec<([u32; 2], FloatEnvironmentError)> {
    let flush_to_zero = 0x8000;
    let denormals_are_zero = 0x0040;
    let [down, up, towards_zero] = [0x2000, 0x4000, 0x6000];
    let set = [flush_to_zero, denormals_are_zero, down, up, towards_zero];
    let seen = [FlushToZero, FlushToZero, Rounding, Rounding, Rounding];
    let set = set.into_iter().zip(seen).map(|(bits, seen)| ([bits, 0], seen));
    // Invalid, denormal, division by zero, overflow, underflow, inexact.
    let unmasked = (7..=12).map(|bit| ([0, 1 << bit], Trap));
    set.chain(unmasked).collect()
}

// REQ-BIT-06
#[test]
fn what_other_libraries_leave_behind_is_seen() {
    for (change, seen) in changes() {
        assert_eq!(with(change, check), Err(seen));
    }
    assert_eq!(check(), Ok(()));
}

/// By directed rounding the rest lengths would not be those of the positions.
// REQ-BIT-06
#[test]
fn a_model_names_the_arithmetic_and_not_a_number() {
    for (change, seen) in changes() {
        let why = with(change, || Model::from_bytes(PLANE9).map(|model| model.cells()));
        assert_eq!(why, Err(ModelError::Float(seen)));
    }
    assert_eq!(Model::from_bytes(PLANE9).map(|model| model.cells()), Ok(81));
}
