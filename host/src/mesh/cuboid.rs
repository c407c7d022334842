//! `box:NXxNYxNZxD`: a block of cubes, centred in x and y, z from 0.

use std::collections::BTreeMap;

use super::Mesh;
use super::size::{centred, parse};
use crate::error::Result;

/// Generates NX x NY x NZ nodes D metres apart, id = (i * NY + j) * NZ + k with i, j, k along x, y, z.
///
/// A cube has five tetrahedra: one over the four corners with odd i + j + k and one at each other
/// corner, so that neighbouring cubes divide their common face alike. The bottom z = 0 is held.
pub(super) fn generate(size: &str, nodes_max: usize) -> Result<Mesh> {
    let ([nx, ny, nz], spacing_m) = parse::<3>("box:NXxNYxNZxD", size, nodes_max)?;
    let id = |[i, j, k]: [usize; 3]| ((i * ny + j) * nz + k) as u32;
    let mut nodes_m = Vec::with_capacity(nx * ny * nz);
    let mut tetrahedra = Vec::new();
    let mut bottom = Vec::new();
    for i in 0..nx {
        for j in 0..ny {
            bottom.push(id([i, j, 0]));
            for k in 0..nz {
                let z_m = k as f64 * spacing_m;
                nodes_m.push([centred(i, nx, spacing_m), centred(j, ny, spacing_m), z_m]);
                if i + 1 < nx && j + 1 < ny && k + 1 < nz {
                    tetrahedra.extend(cube([i, j, k]).map(|t| t.map(id)));
                }
            }
        }
    }
    let mesh = Mesh::from_tetrahedra(nodes_m, &tetrahedra, BTreeMap::new());
    Ok(Mesh { default_fixed: bottom, ..mesh })
}

/// Returns the grid positions of the five tetrahedra of the cube whose lowest corner is `low`.
fn cube(low: [usize; 3]) -> [[[usize; 3]; 4]; 5] {
    // A cube at an odd position is its even neighbour mirrored in x.
    let flip = (low[0] + low[1] + low[2]) % 2;
    let at = |x: usize, y: usize, z: usize| [low[0] + (x ^ flip), low[1] + y, low[2] + z];
    let odd = [at(1, 0, 0), at(0, 1, 0), at(0, 0, 1), at(1, 1, 1)];
    [
        odd,
        [at(0, 0, 0), odd[0], odd[1], odd[2]],
        [at(1, 1, 0), odd[0], odd[1], odd[3]],
        [at(1, 0, 1), odd[0], odd[2], odd[3]],
        [at(0, 1, 1), odd[1], odd[2], odd[3]],
    ]
}

#[cfg(test)]
mod tests {
    use super::super::geometry::{corners, volume6};
    use super::super::surface::boundary;
    use super::*;
    use crate::mesh::CELLS_MAX;

    #[test]
    fn ids_and_place() {
        let mesh = generate("3x2x4x0.1", CELLS_MAX).unwrap();
        assert_eq!(mesh.nodes_m.len(), 24);
        assert_eq!(mesh.nodes_m[0], [-0.1, -0.05, 0.0]);
        assert_eq!(mesh.nodes_m[(2 * 2 + 1) * 4 + 3], [0.1, 0.05, 3.0 * 0.1]);
        assert_eq!(mesh.default_fixed, [0, 4, 8, 12, 16, 20]);
    }

    #[test]
    fn volumes_positive_and_faces_conforming() {
        let mesh = generate("4x5x3x0.5", CELLS_MAX).unwrap();
        let volumes = mesh.tetrahedra.iter().map(|t| volume6(corners(&mesh.nodes_m, *t)) / 6.0);
        assert!(volumes.clone().all(|v| v > 0.0));
        assert!((volumes.sum::<f64>() - 3.0 * 4.0 * 2.0 * 0.125).abs() < 1e-12);
        assert_eq!(mesh.tetrahedra.len(), 5 * 3 * 4 * 2);
        // Faces that do not conform would stay single inside the block.
        let faces = boundary(&mesh.tetrahedra);
        assert_eq!(faces, mesh.triangles);
        assert_eq!(faces.len(), 4 * (3 * 4 + 3 * 2 + 4 * 2));
        let odd = |id: u32| {
            let (i, j, k) = (id / 15, id / 3 % 5, id % 3);
            (i + j + k) % 2 == 1
        };
        let diagonal = |[i, j]: [u32; 2]| odd(i) == odd(j);
        assert!(mesh.links.iter().filter(|l| diagonal(**l)).all(|l| odd(l[0])));
    }

    #[test]
    fn as_large_as_the_reference_block() {
        let mesh = generate("21x21x11x0.005", CELLS_MAX).unwrap();
        assert_eq!((mesh.nodes_m.len(), mesh.tetrahedra.len()), (4_851, 20_000));
        assert_eq!(mesh.links.len(), 26_450);
    }
}
