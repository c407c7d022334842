//! A wound ahead of a blade: a sample before which the tissue is open has no force.
//!
//! Ahead of a sample lie two parallelograms of the body at rest: from the lines between its front and those of its two
//! neighbours, one mean link length in the direction of cutting. Of the faces for which the line between the middles
//! of their tetrahedra crosses one of these, the nearest ahead counts: where that face is open, the sample is free.
//! All that the blade itself opens lies behind its fronts, so a blade in whole tissue is never free. Where no line
//! crosses, the sample stays as it is.
//!
//! A closed face counts as open where one of its tetrahedra has an opened face on the other side, ahead of the front:
//! between the blade and the wound lies no more than that tetrahedron. So a hand that comes back a little beside
//! its wound, by up to a third of a link, pays for little of it again.
//!
//! A free sample has a limit of 0: its front follows it without a force, and the area that it passes does not count.
//! The end of a wound is known to half a link, the distance between such lines.
//!
//! Cost: the faces of the tetrahedra ahead of each sample, at most nine.

use super::body::CutBody;
use super::place::Point;
use crate::energy::surface::{EDGE_SAMPLES, Edge, EdgeSample};
use crate::number::cell::{add, dot, scale, sub};
use crate::number::turn::cross;

/// Length of the parallelograms [mean link lengths].
const AHEAD: f32 = 1.0;

/// A parallelogram ahead of the line between two fronts.
struct Patch {
    corner: [f32; 3],
    /// From the corner to the other front.
    side: [f32; 3],
    ahead: [f32; 3],
    normal: [f32; 3],
}

impl Patch {
    fn new(corner: [f32; 3], side: [f32; 3], ahead: [f32; 3]) -> Self {
        Self { corner, side, ahead, normal: cross(side, ahead) }
    }

    /// Height of a point above its plane, in units of its own.
    fn above(&self, point: [f32; 3]) -> f32 {
        dot(self.normal, sub(point, self.corner))
    }

    /// Distance of a point ahead of the line between the fronts, over the length of the parallelogram.
    fn ahead_of(&self, point: [f32; 3]) -> f32 {
        let across = cross(self.side, sub(point, self.corner));
        dot(across, self.normal) / dot(self.normal, self.normal)
    }

    /// Distance ahead at which a line crosses it, from 0 to 1.
    fn crossed(&self, [p, q]: [[f32; 3]; 2]) -> Option<f32> {
        let (first, second) = (self.above(p), self.above(q));
        if (first >= 0.0) == (second >= 0.0) {
            return None;
        }
        let point = add(p, scale(first / (first - second), sub(q, p)));
        let across = cross(sub(point, self.corner), self.ahead);
        let beside = dot(across, self.normal) / dot(self.normal, self.normal);
        let ahead = self.ahead_of(point);
        ((0.0..=1.0).contains(&beside) && (0.0..=1.0).contains(&ahead)).then_some(ahead)
    }
}

impl CutBody<'_, '_> {
    /// Frees the samples of an edge before which the tissue is open, and gives the others their limit. Returns true
    /// if one has changed.
    pub(super) fn free(&self, edge: &mut Edge, at: &impl Fn(usize) -> [f32; 3]) -> bool {
        let mut limits = [None; EDGE_SAMPLES];
        for (index, (sample, slot)) in edge.samples().iter().zip(&mut limits).enumerate() {
            if sample.is_in() {
                let is_open = self.is_open_ahead(edge, index, sample, at);
                let is_open = is_open.unwrap_or(sample.limit == 0.0);
                *slot = Some(if is_open { 0.0 } else { self.limit(sample) });
            }
        }
        let mut is_changed = false;
        for (sample, limit) in edge.samples_mut().iter_mut().zip(limits) {
            let limit = limit.unwrap_or(sample.limit);
            is_changed |= limit != sample.limit;
            sample.limit = limit;
        }
        is_changed
    }

    /// Returns true for a sample before which the tissue is open, `None` if no face is there.
    fn is_open_ahead(
        &self,
        edge: &Edge,
        index: usize,
        sample: &EdgeSample,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<bool> {
        let from = Point::of(sample);
        let ahead = self.way_at_rest(from.tetrahedron, scale(AHEAD, edge.forward()), at)?;
        let patches = [index.checked_sub(1), Some(index + 1)].map(|neighbour| {
            let other = edge.samples().get(neighbour?)?;
            let side = if other.is_in() {
                sub(other.rest, from.rest)
            } else {
                self.way_at_rest(from.tetrahedron, sub(other.place, sample.place), at)?
            };
            Some(Patch::new(from.rest, side, ahead))
        });
        let mut nearest: Option<(f32, bool)> = None;
        self.walk(from, add(from.rest, ahead), |tetrahedron| {
            for corner in 0..4 {
                for patch in patches.iter().flatten() {
                    let Some(found) = self.is_open_on(patch, tetrahedron, corner) else { continue };
                    if nearest.is_none_or(|nearest| found.0 < nearest.0) {
                        nearest = Some(found);
                    }
                }
            }
        });
        nearest.map(|(_, is_open)| is_open)
    }

    /// Distance ahead at which the line of a face crosses a patch, and true if the tissue is open there.
    fn is_open_on(&self, patch: &Patch, tetrahedron: usize, corner: usize) -> Option<(f32, bool)> {
        let (other, _) = self.across(tetrahedron, corner)?;
        let line = [self.middle_at_rest(tetrahedron)?, self.middle_at_rest(other)?];
        let ahead = patch.crossed(line)?;
        let is_open = self.is_open(tetrahedron, corner)
            || self.is_open_beyond(patch, tetrahedron, other)
            || self.is_open_beyond(patch, other, tetrahedron);
        Some((ahead, is_open))
    }

    /// Returns true if a tetrahedron has an opened face ahead, on the side of a patch away from another one.
    fn is_open_beyond(&self, patch: &Patch, tetrahedron: usize, other: usize) -> bool {
        let [Some(here), Some(there)] = [tetrahedron, other].map(|of| self.middle_at_rest(of))
        else {
            return false;
        };
        let higher = |point| patch.above(point) - patch.above(here);
        self.open_corners(tetrahedron).any(|corner| {
            let beyond = self.across(tetrahedron, corner);
            let beyond = beyond.and_then(|(beyond, _)| self.middle_at_rest(beyond));
            beyond.is_some_and(|beyond| {
                let is_ahead = patch.ahead_of(scale(0.5, add(here, beyond))) >= 0.0;
                is_ahead && higher(beyond) * higher(there) < 0.0
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_as_far_ahead_as_it_crosses() {
        let patch = Patch::new([1.0, 0.0, 0.0], [0.5, 0.25, 0.0], [0.0, 2.0, 0.0]);
        let at = |x: f32, y: f32| patch.crossed([[x, y, -0.5], [x, y, 0.5]]);
        assert_eq!(at(1.25, 0.625), Some(0.25));
        assert_eq!(at(1.25, 0.125), Some(0.0)); // on the line between the fronts
        assert_eq!([at(1.25, 0.0), at(1.25, 2.25), at(0.9, 1.0), at(1.6, 1.0)], [None; 4]);
        // Above it.
        assert_eq!(patch.crossed([[1.25, 0.625, 0.25], [1.25, 0.625, 0.5]]), None);
    }
}
