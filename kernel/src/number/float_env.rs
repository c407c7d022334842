//! The floating-point environment the bits rely on: round to nearest, denormals kept, no trap.

use core::hint::black_box;

use super::sqrt::exceptions_are_masked;

#[cfg(all(target_arch = "x86", not(target_feature = "sse2")))]
compile_error!("x87 arithmetic carries excess precision: build for a target with SSE2");

/// A fault of the floating-point environment of the calling thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum FloatEnvironmentError {
    /// Denormal numbers are flushed to zero (FTZ, DAZ or FZ is on).
    #[error("denormals are flushed to zero: switch FTZ/DAZ/FZ off")]
    FlushToZero,
    /// The rounding mode is not round-to-nearest-even.
    #[error("rounding is not to nearest: restore the default rounding mode")]
    Rounding,
    /// An exception stops the program. Results below the normal numbers are part of every tick, and
    /// unused lanes of vector units divide 0 by 0.
    #[error(
        "floating-point exceptions stop the program: mask them, by fedisableexcept(FE_ALL_EXCEPT)"
    )]
    Trap,
}

/// Checks that this thread's arithmetic is IEEE 754 to nearest: reads the control register of a 64-bit x86 or
/// Arm processor, then tries six operations.
///
/// ```
/// use chaincell_kernel::float_env;
///
/// assert_eq!(float_env::check(), Ok(())); // before a run, on the thread that ticks
/// ```
///
/// # Errors
/// The first fault found: a trap, flushed denormals, or another rounding.
pub fn check() -> Result<(), FloatEnvironmentError> {
    // This check comes first, since the operations below raise exceptions.
    if !exceptions_are_masked() {
        return Err(FloatEnvironmentError::Trap);
    }
    let smallest = black_box(f32::from_bits(1));
    let half_normal = black_box(f32::MIN_POSITIVE) * black_box(0.5);
    if half_normal == 0.0 || smallest * black_box(2.0) == 0.0 {
        return Err(FloatEnvironmentError::FlushToZero);
    }
    let one = black_box(1.0_f32);
    let quarter_ulp = black_box(f32::EPSILON * 0.25);
    let nearest = one + quarter_ulp == one
        && one - quarter_ulp * 0.5 == one
        && -one - quarter_ulp == -one
        && -one + quarter_ulp * 0.5 == -one;
    if nearest { Ok(()) } else { Err(FloatEnvironmentError::Rounding) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_default_environment_passes() {
        assert_eq!(super::check(), Ok(()));
    }
}
