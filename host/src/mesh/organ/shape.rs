//! The liver as a level set: it has a large right lobe and a thin left one, domed above, flat below.
//!
//! x is from right (negative) to left, y from front to back, z upwards, all in metres. The only
//! operations are + - * / and square roots, so that every machine gets the same bits.

use crate::mesh::geometry::dot;
use crate::mesh::stuffing::{Shape, between};

/// The liver.
pub(super) struct Liver;

/// A box around the body, in metres.
const LOW_M: [f64; 3] = [-0.102, -0.08, -0.04];
/// See [`LOW_M`].
const HIGH_M: [f64; 3] = [0.102, 0.08, 0.075];

/// Half the length from the right end to the left tip.
const HALF_LENGTH_M: f64 = 0.1;
/// Scale of the half-depth from front to back.
const DEPTH_M: f64 = 0.077;
/// Scale of the height above the widest section.
const ABOVE_M: f64 = 0.058;
/// Scale of the height below it.
const BELOW_M: f64 = 0.0322;

/// Steps of a bisection: its error is below 1e-9 of the edge.
const BISECTIONS: usize = 32;
/// Steps of a projection onto the surface.
const PROJECTIONS: usize = 4;
/// Half the distance of the two points of a finite difference.
const DERIVATIVE_M: f64 = 1e-6;

/// Returns the level-set value: positive inside the body, negative outside, of order one.
pub(super) fn value([x, y, z]: [f64; 3]) -> f64 {
    let x = x / HALF_LENGTH_M;
    let depth = DEPTH_M * (0.92 - 0.22 * x);
    let height = 0.86 - 0.38 * x;
    let y = (y + 0.012 * x) / depth;
    let z = z - 0.006 * x;
    let rise = if z > 0.0 {
        let z = z / (ABOVE_M * height);
        z * z
    } else {
        // The fourth power makes a flat bottom with a rounded rim.
        let z = z / (BELOW_M * height);
        z * z * z * z
    };
    1.0 - 0.5 * x * x * (1.0 + x * x) - y * y - rise
}

impl Shape for Liver {
    fn bounds_m(&self) -> [[f64; 3]; 2] {
        [LOW_M, HIGH_M]
    }

    fn value(&self, place_m: [f64; 3]) -> f64 {
        value(place_m)
    }

    fn crossing(&self, inside: [f64; 3], outside: [f64; 3]) -> [f64; 3] {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = (low + high) / 2.0;
            if value(between(inside, outside, middle)) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        between(inside, outside, (low + high) / 2.0)
    }

    fn project(&self, mut point: [f64; 3]) -> [f64; 3] {
        for _ in 0..PROJECTIONS {
            let mut slope = [0.0; 3];
            for axis in 0..3 {
                let (mut before, mut after) = (point, point);
                before[axis] -= DERIVATIVE_M;
                after[axis] += DERIVATIVE_M;
                slope[axis] = (value(after) - value(before)) / (2.0 * DERIVATIVE_M);
            }
            let step = value(point) / dot(slope, slope);
            for axis in 0..3 {
                point[axis] -= step * slope[axis];
            }
        }
        point
    }
}
