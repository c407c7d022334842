//! Tests if two triangles meet, by exact signs of determinants.

use robust::{Coord, Coord3D, orient2d, orient3d};

type Place = [f64; 3];

fn turn(a: Place, b: Place, c: Place, d: Place) -> f64 {
    let of = |[x, y, z]: Place| Coord3D { x, y, z };
    orient3d(of(a), of(b), of(c), of(d))
}

/// Returns true if two triangles meet outside the corners they share; `ids` are those of the corners.
///
/// Triangles that share an edge meet if they overlap in one plane.
pub(super) fn meet(places: [[Place; 3]; 2], ids: [[u32; 3]; 2]) -> bool {
    let [own, other] = places;
    let shared = |k: usize| ids[1].contains(&ids[0][k]);
    let shared_count = (0..3).filter(|&k| shared(k)).count();
    let outside = |a: [u32; 3], b: [u32; 3]| (0..3).find(|&k| !b.contains(&a[k])).unwrap_or(0);
    match shared_count {
        0 => {
            (0..3).any(|k| segment_meets(own[k], own[(k + 1) % 3], other))
                || (0..3).any(|k| segment_meets(other[k], other[(k + 1) % 3], own))
        }
        // Their common part ends on the edge of one of them that lies opposite the corner.
        1 => {
            let own_corner = (0..3).find(|&k| shared(k)).unwrap_or(0);
            let other_corner = (0..3).find(|&k| ids[0].contains(&ids[1][k])).unwrap_or(0);
            let opposite = |t: [Place; 3], k: usize| (t[(k + 1) % 3], t[(k + 2) % 3]);
            let (a, b) = opposite(own, own_corner);
            let (c, d) = opposite(other, other_corner);
            segment_meets(a, b, other) || segment_meets(c, d, own)
        }
        2 => {
            let k = outside(ids[0], ids[1]);
            let (apex, a, b) = (own[k], own[(k + 1) % 3], own[(k + 2) % 3]);
            let far = other[outside(ids[1], ids[0])];
            turn(apex, a, b, far) == 0.0 && {
                let axis = plane(own);
                flat(a, b, apex, axis) * flat(a, b, far, axis) > 0.0
            }
        }
        _ => true,
    }
}

/// Returns true if a segment meets a triangle, its border included.
fn segment_meets(p: Place, q: Place, [a, b, c]: [Place; 3]) -> bool {
    let (from, to) = (turn(a, b, c, p), turn(a, b, c, q));
    if from == 0.0 && to == 0.0 {
        return flat_meets(p, q, [a, b, c]);
    }
    if from > 0.0 && to > 0.0 || from < 0.0 && to < 0.0 {
        return false;
    }
    let sides = [turn(p, q, a, b), turn(p, q, b, c), turn(p, q, c, a)];
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

/// Returns the axis of projection that keeps most of the triangle's area.
fn plane(triangle: [Place; 3]) -> usize {
    let normal = super::tree::area2(triangle).map(f64::abs);
    (0..3).max_by(|&a, &b| normal[a].total_cmp(&normal[b])).unwrap_or(0)
}

/// Returns the orientation of three points seen along an axis.
fn flat(a: Place, b: Place, c: Place, axis: usize) -> f64 {
    let of = |place: Place| Coord { x: place[(axis + 1) % 3], y: place[(axis + 2) % 3] };
    orient2d(of(a), of(b), of(c))
}

/// Returns true if a segment meets a triangle of the same plane.
fn flat_meets(p: Place, q: Place, triangle: [Place; 3]) -> bool {
    let axis = plane(triangle);
    let inside = |place: Place| {
        let sides = [0, 1, 2].map(|k| flat(triangle[k], triangle[(k + 1) % 3], place, axis));
        sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
    };
    let crosses = |a: Place, b: Place| {
        let opposite = |x: f64, y: f64| x <= 0.0 && y >= 0.0 || x >= 0.0 && y <= 0.0;
        opposite(flat(p, q, a, axis), flat(p, q, b, axis))
            && opposite(flat(a, b, p, axis), flat(a, b, q, axis))
            && boxes_meet([p, q], [a, b])
    };
    inside(p) || inside(q) || (0..3).any(|k| crosses(triangle[k], triangle[(k + 1) % 3]))
}

/// Returns true if the boxes around two segments meet, which separates segments in one line.
fn boxes_meet([a, b]: [Place; 2], [c, d]: [Place; 2]) -> bool {
    (0..3).all(|axis| {
        a[axis].min(b[axis]) <= c[axis].max(d[axis]) && c[axis].min(d[axis]) <= a[axis].max(b[axis])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: [Place; 3] = [[0., 0., 0.], [4., 0., 0.], [0., 4., 0.]];

    /// Triangles without common corners.
    fn meets(other: [Place; 3]) -> bool {
        let met = meet([FLAT, other], [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(met, meet([other, FLAT], [[3, 4, 5], [0, 1, 2]]));
        let [a, b, c] = other;
        assert_eq!(met, meet([FLAT, [c, b, a]], [[0, 1, 2], [5, 4, 3]]));
        met
    }

    #[test]
    fn triangles_apart_touching_and_through_each_other() {
        assert!(meets([[1., 1., -1.], [1., 1., 1.], [9., 9., 1.]]));
        assert!(meets([[1., 1., 0.], [1., 1., 1.], [9., 9., 1.]]), "a corner touches");
        assert!(meets([[0., 2., 0.], [0., 2., 1.], [-9., 2., 1.]]), "a corner touches an edge");
        assert!(!meets([[1., 1., 1e-300], [1., 1., 1.], [9., 9., 1.]]));
        assert!(!meets([[3., 3., -1.], [3., 3., 1.], [9., 9., 1.]]), "past the long edge");
        // A large one around the other: its edges pass it.
        assert!(meets([[-9., 1., -1.], [9., 1., -1.], [1., 1., 9.]]));
        // In one plane.
        assert!(meets([[1., 1., 0.], [9., 1., 0.], [9., 9., 0.]]));
        assert!(meets([[-9., -9., 0.], [30., -9., 0.], [-9., 30., 0.]]), "around it");
        assert!(!meets([[5., 0., 0.], [9., 0., 0.], [5., 4., 0.]]), "in line with an edge");
        assert!(!meets([[3., 3., 0.], [9., 3., 0.], [9., 9., 0.]]));
    }

    #[test]
    fn neighbours_meet_only_beyond_what_they_share() {
        let share = |other, ids| meet([FLAT, other], [[0, 1, 2], ids]);
        // A corner.
        assert!(!share([FLAT[0], [-4., 0., 0.], [0., -4., 0.]], [0, 3, 4]));
        assert!(share([FLAT[0], [3., 1., -1.], [1., 1., 1.]], [0, 3, 4]));
        assert!(share([[3., 1., -1.], [1., 1., 1.], FLAT[0]], [3, 4, 0]));
        assert!(share([FLAT[0], [9., 1., 0.], [9., 2., 0.]], [0, 3, 4]), "in one plane");
        // An edge.
        assert!(!share([FLAT[1], FLAT[0], [1., 1., 1e-9]], [1, 0, 3]));
        assert!(!share([FLAT[1], FLAT[0], [1., -1., 0.]], [1, 0, 3]), "flat on");
        assert!(share([FLAT[1], FLAT[0], [1., 1., 0.]], [1, 0, 3]), "folded back");
        assert!(share(FLAT, [0, 1, 2]));
    }
}
