//! Integration points of an element that turns around the axis.

use std::f64::consts::TAU;

use super::law::Slopes;

/// Gauss's three points between -1 and 1, and their weights.
const GAUSS: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// Where the corners and the middles of the edges lie.
const NODES: [[f64; 2]; 8] = [
    [-1.0, -1.0],
    [1.0, -1.0],
    [1.0, 1.0],
    [-1.0, 1.0],
    [0.0, -1.0],
    [1.0, 0.0],
    [0.0, 1.0],
    [-1.0, 0.0],
];

/// A point of an element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Volume of the ring that it stands for \[m^3\].
    pub volume_m3: f64,
    /// Of each node's shape the slopes by r and z, and the value over r \[1/m\].
    pub shapes: [[f64; 3]; 8],
}

impl Point {
    /// Slopes of a displacement by that of the nodes.
    pub fn slopes(&self, nodes: &[[f64; 2]; 8]) -> Slopes {
        let mut slopes = [0.0; 5];
        for ([r, z], [by_r, by_z, over_r]) in nodes.iter().zip(self.shapes) {
            let more = [by_r * r, by_z * r, by_r * z, by_z * z, over_r * r];
            slopes.iter_mut().zip(more).for_each(|(slope, more)| *slope += more);
        }
        slopes
    }

    /// What a unit of a node's motion along r and along z does to the slopes.
    pub fn unit(&self, node: usize) -> [Slopes; 2] {
        let [by_r, by_z, over_r] = self.shapes[node];
        [[by_r, by_z, 0.0, 0.0, over_r], [0.0, 0.0, by_r, by_z, 0.0]]
    }
}

/// The nine points of an element with its nodes at `x`.
pub fn points(x: &[[f64; 2]; 8]) -> [Point; 9] {
    std::array::from_fn(|k| {
        let ((s, across), (t, along)) = (GAUSS[k / 3], GAUSS[k % 3]);
        let values = values(s, t);
        let mut jacobian = [[0.0; 2]; 2];
        let mut r = 0.0;
        for (x, [value, by_s, by_t]) in x.iter().zip(values) {
            r += value * x[0];
            for axis in 0..2 {
                jacobian[axis][0] += by_s * x[axis];
                jacobian[axis][1] += by_t * x[axis];
            }
        }
        let [[r_s, r_t], [z_s, z_t]] = jacobian;
        let area = r_s * z_t - r_t * z_s;
        let shapes = values.map(|[value, by_s, by_t]| {
            [(by_s * z_t - by_t * z_s) / area, (by_t * r_s - by_s * r_t) / area, value / r]
        });
        Point { volume_m3: TAU * r * area * across * along, shapes }
    })
}

/// Of each node's shape the value and its slopes by s and t.
fn values(s: f64, t: f64) -> [[f64; 3]; 8] {
    NODES.map(|[a, b]| {
        if a == 0.0 {
            [0.5 * (1.0 - s * s) * (1.0 + b * t), -s * (1.0 + b * t), 0.5 * b * (1.0 - s * s)]
        } else if b == 0.0 {
            [0.5 * (1.0 - t * t) * (1.0 + a * s), 0.5 * a * (1.0 - t * t), -t * (1.0 + a * s)]
        } else {
            let (u, v) = (1.0 + a * s, 1.0 + b * t);
            let sum = a * s + b * t - 1.0;
            [0.25 * u * v * sum, 0.25 * a * v * (sum + u), 0.25 * b * u * (sum + v)]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_has_its_volume_and_quadratic_fields_their_slopes() {
        let x = NODES.map(|[a, b]| [3.0 + a, 2.0 + 2.0 * b]);
        let points = points(&x);
        let volume: f64 = points.iter().map(|point| point.volume_m3).sum();
        assert!((volume - 0.5 * TAU * (16.0 - 4.0) * 4.0).abs() < 1e-12);
        let field = x.map(|[r, z]| [r * r + r * z, z * z - 3.0 * r]);
        for (k, point) in points.iter().enumerate() {
            let (r, z) = (3.0 + GAUSS[k / 3].0, 2.0 + 2.0 * GAUSS[k % 3].0);
            let right = [2.0 * r + z, r, -3.0, 2.0 * z, r + z];
            let slopes = point.slopes(&field);
            assert!(slopes.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-12), "{slopes:?}");
        }
    }
}
