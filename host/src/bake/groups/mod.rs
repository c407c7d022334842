//! Partitions the nodes of a mesh into groups, each of which becomes a cell.
//!
//! A group is connected, all fixed or all free, all on the surface or all inside. The spacing of the
//! groups is about the same in the whole body, so a group of the surface holds fewer nodes than one
//! inside. Its cell is at one of its nodes, the one nearest to its middle: cells of the surface lie
//! on the surface, and each has its own input id.

mod embedding;
mod graph;
mod links;
mod moments;
mod response;

pub use embedding::{Embedding, embed};
pub use graph::NONE;
use graph::{Graph, mean, squared};
pub use links::{CoarseLinks, couple};
pub use response::stiffening;

use crate::error::{Error, Result};
use crate::interrupt;
use crate::mesh::{CELLS_MAX, Mesh};

/// Rounds of nearest seeds and new middles (Lloyd 1982): later ones move little.
const ROUNDS: usize = 8;

/// Nodes of a mesh in groups.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Groups {
    /// Group of each node, `u32::MAX` for an unused one.
    pub of: Vec<u32>,
    /// Node at which each group's cell is.
    pub node: Vec<u32>,
    /// True for each group that is fixed.
    pub fixed: Vec<bool>,
}

/// Puts the nodes of a mesh into `cells` groups, with the nodes `fixed` (in any order) in separate ones.
///
/// If the body has more parts that must stay separate than that, each of them is a group.
///
/// # Errors
/// A number of cells out of range, or an interrupt of the user.
pub fn partition(mesh: &Mesh, fixed: &[u32], cells: usize) -> Result<Groups> {
    let kinds = Kinds::new(mesh, fixed);
    let used: Vec<u32> = kinds.used();
    if !(2..=used.len().min(CELLS_MAX)).contains(&cells) {
        return Err(Error::input(format!(
            "`cells` {cells}: must be from 2 to {}, the {}",
            used.len().min(CELLS_MAX),
            if used.len() > CELLS_MAX { "most cells of a model" } else { "nodes of the mesh" }
        )));
    }
    // Seeds, spread over each part.
    let graph = Graph::new(&mesh.nodes_m, &kinds.inner_edges(mesh));
    let parts = graph.parts(&used);
    let sizes: Vec<(usize, bool)> =
        parts.iter().map(|part| (part.len(), kinds.surface[part[0] as usize])).collect();
    let mut seeds = Vec::with_capacity(cells);
    for (part, count) in parts.iter().zip(shares(&sizes, cells)) {
        seeds.extend(graph.spread(&mesh.nodes_m, part, count));
        interrupt::check()?;
    }
    // Groups around the seeds, and new seeds in their middles.
    let mut of = graph.nearest(&seeds);
    for _ in 0..ROUNDS {
        let middles = middles(&mesh.nodes_m, &of, seeds.len());
        if middles == seeds {
            break;
        }
        seeds = middles;
        of = graph.nearest(&seeds);
        interrupt::check()?;
    }
    let node = middles(&mesh.nodes_m, &of, seeds.len());
    let fixed = node.iter().map(|&node| kinds.fixed[node as usize]).collect();
    Ok(Groups { of, node, fixed })
}

/// Properties of nodes that separate groups.
struct Kinds {
    used: Vec<bool>,
    fixed: Vec<bool>,
    surface: Vec<bool>,
    /// Edges of the surface's triangles, lower node first, sorted.
    rims: Vec<[u32; 2]>,
}

impl Kinds {
    fn new(mesh: &Mesh, fixed_nodes: &[u32]) -> Self {
        let mut used = vec![true; mesh.nodes_m.len()];
        for &node in &mesh.unused {
            used[node as usize] = false;
        }
        let (mut fixed, mut surface) = (vec![false; used.len()], vec![false; used.len()]);
        for &node in fixed_nodes {
            if let Some(fixed) = fixed.get_mut(node as usize) {
                *fixed = true;
            }
        }
        for &node in mesh.triangles.as_flattened() {
            surface[node as usize] = true;
        }
        let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
        let mut rims: Vec<[u32; 2]> = sides.map(|[i, j]| [i.min(j), i.max(j)]).collect();
        rims.sort_unstable();
        rims.dedup();
        Self { used, fixed, surface, rims }
    }

    fn used(&self) -> Vec<u32> {
        (0..self.used.len() as u32).filter(|&node| self.used[node as usize]).collect()
    }

    /// Returns the links along which a group may spread; on the surface only edges of the surface, so
    /// that no group reaches through a thin lobe.
    fn inner_edges(&self, mesh: &Mesh) -> Vec<[u32; 2]> {
        let inner = |link: &&[u32; 2]| {
            let [i, j] = link.map(|node| node as usize);
            let along = !self.surface[i] || self.rims.binary_search(link).is_ok();
            self.fixed[i] == self.fixed[j] && self.surface[i] == self.surface[j] && along
        };
        mesh.links.iter().filter(inner).copied().collect()
    }
}

/// Returns the number of groups for each part, given its number of nodes and if it is on the surface:
/// `cells` in all, at least one a part and at most one a node, so that the spacing is about the same
/// everywhere.
fn shares(parts: &[(usize, bool)], cells: usize) -> Vec<usize> {
    // The nodes of a group scale with the square of the spacing on the surface, with its cube inside.
    let share = |spacing: f64, &(nodes, on_surface): &(usize, bool)| {
        let each = if on_surface { spacing * spacing } else { spacing * spacing * spacing };
        (nodes as f64 / each).max(1.0)
    };
    // Find the spacing by bisection.
    let (mut low, mut high) = (1.0_f64, 1e7_f64);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        let total: f64 = parts.iter().map(|part| share(middle, part)).sum();
        if total > cells as f64 { low = middle } else { high = middle }
    }
    // Round down, then hand out the rest by the largest fractions.
    let wanted: Vec<f64> = parts.iter().map(|part| share(high, part)).collect();
    let mut counts: Vec<usize> = wanted.iter().map(|&share| share as usize).collect();
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|&a, &b| wanted[b].fract().total_cmp(&wanted[a].fract()).then(a.cmp(&b)));
    let mut left = cells.saturating_sub(counts.iter().sum());
    while left > 0 {
        let before = left;
        for &at in &order {
            if left > 0 && counts[at] < parts[at].0 {
                counts[at] += 1;
                left -= 1;
            }
        }
        if left == before {
            break;
        }
    }
    counts
}

/// Returns the node of each group nearest to its middle, the lowest of equally near ones.
fn middles(nodes_m: &[[f64; 3]], of: &[u32], groups: usize) -> Vec<u32> {
    let mut members = vec![Vec::new(); groups];
    for (node, &group) in (0_u32..).zip(of) {
        if group != NONE {
            members[group as usize].push(node);
        }
    }
    let middle = |members: &Vec<u32>| {
        let centre = mean(members.iter().map(|&node| nodes_m[node as usize]));
        let away = |node: u32| squared(nodes_m[node as usize], centre);
        members.iter().copied().min_by(|&a, &b| away(a).total_cmp(&away(b)).then(a.cmp(&b)))
    };
    members.iter().map(|members| middle(members).unwrap_or(NONE)).collect()
}

#[cfg(test)]
mod tests;
