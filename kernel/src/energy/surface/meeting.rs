//! Contact of a tool over all its triangles: energy, force, torque and stiffness.

use super::friction::Anchor;
use super::near::NearTriangle;
use super::press::each_met;
use super::proxy::Proxy;
use crate::number::cell::{add, dot, sub};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;
use crate::number::turn::cross;
use crate::number::two_float::TwoFloat;

kept! {
    /// Contact of a tool, in internal units.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct Meeting {
        pub energy: TwoFloat,
        /// Force on the tool.
        pub force: [f32; 3],
        /// Torque on the tool, about its pivot.
        pub torque: [f32; 3],
        /// Stiffness of the samples inside [2 `k_ref`].
        pub stiffness: f32,
        /// Stiffness against rotation about the pivot [2 `k_ref`, lengths squared].
        pub turning: f32,
        /// Smallest distance of a sample from a part's core, over the part's full radius.
        pub nearest: f32,
        /// Number of triangles with a sample inside the tool or held by it.
        pub touched: u32,
    }
}

impl Meeting {
    /// No contact.
    pub const NONE: Self = Self {
        energy: TwoFloat::ZERO,
        force: [0.0; 3],
        torque: [0.0; 3],
        stiffness: 0.0,
        turning: 0.0,
        nearest: f32::MAX,
        touched: 0,
    };

