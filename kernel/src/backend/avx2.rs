//! AVX2: eight lanes in one register.

#![allow(unsafe_code)]

use core::arch::x86_64::*;

use fearless_simd::{f32x8, kernel, prelude::*};

pub(super) use fearless_simd::x86::Avx2 as Unit;

/// Returns true if processor and operating system offer what [`Unit`] stands for: AVX2 and all else of the
/// level x86-64-v3.
pub(super) fn is_offered() -> bool {
    const FMA_CMPXCHG16B: u32 = 1 << 12 | 1 << 13;
    const MOVBE_POPCNT: u32 = 1 << 22 | 1 << 23;
    const XSAVE_OSXSAVE_AVX_F16C: u32 = 0b1111 << 26;
    const FIRST: u32 = FMA_CMPXCHG16B | MOVBE_POPCNT | XSAVE_OSXSAVE_AVX_F16C;
    const BMI1_AVX2_BMI2: u32 = 1 << 3 | 1 << 5 | 1 << 8;
    const LZCNT: u32 = 1 << 5;
    const YMM_SAVED: u64 = 0b110;
    if __cpuid(0).eax < 7 || __cpuid(1).ecx & FIRST != FIRST {
        return false;
    }
    // SAFETY: OSXSAVE says that the instruction exists.
    let saved = unsafe { _xgetbv(0) };
    saved & YMM_SAVED == YMM_SAVED
        && __cpuid_count(7, 0).ebx & BMI1_AVX2_BMI2 == BMI1_AVX2_BMI2
        && __cpuid(0x8000_0000).eax > 0x8000_0000
        && __cpuid(0x8000_0001).ecx & LZCNT != 0
}

kernel!(
    /// Transposes the low halves of four rows, and the high ones; it is its own inverse.
    #[inline(always)]
    pub(super) fn transposed(unit: Avx2, rows: [f32x8<Unit>; 4]) -> [f32x8<Unit>; 4] {
        let [a, b, c, d] = rows.map(__m256::from);
        let (xy_low, xy_high) = (_mm256_unpacklo_ps(a, c), _mm256_unpacklo_ps(b, d));
        let (zw_low, zw_high) = (_mm256_unpackhi_ps(a, c), _mm256_unpackhi_ps(b, d));
        [
            _mm256_unpacklo_ps(xy_low, xy_high).simd_into(unit),
            _mm256_unpackhi_ps(xy_low, xy_high).simd_into(unit),
            _mm256_unpacklo_ps(zw_low, zw_high).simd_into(unit),
            _mm256_unpackhi_ps(zw_low, zw_high).simd_into(unit),
        ]
    }
);

/// Calls a function that is always inlined, from a function of its own that is compiled for the unit. `_unit` is
/// the proof that the unit is there.
#[inline(always)]
pub(super) fn apart<R>(_unit: Unit, work: impl FnOnce() -> R) -> R {
    #[inline(never)]
    #[target_feature(enable = "avx2,bmi1,bmi2,cmpxchg16b,f16c,fma,fxsr,lzcnt,movbe,popcnt,xsave")]
    fn alone<R>(work: impl FnOnce() -> R) -> R {
        work()
    }
    // SAFETY: a token of the unit exists only where processor and system offer it.
    unsafe { alone(work) }
}
