//! A smooth rigid sphere on the axis that the top of the slab meets, by a stiff penalty.
//!
//! Its energy is that of the depth of the top's points in it, a sum of k depth^2 / 2 by area, so force and
//! stiffness are its derivatives and friction has no part.

use std::f64::consts::TAU;

/// Gauss's four points between 0 and 1, and their weights.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// A point of the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TopPoint {
    pub nodes: [usize; 3],
    /// Of each node.
    pub weights: [f64; 3],
    /// Area of the ring that it stands for \[m^2\].
    pub area_m2: f64,
    /// Distance from the axis \[m\].
    pub rest_m: f64,
}

/// The points of the top's edges.
pub fn points(top: &[[usize; 3]], nodes_m: &[[f64; 2]]) -> Vec<TopPoint> {
    let of = |&nodes: &[usize; 3]| {
        let [inner, _, outer] = nodes.map(|node| nodes_m[node][0]);
        GAUSS.map(|(s, share)| {
            let weights = [(1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)];
            let rest_m = inner + s * (outer - inner);
            TopPoint { nodes, weights, area_m2: TAU * rest_m * share * (outer - inner), rest_m }
        })
    };
    top.iter().flat_map(of).collect()
}

/// A sphere on the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    pub radius_m: f64,
    /// Height of its centre \[m\].
    pub centre_m: f64,
    /// Pressure by depth \[Pa/m\].
    pub stiffness: f64,
    /// Depth from which on [`Touch::hessian`] takes the turning of a push as that of this depth, for
    /// deeper points are on their way out \[m\].
    pub turns_m: f64,
}

/// What a point feels of the sphere, by its own motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    pub energy_j: f64,
    /// Derivative of the energy \[N\].
    pub gradient: [f64; 2],
    /// Its derivative \[N/m\].
    pub hessian: [[f64; 2]; 2],
    pub depth_m: f64,
}

impl Sphere {
    /// What a point of some area at `x` (r, z) meets, where it lies inside.
    pub fn touch(&self, [r, z]: [f64; 2], area_m2: f64) -> Option<Touch> {
        let way = [r, z - self.centre_m];
        let distance = way[0].hypot(way[1]);
        let depth_m = self.radius_m - distance;
        if depth_m <= 0.0 || distance == 0.0 {
            return None;
        }
        let (k, out) = (self.stiffness * area_m2, way.map(|x| x / distance));
        let turn = depth_m.min(self.turns_m) / distance;
        let entry = |a: usize, b: usize| {
            let same = f64::from(u8::from(a == b));
            k * (out[a] * out[b] - turn * (same - out[a] * out[b]))
        };
        Some(Touch {
            energy_j: 0.5 * k * depth_m * depth_m,
            gradient: out.map(|n| -k * depth_m * n),
            hessian: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
            depth_m,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_touch_is_the_derivative_of_its_energy() {
        let sphere = Sphere { radius_m: 2.0, centre_m: 3.0, stiffness: 7.0, turns_m: 1.0 };
        let at = [0.7, 1.4];
        let here = sphere.touch(at, 0.5).unwrap();
        for a in 0..2 {
            let [less, more] = [-1e-6, 1e-6].map(|by| {
                let mut x = at;
                x[a] += by;
                sphere.touch(x, 0.5).unwrap()
            });
            assert!(((more.energy_j - less.energy_j) / 2e-6 - here.gradient[a]).abs() < 1e-7);
            for b in 0..2 {
                let slope = (more.gradient[b] - less.gradient[b]) / 2e-6;
                assert!((slope - here.hessian[b][a]).abs() < 1e-7);
            }
        }
        assert_eq!(sphere.touch([0.0, 0.9], 1.0), None);
    }

    #[test]
    fn the_top_has_its_area() {
        let nodes = [[0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [3.5, 1.0], [5.0, 1.0]];
        let points = points(&[[0, 1, 2], [2, 3, 4]], &nodes);
        let area: f64 = points.iter().map(|point| point.area_m2).sum();
        assert!((area - 0.5 * TAU * 25.0).abs() < 1e-12);
        let place = |point: &TopPoint| {
            (0..3).map(|k| point.weights[k] * nodes[point.nodes[k]][0]).sum::<f64>()
        };
        assert!(points.iter().all(|point| (place(point) - point.rest_m).abs() < 1e-12));
    }
}