    /// Contact of tool number `tool` with these triangles; without anchors, contact forces only.
    pub fn of(
        (proxy, tool): (&Proxy, usize),
        (near, anchors): (&[NearTriangle], &[Anchor]),
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Self {
        let mut sum = Self::NONE;
        for near in near.iter().filter(|near| near.tool() == tool) {
            let Some(solid) = proxy.parts().get(near.part()) else { continue };
            let corners = near.corners.map(|cell| at(cell.into()));
            // Sum the triangle's samples first, then add the triangle.
            let (mut energy, mut stiffness, mut turning, mut is_met) = (0.0, 0.0, 0.0, false);
            let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
            let nearest = each_met(solid, near, anchors, corners, |sample| {
                is_met = true;
                energy += sample.energy;
                let on_tissue = add(sample.push, sample.drag);
                force = sub(force, on_tissue);
                let arm = sub(sample.point, proxy.pivot);
                torque = sub(torque, cross(arm, on_tissue));
                let of_contact = if sample.depth > 0.0 { sample.stiffness } else { 0.0 };
                let of_anchor = if sample.is_stuck { sample.stiffness } else { 0.0 };
                stiffness += if of_contact > of_anchor { of_contact } else { of_anchor };
                // A sample that slides resists along its normal, one that sticks in all directions.
                let lever = if sample.is_stuck { arm } else { cross(arm, sample.normal) };
                turning += sample.stiffness * dot(lever, lever);
            });
            let nearest = sqrt(nearest) / solid.whole;
            sum.nearest = if nearest < sum.nearest { nearest } else { sum.nearest };
            if is_met {
                sum.energy = sum.energy.plus(energy.into());
                sum.force = add(sum.force, force);
                sum.torque = add(sum.torque, torque);
                sum.stiffness += stiffness;
                sum.turning += turning;
                sum.touched += 1;
            }
        }
        sum.with_edge(proxy, at)
    }

    /// Adds the edge of a blade.
    fn with_edge(mut self, proxy: &Proxy, at: &impl Fn(usize) -> [f32; 3]) -> Self {
        for sample in proxy.edge.fronts() {
            let Some(pressed) = sample.press(proxy.edge.forward(), at) else { continue };
            self.energy = self.energy.plus(pressed.energy.into());
            self.force = sub(self.force, pressed.force);
            let arm = sub(sample.place, proxy.pivot);
            self.torque = sub(self.torque, cross(arm, pressed.force));
            self.turning += sample.stiffness * dot(arm, arm);
            // Drawn back a sample above its limit resists as one below it.
            self.stiffness += sample.stiffness;
            self.touched += 1;
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::surface::Solid;
    use crate::energy::surface::press::at_corners;
    use crate::number::turn::Turn;

    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.1], [0.0, 2.0, -0.2]];

    fn near() -> [NearTriangle; 1] {
        [NearTriangle { corners: [0, 1, 2], parts: 6, weight: 3.0, ..NearTriangle::NONE }]
    }

    /// A capsule across the triangle; its frame is offset.
    fn tool() -> Proxy {
        let core = [[-0.6, 0.0, 0.0], [0.6, 0.0, 0.0]];
        let centre = [0.3, 0.0, 0.1];
        let part = Solid { centre, core, whole: 1.2, sampled: 1.2, radius: 1.2, ..Solid::NONE };
        let turn = Turn::new([0.9, 0.1, 0.2, 0.3]).unwrap();
        Proxy::of([part].into_iter()).at([0.3, 0.4, 0.8], turn, 1.0)
    }

    fn meet(proxy: &Proxy, corners: [[f32; 3]; 3]) -> Meeting {
        Meeting::of((proxy, 0), (&near(), &[]), &|cell| corners[cell])
    }

    fn energy(proxy: &Proxy, corners: [[f32; 3]; 3]) -> f64 {
        meet(proxy, corners).energy.into()
    }

    // REQ-CON-06
    #[test]
    fn forces_and_torque_are_the_gradient_of_the_energy() {
        let (tool, step) = (tool(), 1.0e-2);
        let meeting = meet(&tool, CORNERS);
        let pressed = at_corners(&tool.parts()[0], &near()[0], &[], CORNERS).unwrap();
        let mut balance = meeting.force;
        assert!(meeting.touched == 1 && meeting.force[2] > 0.2, "{meeting:?}");
        for axis in 0..3 {
            let mut way = [0.0; 3];
            way[axis] = step;
            let moved = |sign: f32| add(tool.pivot, way.map(|x| sign * x));
            let by = |sign: f32| energy(&tool.at(moved(sign), tool.turn, 1.0), CORNERS);
            let slope = (by(1.0) - by(-1.0)) / f64::from(2.0 * step);
            assert!((slope + f64::from(meeting.force[axis])).abs() < 5e-3, "{slope} {meeting:?}");
            let [a, b, c] = way.map(|x| 0.5 * x);
            let turned = |sign: f32| {
                let small = Turn::new([1.0, sign * a, sign * b, sign * c]).unwrap();
                energy(&tool.at(tool.pivot, small.after(tool.turn), 1.0), CORNERS)
            };
            let slope = (turned(1.0) - turned(-1.0)) / f64::from(2.0 * step);
            assert!((slope + f64::from(meeting.torque[axis])).abs() < 5e-3, "{slope} {meeting:?}");
            for corner in 0..3 {
                let by = |sign: f32| {
                    let mut corners = CORNERS;
                    corners[corner][axis] += sign * step;
                    energy(&tool, corners)
                };
                let slope = (by(1.0) - by(-1.0)) / f64::from(2.0 * step);
                let own = pressed[corner][axis];
                assert!((slope + f64::from(own)).abs() < 5e-3, "{slope} {own}");
                balance[axis] += own;
            }
        }
        // The forces on the corners balance the tool's.
        assert!(dot(balance, balance) < 1e-10, "{balance:?}");
        let stored: f32 = pressed.iter().map(|corner| corner[3] / 8.0).sum();
        assert!((f64::from(stored) - energy(&tool, CORNERS)).abs() < 1e-5);
    }

    #[test]
    fn a_tool_beside_the_triangle_meets_nothing() {
        let tool = tool();
        let meeting = meet(&tool.at([0.3, 0.4, 2.5], tool.turn, 1.0), CORNERS);
        assert!(meeting.nearest >= 1.0);
        assert_eq!(Meeting { nearest: f32::MAX, ..meeting }, Meeting::NONE);
    }

    #[test]
    fn a_sample_in_the_core_is_pushed_nowhere() {
        let near = NearTriangle { parts: 1, ..near()[0] };
        let tool = tool();
        let middle = CORNERS.iter().fold([0.0; 3], |sum, corner| add(sum, corner.map(|x| x / 3.0)));
        let part = Solid { centre: middle, ..tool.parts()[0] };
        let corners = at_corners(&part, &near, &[], CORNERS).unwrap();
        let pushes = corners.iter().flat_map(|corner| &corner[..3]);
        assert!(pushes.into_iter().all(|x| *x == 0.0) && corners[0][3] > 1.0, "{corners:?}");
    }
}
