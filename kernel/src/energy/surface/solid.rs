//! Parts of a tool: convex bodies with rounded edges.
//!
//! A part is all that lies within a radius of its core, a box that may be flat in any axis: a point for a
//! sphere, a line for a capsule, the half space below for a half space. A sample at a distance d from the
//! core is r - d deep, and is pushed straight away from the core's nearest point.
//!
//! **The theorem** holds for each part: half the squared depth curves upwards by at most 1. Along the normal
//! it curves by 1, perpendicular to it by -(r - d) / d or by 0. Inside the core the energy is that at the
//! core's surface, and no sample is pushed there: it rises to that value and stays, which bends it downwards.

use crate::number::cell::{add, dot, scale, sub};
use crate::number::kept::kept;
use crate::number::turn::{Turn, cross, turned};

kept! {
    /// A part of a tool's proxy in the body's frame [mean link lengths].
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct Solid {
        pub centre: [f32; 3],
        /// Rotation from the part's frame to the body's.
        pub turn: Turn,
        /// The core's lowest and highest coordinates in the part's frame.
        pub core: [[f32; 3]; 2],
        /// Radius around the core. It grows if the tool engaged in contact.
        pub radius: f32,
        /// The full radius.
        pub whole: f32,
        /// Radius of the sphere that samples and stiffness are chosen for.
        pub sampled: f32,
    }
}

impl Solid {
    /// No part.
    pub const NONE: Self = Self {
        centre: [0.0; 3],
        turn: Turn::NONE,
        core: [[0.0; 3]; 2],
        radius: 0.0,
        whole: 0.0,
        sampled: 0.0,
    };

    /// All bits 0, for memory that is never read.
    pub const EMPTY: Self = Self { turn: Turn::EMPTY, ..Self::NONE };

    /// Returns true for a sphere: its core is a point.
    #[inline(always)]
    pub fn is_ball(&self) -> bool {
        let [[a, b, c], [d, e, f]] = self.core;
        [a, b, c, d, e, f].iter().all(|x| *x == 0.0)
    }

    /// The vector from the core's nearest point to a point.
    #[inline(always)]
    pub fn way_to(&self, point: [f32; 3]) -> [f32; 3] {
        let way = sub(point, self.centre);
        if self.is_ball() {
            return way;
        }
        let place = turned(self.turn.back(), way);
        let [low, high] = self.core;
        let mut out = [0.0; 3];
        for ((out, at), (low, high)) in out.iter_mut().zip(place).zip(low.into_iter().zip(high)) {
            // No difference of infinities: a core may be unbounded.
            *out = if at < low {
                at - low
            } else if at > high {
                at - high
            } else {
                0.0
            };
        }
        turned(self.turn, out)
    }

    /// Returns true for a half space: its core is unbounded.
    pub fn is_endless(&self) -> bool {
        !self.core[1][0].is_finite()
    }

    /// Half edges of the core, and its middle in the body's frame.
    fn box_of_core(&self) -> ([f32; 3], [f32; 3]) {
        let [low, high] = self.core;
        let middle = scale(0.5, add(low, high));
        (scale(0.5, sub(high, low)), add(self.centre, turned(self.turn, middle)))
    }

    /// The middle of the core in the body's frame.
    pub fn middle(&self) -> [f32; 3] {
        self.box_of_core().1
    }

    /// Returns true if a triangle intersects the core: no axis across a face or an edge of either separates
    /// the two. A sphere's core is a point, which never intersects.
    pub fn is_crossed(&self, corners: [[f32; 3]; 3]) -> bool {
        if self.is_ball() || self.is_endless() {
            return false;
        }
        let (half, middle) = self.box_of_core();
        let [a, b, c] = corners.map(|corner| turned(self.turn.back(), sub(corner, middle)));
        let keeps_apart = |axis: [f32; 3]| {
            let reach = dot(half, axis.map(f32::abs));
            let along = [a, b, c].map(|corner| dot(axis, corner));
            along.iter().all(|x| *x > reach) || along.iter().all(|x| *x < -reach)
        };
        // Test the box's faces, the triangle's face, and all pairs of edges.
        let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let edges = [sub(b, a), sub(c, b), sub(a, c)];
        let mut across = edges.iter().flat_map(|edge| units.map(|unit| cross(*edge, unit)));
        !(units.into_iter().any(keeps_apart)
            || keeps_apart(cross(edges[0], edges[1]))
            || across.any(keeps_apart))
    }

