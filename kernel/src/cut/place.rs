//! Points in tetrahedra, at rest and deformed.

use super::body::CutBody;
use crate::energy::surface::EdgeSample;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::turn::cross;

/// Most faces that a way crosses.
const FACES_MAX: usize = 8;
/// Weights of a point within rounding of a tetrahedron's faces.
const ROUNDING: f32 = 1.0e-5;
/// Smallest volume of a tetrahedron that is deformed, relative to that at rest: one that is flatter does not
/// tell a place at rest.
const FLAT: f32 = 0.02;

/// A point of the body at rest.
#[derive(Clone, Copy)]
pub(super) struct Point {
    pub tetrahedron: usize,
    pub rest: [f32; 3],
}

impl Point {
    /// The front of a sample.
    pub fn of(sample: &EdgeSample) -> Self {
        Self { tetrahedron: sample.tetrahedron as usize, rest: sample.rest }
    }
}

/// Six times the volume between three edges.
fn volume(edges: [[f32; 3]; 3]) -> f32 {
    let [a, b, c] = edges;
    dot(a, cross(b, c))
}

/// The edges from the first corner.
pub(super) fn edges([a, b, c, d]: [[f32; 3]; 4]) -> [[f32; 3]; 3] {
    [sub(b, a), sub(c, a), sub(d, a)]
}

/// How a point's weights change along a way.
fn weights_along(edges: [[f32; 3]; 3], way: [f32; 3]) -> [f32; 4] {
    let ([a, b, c], whole) = (edges, volume(edges));
    let [x, y, z] = [cross(b, c), cross(c, a), cross(a, b)].map(|across| dot(across, way) / whole);
    [0.0 - x - y - z, x, y, z]
}

/// Weights of the corners at a point.
pub(super) fn weights(corners: [[f32; 3]; 4], point: [f32; 3]) -> [f32; 4] {
    let [a, b, c, d] = weights_along(edges(corners), sub(point, corners[0]));
    [1.0 + a, b, c, d]
}

impl CutBody<'_, '_> {
    /// Corners of a tetrahedron at rest.
    pub(super) fn corners_at_rest(&self, tetrahedron: usize) -> Option<[[f32; 3]; 4]> {
        let corners = self.cut.corners.get(tetrahedron)?;
        Some(corners.map(|cell| self.rest_position(cell)))
    }

    /// Middle of a tetrahedron at rest.
    pub(super) fn middle_at_rest(&self, tetrahedron: usize) -> Option<[f32; 3]> {
        let corners = self.corners_at_rest(tetrahedron)?;
        Some(scale(0.25, corners.into_iter().fold([0.0; 3], add)))
    }

    /// The way at rest of a way in a tetrahedron as it is now; `None` if it is flat.
    pub(super) fn way_at_rest(
        &self,
        tetrahedron: usize,
        way: [f32; 3],
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<[f32; 3]> {
        let rest = edges(self.corners_at_rest(tetrahedron)?);
        let now = self.arrays.corners.get(tetrahedron)?.map(|cell| at(cell.into()));
        let now = edges(now);
        if volume(now) < FLAT * volume(rest) {
            return None;
        }
        let [_, x, y, z] = weights_along(now, way);
        let [a, b, c] = rest;
        Some(add(scale(x, a), add(scale(y, b), scale(z, c))))
    }

    /// Walks straight from a point to a place at rest, through at most [`FACES_MAX`] faces, and calls `visit` for
    /// each tetrahedron on the way. `None` if the way leaves the body.
    pub(super) fn walk(
        &self,
        from: Point,
        to: [f32; 3],
        mut visit: impl FnMut(usize),
    ) -> Option<Point> {
        let (mut tetrahedron, mut before) = (from.tetrahedron, usize::MAX);
        visit(tetrahedron);
        for _ in 0..FACES_MAX {
            let corners = self.corners_at_rest(tetrahedron)?;
            let (start, end) = (weights(corners, from.rest), weights(corners, to));
            // Find the face through which the way leaves.
            let mut leaves: Option<(f32, Option<usize>)> = None;
            for (corner, (start, end)) in start.into_iter().zip(end).enumerate() {
                if end >= -ROUNDING || end >= start {
                    continue;
                }
                let next = self.across(tetrahedron, corner).map(|(next, _)| next);
                let share = start / (start - end);
                if next != Some(before) && leaves.is_none_or(|(first, _)| share < first) {
                    leaves = Some((share, next));
                }
            }
            let Some((_, next)) = leaves else {
                return Some(Point { tetrahedron, rest: to });
            };
            before = tetrahedron;
            tetrahedron = next?;
            visit(tetrahedron);
        }
        // The way is too long: stop where it entered the last tetrahedron's middle.
        Some(Point { tetrahedron, rest: self.middle_at_rest(tetrahedron)? })
    }
}
