//! Divides faces of more than three corners into triangles.
//!
//! A face is projected along its normal (Newell's). It becomes a fan from its first corner if that is
//! possible; else ears are cut off one by one (G. H. Meisters, *Polygons have ears*, 1975). If the
//! projection intersects itself, as that of a face far from flat may, the corner with the shortest diagonal
//! is cut off each time; later checks find the faults. Cost: the square of the corners, at worst the cube.

use robust::{Coord, orient2d};

use crate::mesh::geometry::distance;

/// Most corners of a face that is no fan.
pub(super) const CORNERS_MAX: usize = 1000;

type Flat = Coord<f64>;

/// Returns the triangles of a face, `at` being the positions of its corners; none if it is no fan and has
/// too many corners.
pub(super) fn cut(corners: &[u32], at: &[[f64; 3]]) -> Option<Vec<[u32; 3]>> {
    let flat = flattened(at);
    let fan: Vec<[usize; 3]> = (2..corners.len()).map(|last| [0, last - 1, last]).collect();
    let is_fan = |flat: &Vec<Flat>| fan.iter().all(|triangle| turns_left(flat, *triangle));
    let triangles = match corners.len() {
        _ if flat.as_ref().is_some_and(is_fan) => fan,
        4..=CORNERS_MAX => flat.and_then(|flat| ears(&flat)).unwrap_or_else(|| shortest(at)),
        _ => return None,
    };
    Some(triangles.into_iter().map(|triangle| triangle.map(|corner| corners[corner])).collect())
}

/// Projects the face along its normal, counter-clockwise.
fn flattened(at: &[[f64; 3]]) -> Option<Vec<Flat>> {
    let mut normal = [0.0; 3];
    for (a, b) in at.iter().zip(at.iter().cycle().skip(1)) {
        for (axis, sum) in normal.iter_mut().enumerate() {
            let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += (a[y] - b[y]) * (a[z] + b[z]);
        }
    }
    let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
    let (mut x, mut y) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (x, y) = (y, x);
    }
    (normal[axis] != 0.0).then(|| at.iter().map(|p| Coord { x: p[x], y: p[y] }).collect())
}

fn turns_left(flat: &[Flat], [a, b, c]: [usize; 3]) -> bool {
    orient2d(flat[a], flat[b], flat[c]) > 0.0
}

/// Cuts off ears until a triangle is left; none if no ear is found.
fn ears(flat: &[Flat]) -> Option<Vec<[usize; 3]>> {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut triangles = Vec::with_capacity(flat.len() - 2);
    while left.len() > 3 {
        let count = left.len();
        let around = |place: usize| {
            [left[(place + count - 1) % count], left[place], left[(place + 1) % count]]
        };
        let place = (0..count).find(|&place| is_ear(flat, &left, around(place)))?;
        triangles.push(around(place));
        left.remove(place);
    }
    let last = [left[0], left[1], left[2]];
    triangles.push(last);
    turns_left(flat, last).then_some(triangles)
}

/// Cuts off the corner whose neighbours are nearest to each other until a triangle is left.
fn shortest(at: &[[f64; 3]]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..at.len()).collect();
    let mut triangles = Vec::with_capacity(at.len() - 2);
    while left.len() > 3 {
        let count = left.len();
        let around = |place: usize| {
            [left[(place + count - 1) % count], left[place], left[(place + 1) % count]]
        };
        let diagonal = |place: &usize| {
            let [a, _, c] = around(*place);
            distance(at[a], at[c])
        };
        let order = |a: &usize, b: &usize| diagonal(a).total_cmp(&diagonal(b));
        let place = (0..count).min_by(order).unwrap_or(0);
        triangles.push(around(place));
        left.remove(place);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

/// Returns true if a corner is convex and no other one lies in the triangle of it and its neighbours.
fn is_ear(flat: &[Flat], left: &[usize], ear: [usize; 3]) -> bool {
    let [a, b, c] = ear;
    let is_in = |corner: usize| {
        [[a, b], [b, c], [c, a]]
            .iter()
            .all(|&[from, to]| orient2d(flat[from], flat[to], flat[corner]) >= 0.0)
    };
    turns_left(flat, ear) && !left.iter().any(|&corner| !ear.contains(&corner) && is_in(corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area of the triangles, seen along z.
    fn area(at: &[[f64; 3]]) -> Option<f64> {
        let corners: Vec<u32> = (0..at.len() as u32).collect();
        let triangles = cut(&corners, at)?;
        assert_eq!(triangles.len(), at.len() - 2);
        let of = |[a, b, c]: [u32; 3]| {
            let [a, b, c] = [a, b, c].map(|corner| at[corner as usize]);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        };
        assert!(triangles.iter().all(|triangle| of(*triangle).abs() > 1e-9), "{triangles:?}");
        Some(triangles.into_iter().map(of).sum())
    }

    fn turned(at: &[[f64; 2]], first: usize) -> Vec<[f64; 3]> {
        let of = |place: usize| at[(first + place) % at.len()];
        (0..at.len()).map(|place| [of(place)[0], of(place)[1], 0.5]).collect()
    }

    #[test]
    fn corners_that_point_inward_or_lie_in_a_line_are_cut_from_any_first_one() {
        let shapes: [(&[[f64; 2]], f64); 3] = [
            (&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]], 3.0),
            (&[[0., 0.], [1., 0.], [2., 0.], [2., 2.], [0., 2.]], 4.0),
            (
                &[[0., 0.], [3., 0.], [3., 2.], [2., 2.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]],
                5.0,
            ),
        ];
        for (shape, size) in shapes {
            for first in 0..shape.len() {
                let at = turned(shape, first);
                assert!((area(&at).unwrap() - size).abs() < 1e-12, "{at:?}");
                let back: Vec<_> = at.into_iter().rev().collect();
                assert!((area(&back).unwrap() + size).abs() < 1e-12, "{back:?}");
            }
        }
    }

    #[test]
    fn what_is_not_flat_is_cut_by_the_shorter_diagonals() {
        // Its projection along the normal intersects itself.
        let twisted =
            [[0., 0.02, 0.037], [0.04, 0.02, 0.042], [0.04, 0.021, 0.0386], [0., 0.0203, 0.043]];
        assert!(flattened(&twisted).is_none_or(|flat| ears(&flat).is_none()));
        for first in 0..4_u32 {
            let corners = [0, 1, 2, 3].map(|place| (first + place) % 4);
            let at = corners.map(|corner| twisted[corner as usize]);
            let triangles = cut(&corners, &at).unwrap();
            let has_shorter = |of: &[u32; 3]| of.contains(&1) && of.contains(&3);
            assert!(triangles.len() == 2 && triangles.iter().all(has_shorter), "{triangles:?}");
        }
        // Later checks refuse triangles without area.
        assert_eq!(
            cut(&[0, 1, 2, 3], &[[0.; 3], [1., 0., 0.], [2., 0., 0.], [3., 0., 0.]]).unwrap().len(),
            2
        );
        assert!(cut(&[0; CORNERS_MAX + 1], &[[0.; 3]; CORNERS_MAX + 1]).is_none());
    }
}
