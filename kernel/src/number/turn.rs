//! Rotations as unit quaternions.

use super::cell::{add, scale};
use super::sqrt::sqrt;
use crate::number::kept::kept;

kept! {
    /// A rotation: a unit quaternion, its real part first.
    ///
    /// ```
    /// use chaincell_kernel::number::turn::{Turn, turned};
    ///
    /// let half = 0.5_f32.sqrt();
    /// let quarter = Turn::of_orientation([0.0, 0.0, half, half]).ok_or("no rotation")?; // about z
    /// let [x, y, _] = turned(quarter, [1.0, 0.0, 0.0]);
    /// assert!(x.abs() < 1e-6 && (y - 1.0).abs() < 1e-6);
    /// assert_eq!(turned(quarter.back(), [0.0, 0.0, 2.0]), [0.0, 0.0, 2.0]); // the axis stays
    /// # Ok::<(), &str>(())
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Turn([f32; 4]);
}

/// Returns a x b.
#[must_use]
pub fn cross([a, b, c]: [f32; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// Returns the rotated vector.
#[must_use]
#[inline(always)]
pub fn turned(Turn([real, a, b, c]): Turn, v: [f32; 3]) -> [f32; 3] {
    // v + 2 a x (a x v + w v).
    let axis = [a, b, c];
    let inner = add(cross(axis, v), scale(real, v));
    add(v, scale(2.0, cross(axis, inner)))
}

impl Turn {
    /// No rotation.
    pub const NONE: Self = Self([1.0, 0.0, 0.0, 0.0]);

    /// All bits 0, for memory that is not read.
    pub(crate) const EMPTY: Self = Self([0.0; 4]);

    /// Returns the rotation of a quaternion, real part first, normalised; `None` if it is not finite or its
    /// length is not between 1/2 and 2.
    #[must_use]
    pub fn new(quaternion: [f32; 4]) -> Option<Self> {
        let [w, x, y, z] = quaternion;
        let squared = w * w + x * x + y * y + z * z;
        (0.25..=4.0).contains(&squared).then(|| {
            let scale = 1.0 / sqrt(squared);
            // -0.0 becomes +0.0.
            Self(quaternion.map(|part| part * scale + 0.0))
        })
    }

    /// Returns the rotation of an orientation x, y, z, w; `None` as in [`Self::new`].
    #[must_use]
    pub fn of_orientation([x, y, z, w]: [f32; 4]) -> Option<Self> {
        Self::new([w, x, y, z])
    }

    /// Returns the rotation of a unit quaternion.
    #[must_use]
    pub(crate) const fn of_unit(quaternion: [f32; 4]) -> Self {
        Self(quaternion)
    }

    /// Returns the inverse rotation.
    #[must_use]
    pub fn back(self) -> Self {
        let Self([w, x, y, z]) = self;
        Self([w, -x, -y, -z])
    }

    /// Returns the rotation that is `first` followed by this one.
    #[must_use]
    pub fn after(self, first: Self) -> Self {
        let (Self([w, x, y, z]), Self([r, a, b, c])) = (self, first);
        let product = [
            w * r - x * a - y * b - z * c,
            w * a + x * r + y * c - z * b,
            w * b - x * c + y * r + z * a,
            w * c + x * b - y * a + z * r,
        ];
        Self::new(product).unwrap_or(self)
    }

    /// Returns the rotation at a share of the shorter path from this one to another. The angle is nearly
    /// linear in the share if the two are close.
    #[must_use]
    pub fn towards(self, to: Self, share: f32) -> Self {
        if share >= 1.0 {
            return to;
        }
        let (Self(from), Self(mut end)) = (self, to);
        let inner: f32 = from.iter().zip(end).fold(0.0, |sum, (a, b)| sum + a * b);
        if inner < 0.0 {
            end = end.map(|part| -part);
        }
        let mut between = from;
        for (slot, end) in between.iter_mut().zip(end) {
            *slot += share * (end - *slot);
        }
        Self::new(between).unwrap_or(to)
    }

    /// Returns axis times angle of a small rotation \[rad\]: twice the imaginary part.
    #[must_use]
    pub fn small(self) -> [f32; 3] {
        let Self([w, x, y, z]) = self;
        let twice = if w < 0.0 { -2.0 } else { 2.0 };
        [x, y, z].map(|part| twice * part)
    }

    /// Returns the orientation x, y, z, w.
    #[must_use]
    pub fn orientation(self) -> [f32; 4] {
        let Self([w, x, y, z]) = self;
        [x, y, z, w]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::number::cell::{dot, sub};

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        let way = sub(a, b);
        dot(way, way) < 1e-12
    }

    #[test]
    fn turns_follow_each_other() {
        let half = 0.5_f32.sqrt();
        let about_z = Turn::new([half, 0.0, 0.0, half]).unwrap();
        let about_x = Turn::new([half, half, 0.0, 0.0]).unwrap();
        assert!(near(turned(about_z, [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]));
        let both = about_x.after(about_z);
        assert!(near(turned(both, [1.0, 0.0, 0.0]), [0.0, 0.0, 1.0]));
        assert!(near(turned(both.back(), turned(both, [0.3, 0.2, 0.1])), [0.3, 0.2, 0.1]));
    }

    #[test]
    fn a_share_of_a_turn_takes_the_shorter_way() {
        let (half, none) = (0.5_f32.sqrt(), Turn::NONE);
        let quarter = Turn::new([-half, 0.0, 0.0, -half]).unwrap();
        let middle = none.towards(quarter, 0.5);
        assert!(near(turned(middle, [1.0, 0.0, 0.0]), [half, half, 0.0]), "{middle:?}");
        assert_eq!(none.towards(quarter, 1.0), quarter);
        let [_, _, angle] = none.towards(quarter, 1.0e-3).small();
        assert!((angle - 1.0e-3 * 2.0 * half).abs() < 1e-6, "{angle}");
    }

    #[test]
    fn what_is_no_rotation_is_none() {
        for bad in [[0.0; 4], [f32::NAN, 0.0, 0.0, 1.0], [f32::INFINITY; 4], [3.0, 0.0, 0.0, 0.0]] {
            assert_eq!(Turn::new(bad), None, "{bad:?}");
        }
        assert_eq!(Turn::new([2.0, -0.0, 0.0, 0.0]), Some(Turn::NONE));
    }
}
