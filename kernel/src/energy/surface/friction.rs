//! Coulomb friction, and grips: samples that are held at their position in the tool's frame.
//!
//! Each sample in contact has an anchor in the tool's frame. With p the sample's displacement from its
//! anchor, in the plane perpendicular to the normal n, the term is
//!
//! ```text
//! E_f = k_t |p|^2 / 2                         where k_t |p| <= mu f_n
//!       mu f_n |p| - (mu f_n)^2 / (2 k_t)     beyond: it slips
//! ```
//!
//! n and the normal force `f_n` are those of the last tick, so both are fixed in a tick; k_t is the contact
//! stiffness. The force is k_t |p| towards the anchor, at most mu `f_n`.
//!
//! **The theorem.** E_f is the minimum over all slips s of k_t |p - s|^2 / 2 + mu `f_n` |s|: a minimum of
//! quadratics curves upwards by at most k_t, as each of them does. The cells' bounds grow by as much as for
//! contact.
//!
//! **After the sweeps** an anchor takes the present normal and force of its sample: p loses its component
//! along the new normal, and the anchor is dragged until |p| is at most mu `f_n` / k_t. A sample that left
//! contact has no anchor. The change of the energy is booked.
//!
//! **A grip** has no normal and no limit: p has all three components. It holds its sample in and out of
//! contact until it is released: its stiffness then falls to 0 within some ticks, which lowers the energy.

use super::proxy::Proxy;
use super::samples::Sample;
use crate::number::cell::{dot, scale, sub};
use crate::number::kept::kept;
use crate::number::sqrt::sqrt;

kept! {
    /// The anchor of a sample: friction or a grip holds the sample there.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Anchor {
        /// Name of the triangle, in the model's order.
        pub(crate) triangle: u32,
        /// Index of the sample in the triangle.
        pub(crate) sample: u16,
        /// The part and its tool.
        pub(crate) part: u8,
        /// Position in the tool's frame [mean link lengths].
        pub(crate) point: [f32; 3],
        /// That position in the body's frame in this tick.
        pub(crate) place: [f32; 3],
        /// Contact normal in the last tick; 0 for a grip.
        pub(crate) normal: [f32; 3],
        /// Largest force, mu `f_n`; infinite for a grip.
        pub(crate) limit: f32,
        /// Remaining share of the release time, 1 to 0. The stiffness scales with its cube, since a pull through
        /// soft tissue hardly falls before the grip is softer than the tissue.
        pub(crate) share: f32,
    }
}

/// Force and energy of an anchor.
pub(crate) struct Hold {
    /// Force on the tissue.
    pub force: [f32; 3],
    pub energy: f32,
    pub is_stuck: bool,
}

impl Anchor {
    /// An empty slot.
    pub const NONE: Self = Self {
        triangle: u32::MAX,
        sample: 0,
        part: 0,
        point: [0.0; 3],
        place: [0.0; 3],
        normal: [0.0; 3],
        limit: 0.0,
        share: 1.0,
    };

    /// All bits 0, for static memory that takes up no flash.
    pub(crate) const EMPTY: Self = Self { triangle: 0, share: 0.0, ..Self::NONE };

    /// Returns true if it holds its sample without a force limit.
    pub(crate) fn is_grip(&self) -> bool {
        self.limit == f32::INFINITY
    }

    /// p: the displacement of a point from the anchor, perpendicular to the normal.
    fn way_to(&self, point: [f32; 3]) -> [f32; 3] {
        let way = sub(point, self.place);
        sub(way, scale(dot(self.normal, way), self.normal))
    }

    /// Its force and energy on a sample with this stiffness.
    #[inline(always)]
    pub(crate) fn hold(&self, point: [f32; 3], stiffness: f32) -> Hold {
        let kept = self.share * self.share * self.share;
        let (way, stiffness) = (self.way_to(point), kept * stiffness);
        let squared = dot(way, way);
        let pull = stiffness * sqrt(squared);
        if pull <= self.limit {
            let energy = 0.5 * stiffness * squared;
            return Hold { force: scale(-stiffness, way), energy, is_stuck: true };
        }
        let energy = self.limit * (sqrt(squared) - 0.5 * self.limit / stiffness);
        let force = scale(-self.limit / sqrt(squared), way);
        Hold { force, energy, is_stuck: false }
    }

