//! Magnitude clamps: the largest force that may be given, the largest number that a word holds.

use super::cell::{dot, scale};
use super::sqrt::sqrt;

/// Factor that leaves a margin for rounding when a length is shortened.
pub(crate) const ROUND_DOWN: f32 = 1.0 - 4.0 * f32::EPSILON;

/// A limit below this admits no force: the squares of so small a force may underflow \[N\].
const LEAST: f32 = 1.0e-15;

/// Returns `force` shortened to `most` \[N\], and true if that changed it; a limit below [`LEAST`] admits no
/// force.
pub(crate) fn clamped(force: [f32; 3], most: f32) -> ([f32; 3], bool) {
    if most < LEAST {
        return ([0.0; 3], force != [0.0; 3]);
    }
    let magnitude = sqrt(dot(force, force));
    // The magnitude is rounded too: keep a margin.
    if magnitude <= ROUND_DOWN * most && magnitude <= f32::MAX {
        return (force, false);
    }
    let most = ROUND_DOWN * finite(most);
    if magnitude <= f32::MAX {
        return (scale(most / magnitude, force), true);
    }
    // The squares overflow: scale the force down first.
    let force = scale(1.0e-20, force.map(finite));
    (scale(most, scale(1.0 / sqrt(dot(force, force)), force)), true)
}

/// Returns `value`, or the largest number of its sign if it is infinite; NaN gives the largest number.
#[inline(always)]
pub(crate) fn finite(value: f32) -> f32 {
    // Not by `clamp`, which may panic.
    let value = if value < f32::MAX { value } else { f32::MAX };
    if value > f32::MIN { value } else { f32::MIN }
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-STG-05
    #[test]
    fn direction_is_kept() {
        assert_eq!(clamped([0.0, 3.0, 4.0], 5.1), ([0.0, 3.0, 4.0], false));
        let ([x, y, z], bit) = clamped([0.0, 30.0, -40.0], 5.0);
        assert!(bit && x == 0.0 && (y - 3.0).abs() < 1e-5 && (z + 4.0).abs() < 1e-5);
        assert!(y * y + z * z <= 25.0);
    }

    #[test]
    fn what_is_beyond_the_numbers_is_the_largest_of_them() {
        let beyond = [f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        assert_eq!(beyond.map(finite), [f32::MAX, f32::MIN, f32::MAX]);
        assert_eq!([0.0, -1.5, f32::MIN, 1e-40].map(finite), [0.0, -1.5, f32::MIN, 1e-40]);
    }

    #[test]
    fn a_force_beyond_the_numbers_is_clamped_like_another() {
        let (of, bit) = clamped([0.0, 3.0e30, -4.0e30], 5.0);
        assert!(bit && of[0] == 0.0 && (of[1] - 3.0).abs() < 1e-5 && (of[2] + 4.0).abs() < 1e-5);
        for most in [5.0, f32::MAX, f32::INFINITY] {
            let (of, bit) = clamped([f32::INFINITY, f32::NAN, 1.0], most);
            assert!(bit && of.iter().all(|x| x.is_finite()), "{most}: {of:?}");
        }
    }

    #[test]
    fn the_smallest_limits_admit_no_force() {
        assert_eq!(clamped([1.0e-34, 0.0, 0.0], 9.1e-36), ([0.0; 3], true));
        assert_eq!(clamped([0.0; 3], 9.1e-36), ([0.0; 3], false));
        let (of, bit) = clamped([1.0, 0.0, 0.0], 2.0e-15);
        assert!(bit && of[0] > 0.0 && of[0] <= 2.0e-15);
    }

    #[test]
    fn no_force_is_above_the_largest() {
        for n in 0..2000_u16 {
            let force = [0.3 + 0.01 * f32::from(n), 2.0 - 0.007 * f32::from(n), 0.1];
            let most = 0.2 + 1.0e-4 * f32::from(n);
            let (of, bit) = clamped(force, most);
            let squared: f64 = of.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
            assert!(bit && squared <= f64::from(most) * f64::from(most), "{n}: {of:?} {most}");
        }
    }
}
