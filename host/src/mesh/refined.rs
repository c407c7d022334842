//! A mesh with every tetrahedron cut into eight.
//!
//! Each edge gets a node in its middle. Four small tetrahedra lie at the corners; the octahedron between them is cut
//! along its shortest diagonal into four more (J. Bey, *Tetrahedral grid refinement*, 1995).

use super::geometry::{distance, edges};
use super::{CELLS_MAX, Mesh};
use crate::error::{Error, Result};

/// A mesh that was cut once.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The nodes of the given mesh, then the middles of its edges.
    pub mesh: Mesh,
    /// The edges, by their middles: node `first_middle + k` is that of edge `k`.
    pub edges: Vec<[u32; 2]>,
    /// Number of nodes of the given mesh.
    pub first_middle: u32,
}

impl Refined {
    /// Cuts a mesh of tetrahedra once. Groups and the nodes held by default have
    /// the middles of [`Self::with_middles`] too.
    ///
    /// # Errors
    /// A mesh without tetrahedra; one that would have more nodes than a body has cells.
    pub fn of(mesh: &Mesh) -> Result<Self> {
        if mesh.tetrahedra.is_empty() {
            return Err(Error::input(
                "the mesh has no tetrahedra that could be cut; take a file of tetrahedra, box:, organ:, or `fill_m`",
            ));
        }
        let edges = edges(&mesh.tetrahedra);
        let count = mesh.nodes_m.len();
        if count + edges.len() > CELLS_MAX {
            return Err(Error::input(format!(
                "cut once the mesh has {} nodes, more than {CELLS_MAX}: give a coarser mesh, or a smaller part of the \
                 body around the tool",
                count + edges.len()
            )));
        }
        // The middles of the edges.
        let mut nodes_m = mesh.nodes_m.clone();
        nodes_m.extend(edges.iter().map(|&[i, j]| {
            let (a, b) = (mesh.nodes_m[i as usize], mesh.nodes_m[j as usize]);
            std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis]))
        }));
        // The small tetrahedra.
        let middle = |i: u32, j: u32| {
            let edge = [i.min(j), i.max(j)];
            (count + edges.binary_search(&edge).unwrap_or_default()) as u32
        };
        let tetrahedra: Vec<[u32; 4]> =
            mesh.tetrahedra.iter().flat_map(|&corners| eight(corners, middle, &nodes_m)).collect();
        // Groups and held nodes have the middles between them.
        let mut refined = Self { mesh: Mesh::default(), edges, first_middle: count as u32 };
        let groups = mesh.groups.iter();
        let groups = groups.map(|(name, of)| (name.clone(), refined.with_middles(mesh, of)));
        let groups = groups.collect();
        let default_fixed = refined.with_middles(mesh, &mesh.default_fixed);
        refined.mesh = Mesh {
            default_fixed,
            unused: mesh.unused.clone(),
            ..Mesh::from_tetrahedra(nodes_m, &tetrahedra, groups)
        };
        Ok(refined)
    }

    /// Some nodes of the given mesh, ascending, and the middles of the edges that they hold: edges of the surface
    /// between two of them, and those of tetrahedra that have no other corner.
    #[must_use]
    pub fn with_middles(&self, mesh: &Mesh, nodes: &[u32]) -> Vec<u32> {
        let has = |node: &u32| nodes.binary_search(node).is_ok();
        let surface = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let surface = surface.filter(|edge| edge.iter().all(has));
        let full = mesh.tetrahedra.iter().copied().filter(|corners| corners.iter().all(has));
        let held = surface.chain(edges(&full.collect::<Vec<_>>()));
        let mut middles: Vec<u32> = held
            .filter_map(|[i, j]| self.edges.binary_search(&[i.min(j), i.max(j)]).ok())
            .map(|edge| self.first_middle + edge as u32)
            .collect();
        middles.sort_unstable();
        middles.dedup();
        nodes.iter().copied().chain(middles).collect()
    }
}