    /// The sample's anchor after a tick's sweeps, dragged by the excess over the limit. `None` if the sample
    /// left contact.
    pub(crate) fn after(&self, sample: &Sample, friction: f32) -> Option<Self> {
        if self.is_grip() {
            return Some(*self);
        }
        let limit = friction * (sample.stiffness * sample.depth);
        if !(limit > 0.0 && sample.normal != [0.0; 3]) {
            return None;
        }
        let way = sub(sample.point, self.place);
        let across = sub(way, scale(dot(sample.normal, way), sample.normal));
        let (most, length) = (limit / sample.stiffness, sqrt(dot(across, across)));
        let kept = if length > most { scale(most / length, across) } else { across };
        let place = sub(sample.point, kept);
        Some(Self { place, normal: sample.normal, limit, ..*self })
    }

    /// An anchor at a sample's present position, for a sample without one.
    pub(crate) fn new(sample: &Sample, triangle: u32, part: u8, friction: f32) -> Option<Self> {
        Self { limit: 0.0, ..Self::grip(sample, triangle, part) }.after(sample, friction)
    }

    /// A grip of a sample at its present position, with or without an anchor before.
    pub(crate) fn grip(sample: &Sample, triangle: u32, part: u8) -> Self {
        let (index, place) = (sample.index, sample.point);
        Self { triangle, sample: index, part, place, limit: f32::INFINITY, ..Self::NONE }
    }

    /// Stores its position in the tool's frame.
    pub(crate) fn fastened(self, proxy: &Proxy) -> Self {
        Self { point: proxy.in_tool(self.place), ..self }
    }

    /// Moves with the tool.
    pub(crate) fn follow(&mut self, proxy: &Proxy) {
        self.place = proxy.in_body(self.point);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn anchor() -> Anchor {
        Anchor { place: [1.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0], limit: 0.3, ..Anchor::NONE }
    }

    // REQ-CON-08
    #[test]
    fn friction_is_the_slope_of_its_energy_and_no_more_than_the_limit() {
        for x in [1.0_f32, 1.05, 1.2, 4.0] {
            let (hold, step) = (anchor().hold([x, 0.0, 7.0], 2.0), 1.0e-2);
            let by = |x: f32| anchor().hold([x, 0.0, 7.0], 2.0).energy;
            let slope = (by(x + step) - by(x - step)) / (2.0 * step);
            assert!((slope + hold.force[0]).abs() < 2e-3, "{x}: {slope} {:?}", hold.force);
            assert!(hold.force[0].abs() <= 0.3 && hold.force[2] == 0.0);
            assert_eq!(hold.is_stuck, x <= 1.15);
        }
    }

    #[test]
    fn an_anchor_is_dragged_up_to_the_limit() {
        let sample = Sample {
            index: 0,
            weights: [1.0, 0.0, 0.0],
            point: [3.0, 0.0, 0.5],
            depth: 0.5,
            normal: [0.0, 0.0, 1.0],
            stiffness: 2.0,
            push: [0.0; 3],
            drag: [0.0; 3],
            is_stuck: false,
            energy: 0.0,
        };
        // mu f_n / k = 0.3 * 0.5.
        let dragged = anchor().after(&sample, 0.3).unwrap();
        assert!((dragged.place[0] - 2.85).abs() < 1e-6 && dragged.place[2] == 0.5, "{dragged:?}");
        assert!((dragged.limit - 0.3).abs() < 1e-6);
        let slips = dragged.hold(sample.point, 2.0);
        assert!((slips.force[0] + 0.3).abs() < 1e-6, "{:?}", slips.force);
        assert_eq!(anchor().after(&Sample { depth: 0.0, ..sample }, 0.3), None);
        let held = Anchor { limit: f32::INFINITY, ..anchor() };
        assert!(held.after(&Sample { depth: 0.0, ..sample }, 0.0).is_some());
    }

    #[test]
    fn a_grip_holds_in_every_direction_and_fades() {
        let held = Anchor { normal: [0.0; 3], limit: f32::INFINITY, ..anchor() };
        assert_eq!(held.hold([1.0, 0.0, 2.0], 3.0).force, [0.0, 0.0, -6.0]);
        let fading = Anchor { share: 0.5, ..held };
        assert_eq!(fading.hold([1.0, 0.0, 2.0], 3.0).force, [0.0, 0.0, -0.75]);
        assert!(fading.hold([9.0, 0.0, 2.0], 3.0).energy < held.hold([9.0, 0.0, 2.0], 3.0).energy);
    }
}
