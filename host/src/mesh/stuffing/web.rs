//! The neighbourhood of each node of a body, which does not change when nodes move.

use super::TetMesh;
use crate::mesh::geometry::{distance, edges};
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

/// Lengths of the edges at each node.
pub(in crate::mesh) struct Lengths {
    /// Mean \[m\].
    pub(in crate::mesh) mean_m: Vec<f64>,
    /// Longest \[m\].
    pub(in crate::mesh) longest_m: Vec<f64>,
    /// Mean over that of all edges.
    pub(in crate::mesh) relative: Vec<f64>,
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

    /// Mean edge of the body \[m\].
    pub(super) fn mean_m(&self, nodes_m: &[[f64; 3]]) -> f64 {
        let lengths_m = self.links.iter().map(|link| length_m(nodes_m, *link));
        lengths_m.sum::<f64>() / self.links.len() as f64
    }

    /// Measures the edges.
    pub(in crate::mesh) fn lengths(&self, nodes_m: &[[f64; 3]]) -> Lengths {
        let all_m = self.mean_m(nodes_m);
        let each = |(node, others): (u32, &Vec<u32>)| {
            let around = || others.iter().map(|other| length_m(nodes_m, [node, *other]));
            let mean_m = around().sum::<f64>() / others.len() as f64;
            (mean_m, around().fold(0.0, f64::max))
        };
        let (mean_m, longest_m): (Vec<f64>, Vec<f64>) = (0..).zip(&self.inside).map(each).unzip();
        let relative = mean_m.iter().map(|mean_m| mean_m / all_m).collect();
        Lengths { mean_m, longest_m, relative }
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

/// Length of an edge \[m\].
fn length_m(nodes_m: &[[f64; 3]], [i, j]: [u32; 2]) -> f64 {
    distance(nodes_m[i as usize], nodes_m[j as usize])
}
