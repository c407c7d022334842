//! Magnitude clamp: the largest force that may be given.

use super::cell::{dot, scale};
use super::sqrt::sqrt;

/// Room for rounding where a length is cut.
pub(crate) const ROUND_DOWN: f32 = 1.0 - 4.0 * f32::EPSILON;

/// `force` shortened to `most` \[N\], and whether that bit.
pub(crate) fn clamped(force: [f32; 3], most: f32) -> ([f32; 3], bool) {
    let magnitude = sqrt(dot(force, force));
    // A magnitude is rounded too.
    if magnitude <= ROUND_DOWN * most {
        return (force, false);
    }
    (scale(ROUND_DOWN * most / magnitude, force), true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direction_is_kept() {
        assert_eq!(clamped([0.0, 3.0, 4.0], 5.1), ([0.0, 3.0, 4.0], false));
        let ([x, y, z], bit) = clamped([0.0, 30.0, -40.0], 5.0);
        assert!(bit && x == 0.0 && (y - 3.0).abs() < 1e-5 && (z + 4.0).abs() < 1e-5);
        assert!(y * y + z * z <= 25.0);
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
