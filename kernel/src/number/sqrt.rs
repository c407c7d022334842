//! Functions that need an instruction of the target: the correctly rounded square root, and a read of the
//! control register.
//!
//! Without an instruction the root is that of `libm`. Both are correctly rounded (IEEE 754), so every
//! target gives the same bits. An approximate inverse root (the start value of `micromath` and two Newton
//! steps) takes longer on a Cortex-M7: 121,950 instructions a sweep of the plane where root and division
//! take 102,250.

/// Square root of `a`; NaN for negative `a`.
///
/// ```
/// use chaincell_kernel::number::sqrt::sqrt;
///
/// assert_eq!(sqrt(2.0), 2.0_f32.sqrt()); // correctly rounded, without `std`
/// assert!(sqrt(-1.0).is_nan());
/// ```
#[must_use]
#[inline(always)]
#[cfg(target_arch = "x86_64")]
pub fn sqrt(a: f32) -> f32 {
    use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};
    // SAFETY: SSE is part of every x86-64 target.
    unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(a))) }
}

/// Square root of `a`; NaN for negative `a`.
#[must_use]
#[inline(always)]
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
pub fn sqrt(a: f32) -> f32 {
    use core::arch::aarch64::{vdup_n_f32, vget_lane_f32, vsqrt_f32};
    // SAFETY: NEON is part of this target.
    unsafe { vget_lane_f32::<0>(vsqrt_f32(vdup_n_f32(a))) }
}

/// Square root of `a`; NaN for negative `a`.
#[must_use]
#[inline(always)]
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
pub fn sqrt(a: f32) -> f32 {
    let root: u32;
    // The compiler does not admit FPU registers as operands here, only as clobbers.
    // SAFETY: the hard-float ABI says that the FPU is there; the code touches no memory.
    unsafe {
        core::arch::asm!("vmov s0, {a}", "vsqrt.f32 s0, s0", "vmov {root}, s0",
            a = in(reg) a.to_bits(), root = out(reg) root, out("s0") _,
            options(pure, nomem, nostack));
    }
    f32::from_bits(root)
}

/// Square root of `a`; NaN for negative `a`.
#[must_use]
#[inline(always)]
#[cfg(all(any(target_arch = "riscv32", target_arch = "riscv64"), target_feature = "f"))]
pub fn sqrt(a: f32) -> f32 {
    let root: f32;
    // SAFETY: the F extension of the target has the instruction; it touches no memory.
    unsafe {
        core::arch::asm!("fsqrt.s {root}, {a}", root = out(freg) root, a = in(freg) a,
            options(pure, nomem, nostack));
    }
    root
}

/// Square root of `a`; NaN for negative `a`.
#[must_use]
#[inline(always)]
#[cfg(not(any(
    target_arch = "x86_64",
    all(target_arch = "aarch64", target_feature = "neon"),
    all(target_arch = "arm", target_abi = "eabihf"),
    all(any(target_arch = "riscv32", target_arch = "riscv64"), target_feature = "f")
)))]
pub fn sqrt(a: f32) -> f32 {
    libm::sqrtf(a)
}

/// Returns true if no floating-point exception stops the program on this thread.
#[cfg(target_arch = "x86_64")]
pub(crate) fn exceptions_are_masked() -> bool {
    const MASKS: u32 = 0x1f80;
    let mut control = 0_u32;
    // SAFETY: SSE is part of every x86-64 target; the instruction writes these four bytes alone.
    unsafe {
        core::arch::asm!("stmxcsr [{}]", in(reg) &raw mut control, options(nostack, preserves_flags));
    }
    control & MASKS == MASKS
}

/// Returns true if no floating-point exception stops the program on this thread.
#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
pub(crate) fn exceptions_are_masked() -> bool {
    const TRAPS: u64 = 0x9f00;
    let control: u64;
    // SAFETY: the register is part of every target with NEON; the code touches no memory.
    unsafe {
        core::arch::asm!("mrs {}, fpcr", out(reg) control, options(nomem, nostack, preserves_flags));
    }
    control & TRAPS == 0
}

/// Returns true: no floating-point exception stops the program on these processors.
#[cfg(not(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon"))))]
pub(crate) fn exceptions_are_masked() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::sqrt;

    // REQ-BIT-04
    #[test]
    fn agrees_with_libm_to_the_last_bit() {
        let mut bits = 1_u32;
        while bits < 0x7f80_0000 {
            let a = f32::from_bits(bits);
            assert_eq!(sqrt(a).to_bits(), libm::sqrtf(a).to_bits(), "{a:e}");
            bits += 7919;
        }
        assert_eq!(sqrt(0.0).to_bits(), 0);
        assert!(sqrt(-1.0).is_nan());
    }
}
