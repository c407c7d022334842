//! Force of a tool's part on the samples of a triangle.

use super::friction::Anchor;
use super::near::NearTriangle;
use super::samples::{Sample, each};
use super::solid::Solid;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;

/// Share of the radius: a sample nearer to the core is not pushed.
const MIDDLE: f32 = 1.0e-6;
/// Margin for the rounding of distances.
const ROUNDED_UP: f32 = 1.001;

/// Calls `visit` for the samples of a triangle, with corners at `at`, that are in the part or held by an
/// anchor. Returns the square of the smallest distance of a sample from the core, or of the radius if the
/// triangle is out of reach.
#[inline(always)]
pub(crate) fn each_met(
    solid: &Solid,
    near: &NearTriangle,
    anchors: &[Anchor],
    at: [[f32; 3]; 3],
    mut visit: impl FnMut(&Sample),
) -> f32 {
    let (reach, parts) = (solid.radius * solid.radius, f32::from(near.parts));
    let mut anchors = near.anchors_of(anchors);
    if anchors.is_empty() && is_beyond(solid, parts, at) {
        return reach;
    }
    // Visit every sample: find its distance and its anchor.
    let stiffness = near.weight / (parts * parts);
    let (mut nearest, mut next) = (f32::MAX, 0);
    each(near.parts, at, |weights, point| {
        let index = next;
        next += 1;
        let way = solid.way_to(point);
        let squared = dot(way, way);
        nearest = if squared < nearest { squared } else { nearest };
        let anchor = match anchors.split_first() {
            Some((first, rest)) if first.sample == index => {
                anchors = rest;
                Some(first)
            }
            _ => None,
        };
        let is_in = squared < reach;
        if !is_in && anchor.is_none() {
            return;
        }
        let mut sample = Sample {
            index,
            weights,
            point,
            depth: 0.0,
            normal: [0.0; 3],
            stiffness,
            push: [0.0; 3],
            drag: [0.0; 3],
            is_stuck: false,
            energy: 0.0,
        };
        // Add the contact, then the anchor.
        if is_in {
            let distance = sqrt(squared);
            sample.depth = solid.radius - distance;
            sample.energy = 0.5 * stiffness * (sample.depth * sample.depth);
            if distance > MIDDLE * solid.radius {
                sample.normal = scale(1.0 / distance, way);
                sample.push = scale(stiffness * sample.depth / distance, way);
            }
        }
        if let Some(anchor) = anchor {
            let held = anchor.hold(point, stiffness);
            sample.drag = held.force;
            sample.is_stuck = held.is_stuck;
            sample.energy += held.energy;
        }
        visit(&sample);
    });
    nearest
}

/// Returns true if no sample of a triangle can be in the part: those nearest to the corners are the farthest
/// from its middle, by all but one of `parts` parts of the way to a corner.
#[inline(always)]
fn is_beyond(solid: &Solid, parts: f32, [a, b, c]: [[f32; 3]; 3]) -> bool {
    let middle = scale(1.0 / 3.0, add(add(a, b), c));
    let squared = |corner| {
        let way = sub(corner, middle);
        dot(way, way)
    };
    let corners = [a, b, c].map(squared);
    let largest = corners.into_iter().fold(0.0, |most, r| if r > most { r } else { most });
    let far = ROUNDED_UP * (solid.radius + (parts - 1.0) / parts * sqrt(largest));
    let way = solid.way_to(middle);
    dot(way, way) > far * far
}

/// The contribution to a triangle's corners in a pass: residual, and eight times the energy in the fourth
/// lane. `None` without contact.
#[inline(always)]
pub(crate) fn at_corners(
    solid: &Solid,
    near: &NearTriangle,
    anchors: &[Anchor],
    at: [[f32; 3]; 3],
) -> Option<[[f32; 4]; 3]> {
    let (mut corners, mut is_met) = ([[0.0; 4]; 3], false);
    each_met(solid, near, anchors, at, |sample| {
        is_met = true;
        let force = add(sample.push, sample.drag);
        for (corner, weight) in corners.iter_mut().zip(sample.weights) {
            let [x, y, z] = scale(weight, force);
            let [a, b, c, e] = *corner;
            *corner = [a + x, b + y, c + z, e + 8.0 * weight * sample.energy];
        }
    });
    is_met.then_some(corners)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_sample_in_reach_is_ruled_out() {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.3, 0.1], [-0.4, 1.5, -0.2]];
        let (mut met, mut ruled_out) = (0, 0);
        for parts in [1, 2, 3, 8] {
            let near =
                NearTriangle { corners: [0, 1, 2], parts, weight: 1.0, ..NearTriangle::NONE };
            for place in 0..1000_u16 {
                let [x, y, z] = [place % 10, place / 10 % 10, place / 100].map(f32::from);
                let centre = [0.6 * x - 2.0, 0.6 * y - 2.0, 0.3 * z - 1.5];
                let solid = Solid { centre, whole: 0.7, sampled: 0.7, radius: 0.7, ..Solid::NONE };
                let (mut all, mut visited) = (0, 0);
                each(parts, corners, |_, point| {
                    let way = solid.way_to(point);
                    all += usize::from(dot(way, way) < 0.7 * 0.7);
                });
                each_met(&solid, &near, &[], corners, |_| visited += 1);
                assert_eq!(visited, all, "{parts} {centre:?}");
                met += visited;
                ruled_out += usize::from(is_beyond(&solid, parts.into(), corners));
            }
        }
        assert!(met > 100 && ruled_out > 2000, "{met} {ruled_out}");
    }
}
