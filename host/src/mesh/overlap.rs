//! Finds tetrahedra that overlap: in a folded mesh, or in parts that lie in each other.
//!
//! A tree finds pairs whose boxes meet. Two overlap unless there is a separating axis: a normal of a face,
//! or the cross product of an edge of each. Their common part may be thin: of rounding error if they share
//! corners, and below a ten thousandth of an edge if parts with separate nodes touch.

use super::Mesh;
use super::geometry::{EDGES, corners, cross, distance, dot, minus};
use super::solid::tree::Tree;

/// Thickness that may lie in both, as a share of the smaller one's longest edge.
const THIN: f64 = 1e-4;

/// Corners of the faces of a tetrahedron.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]];

type Corners = [[f64; 3]; 4];

/// Tetrahedra that overlap others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlaps {
    /// Number of them.
    pub tetrahedra: usize,
    /// Middle of the first two of them \[m\].
    pub place_m: [f64; 3],
}

/// Returns the tetrahedra of a mesh that overlap others, if there are any.
#[must_use]
pub fn overlaps(mesh: &Mesh) -> Option<Overlaps> {
    if mesh.tetrahedra.is_empty() {
        return None;
    }
    let all = mesh.tetrahedra.iter().map(|ids| corners(&mesh.nodes_m, *ids)).collect();
    let tree: Tree<4> = Tree::new(all);
    let mut is_over = vec![false; mesh.tetrahedra.len()];
    let mut first = None;
    for own in 0..mesh.tetrahedra.len() as u32 {
        let solid = Solid::new(tree.corners(own));
        tree.meeting(own, |other| {
            let is_known = is_over[own as usize] && is_over[other as usize];
            if !is_known && solid.overlaps(tree.corners(other)) {
                first = first.or(Some([own, other]));
                is_over[own as usize] = true;
                is_over[other as usize] = true;
            }
        });
    }
    let pair = first?.map(|of| tree.corners(of));
    let middle = |axis: usize| pair.as_flattened().iter().map(|of| of[axis]).sum::<f64>() / 8.0;
    Some(Overlaps {
        tetrahedra: is_over.iter().filter(|over| **over).count(),
        place_m: [0, 1, 2].map(middle),
    })
}

/// A tetrahedron prepared for comparison with others, its first corner at 0.
struct Solid {
    first: [f64; 3],
    corners: Corners,
    /// The axes of space and the normals of its faces.
    sides: [Side; 7],
    longest: f64,
}

/// An axis, and a tetrahedron's lowest and highest coordinate along it.
struct Side {
    axis: [f64; 3],
    reach: [f64; 2],
}

impl Side {
    fn new(axis: [f64; 3], of: &Corners) -> Self {
        Self { axis, reach: reach(of, axis) }
    }

    /// Returns true if the axis separates another tetrahedron, except for a common part of `thin`.
    fn parts(&self, other: &Corners, thin: f64) -> bool {
        let [low, high] = reach(other, self.axis);
        let both = high.min(self.reach[1]) - low.max(self.reach[0]);
        let square = dot(self.axis, self.axis);
        // An axis without length separates nothing.
        square > 0.0 && (both <= 0.0 || both * both <= thin * thin * square)
    }
}

impl Solid {
    fn new(of: Corners) -> Self {
        let corners = of.map(|corner| minus(corner, of[0]));
        let side = |axis: [f64; 3]| Side::new(axis, &corners);
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(side);
        let [a, b, c, d] = FACES.map(|face| side(normal(&corners, face)));
        Self { first: of[0], corners, sides: [x, y, z, a, b, c, d], longest: longest(&corners) }
    }

    /// Returns true if both have more in common than corners, edges and parts of faces.
    fn overlaps(&self, other: Corners) -> bool {
        let other = other.map(|corner| minus(corner, self.first));
        let thin = THIN * self.longest.min(longest(&other));
        if self.sides.iter().any(|side| side.parts(&other, thin)) {
            return false;
        }
        let parts = |axis: [f64; 3]| Side::new(axis, &self.corners).parts(&other, thin);
        if FACES.iter().any(|face| parts(normal(&other, *face))) {
            return false;
        }
        let edge = |of: &Corners, [i, j]: [usize; 2]| minus(of[j], of[i]);
        !EDGES.iter().any(|own| {
            let own = edge(&self.corners, *own);
            EDGES.iter().any(|of| parts(cross(own, edge(&other, *of))))
        })
    }
}

