//! `plane:NXxNYxD`: a flat sheet in the xy-plane, z = 0, centred on the origin.

use super::size::{centred, parse};
use super::{Mesh, MeshOptions};
use crate::error::Result;

/// Generates NX x NY nodes D metres apart, id = i * NY + j with i along x and j along y, linked to
/// four neighbours and, with `diagonals`, along both diagonals of each square. The border is held.
pub(super) fn generate(size: &str, options: &MeshOptions) -> Result<Mesh> {
    let diagonals = options.diagonals;
    let ([nx, ny], spacing_m) = parse::<2>("plane:NXxNYxD", size, options.nodes_max)?;
    let id = |i: usize, j: usize| (i * ny + j) as u32;
    let mut mesh = Mesh::default();
    for i in 0..nx {
        for j in 0..ny {
            mesh.nodes_m.push([centred(i, nx, spacing_m), centred(j, ny, spacing_m), 0.0]);
            if i == 0 || j == 0 || i + 1 == nx || j + 1 == ny {
                mesh.border.push(id(i, j));
            }
            if j + 1 < ny {
                mesh.links.push([id(i, j), id(i, j + 1)]);
            }
            if i + 1 < nx {
                mesh.links.push([id(i, j), id(i + 1, j)]);
            }
            if i + 1 < nx && j + 1 < ny {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
                if diagonals {
                    mesh.links.extend([[a, c], [d, b]]);
                }
            }
        }
    }
    mesh.links.sort_unstable();
    mesh.default_fixed.clone_from(&mesh.border);
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_links_and_border() {
        let mesh = generate("21x21x0.01", &MeshOptions::default()).unwrap();
        assert_eq!(mesh.nodes_m.len(), 441);
        assert_eq!(mesh.nodes_m[220], [0.0; 3]);
        let near = |at: [f64; 3], x: f64, y: f64| (at[0] - x).abs() + (at[1] - y).abs() < 1e-15;
        assert!(near(mesh.nodes_m[3 * 21 + 5], -0.07, -0.05));
        assert_eq!((mesh.links.len(), mesh.border.len()), (2 * 20 * 21, 80));
        assert_eq!(mesh.default_fixed, mesh.border);
        assert!(
            mesh.links.windows(2).all(|w| w[0] < w[1]) && mesh.links.iter().all(|l| l[0] < l[1])
        );
        assert_eq!(mesh.triangles.len(), 2 * 20 * 20);
    }

    #[test]
    fn oblong_with_diagonals() {
        let mesh = generate("3x2x0.5", &MeshOptions { diagonals: true, ..MeshOptions::default() })
            .unwrap();
        assert_eq!(mesh.nodes_m[1], [-0.5, 0.25, 0.0]);
        let expected = [
            [0, 1],
            [0, 2],
            [0, 3],
            [1, 2],
            [1, 3],
            [2, 3],
            [2, 4],
            [2, 5],
            [3, 4],
            [3, 5],
            [4, 5],
        ];
        assert_eq!(mesh.links, expected);
        for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|id| mesh.nodes_m[id as usize])) {
            let turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            assert!(turn > 0.0);
        }
    }
}
