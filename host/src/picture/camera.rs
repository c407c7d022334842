//! Where the eye is: a parallel projection onto pixels.

use nalgebra::Vector3;

/// Directions of the picture and the place and scale of its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    towards: Vector3<f64>,
    centre_m: Vector3<f64>,
    /// Scale \[px/m\].
    pub pixels_per_m: f64,
    size_px: (u32, u32),
}

impl View {
    /// Looks against `towards`, the direction from the body to the eye, with `up` upwards; the
    /// points fill the picture up to `margin_px` \[px\]. Points `[axis]` \[m\].
    #[must_use]
    pub fn fit<'p>(
        points_m: impl Iterator<Item = &'p [f64; 3]>,
        towards: [f64; 3],
        up: [f64; 3],
        size_px: (u32, u32),
        margin_px: f64,
    ) -> Self {
        let towards = unit(Vector3::from(towards), Vector3::z());
        let up = Vector3::from(up);
        let sideways = unit(Vector3::y().cross(&towards), Vector3::x());
        let right = unit(up.cross(&towards), sideways);
        let up = towards.cross(&right);
        let (mut least, mut most) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for point in points_m {
            let point = Vector3::from(*point);
            for (axis, along) in [right, up, towards].iter().enumerate() {
                least[axis] = least[axis].min(point.dot(along));
                most[axis] = most[axis].max(point.dot(along));
            }
        }
        if least[0] > most[0] {
            (least, most) = ([-0.5; 3], [0.5; 3]);
        }
        let middle = |axis: usize| 0.5 * (least[axis] + most[axis]);
        let scale = |axis: usize, pixels: u32| {
            (f64::from(pixels) - 2.0 * margin_px).max(1.0) / (most[axis] - least[axis]).max(1e-12)
        };
        Self {
            right,
            up,
            towards,
            centre_m: right * middle(0) + up * middle(1) + towards * middle(2),
            pixels_per_m: scale(0, size_px.0).min(scale(1, size_px.1)),
            size_px,
        }
    }

    /// The same view, `fine` pixels for one.
    pub(super) fn finer(mut self, fine: u32) -> Self {
        self.pixels_per_m *= f64::from(fine);
        self.size_px = (self.size_px.0 * fine, self.size_px.1 * fine);
        self
    }

    /// Width and height \[px\].
    pub(super) fn size_px(&self) -> (u32, u32) {
        self.size_px
    }

    /// Where a point \[m\] stands: pixels to the right, pixels down, pixels towards the eye.
    #[must_use]
    pub fn place(&self, point_m: [f64; 3]) -> [f64; 3] {
        let off = (Vector3::from(point_m) - self.centre_m) * self.pixels_per_m;
        let (wide, high) = (f64::from(self.size_px.0), f64::from(self.size_px.1));
        [0.5 * wide + off.dot(&self.right), 0.5 * high - off.dot(&self.up), off.dot(&self.towards)]
    }

    /// A direction of the body in those of the picture: right, up, towards the eye.
    pub(super) fn turn(&self, direction: [f64; 3]) -> [f64; 3] {
        let direction = Vector3::from(direction);
        [direction.dot(&self.right), direction.dot(&self.up), direction.dot(&self.towards)]
    }
}

fn unit(vector: Vector3<f64>, otherwise: Vector3<f64>) -> Vector3<f64> {
    vector.try_normalize(1e-12).unwrap_or(otherwise)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_the_picture_and_the_nearer_one_is_nearer() {
        let points = [[-1.0, 0.0, -0.5], [1.0, 0.0, 0.5], [0.0, 2.0, 0.0]];
        let view = View::fit(points.iter(), [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], (220, 200), 10.0);
        // Seen along -y with z up, x points to the left.
        assert_eq!(view.pixels_per_m, 100.0);
        assert_eq!(view.place(points[0]), [210.0, 150.0, -100.0]);
        assert_eq!(view.place(points[1]), [10.0, 50.0, -100.0]);
        assert!(view.place(points[2])[2] > view.place(points[0])[2]);
        assert_eq!(view.finer(2).place(points[1]), [20.0, 100.0, -200.0]);
    }
}
