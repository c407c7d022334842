//! Keeps the part of one tetrahedron that lies inside the shape.

use crate::mesh::geometry::distance;

/// A corner of a lattice tetrahedron.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    pub(super) index: u32,
    pub(super) place_m: [f64; 3],
    /// Positive inside, 0 on the surface.
    pub(super) value: f64,
}

/// A node of the result: a lattice point `[i, i]`, or the crossing `[i, j]` of the edge from i, inside,
/// to j, outside.
type Key = [u32; 2];

/// Appends the tetrahedra that fill the inside part; none for a part without volume.
///
/// Quadrangles on common faces are divided by a rule that depends only on the face, so that neighbours
/// conform. `place_m` returns the point at which the edge from a corner inside to one outside leaves
/// the shape.
pub(super) fn cut(
    corners: [Corner; 4],
    place_m: &mut impl FnMut(&Corner, &Corner) -> [f64; 3],
    pieces: &mut Vec<[Key; 4]>,
) {
    // Sort the corners by their side of the surface.
    let inside: Vec<Corner> = corners.into_iter().filter(|c| c.value > 0.0).collect();
    let outside: Vec<Corner> = corners.into_iter().filter(|c| c.value < 0.0).collect();
    let on = corners.iter().find(|c| c.value == 0.0).map(own);
    match (inside.as_slice(), outside.as_slice(), on) {
        ([], _, _) => {}
        (_, [], _) => pieces.push(corners.map(|c| own(&c))),
        ([a], _, _) => {
            pieces.push(corners.map(|c| if c.value < 0.0 { crossing(a, &c) } else { own(&c) }));
        }
        ([a, b], [n], Some(top)) => {
            // A pyramid over the quadrangle a, b and their crossings.
            let (a, b) = if first(place_m, a, b, n) { (a, b) } else { (b, a) };
            pieces.push([top, own(a), crossing(b, n), own(b)]);
            pieces.push([top, own(a), crossing(b, n), crossing(a, n)]);
        }
        ([a, b, c], [n], _) => {
            let upper = [crossing(a, n), crossing(b, n), crossing(c, n)];
            let diagonals =
                [first(place_m, a, b, n), first(place_m, b, c, n), first(place_m, c, a, n)];
            prism([own(a), own(b), own(c)], upper, diagonals, pieces);
        }
        ([a, b], [m, n], _) => {
            let left = [own(a), crossing(a, m), crossing(a, n)];
            let right = [own(b), crossing(b, m), crossing(b, n)];
            let (base, back) = (first(place_m, a, b, m), first(place_m, b, a, n));
            // The quadrangle on the surface has no neighbour: it takes its shorter diagonal, unless the
            // three diagonals would then form a cycle, which no tetrahedra fill.
            let mut span = |[a, m, b, n]: [&Corner; 4]| distance(place_m(a, m), place_m(b, n));
            let shorter = span([a, m, b, n]) <= span([b, m, a, n]);
            let free = if base == back { !base } else { shorter };
            prism(left, right, [base, free, back], pieces);
        }
        _ => {}
    }
}

fn own(corner: &Corner) -> Key {
    [corner.index; 2]
}

fn crossing(inside: &Corner, outside: &Corner) -> Key {
    [inside.index, outside.index]
}

/// Returns true if the diagonal of the quadrangle a, b and their crossings towards n starts at a. It
/// starts at the corner with the shorter remaining edge, which gives the shorter diagonal.
fn first(
    place_m: &mut impl FnMut(&Corner, &Corner) -> [f64; 3],
    a: &Corner,
    b: &Corner,
    n: &Corner,
) -> bool {
    let own = distance(a.place_m, place_m(a, n));
    let other = distance(b.place_m, place_m(b, n));
    own < other || (own == other && a.index < b.index)
}

/// Cuts the prism between triangles a and b into three tetrahedra. The quadrangle from corner i
/// to corner i + 1 has the diagonal a[i] - b[i + 1] if `from_a[i]`, else b[i] - a[i + 1].
fn prism(a: [Key; 3], b: [Key; 3], from_a: [bool; 3], pieces: &mut Vec<[Key; 4]>) {
    for corner in 0..3 {
        let before = (corner + 2) % 3;
        // Both diagonals next to this corner of a end there; one corner of b has the same property.
        if !from_a[corner] || from_a[before] {
            continue;
        }
        for other in [(corner + 1) % 3, before] {
            if !from_a[other] && from_a[(other + 2) % 3] {
                let third = 3 - corner - other;
                pieces.push([a[corner], b[0], b[1], b[2]]);
                pieces.push([b[other], a[0], a[1], a[2]]);
                pieces.push([a[corner], b[other], a[third], b[third]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A ball of radius 1 around the origin.
    fn leaves_ball(inside: &Corner, outside: &Corner) -> [f64; 3] {
        let (mut low, mut high) = (0.0, 1.0);
        let at = |t: f64| {
            [0, 1, 2].map(|i| inside.place_m[i] + t * (outside.place_m[i] - inside.place_m[i]))
        };
        for _ in 0..40 {
            let middle = (low + high) / 2.0;
            *(if ball(at(middle)) > 0.0 { &mut low } else { &mut high }) = middle;
        }
        at(low)
    }

    fn ball(place_m: [f64; 3]) -> f64 {
        1.0 - distance(place_m, [0.0; 3])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// Also if the shorter diagonals would form a cycle.
        #[test]
        fn halves_are_filled(offsets in prop::array::uniform4(prop::array::uniform3(-0.2..0.2))) {
            let corners = [0, 1, 2, 3].map(|index: usize| {
                let place_m = [0, 1, 2].map(|axis| f64::from(axis == 2) + offsets[index][axis]);
                Corner { index: index as u32, place_m, value: ball(place_m) }
            });
            prop_assume!(corners.iter().filter(|corner| corner.value > 0.0).count() == 2);
            let mut pieces = Vec::new();
            cut(corners, &mut leaves_ball, &mut pieces);
            prop_assert_eq!(pieces.len(), 3);
        }
    }

    /// Every division of a prism fills it with three tetrahedra that share their faces.
    #[test]
    fn prisms_are_filled() {
        let (a, b) = ([[0; 2], [1; 2], [2; 2]], [[3; 2], [4; 2], [5; 2]]);
        for bits in 1..7 {
            let diagonals = [bits & 1 == 1, bits & 2 == 2, bits & 4 == 4];
            let mut pieces = Vec::new();
            prism(a, b, diagonals, &mut pieces);
            assert_eq!(pieces.len(), 3);
            let ids: Vec<[u32; 4]> = pieces.iter().map(|p| p.map(|key| key[0])).collect();
            let faces = crate::mesh::boundary(&ids);
            assert_eq!(faces.len(), 8);
            for i in 0..3u32 {
                let (j, pair) = ((i + 1) % 3, diagonals[i as usize]);
                let diagonal = if pair { [i, j + 3] } else { [j, i + 3] };
                assert!(faces.iter().any(|face| diagonal.iter().all(|id| face.contains(id))));
            }
        }
    }
}
