//! Test of whether a point lies in the tissue, by the present surface.
//!
//! Along a line through the point in direction z, each crossed triangle counts 1 where the
//! line leaves the body and -1 where it enters. The point is inside if the sum is above 0 both above and
//! below it: on a closed surface the two are equal, also around cavities and where parts overlap, and an open
//! surface has no inside. Crossings are decided edge by edge, and two triangles decide alike about their
//! shared edge, so a line through an edge or a corner is counted once.
//!
//! A point within rounding of the surface is outside. A body without thickness has no inside.
//!
//! Cost: one look at each triangle of the surface; seven times that with a margin.

use crate::model::Model;
use crate::number::cell::{add, peak, scale, sub};

/// Rounding of a distance, relative to the size of its coordinates.
const GRAIN: f32 = 4.0 * f32::EPSILON;

/// Zero, and the unit steps along the axes.
const AROUND: [[f32; 3]; 7] = [
    [0.0; 3],
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
];

/// Returns true if a point, or one at the distance `margin` from it along an axis, lies in the body; `at`
/// gives the cells' positions [mean link lengths].
pub(crate) fn is_inside(
    model: &Model<'_>,
    at: &impl Fn(usize) -> [f32; 3],
    point: [f32; 3],
    margin: f32,
) -> bool {
    let points = if margin > 0.0 { AROUND.len() } else { 1 };
    let mut points = AROUND.iter().take(points).map(|step| add(point, scale(margin, *step)));
    model.dimension() == 3 && points.any(|point| holds(model, at, point))
}

/// Returns true if a point lies in a body that has an inside. Not inlined, so that several callers share the
/// code.
#[inline(never)]
fn holds(model: &Model<'_>, at: &impl Fn(usize) -> [f32; 3], point: [f32; 3]) -> bool {
    let grain = GRAIN * (1.0 + peak(point));
    is_between(model.triangles, at, point, grain)
}

/// Returns true if the line through a point leaves the body both above and below the point.
fn is_between(
    triangles: &[[u16; 3]],
    at: &impl Fn(usize) -> [f32; 3],
    point: [f32; 3],
    grain: f32,
) -> bool {
    let (mut above, mut below) = (0_i32, 0_i32);
    for &corners in triangles {
        let offsets = corners.map(|cell| sub(at(cell.into()), point));
        let turns = turns(corners, offsets);
        if turns == 0 {
            continue;
        }
        let height = height(offsets);
        if height > grain {
            above += turns;
        } else if height < -grain {
            below -= turns;
        }
    }
    above > 0 && below > 0
}

/// Winding number of a triangle around the line, seen from above: 1 if it faces upwards, -1 if it faces
/// downwards, 0 if the line does not cross it.
#[inline(always)]
fn turns([a, b, c]: [u16; 3], [p, q, r]: [[f32; 3]; 3]) -> i32 {
    edge(a, p, b, q) + edge(b, q, c, r) + edge(c, r, a, p)
}

/// 1 if an edge passes the line on the side of larger x towards larger y, -1 if towards smaller y.
#[inline(always)]
fn edge(a: u16, p: [f32; 3], b: u16, q: [f32; 3]) -> i32 {
    let is_upward = q[1] > 0.0;
    if (p[1] > 0.0) == is_upward {
        return 0;
    }
    // From the lower id to the higher one: the other triangle at this edge gets the same sign.
    let area = if a < b { p[0] * q[1] - q[0] * p[1] } else { q[0] * p[1] - p[0] * q[1] };
    let is_beyond = (area > 0.0) == (is_upward == (a < b));
    match (is_beyond, is_upward) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => -1,
    }
}

/// Height at which the line crosses a triangle.
fn height([p, q, r]: [[f32; 3]; 3]) -> f32 {
    let area = |a: [f32; 3], b: [f32; 3]| a[0] * b[1] - b[0] * a[1];
    let (of_p, of_q, of_r) = (area(q, r), area(r, p), area(p, q));
    let height = (of_p * p[2] + of_q * q[2] + of_r * r[2]) / (of_p + of_q + of_r);
    let lower = |a: f32, b: f32| if b < a { b } else { a };
    let higher = |a: f32, b: f32| if b > a { b } else { a };
    let (least, most) = (lower(lower(p[2], q[2]), r[2]), higher(higher(p[2], q[2]), r[2]));
    // The areas of a vertical triangle are rounding errors only.
    if height > least { lower(height, most) } else { least }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    /// The corners of a cube of this half edge.
    fn cube(half: f32) -> impl Iterator<Item = [f32; 3]> {
        (0..8).map(move |id| [1, 2, 4].map(|axis| if id & axis == 0 { -half } else { half }))
    }

    /// Its faces, outward.
    const FACES: [[u16; 3]; 12] = [
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
    ];

    /// Grid points that lie on no face; lines through them meet corners, edges and faces.
    fn places() -> impl Iterator<Item = [f32; 3]> {
        let steps = || (-7..=7).map(|step| 0.5 * step as f32);
        let all =
            steps().flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
        all.filter(|place| ![1.0, 3.0].contains(&peak(*place)))
    }

    fn between(triangles: &[[u16; 3]], corners: &[[f32; 3]], point: [f32; 3]) -> bool {
        is_between(triangles, &|cell| corners[cell], point, 1e-6)
    }

    // REQ-CON-10
    #[test]
    fn a_body_with_a_cavity_is_between_its_surfaces() {
        let corners: Vec<_> = cube(3.0).chain(cube(1.0)).collect();
        let inner = FACES.iter().map(|&[a, b, c]| [a + 8, c + 8, b + 8]);
        let triangles: Vec<_> = FACES.into_iter().chain(inner).collect();
        for turn in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
            let turned = |of: [f32; 3]| turn.map(|axis: usize| of[axis]);
            let corners: Vec<_> = corners.iter().map(|corner| turned(*corner)).collect();
            for place in places() {
                let is_in = peak(place) < 3.0 && peak(place) > 1.0;
                assert_eq!(between(&triangles, &corners, turned(place)), is_in, "{place:?}");
            }
        }
    }

    // REQ-CON-10
    #[test]
    fn what_overlaps_is_inside_and_what_is_open_has_no_inside() {
        let corners: Vec<_> = cube(1.0).chain(cube(1.0).map(|[x, y, z]| [x + 1.0, y, z])).collect();
        let second = FACES.iter().map(|face| face.map(|id| id + 8));
        let both: Vec<_> = FACES.into_iter().chain(second).collect();
        for x in [-0.75, 0.25, 1.75] {
            assert!(between(&both, &corners, [x, 0.1, 0.2]), "{x}");
        }
        assert!(!between(&both, &corners, [2.25, 0.1, 0.2]));
        // Without its top.
        for z in [-2.0, 0.0, 2.0] {
            assert!(!between(&FACES[..10], &corners, [0.1, 0.2, z]), "{z}");
        }
        // On its surface.
        for place in [[0.1, 0.2, 1.0], [0.1, 0.2, -1.0], [0.5, 0.5, 1.0]] {
            assert!(!between(&FACES, &corners, place), "{place:?}");
        }
    }
}
