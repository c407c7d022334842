//! The triangles that a sphere may touch in a tick.

use super::meeting::Ball;
use crate::model::surface::ContactSurface;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;

/// A triangle in reach of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearTriangle {
    pub(crate) corners: [u16; 3],
    /// Into so many parts each edge is cut.
    pub(crate) parts: u16,
    /// Stiffness of all samples together [2 `k_ref`].
    pub(crate) weight: f32,
    /// At most the distance of its points from the centre of the search.
    pub(crate) distance: f32,
}

impl NearTriangle {
    /// An empty slot.
    pub const NONE: Self = Self { corners: [0; 3], parts: 0, weight: 0.0, distance: 0.0 };
}

/// What a search found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Near {
    /// Slots taken.
    pub count: usize,
    /// Some triangle in reach found no slot.
    pub full: bool,
    /// At most the distance of the surface from the centre.
    pub distance: f32,
}

/// Finds the triangles that a sphere of the radius of `ball` may touch while its centre goes by
/// `reach` at most. Where there are more than slots, the nearest ones are kept.
///
/// Cost: one look at each triangle of the surface; where slots are lacking, at most 2 log2(slots)
/// moves for each further one.
pub(crate) fn search(
    surface: &ContactSurface<'_>,
    at: &impl Fn(usize) -> [f32; 3],
    (ball, reach): (Ball, f32),
    slots: &mut [NearTriangle],
) -> Near {
    let mut near = Near { count: 0, full: false, distance: f32::MAX };
    let far = ball.radius + reach;
    for index in 0..surface.triangles.len() {
        let Some(&corners) = surface.triangles.get(index) else { break };
        let distance = least_distance(ball.centre, corners.map(|cell| at(cell.into())));
        near.distance = if distance < near.distance { distance } else { near.distance };
        if distance > far {
            continue;
        }
        let Some((_, of)) = surface.triangle(index) else { break };
        let (parts, weight) = (of.parts(ball.whole), of.weight(ball.whole));
        let found = NearTriangle { corners, parts, weight, distance };
        if let Some(slot) = slots.get_mut(near.count) {
            *slot = found;
            near.count += 1;
            continue;
        }
        if !near.full {
            near.full = true;
            (0..slots.len() / 2).rev().for_each(|root| sift(slots, root));
        }
        if let Some(farthest) = slots.first_mut().filter(|slot| slot.distance > distance) {
            *farthest = found;
            sift(slots, 0);
        }
    }
    near
}

/// At most the distance of a triangle's points: that of its centre less that of its farthest corner.
fn least_distance(centre: [f32; 3], corners: [[f32; 3]; 3]) -> f32 {
    let [a, b, c] = corners;
    let middle = scale(1.0 / 3.0, add(add(a, b), c));
    let squared = |corner| {
        let way = sub(corner, middle);
        dot(way, way)
    };
    let largest =
        corners.map(squared).into_iter().fold(0.0, |most, r| if r > most { r } else { most });
    let way = sub(middle, centre);
    sqrt(dot(way, way)) - sqrt(largest)
}

/// Lets a slot sink to its place in a heap with the farthest triangle on top.
fn sift(slots: &mut [NearTriangle], mut root: usize) {
    let distance = |slots: &[NearTriangle], at: usize| slots.get(at).map(|slot| slot.distance);
    loop {
        let (left, right) = (2 * root + 1, 2 * root + 2);
        let child = if distance(slots, right) > distance(slots, left) { right } else { left };
        // `None`, beyond the end, is less than any.
        if distance(slots, child) <= distance(slots, root) {
            return;
        }
        let (Some(&up), Some(&down)) = (slots.get(child), slots.get(root)) else { return };
        for (at, value) in [(root, up), (child, down)] {
            if let Some(slot) = slots.get_mut(at) {
                *slot = value;
            }
        }
        root = child;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn a_heap_keeps_the_nearest() {
        let all: Vec<f32> = (0..57).map(|i| ((i * 37) % 101) as f32).collect();
        let mut slots = vec![NearTriangle::NONE; 8];
        for (slot, &distance) in slots.iter_mut().zip(&all) {
            slot.distance = distance;
        }
        (0..4).rev().for_each(|root| sift(&mut slots, root));
        for &distance in &all[8..] {
            if slots[0].distance > distance {
                slots[0].distance = distance;
                sift(&mut slots, 0);
            }
        }
        let mut kept: Vec<f32> = slots.iter().map(|slot| slot.distance).collect();
        let mut sorted = all.clone();
        kept.sort_unstable_by(f32::total_cmp);
        sorted.sort_unstable_by(f32::total_cmp);
        assert_eq!(kept, sorted[..8]);
    }

    #[test]
    fn no_point_of_a_triangle_is_nearer_than_its_least_distance() {
        let corners = [[1.0, 0.0, 0.0], [4.0, 0.0, 3.0], [1.0, 6.0, 0.0]];
        for centre in [[0.0; 3], [2.0, 1.0, 0.5], [-7.0, 3.0, 2.0]] {
            let least = least_distance(centre, corners);
            super::super::samples::each(9, corners, |_, point| {
                let way = sub(point, centre);
                assert!(sqrt(dot(way, way)) >= least - 1e-5);
            });
        }
    }
}