    /// The part of a tool at `pivot`, rotated; the part itself is in the tool's frame.
    pub fn placed(&self, pivot: [f32; 3], turn: Turn) -> Self {
        let centre = add(pivot, turned(turn, self.centre));
        Self { centre, turn: turn.after(self.turn), ..*self }
    }

    /// The part with a share of its radius.
    pub fn grown(&self, share: f32) -> Self {
        Self { radius: if share < 1.0 { share * self.whole } else { self.whole }, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(a: [f32; 3]) -> f32 {
        crate::number::sqrt::sqrt(dot(a, a))
    }

    #[test]
    fn ways_lead_from_the_nearest_point_of_the_core() {
        let quarter = Turn::new([0.5_f32.sqrt(), 0.0, 0.0, 0.5_f32.sqrt()]).unwrap();
        let capsule = Solid {
            centre: [1.0, 0.0, 0.0],
            turn: quarter,
            core: [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
            ..Solid::NONE
        };
        // Rotated by 90 degrees about z, its line is along y.
        for (point, way) in [
            ([1.5, 1.0, 0.0], [0.5, 0.0, 0.0]),
            ([1.0, 3.0, 0.0], [0.0, 1.0, 0.0]),
            ([1.0, -2.5, 0.5], [0.0, -0.5, 0.5]),
            ([1.0, 1.9, 0.0], [0.0; 3]),
        ] {
            assert!(length(sub(capsule.way_to(point), way)) < 1e-6, "{point:?}");
        }
    }

    #[test]
    fn a_triangle_runs_through_a_core_or_past_it() {
        let corners = [[-9.0, -9.0, 0.25], [9.0, -9.0, 0.25], [0.0, 9.0, 0.25]];
        let upright = Solid { core: [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], ..Solid::NONE };
        let plate = Solid { core: [[-2.0, -1.0, -0.5], [2.0, 1.0, 0.5]], ..upright };
        let turn = Turn::new([0.5_f32.sqrt(), 0.5_f32.sqrt(), 0.0, 0.0]).unwrap();
        for (core, is_crossed) in [
            (upright, true),
            (Solid { centre: [0.0, 0.0, 1.5], ..upright }, false),
            (Solid { centre: [0.0, 9.5, 0.0], ..upright }, false),
            (Solid { turn, ..upright }, false),
            (plate, true),
            (Solid { centre: [0.0, 0.0, 0.8], ..plate }, false),
            // On edge it is higher.
            (Solid { centre: [0.0, 0.0, 0.8], turn, ..plate }, true),
            (Solid { centre: [0.0, 0.0, 0.25], ..Solid::NONE }, false),
        ] {
            assert_eq!(core.is_crossed(corners), is_crossed, "{core:?}");
        }
    }

    #[test]
    fn a_core_without_end_has_finite_ways() {
        let end = f32::INFINITY;
        let half_space = Solid { core: [[-end; 3], [end, end, -1.0]], ..Solid::NONE };
        assert_eq!(half_space.way_to([7.0, -3.0, -0.25]), [0.0, 0.0, 0.75]);
        assert_eq!(half_space.way_to([7.0, -3.0, -8.0]), [0.0; 3]);
    }

    #[test]
    fn a_part_turns_about_its_tool() {
        let quarter = Turn::new([0.5_f32.sqrt(), 0.0, 0.0, 0.5_f32.sqrt()]).unwrap();
        let part = Solid { centre: [2.0, 0.0, 0.0], whole: 3.0, ..Solid::NONE };
        let placed = part.placed([1.0, 0.0, 5.0], quarter);
        assert!(length(sub(placed.centre, [1.0, 2.0, 5.0])) < 1e-6, "{placed:?}");
        assert_eq!([placed.grown(0.5).radius, placed.grown(1.5).radius], [1.5, 3.0]);
    }
}
