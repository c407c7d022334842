//! Sets of edges and tetrahedra, lengths and volumes.

/// Volume below this share of the cubed longest edge counts as none.
const FLAT: f64 = 1e-12;

/// a - b.
pub(crate) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Scalar product.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the vector of length 1 in this direction; not a number if it has none.
pub(super) fn unit(direction: [f64; 3]) -> [f64; 3] {
    // Scale first: squares of tiny numbers would vanish.
    let largest = direction.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let scaled = direction.map(|x| x / largest);
    let length = dot(scaled, scaled).sqrt();
    scaled.map(|x| x / length)
}

/// Distance of two points.
pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = minus(a, b);
    dot(d, d).sqrt()
}

/// Signed volume of a tetrahedron times six: positive if b, c, d are counter-clockwise seen from outside.
pub(crate) fn volume6(corners: [[f64; 3]; 4]) -> f64 {
    let [a, b, c, d] = corners;
    dot(minus(b, a), cross(minus(c, a), minus(d, a)))
}

/// Positions of the four corners.
pub(super) fn corners(nodes: &[[f64; 3]], tetrahedron: [u32; 4]) -> [[f64; 3]; 4] {
    tetrahedron.map(|id| nodes[id as usize])
}

/// Returns the tetrahedra without later repetitions of the same four nodes (Gmsh 2.2 writes an
/// element once for each of its groups), in the order given.
pub(super) fn unique(tetrahedra: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let mut order: Vec<([u32; 4], usize)> =
        tetrahedra.iter().copied().map(sorted).zip(0..).collect();
    order.sort_unstable();
    order.dedup_by_key(|entry| entry.0);
    let mut first: Vec<usize> = order.into_iter().map(|entry| entry.1).collect();
    first.sort_unstable();
    first.into_iter().map(|at| tetrahedra[at]).collect()
}

fn sorted(mut ids: [u32; 4]) -> [u32; 4] {
    ids.sort_unstable();
    ids
}

/// Reverses tetrahedra of negative volume; returns all with the number of flat ones.
pub(super) fn orient(nodes: &[[f64; 3]], mut tetrahedra: Vec<[u32; 4]>) -> (Vec<[u32; 4]>, usize) {
    let mut flat = 0;
    for tetrahedron in &mut tetrahedra {
        let points = corners(nodes, *tetrahedron);
        let volume6 = volume6(points);
        let longest =
            EDGES.iter().map(|&[i, j]| distance(points[i], points[j])).fold(0.0, f64::max);
        if volume6.abs() <= FLAT * longest * longest * longest {
            flat += 1;
        }
        if volume6 < 0.0 {
            tetrahedron.swap(2, 3);
        }
    }
    (tetrahedra, flat)
}

/// Corners of the six edges of a tetrahedron.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Edges `[i, j]` of the tetrahedra, i < j, unique and sorted.
pub(crate) fn edges(tetrahedra: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let pairs =
        tetrahedra.iter().flat_map(|t| EDGES.map(|[i, j]| [t[i].min(t[j]), t[i].max(t[j])]));
    let mut all: Vec<_> = pairs.collect();
    all.sort_unstable();
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_flat_and_turned() {
        let nodes = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 1., 0.]];
        let given = [[0, 2, 1, 3], [1, 0, 3, 2], [0, 1, 2, 4]];
        let (kept, flat) = orient(&nodes, unique(&given));
        assert_eq!((kept.len(), flat), (2, 1));
        assert_eq!(volume6(corners(&nodes, kept[0])), 1.0);
        assert_eq!(kept[1], [0, 1, 2, 4]);
        assert_eq!(edges(&kept).len(), 9);
    }
}