/// The parts of a tetrahedron; `middle` is the node between two of its corners.
fn eight(
    [a, b, c, d]: [u32; 4],
    middle: impl Fn(u32, u32) -> u32,
    nodes_m: &[[f64; 3]],
) -> [[u32; 4]; 8] {
    let (ab, ac, ad) = (middle(a, b), middle(a, c), middle(a, d));
    let (bc, bd, cd) = (middle(b, c), middle(b, d), middle(c, d));
    // The octahedron's diagonals, each with the four other nodes around it.
    let diagonals =
        [([ab, cd], [ac, bc, bd, ad]), ([ac, bd], [ab, bc, cd, ad]), ([ad, bc], [ab, ac, cd, bd])];
    let length = |[i, j]: [u32; 2]| distance(nodes_m[i as usize], nodes_m[j as usize]);
    let [first, second, third] = diagonals;
    let shorter = |one: ([u32; 2], [u32; 4]), other: ([u32; 2], [u32; 4])| {
        if length(other.0) < length(one.0) { other } else { one }
    };
    let ([i, j], [p, q, r, s]) = shorter(shorter(first, second), third);
    [
        [a, ab, ac, ad],
        [b, ab, bc, bd],
        [c, ac, bc, cd],
        [d, ad, bd, cd],
        [i, j, p, q],
        [i, j, q, r],
        [i, j, r, s],
        [i, j, s, p],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::geometry::{corners, volume6};
    use crate::mesh::{MeshOptions, load};

    fn volume_m3(mesh: &Mesh) -> f64 {
        mesh.tetrahedra.iter().map(|&of| volume6(corners(&mesh.nodes_m, of)) / 6.0).sum()
    }

    #[test]
    fn a_cut_mesh_has_eight_parts_a_tetrahedron_and_the_same_body() {
        for spec in ["box:4x3x3x0.01", "organ:200"] {
            let mesh = load(spec, &MeshOptions::default()).unwrap();
            let refined = Refined::of(&mesh).unwrap();
            assert_eq!(refined.mesh.tetrahedra.len(), 8 * mesh.tetrahedra.len(), "{spec}");
            assert_eq!(refined.mesh.triangles.len(), 4 * mesh.triangles.len(), "{spec}");
            assert_eq!(refined.mesh.flat_tetrahedra, 0);
            let (before, after) = (volume_m3(&mesh), volume_m3(&refined.mesh));
            assert!((after - before).abs() < 1e-12 * before, "{spec}: {before} {after}");
            // Every small tetrahedron has an eighth of its volume, whichever diagonal was taken.
            let largest = |mesh: &Mesh| {
                let of = mesh.tetrahedra.iter().map(|&of| volume6(corners(&mesh.nodes_m, of)));
                of.fold(0.0, f64::max)
            };
            assert!((8.0 * largest(&refined.mesh) - largest(&mesh)).abs() < 1e-9 * largest(&mesh));
        }
    }

    #[test]
    fn groups_have_the_middles_of_their_edges() {
        // The bottom of 3 x 3 nodes: 12 sides of squares and 4 diagonals.
        let mesh = load("box:3x3x2x0.01", &MeshOptions::default()).unwrap();
        let refined = Refined::of(&mesh).unwrap();
        let bottom = &refined.mesh.default_fixed;
        assert_eq!(bottom.len(), 9 + 16);
        let low = mesh.nodes_m[mesh.default_fixed[0] as usize][2];
        assert!(bottom.iter().all(|&node| refined.mesh.nodes_m[node as usize][2] == low));
        assert!(bottom.is_sorted());
    }

    #[test]
    fn what_cannot_be_cut_is_refused_with_a_remedy() {
        let plane = load("plane:4x4x0.01", &MeshOptions::default()).unwrap();
        let why = Refined::of(&plane).unwrap_err().to_string();
        assert!(why.contains("no tetrahedra"), "{why}");
        let large = load("box:24x24x24x0.01", &MeshOptions::default()).unwrap();
        let why = Refined::of(&large).unwrap_err().to_string();
        assert!(why.contains("coarser"), "{why}");
    }
}
