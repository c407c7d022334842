//! A sample of an edge enters the tissue.
//!
//! The edge comes first and the blade behind it, so a sample is in the tissue if the line from it against the
//! direction of cutting leaves the tissue within [`BEHIND`] mean link lengths: through an outer face, or
//! through one that was opened before. There its front begins, but no farther behind the sample than the blade
//! has moved, so that no force begins without a motion of the hand: a front that begins deeper is in the tetrahedron
//! to which the way from the face leads. A blade that meets tissue with its back does not enter, nor does one deeper
//! inside: it has to be drawn out first.
//!
//! Cost: one look at each outer triangle and at each opened face.

use super::body::CutBody;
use super::place::Point;
use crate::energy::surface::{Edge, EdgeSample};
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::cross;

/// Length of the line [mean link lengths]; a blade that moves farther in a tick cuts nothing.
pub(super) const BEHIND: f32 = 0.25;
/// Faces farther from the edge are not looked at [mean link lengths].
const NEAR: f32 = 3.0;

/// A way into the tissue.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    /// Distance from the sample back to the face [mean link lengths].
    depth: f32,
    /// The same to the front.
    behind: f32,
    face: Face,
}

/// A face through which a sample has entered.
#[derive(Clone, Copy)]
enum Face {
    /// A triangle of the image's surface.
    Outer([u16; 3]),
    /// An opened face of this tetrahedron.
    Opened(usize),
}

impl Entry {
    /// The same with the front at most this far behind the sample.
    pub fn within(self, most: f32) -> Self {
        Self { behind: if self.behind < most { self.behind } else { most }, ..self }
    }
}

/// A triangle that faces against a direction.
struct Facing {
    corner: [f32; 3],
    along: [f32; 3],
    across: [f32; 3],
    normal: [f32; 3],
    forward: [f32; 3],
    slope: f32,
}

impl Facing {
    /// `None` for one that faces along the direction.
    fn of([a, b, c]: [[f32; 3]; 3], forward: [f32; 3]) -> Option<Self> {
        let (along, across) = (sub(b, a), sub(c, a));
        let normal = cross(along, across);
        let slope = dot(normal, forward);
        (slope < 0.0).then_some(Self { corner: a, along, across, normal, forward, slope })
    }

    /// Distance from a point against the direction to the triangle; `None` if it is not within [`BEHIND`].
    fn depth_under(&self, point: [f32; 3]) -> Option<f32> {
        let Self { corner, along, across, normal, forward, slope } = *self;
        let depth = dot(normal, sub(point, corner)) / slope;
        if !(0.0..=BEHIND).contains(&depth) {
            return None;
        }
        // The point of the plane lies within the triangle.
        let from = sub(sub(point, scale(depth, forward)), corner);
        let whole = dot(normal, normal);
        let u = dot(cross(from, across), normal) / whole;
        let v = dot(cross(along, from), normal) / whole;
        (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then_some(depth)
    }
}

impl CutBody<'_, '_> {
    /// Finds for each sample without a front how it has entered; `entries` has a place for each sample.
    pub(super) fn find_entries(
        &self,
        edge: &Edge,
        at: &impl Fn(usize) -> [f32; 3],
        entries: &mut [Option<Entry>],
    ) {
        let places = || edge.samples().iter().map(|sample| sample.place);
        let count = places().count() as f32;
        let middle = scale(1.0 / count, places().fold([0.0; 3], add));
        let reach = places().fold(0.0, |most, place| {
            let way = sub(place, middle);
            let length = sqrt(dot(way, way));
            if length > most { length } else { most }
        });
        let reach = (reach + NEAR) * (reach + NEAR);
        let is_near = |[first, ..]: [u16; 3]| {
            let way = sub(at(first.into()), middle);
            dot(way, way) <= reach
        };
        let mut look = |face: Face, corners: [u16; 3]| {
            let corners = corners.map(|cell| at(cell.into()));
            let Some(facing) = Facing::of(corners, edge.forward()) else { return };
            let outside = edge.samples().iter().zip(&mut *entries);
            for (sample, slot) in outside.filter(|(sample, _)| !sample.is_in()) {
                let Some(depth) = facing.depth_under(sample.place) else { continue };
                if slot.is_none_or(|known| depth < known.depth) {
                    *slot = Some(Entry { depth, behind: depth, face });
                }
            }
        };
        for tetrahedron in (0..self.cut.corners.len()).filter(|&of| !self.drops(of)) {
            for corner in self.open_corners(tetrahedron) {
                let corners = self.side(tetrahedron, corner);
                if is_near(corners) {
                    look(Face::Opened(tetrahedron), corners);
                }
            }
        }
        for (triangle, corners) in self.model.triangles.iter().zip(&*self.arrays.triangles) {
            if is_near(*corners) {
                look(Face::Outer(*triangle), *corners);
            }
        }
    }

    /// The tetrahedron of a face.
    fn owner(&self, face: Face) -> Option<usize> {
        let triangle = match face {
            Face::Opened(tetrahedron) => return Some(tetrahedron),
            Face::Outer(triangle) => triangle,
        };
        let [first, ..] = triangle;
        self.cut.star(first.into()).iter().map(|&of| of as usize).find(|&tetrahedron| {
            let corners = self.cut.corners.get(tetrahedron);
            corners.is_some_and(|corners| triangle.iter().all(|id| corners.contains(id)))
        })
    }

    /// The place at rest where the front of a sample that has entered begins; `None` if the tissue there is flat, and
    /// if the body ends between the face and the front.
    pub(super) fn door(
        &self,
        sample: &EdgeSample,
        forward: [f32; 3],
        entry: Entry,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<Point> {
        let tetrahedron = self.owner(entry.face)?;
        let [cell, ..] = *self.arrays.corners.get(tetrahedron)?;
        let [corner, ..] = self.corners_at_rest(tetrahedron)?;
        let at_rest = |back: f32| {
            let place = sub(sample.place, scale(back, forward));
            Some(add(corner, self.way_at_rest(tetrahedron, sub(place, at(cell.into())), at)?))
        };
        let door = Point { tetrahedron, rest: at_rest(entry.depth)? };
        self.walk(door, at_rest(entry.behind)?, |_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_under_a_face_has_entered() {
        let face = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let down = [0.0, 0.0, -1.0];
        let facing = Facing::of(face, down).unwrap();
        let depth = |point| facing.depth_under(point);
        assert_eq!(depth([0.25, 0.25, -0.125]), Some(0.125));
        assert_eq!(depth([0.25, 0.25, 0.125]), None); // above
        assert_eq!(depth([0.25, 0.25, -0.375]), None); // too deep
        assert_eq!(depth([0.75, 0.75, -0.125]), None); // beside
        // With its back.
        assert!(Facing::of(face, [0.0, 0.0, 1.0]).is_none());
    }
}
