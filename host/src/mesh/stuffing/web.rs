//! The neighbourhood of each node of a body, which does not change when nodes move.

use super::TetMesh;
use crate::mesh::geometry::edges;
use crate::mesh::surface::boundary;

/// The neighbours of each node, and the tetrahedra around it.
pub(in crate::mesh) struct Web {
    /// Edges, each once.
    pub(super) links: Vec<[u32; 2]>,
    /// Neighbours along edges, and those along edges of the surface: none for a node inside.
    pub(super) inside: Vec<Vec<u32>>,
    pub(in crate::mesh) on_skin: Vec<Vec<u32>>,
    /// Tetrahedra that have the node.
    pub(in crate::mesh) around: Vec<Vec<[u32; 4]>>,
}

impl Web {
    /// Builds the web of a body. Cost: n log n of its tetrahedra.
    pub(in crate::mesh) fn new(body: &TetMesh) -> Self {
        let count = body.nodes_m.len();
        let mut skin: Vec<[u32; 2]> = boundary(&body.tetrahedra)
            .iter()
            .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
            .map(|[i, j]| [i.min(j), i.max(j)])
            .collect();
        skin.sort_unstable();
        skin.dedup();
        let links = edges(&body.tetrahedra);
        let mut around = vec![Vec::new(); count];
        for tetrahedron in &body.tetrahedra {
            tetrahedron.iter().for_each(|id| around[*id as usize].push(*tetrahedron));
        }
        let (inside, on_skin) = (neighbours(count, &links), neighbours(count, &skin));
        Self { links, inside, on_skin, around }
    }

    /// Returns the nodes of the surface.
    pub(in crate::mesh) fn skin(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.on_skin).filter(|(_, beside)| !beside.is_empty()).map(|(node, _)| node)
    }
}

fn neighbours(count: usize, links: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); count];
    for &[i, j] in links {
        lists[i as usize].push(j);
        lists[j as usize].push(i);
    }
    lists
}
