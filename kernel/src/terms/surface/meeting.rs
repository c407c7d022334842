//! What a tool meets in all its triangles: energy, force, torque and stiffness.

use super::friction::Anchor;
use super::press::each_met;
use super::proxy::Proxy;
use super::search::NearTriangle;
use crate::number::cell::{add, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::cross;
use crate::number::two_float::TwoFloat;

/// What a tool meets, in internal units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Meeting {
    pub energy: TwoFloat,
    /// On the tool.
    pub force: [f32; 3],
    /// On the tool, about its pivot.
    pub torque: [f32; 3],
    /// Stiffness of the samples inside [2 `k_ref`].
    pub stiffness: f32,
    /// Smallest distance of a sample from the core of a part over the part's radius as chosen.
    pub nearest: f32,
    /// Triangles with a sample inside, or one that is held.
    pub touched: u32,
}

impl Meeting {
    /// Of nothing.
    pub const NONE: Self = Self {
        energy: TwoFloat::ZERO,
        force: [0.0; 3],
        torque: [0.0; 3],
        stiffness: 0.0,
        nearest: f32::MAX,
        touched: 0,
    };

    /// Tool number `tool` among these triangles; without anchors that of contact alone.
    pub fn of(
        (proxy, tool): (&Proxy, usize),
        (near, anchors): (&[NearTriangle], &[Anchor]),
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Self {
        let mut sum = Self::NONE;
        for near in near.iter().filter(|near| near.tool() == tool) {
            let Some(solid) = proxy.parts().get(near.part()) else { continue };
            let corners = near.corners.map(|cell| at(cell.into()));
            let (mut energy, mut stiffness, mut is_met) = (0.0, 0.0, false);
            let (mut force, mut torque) = ([0.0; 3], [0.0; 3]);
            let nearest = each_met(solid, near, anchors, corners, |sample| {
                is_met = true;
                energy += sample.energy;
                let on_tissue = add(sample.push, sample.drag);
                force = sub(force, on_tissue);
                torque = sub(torque, cross(sub(sample.point, proxy.pivot), on_tissue));
                let of_contact = if sample.depth > 0.0 { sample.stiffness } else { 0.0 };
                let of_anchor = if sample.is_stuck { sample.stiffness } else { 0.0 };
                stiffness += if of_contact > of_anchor { of_contact } else { of_anchor };
            });
            let nearest = sqrt(nearest) / solid.whole;
            sum.nearest = if nearest < sum.nearest { nearest } else { sum.nearest };
            if is_met {
                sum.energy = sum.energy.plus(energy.into());
                sum.force = add(sum.force, force);
                sum.torque = add(sum.torque, torque);
                sum.stiffness += stiffness;
                sum.touched += 1;
            }
        }
        sum
    }
}
