//! The mesh embedded in the cells: each node is a weighted mean of cells, exact for linear fields.
//!
//! The weights are moving least squares over the nearest cells: of all weights that add up to one and
//! reproduce the node's position, those with the least sum of w^2 d^4, d the distance (Shepard 1968;
//! Lancaster and Salkauskas 1981). Negative ones are dropped, the most negative first, if the others
//! are still exact.

use nalgebra::{Matrix4, SymmetricEigen, Vector4};

use chaincell_kernel::image::{FINE_CELLS, NO_CELL};

use super::graph::squared;
use super::{Groups, NONE};
use crate::mesh::Mesh;

/// Number of nearest cells that are considered.
const CANDIDATES: usize = 24;
/// Largest sum of the weights' magnitudes: above it, a node would shake more than its cells.
const SIZES_MAX: f64 = 3.0;
/// Largest error of the weights in a linear field, as a share of the distance of the cells.
const EXACT: f64 = 1e-6;
/// Directions in which the cells extend less than this share of the largest do not count.
const FLAT: f64 = 1e-10;
/// The same for nodes that follow linear fields only roughly.
const FLAT_ROUGH: f64 = 1e-2;

/// Cells and weights of every node, its own cell first.
#[derive(Debug, Clone, PartialEq)]
pub struct Embedding {
    /// Groups, [`NO_CELL`] for an unused node.
    pub groups: Vec<[u16; FINE_CELLS]>,
    /// Their weights.
    pub weights: Vec<[f32; FINE_CELLS]>,
    /// Free nodes that follow linear fields only roughly: cells around them lie in a plane.
    pub rough: usize,
}

/// Embeds every used node of the mesh in the cells of its group and of those within two links of it.
pub fn embed(mesh: &Mesh, groups: &Groups, links: &[[u32; 2]]) -> Embedding {
    // The neighbours and the nodes of each group.
    let mut linked = vec![Vec::new(); groups.node.len()];
    for &[a, b] in links {
        linked[a as usize].push(b);
        linked[b as usize].push(a);
    }
    let nodes = mesh.nodes_m.len();
    let mut embedding = Embedding {
        groups: vec![[NO_CELL; FINE_CELLS]; nodes],
        weights: vec![[0.0; FINE_CELLS]; nodes],
        rough: 0,
    };
    let mut members = vec![Vec::new(); groups.node.len()];
    for (node, &own) in groups.of.iter().enumerate() {
        if own != NONE {
            members[own as usize].push(node);
        }
    }
    // The weights of each node; the node of a cell follows it alone.
    for (own, members) in members.iter().enumerate() {
        let around = around(own as u32, &linked);
        for &node in members {
            let found = if groups.node[own] as usize == node {
                Weights { of: vec![(own as u32, 1.0)], exact: true }
            } else {
                weights(mesh, groups, node, own as u32, &around)
            };
            embedding.rough += usize::from(!found.exact);
            embedding.groups[node] = [own as u16; FINE_CELLS];
            let slots = embedding.groups[node].iter_mut().zip(&mut embedding.weights[node]);
            for ((group, weight), (from, w)) in slots.zip(found.of) {
                (*group, *weight) = (from as u16, w as f32);
            }
        }
    }
    embedding
}

impl Embedding {
    /// Lets the nodes of fixed groups follow only their own cells, which never move.
    pub fn pin(&mut self, groups: &Groups) {
        let slots = self.groups.iter_mut().zip(&mut self.weights);
        for (&own, (cells, weights)) in groups.of.iter().zip(slots) {
            if own != NONE && groups.fixed[own as usize] {
                *cells = [own as u16; FINE_CELLS];
                *weights = [0.0; FINE_CELLS];
                weights[0] = 1.0;
            }
        }
    }
}

/// Returns a group with those linked to it, and those linked to them.
fn around(own: u32, linked: &[Vec<u32>]) -> Vec<u32> {
    let near = &linked[own as usize];
    let mut all = vec![own];
    all.extend(near);
    all.extend(near.iter().flat_map(|&group| &linked[group as usize]));
    all.sort_unstable();
    all.dedup();
    all
}

/// Groups with weights, the node's own first.
struct Weights {
    of: Vec<(u32, f64)>,
    exact: bool,
}

/// A cell near a node: its group, and its position from the node in mean distances of the cells.
#[derive(Clone, Copy)]
struct Near {
    group: u32,
    way: [f64; 3],
    squared: f64,
}

