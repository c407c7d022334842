//! Where the eye is: it looks at the contact, obliquely along the surface.

use nalgebra::Vector3;

/// Shares of the outward normal, of the level direction and of the height in the direction to the eye.
const OUTWARD: f64 = 0.6;
const LEVEL: f64 = 0.8;
const HIGH: f64 = 0.25;

/// Returns the direction from the body to the eye, and the one that is upwards in the picture: z, or y where
/// the eye is above.
pub(super) fn towards(
    points_m: &[[f64; 3]],
    contact_m: [f64; 3],
    outward: [f64; 3],
) -> ([f64; 3], [f64; 3]) {
    let up = Vector3::z();
    let outward = Vector3::from(outward).try_normalize(1e-12).unwrap_or(up);
    // Level, across the body's longest extent, on the contact's side.
    let across = Vector3::from(front(points_m, up.into()));
    let level = across - outward * across.dot(&outward);
    let level = level.try_normalize(0.1).unwrap_or_else(|| unit(up.cross(&outward), Vector3::x()));
    let off = Vector3::from(contact_m) - middle(points_m);
    let level = if off.dot(&level) < 0.0 { -level } else { level };
    let towards = outward * OUTWARD + level * LEVEL + up * (HIGH * (1.0 - outward.z.abs()));
    let towards = unit(towards, up);
    let up = if towards.z.abs() > 0.98 { Vector3::y() } else { up };
    (towards.into(), up.into())
}

/// Returns the level direction across the longest level extent of some points: perpendicular to `up`.
#[must_use]
pub fn front(points_m: &[[f64; 3]], up: [f64; 3]) -> [f64; 3] {
    let up = unit(Vector3::from(up), Vector3::z());
    let middle = middle(points_m);
    // Power iteration on the spread across `up`.
    let mut long = unit(up.cross(&Vector3::new(0.3, 0.5, 0.8)), Vector3::x());
    for _ in 0..50 {
        let spread: Vector3<f64> = points_m
            .iter()
            .map(|p| (Vector3::from(*p) - middle) * (Vector3::from(*p) - middle).dot(&long))
            .sum();
        let level = spread - up * spread.dot(&up);
        long = level.try_normalize(1e-30).unwrap_or(long);
    }
    long.cross(&up).into()
}

fn middle(points_m: &[[f64; 3]]) -> Vector3<f64> {
    points_m.iter().map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / points_m.len().max(1) as f64
}

fn unit(vector: Vector3<f64>, otherwise: Vector3<f64>) -> Vector3<f64> {
    vector.try_normalize(1e-12).unwrap_or(otherwise)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slab twice as long in x: whichever side is pressed is turned to the eye, and up stays up.
    #[test]
    fn the_pressed_side_is_seen() {
        let corners = [[-2.0, -1.0, -0.5], [2.0, 1.0, 0.5], [-2.0, 1.0, 0.5], [2.0, -1.0, -0.5]];
        assert!(front(&corners, [0.0, 0.0, 1.0])[1].abs() > 0.95);
        for (contact, outward) in [
            ([0.5, 0.2, 0.5], [0.0, 0.0, 1.0]),
            ([2.0, 0.1, 0.0], [1.0, 0.0, 0.0]),
            ([-2.0, 0.1, 0.0], [-1.0, 0.0, 0.0]),
            ([0.0, -1.0, 0.0], [0.0, -1.0, 0.0]),
            ([0.0, 0.3, -0.5], [0.0, 0.0, -1.0]),
        ] {
            let (eye, up) = towards(&corners, contact, outward);
            let dot = |a: [f64; 3], b: [f64; 3]| Vector3::from(a).dot(&Vector3::from(b));
            assert!(dot(eye, outward) > 0.5 && dot(eye, outward) < 0.8, "{outward:?}: {eye:?}");
            assert_eq!(up, [0.0, 0.0, 1.0]);
        }
        // Without a direction it is seen from above.
        assert!(towards(&corners, [0.0; 3], [0.0; 3]).0[2] > 0.5);
    }
}
