//! The surface of a body and its normals.

use std::array;

use super::geometry::{cross, dot, minus, unit};

/// Faces of a tetrahedron of positive volume, counter-clockwise from outside.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// Returns the faces that belong to exactly one of the tetrahedra, which must have positive volume:
/// counter-clockwise from outside, ordered by their sorted ids.
#[must_use]
pub fn boundary(tetrahedra: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let mut faces: Vec<([u32; 3], [u32; 3])> = Vec::with_capacity(4 * tetrahedra.len());
    for tetrahedron in tetrahedra {
        for corners in FACES {
            let face = corners.map(|corner| tetrahedron[corner]);
            let mut key = face;
            key.sort_unstable();
            faces.push((key, face));
        }
    }
    faces.sort_unstable();
    let single = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1);
    single.map(|same| same[0].1).collect()
}

/// Vector along a triangle's normal, twice as long as its area.
fn twice_area(nodes_m: &[[f64; 3]], triangle: [u32; 3]) -> [f64; 3] {
    let [a, b, c] = triangle.map(|id| nodes_m[id as usize]);
    cross(minus(b, a), minus(c, a))
}

/// Returns unit normals `[node]`, each the sum over the node's triangles weighted with their areas;
/// none if a node has no triangle or its triangles cancel. `nodes_m` and the normals are `[axis]`.
#[must_use]
pub fn vertex_normals(nodes_m: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<Option<[f64; 3]>> {
    let mut sums = vec![[0.0f64; 3]; nodes_m.len()];
    for triangle in triangles {
        let twice_area = twice_area(nodes_m, *triangle);
        for id in triangle {
            for (sum, part) in sums[*id as usize].iter_mut().zip(twice_area) {
                *sum += part;
            }
        }
    }
    let normal = |sum: [f64; 3]| Some(unit(sum)).filter(|of| of.iter().all(|x| x.is_finite()));
    sums.into_iter().map(normal).collect()
}

/// Returns unit normals `[triangle][corner]` that are smoothed over edges that bend little: at each corner the
/// sum over the node's triangles whose plane has at least `least_cosine` with this one's, weighted with their
/// areas, on this one's side. A triangle without an area has none. `nodes_m` and the normals are `[axis]`.
#[must_use]
pub fn corner_normals(
    nodes_m: &[[f64; 3]],
    triangles: &[[u32; 3]],
    least_cosine: f64,
) -> Vec<Option<[[f64; 3]; 3]>> {
    let planes: Vec<Option<([f64; 3], [f64; 3])>> = (triangles.iter())
        .map(|triangle| {
            let twice_area = twice_area(nodes_m, *triangle);
            let normal = unit(twice_area);
            normal.iter().all(|x| x.is_finite()).then_some((twice_area, normal))
        })
        .collect();
    let mut around = vec![Vec::new(); nodes_m.len()];
    for (triangle, plane) in triangles.iter().zip(&planes) {
        let Some(plane) = plane else { continue };
        triangle.iter().for_each(|&id| around[id as usize].push(plane));
    }
    let smoothed = |own: [f64; 3], id: u32| {
        let mut sum = [0.0; 3];
        for (twice_area, normal) in &around[id as usize] {
            let cosine = dot(own, *normal);
            let share = if cosine.abs() < least_cosine { 0.0 } else { cosine.signum() };
            sum = array::from_fn(|axis| sum[axis] + share * twice_area[axis]);
        }
        unit(sum)
    };
    let triangles = triangles.iter().zip(&planes);
    triangles.map(|(ids, plane)| plane.map(|(_, own)| ids.map(|id| smoothed(own, id)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [[f64; 3]; 6] =
        [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 1., 1.], [9., 9., 9.]];

    #[test]
    fn outward_and_without_the_shared_face() {
        let triangles = boundary(&[[0, 1, 2, 3], [1, 2, 3, 4]]);
        assert_eq!(triangles.len(), 6);
        let inside = [0.4; 3];
        for ids in &triangles {
            let corner = NODES[ids[0] as usize];
            assert!(dot(twice_area(&NODES, *ids), minus(corner, inside)) > 0.0, "{ids:?}");
        }
        assert!(!triangles.iter().any(|t| !t.contains(&0) && !t.contains(&4)));
    }

    #[test]
    fn normals_are_weighted_units() {
        let normals = vertex_normals(&NODES, &[[0, 1, 2], [0, 3, 1]]);
        let half = 0.5f64.sqrt();
        let corner = normals[0].unwrap();
        assert!((corner[1] - half).abs() < 1e-15 && (corner[2] - half).abs() < 1e-15);
        assert_eq!(normals[2], Some([0.0, 0.0, 1.0]));
        assert_eq!(normals[5], None);
        let tiny: Vec<_> = NODES.iter().map(|p| p.map(|x| x * 1e-100)).collect();
        assert_eq!(vertex_normals(&tiny, &[[0, 1, 2]])[2], Some([0.0, 0.0, 1.0]));
        assert_eq!(vertex_normals(&NODES, &[[0, 1, 2], [0, 2, 1]])[0], None);
    }

    #[test]
    fn corners_are_smoothed_over_flat_edges_alone() {
        // Two squares at a right angle, and a roof that bends by a little, once turned the other way round.
        let square = [[0, 1, 2], [0, 3, 1], [0, 0, 1]];
        let normals = corner_normals(&NODES, &square, 0.6);
        assert_eq!(normals[0], Some([[0.0, 0.0, 1.0]; 3]));
        assert_eq!(normals[1], Some([[0.0, 1.0, 0.0]; 3]));
        assert_eq!(normals[2], None);
        let roof = [[0.0, 0.0, 0.1], [0.0, 1.0, 0.1], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
        for left in [[0, 1, 3], [0, 3, 1]] {
            let normals = corner_normals(&roof, &[[0, 2, 1], left], 0.6);
            let normal =
                |node: u32| normals[1].unwrap()[left.iter().position(|&id| id == node).unwrap()];
            let up = if left[2] == 1 { -1.0 } else { 1.0 };
            assert!((up * normal(0)[2] - 1.0).abs() < 1e-12, "{:?}", normal(0));
            assert!((normal(3)[0] / normal(3)[2] + 0.1).abs() < 1e-12, "{:?}", normal(3));
        }
    }
}
