//! What a sphere meets: energy, force and stiffness of the samples inside it.

use super::samples::each;
use super::search::NearTriangle;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;

/// The sphere that the tissue meets [mean link lengths].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball {
    pub centre: [f32; 3],
    /// As the tissue meets it: it grows where the tool was engaged inside the body.
    pub radius: f32,
    /// As it was chosen.
    pub whole: f32,
}

/// A share of the radius: a sample nearer to the centre is pushed nowhere.
const MIDDLE: f32 = 1.0e-6;

/// What a triangle does at its corners: residual, and eight times the energy in the fourth lane.
pub(crate) struct Press {
    pub corners: [[f32; 4]; 3],
    /// Pressure on the sphere: sum of `k_q` dist along the way to the centre.
    pub force: [f32; 3],
    pub energy: f32,
    /// Stiffness of the samples inside.
    pub stiffness: f32,
    /// Smallest distance of a sample from the centre, squared.
    pub nearest: f32,
    /// Sum of `k_q` and of `k_q` `A_q` over the samples inside.
    pub shares: [f32; 3],
}

impl Press {
    /// The samples of a triangle whose corners are at `at`.
    #[inline(always)]
    pub fn of(ball: &Ball, near: &NearTriangle, at: [[f32; 3]; 3]) -> Self {
        let parts = f32::from(near.parts);
        let each_one = near.weight / (parts * parts);
        let reach = ball.radius * ball.radius;
        let mut press = Self {
            corners: [[0.0; 4]; 3],
            force: [0.0; 3],
            energy: 0.0,
            stiffness: 0.0,
            nearest: f32::MAX,
            shares: [0.0; 3],
        };
        each(near.parts, at, |weights, point| {
            let way = sub(point, ball.centre);
            let squared = dot(way, way);
            press.nearest = if squared < press.nearest { squared } else { press.nearest };
            if squared >= reach {
                return;
            }
            let distance = sqrt(squared);
            let depth = ball.radius - distance;
            let energy = 0.5 * each_one * (depth * depth);
            let middle = distance <= MIDDLE * ball.radius;
            let push = if middle { [0.0; 3] } else { scale(each_one * depth / distance, way) };
            press.energy += energy;
            press.stiffness += each_one;
            press.force = sub(press.force, push);
            press.shares = add(press.shares, scale(each_one, weights));
            for (corner, weight) in press.corners.iter_mut().zip(weights) {
                let [x, y, z] = scale(weight, push);
                let [a, b, c, e] = *corner;
                *corner = [a + x, b + y, c + z, e + 8.0 * weight * energy];
            }
        });
        press
    }
}

/// What a sphere meets in all its triangles, in internal units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Meeting {
    pub energy: TwoFloat,
    /// On the sphere.
    pub force: [f32; 3],
    /// Stiffness of the samples inside [2 `k_ref`].
    pub stiffness: f32,
    /// Smallest distance of a sample from the centre.
    pub nearest: f32,
    /// Triangles with a sample inside.
    pub touched: u32,
}

impl Meeting {
    /// Of nothing.
    pub const NONE: Self = Self {
        energy: TwoFloat::ZERO,
        force: [0.0; 3],
        stiffness: 0.0,
        nearest: f32::MAX,
        touched: 0,
    };

    /// The sphere among these triangles.
    pub fn of(ball: &Ball, near: &[NearTriangle], at: &impl Fn(usize) -> [f32; 3]) -> Self {
        let mut sum = Self::NONE;
        let mut nearest = f32::MAX;
        for near in near {
            let press = Press::of(ball, near, near.corners.map(|cell| at(cell.into())));
            nearest = if press.nearest < nearest { press.nearest } else { nearest };
            if press.stiffness > 0.0 {
                sum.energy = sum.energy.plus(press.energy.into());
                sum.force = add(sum.force, press.force);
                sum.stiffness += press.stiffness;
                sum.touched += 1;
            }
        }
        sum.nearest = sqrt(nearest);
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.1], [0.0, 2.0, -0.2]];

    fn near() -> [NearTriangle; 1] {
        [NearTriangle { corners: [0, 1, 2], parts: 6, weight: 3.0, distance: 0.0 }]
    }

    fn energy(ball: &Ball, corners: [[f32; 3]; 3]) -> f64 {
        let meeting = Meeting::of(ball, &near(), &|cell| corners[cell]);
        f64::from(meeting.energy.hi) + f64::from(meeting.energy.lo)
    }

    #[test]
    fn forces_are_the_gradient_of_the_energy() {
        let ball = Ball { centre: [0.5, 0.5, 0.9], radius: 1.5, whole: 1.5 };
        let meeting = Meeting::of(&ball, &near(), &|cell| CORNERS[cell]);
        let press = Press::of(&ball, &near()[0], CORNERS);
        let (step, mut balance) = (1.0e-2, meeting.force);
        assert!(meeting.touched == 1 && meeting.force[2] > 0.5, "{meeting:?}");
        for axis in 0..3 {
            let by = |sign: f32| {
                let mut ball = ball;
                ball.centre[axis] += sign * step;
                energy(&ball, CORNERS)
            };
            let slope = (by(1.0) - by(-1.0)) / f64::from(2.0 * step);
            assert!((slope + f64::from(meeting.force[axis])).abs() < 5e-3, "{slope} {meeting:?}");
            for corner in 0..3 {
                let by = |sign: f32| {
                    let mut corners = CORNERS;
                    corners[corner][axis] += sign * step;
                    energy(&ball, corners)
                };
                let slope = (by(1.0) - by(-1.0)) / f64::from(2.0 * step);
                let own = press.corners[corner][axis];
                assert!((slope + f64::from(own)).abs() < 5e-3, "{slope} {own}");
                balance[axis] += own;
            }
        }
        // What the sphere feels the corners feel too.
        assert!(balance.iter().all(|sum| sum.abs() < 1e-5), "{balance:?}");
        let stored: f32 = press.corners.iter().map(|corner| corner[3] / 8.0).sum();
        assert!((stored - press.energy).abs() < 1e-6 * press.energy);
    }

    #[test]
    fn a_sphere_beside_the_triangle_meets_nothing() {
        let ball = Ball { centre: [0.5, 0.5, 1.6], radius: 1.5, whole: 1.5 };
        let meeting = Meeting::of(&ball, &near(), &|cell| CORNERS[cell]);
        assert!(meeting.nearest > 1.5 && meeting.nearest < 1.7);
        assert_eq!(Meeting { nearest: f32::MAX, ..meeting }, Meeting::NONE);
    }

    #[test]
    fn a_sample_in_the_middle_is_pushed_nowhere() {
        let near = NearTriangle { parts: 1, ..near()[0] };
        let middle = scale(1.0 / 3.0, add(add(CORNERS[0], CORNERS[1]), CORNERS[2]));
        let press = Press::of(&Ball { centre: middle, radius: 1.0, whole: 1.0 }, &near, CORNERS);
        assert!(press.corners.as_flattened().iter().all(|x| x.is_finite()) && press.energy > 1.0);
    }
}