fn weights(mesh: &Mesh, groups: &Groups, node: usize, own: u32, around: &[u32]) -> Weights {
    // The candidates: the group's cell first, then by distance.
    let at = mesh.nodes_m[node];
    let place = |group: u32| mesh.nodes_m[groups.node[group as usize] as usize];
    let mut order: Vec<(f64, u32)> =
        around.iter().map(|&group| (squared(place(group), at), group)).collect();
    order.sort_by(|a, b| {
        (a.1 != own).cmp(&(b.1 != own)).then(a.0.total_cmp(&b.0)).then(a.1.cmp(&b.1))
    });
    order.truncate(CANDIDATES);
    let size = order.iter().take(FINE_CELLS).map(|entry| entry.0).sum::<f64>()
        / order.len().min(FINE_CELLS) as f64;
    let near: Vec<Near> = (order.iter())
        .map(|&(far, group)| Near {
            group,
            way: std::array::from_fn(|axis| (place(group)[axis] - at[axis]) / size.sqrt()),
            squared: far / size,
        })
        .collect();
    // The nearest cells, if they give exact weights.
    let nearest = &near[..near.len().min(FINE_CELLS)];
    if let Some(found) = trimmed(nearest) {
        return found.with_own_first(own);
    }
    // The nearest lie in a plane or on one side: take the largest weights among all candidates.
    let all = solve(&near, FLAT);
    let mut heaviest: Vec<usize> = (1..near.len()).collect();
    heaviest.sort_by(|&a, &b| all[b].abs().total_cmp(&all[a].abs()).then(a.cmp(&b)));
    let mut chosen = vec![near[0]];
    chosen.extend(heaviest.iter().take(FINE_CELLS - 1).map(|&at| near[at]));
    if let Some(found) = trimmed(&chosen) {
        return found.with_own_first(own);
    }
    // Otherwise rough weights of the nearest.
    let rough = solve(nearest, FLAT_ROUGH);
    let sum: f64 = rough.iter().sum();
    let of = nearest.iter().zip(rough).map(|(near, w)| (near.group, w / sum)).collect();
    Weights { of, exact: false }.with_own_first(own)
}

impl Weights {
    /// Puts the node's own group first, with weight 0 if it was dropped.
    fn with_own_first(mut self, own: u32) -> Self {
        let weight = self.of.iter().find(|entry| entry.0 == own).map_or(0.0, |entry| entry.1);
        self.of.retain(|&(group, w)| group != own && w != 0.0);
        self.of.insert(0, (own, weight));
        self.of.truncate(FINE_CELLS);
        self
    }
}

/// Returns the exact weights of least magnitude that occur while negative ones are dropped; none if
/// none of them are exact and small.
fn trimmed(near: &[Near]) -> Option<Weights> {
    let mut kept = near.to_vec();
    let mut best: Option<(f64, Vec<(u32, f64)>)> = None;
    while !kept.is_empty() {
        let w = solve(&kept, FLAT);
        let size: f64 = w.iter().map(|w| w.abs()).sum();
        if miss(&kept, &w) > EXACT {
            break;
        }
        if size <= SIZES_MAX && best.as_ref().is_none_or(|(least, _)| size < *least) {
            best = Some((size, kept.iter().zip(&w).map(|(near, &w)| (near.group, w)).collect()));
        }
        match (0..kept.len()).min_by(|&a, &b| w[a].total_cmp(&w[b])) {
            Some(worst) if w[worst] < 0.0 => drop(kept.remove(worst)),
            _ => break,
        }
    }
    best.map(|(_, of)| Weights { of, exact: true })
}

/// Returns 1 and the position.
fn linear(near: &Near) -> Vector4<f64> {
    Vector4::new(1.0, near.way[0], near.way[1], near.way[2])
}

/// Minimizes the sum of w^2 d^4 under the four conditions; directions of no extent are left out.
fn solve(near: &[Near], flat: f64) -> Vec<f64> {
    let importance = |near: &Near| 1.0 / (near.squared * near.squared).max(1e-12);
    let mut matrix = Matrix4::zeros();
    for cell in near {
        let row = linear(cell);
        matrix += importance(cell) * row * row.transpose();
    }
    let eigen = SymmetricEigen::new(matrix);
    let largest = eigen.eigenvalues.max();
    let target = Vector4::new(1.0, 0.0, 0.0, 0.0);
    let mut multipliers = Vector4::zeros();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > flat * largest {
            multipliers += vector * (vector.dot(&target) / value);
        }
    }
    near.iter().map(|cell| importance(cell) * linear(cell).dot(&multipliers)).collect()
}

/// Returns the largest error of the four conditions.
fn miss(near: &[Near], w: &[f64]) -> f64 {
    let sum = near.iter().zip(w).fold(Vector4::zeros(), |sum, (near, w)| sum + *w * linear(near));
    (sum - Vector4::new(1.0, 0.0, 0.0, 0.0)).amax()
}
