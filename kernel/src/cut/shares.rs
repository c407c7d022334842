//! The share of a link in a weight of the image, by the volume of the tetrahedra at its edge.
//!
//! Where the tetrahedra at an edge have fallen apart, each piece has a link with the share V' / V, V' the volume of the
//! piece's tetrahedra and V that of all of them. It is computed in double precision and rounded down, so the shares of
//! a weight add up to at most the weight. Both half-links of a link go over the same tetrahedra in the same order, so
//! their shares are equal bit by bit.

use super::body::CutBody;
use super::hats::gradients;
use super::memory::image_groups;
use crate::model::range;
use crate::number::two_float::LANES;

/// A number of a lane in a group, if these numbers are stored.
pub(super) fn lane_of<T: Copy>(groups: &[[T; LANES]], group: usize, lane: usize) -> Option<T> {
    groups.get(group).and_then(|lanes| lanes.get(lane)).copied()
}

/// Sets a number of a lane in a group, if these numbers are stored.
pub(super) fn put_lane<T>(groups: &mut [[T; LANES]], group: usize, lane: usize, number: T) {
    if let Some(slot) = groups.get_mut(group).and_then(|lanes| lanes.get_mut(lane)) {
        *slot = number;
    }
}

/// In single precision, rounded down.
pub(super) fn rounded_down(exact: f64) -> f32 {
    let rounded = exact as f32;
    if f64::from(rounded) > exact { rounded.next_down() } else { rounded }
}

impl CutBody<'_, '_> {
    /// The group of the half-link of a cell of the image to another one, if they are linked.
    pub(super) fn image_group(&self, cell: usize, other: usize) -> Option<usize> {
        let groups = image_groups(self.model);
        range(groups.rows, cell / LANES)
            .find(|&group| lane_of(groups.ids, group, cell % LANES).map(usize::from) == Some(other))
    }

    /// The share of the link between two cells in this weight of the link of the image, rounded down.
    pub(super) fn weight_share(&self, cell: usize, other: usize, weight: f32) -> f32 {
        let (here, there) = (self.origin(cell), self.origin(other));
        // The tetrahedra at the edge, and among them those of this link.
        let edge = |visit: &mut dyn FnMut(usize, bool)| {
            for &tetrahedron in self.cut.star(here) {
                let tetrahedron = tetrahedron as usize;
                let corners = self.cut.corners.get(tetrahedron);
                let is_at_edge =
                    |corners: &[u16; 4]| corners.iter().any(|&id| usize::from(id) == there);
                if corners.is_some_and(is_at_edge) {
                    let names = self.arrays.corners.get(tetrahedron).copied().unwrap_or_default();
                    let is_named = |of: usize| names.iter().any(|&id| usize::from(id) == of);
                    visit(tetrahedron, is_named(cell) && is_named(other));
                }
            }
        };
        let mut is_whole = true;
        edge(&mut |_, is_own| is_whole &= is_own);
        if is_whole {
            return weight;
        }
        // Compare the volumes.
        let (mut own, mut all) = (0.0, 0.0);
        edge(&mut |tetrahedron, is_own| {
            let corners = self.cut.corners.get(tetrahedron).copied().unwrap_or_default();
            let (volume, _) = gradients(corners.map(|id| self.rest_position(id)));
            all += volume;
            own += if is_own { volume } else { 0.0 };
        });
        rounded_down(f64::from(weight) * (own / all))
    }
}
