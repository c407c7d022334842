//! Slew limit: bounds the change of the force per tick.

use crate::number::cell::{add, dot, scale, sub};
use crate::number::clamp::ROUND_DOWN;
use crate::number::sqrt::sqrt;

/// Moves `force_n` towards `target_n` by at most `most_n`, within the rounding of its coordinates \[N\].
#[must_use]
pub fn slew_limited(force_n: [f32; 3], target_n: [f32; 3], most_n: f32) -> [f32; 3] {
    let way = sub(target_n, force_n);
    let length = sqrt(dot(way, way));
    if length <= most_n {
        return target_n;
    }
    add(force_n, scale(ROUND_DOWN * most_n / length, way))
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-STG-05
    #[test]
    fn a_step_is_as_long_as_it_may_be() {
        assert_eq!(slew_limited([1.0; 3], [1.5, 1.0, 1.0], 0.5), [1.5, 1.0, 1.0]);
        assert_eq!(slew_limited([0.0; 3], [9.0, 0.0, 0.0], f32::INFINITY), [9.0, 0.0, 0.0]);
        let [x, y, z] = slew_limited([0.0; 3], [0.0, 30.0, -40.0], 0.5);
        assert!(x == 0.0 && (y - 0.3).abs() < 1e-6 && (z + 0.4).abs() < 1e-6);
        assert!(x * x + y * y + z * z <= 0.25);
    }
}
