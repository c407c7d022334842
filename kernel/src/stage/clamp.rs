//! Magnitude clamp: the largest force that the device may be given.

use crate::number::cell::{dot, scale};
use crate::number::sqrt::sqrt;

/// `force` shortened to `most` \[N\], and whether that bit.
pub(super) fn clamped(force: [f32; 3], most: f32) -> ([f32; 3], bool) {
    let magnitude = sqrt(dot(force, force));
    // A magnitude is rounded too.
    if magnitude <= super::ROUND_DOWN * most {
        return (force, false);
    }
    (scale(super::ROUND_DOWN * most / magnitude, force), true)
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
}