fn longest(of: &Corners) -> f64 {
    EDGES.map(|[i, j]| distance(of[i], of[j])).into_iter().fold(0.0, f64::max)
}

fn normal(of: &Corners, [i, j, k]: [usize; 3]) -> [f64; 3] {
    cross(minus(of[j], of[i]), minus(of[k], of[i]))
}

/// Returns a tetrahedron's lowest and highest coordinate along an axis.
fn reach(of: &Corners, axis: [f64; 3]) -> [f64; 2] {
    let [a, b, c, d] = of.map(|corner| dot(corner, axis));
    [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::{MeshOptions, load};

    /// The tetrahedra of a generated body, with one of its nodes moved.
    fn moved(spec: &str, node: usize, to_m: [f64; 3]) -> Option<Overlaps> {
        let mut mesh = load(spec, &MeshOptions::default()).unwrap();
        mesh.nodes_m[node] = to_m;
        overlaps(&mesh)
    }

    #[test]
    fn tetrahedra_that_share_faces_edges_and_corners_do_not_overlap() {
        for spec in ["box:7x5x4x0.01", "box:3x3x3x1e-5", "organ:1000"] {
            assert_eq!(overlaps(&load(spec, &MeshOptions::default()).unwrap()), None, "{spec}");
        }
        assert_eq!(overlaps(&Mesh::default()), None);
    }

    #[test]
    fn a_node_beyond_the_surface_folds_the_tetrahedra_around_it() {
        // The middle of 27 nodes, and where it lies above the top.
        let [x, y, z] = load("box:3x3x3x0.01", &MeshOptions::default()).unwrap().nodes_m[13];
        assert_eq!(moved("box:3x3x3x0.01", 13, [x, y, z + 0.009]), None);
        let folded = moved("box:3x3x3x0.01", 13, [x, y, z + 0.014]).unwrap();
        assert!(folded.tetrahedra > 4 && folded.tetrahedra <= 40, "{folded:?}");
        assert!(distance(folded.place_m, [x, y, z]) < 0.02, "{folded:?}");
    }

    fn place() -> impl Strategy<Value = [f64; 3]> {
        prop::array::uniform3(0.0..1.0)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        /// Two overlap where a point lies well inside both; where a plane is between them they do not.
        #[test]
        fn a_common_point_or_a_plane_between_tells(
            one in prop::array::uniform4(place()),
            other in prop::array::uniform4(place()),
            shares in prop::array::uniform4(0.1..1.0),
        ) {
            let sum: f64 = shares.iter().sum();
            let inside = |of: Corners| {
                [0, 1, 2].map(|axis| (0..4).map(|at| shares[at] * of[at][axis]).sum::<f64>() / sum)
            };
            let volume = super::super::geometry::volume6;
            prop_assume!(volume(one).abs() > 0.02 && volume(other).abs() > 0.02);
            let way = minus(inside(one), inside(other));
            let shifted = other.map(|corner| [0, 1, 2].map(|axis| corner[axis] + way[axis]));
            prop_assert!(Solid::new(one).overlaps(shifted));
            let [from, to] = [one, other].map(|of| reach(&of, [1.0, 0.0, 0.0]));
            let beside = other.map(|[x, y, z]| [x + from[1] - to[0], y, z]);
            prop_assert!(!Solid::new(one).overlaps(beside));
            // A mirror image over a face shares the face alone.
            let [a, b, c, d] = one;
            let normal = cross(minus(b, a), minus(c, a));
            let away = 2.0 * dot(minus(d, a), normal) / dot(normal, normal);
            let mirrored = [0, 1, 2].map(|axis| d[axis] - away * normal[axis]);
            prop_assert!(!Solid::new(one).overlaps([c, a, b, mirrored]));
        }
    }
}
