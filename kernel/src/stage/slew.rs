//! Slew limit: how far a force may be from the one before.

use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;

/// `force` moved towards `target` by at most `most` \[N\], within the rounding of its coordinates.
pub(super) fn limited(force: [f32; 3], target: [f32; 3], most: f32) -> [f32; 3] {
    let way = sub(target, force);
    let length = sqrt(dot(way, way));
    if length <= most {
        return target;
    }
    add(force, scale(super::ROUND_DOWN * most / length, way))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_as_long_as_it_may_be() {
        assert_eq!(limited([1.0; 3], [1.5, 1.0, 1.0], 0.5), [1.5, 1.0, 1.0]);
        assert_eq!(limited([0.0; 3], [9.0, 0.0, 0.0], f32::INFINITY), [9.0, 0.0, 0.0]);
        let [x, y, z] = limited([0.0; 3], [0.0, 30.0, -40.0], 0.5);
        assert!(x == 0.0 && (y - 0.3).abs() < 1e-6 && (z + 0.4).abs() < 1e-6);
        assert!(x * x + y * y + z * z <= 0.25);
    }
}
