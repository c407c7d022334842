//! Moves nodes towards the middle of their neighbours if that makes tetrahedra rounder.

use super::web::Web;
use super::{Shape, TetMesh, between};
use crate::mesh::geometry::{EDGES, corners, distance, volume6};

/// Rounds over all nodes.
const PASSES: usize = 10;

/// Shares of the distance to the middle of the neighbours that are tried.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];

/// Length of the steps that are tried, as a share of the mean edge.
const STEP: f64 = 0.05;

/// Tetrahedra of at least this quality need no improvement.
const GOOD: f64 = 0.6;

/// Edges shorter than this share of the mean edge lower the quality.
const SHORT: f64 = 0.6;

/// Smooths a body of this web in place; surface nodes stay on the surface, `held` nodes do not move.
/// `relative` has the mean edge around each node over that of the body; it is empty where all are alike.
pub(in crate::mesh) fn smooth(
    shape: &impl Shape,
    web: &Web,
    body: &mut TetMesh,
    held: &[bool],
    relative: &[f64],
) {
    let Web { inside, on_skin, around, .. } = web;
    let mean_m = web.mean_m(&body.nodes_m);
    for _ in 0..PASSES {
        for node in 0..body.nodes_m.len() {
            if held.get(node) == Some(&true) {
                continue;
            }
            let surface = !on_skin[node].is_empty();
            let mean_m = mean_m * relative.get(node).unwrap_or(&1.0);
            let site = Site { shape, node, surface, around: &around[node], mean_m };
            let nodes_m = &mut body.nodes_m;
            if surface || site.quality(nodes_m) < GOOD {
                let ids = if surface { &on_skin[node] } else { &inside[node] };
                let target = middle(nodes_m, ids);
                site.relax(nodes_m, target);
                site.probe(nodes_m);
            }
        }
    }
}

/// A node that may move.
struct Site<'a, S> {
    shape: &'a S,
    node: usize,
    surface: bool,
    /// Tetrahedra that have the node.
    around: &'a [[u32; 4]],
    /// Mean edge around the node \[m\].
    mean_m: f64,
}

impl<S: Shape> Site<'_, S> {
    /// Moves the node by the largest share of the distance to `target` that leaves all tetrahedra good or
    /// no worse.
    fn relax(&self, nodes_m: &mut [[f64; 3]], target: [f64; 3]) {
        let old = nodes_m[self.node];
        let enough = self.quality(nodes_m).min(GOOD);
        for share in SHARES {
            self.put(nodes_m, between(old, target, share));
            if self.quality(nodes_m) >= enough {
                return;
            }
        }
        nodes_m[self.node] = old;
    }

    /// Moves a node whose tetrahedra are not all good by those steps along the axes that improve them.
    fn probe(&self, nodes_m: &mut [[f64; 3]]) {
        let mut best = self.quality(nodes_m);
        if best >= GOOD {
            return;
        }
        for axis in 0..3 {
            for step in [-STEP, STEP] {
                let old = nodes_m[self.node];
                let mut moved = old;
                moved[axis] += step * self.mean_m;
                self.put(nodes_m, moved);
                let now = self.quality(nodes_m);
                if now > best {
                    best = now;
                } else {
                    nodes_m[self.node] = old;
                }
            }
        }
    }

    fn put(&self, nodes_m: &mut [[f64; 3]], place_m: [f64; 3]) {
        nodes_m[self.node] = if self.surface { self.shape.project(place_m) } else { place_m };
    }

    /// Returns the least roundness around the node, reduced for short edges.
    fn quality(&self, nodes_m: &[[f64; 3]]) -> f64 {
        let short_m = SHORT * self.mean_m;
        let each = self.around.iter().map(|tetrahedron| {
            let points = corners(nodes_m, *tetrahedron);
            let lengths = EDGES.map(|[i, j]| distance(points[i], points[j]));
            let shortest_m = lengths.into_iter().fold(f64::INFINITY, f64::min);
            roundness(points) * (shortest_m / short_m).min(1.0)
        });
        each.fold(f64::INFINITY, f64::min)
    }
}

fn middle(nodes_m: &[[f64; 3]], ids: &[u32]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for id in ids {
        for (axis, x) in nodes_m[*id as usize].into_iter().enumerate() {
            sum[axis] += x;
        }
    }
    sum.map(|x| x / ids.len() as f64)
}

/// Returns the volume over the cubed root mean square edge: 1 for a regular tetrahedron, 0 for a flat
/// one, negative for an inverted one.
pub(in crate::mesh) fn roundness(points: [[f64; 3]; 4]) -> f64 {
    let squares = EDGES.iter().map(|&[i, j]| {
        let length = distance(points[i], points[j]);
        length * length
    });
    let mean = squares.sum::<f64>() / 6.0;
    volume6(points) * 2.0f64.sqrt() / (mean * mean.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roundness_of_known_tetrahedra() {
        let regular = [[1., -1., -1.], [1., 1., 1.], [-1., 1., -1.], [-1., -1., 1.]];
        assert!((roundness(regular) - 1.0).abs() < 1e-12);
        let flat = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
        assert_eq!(roundness(flat), 0.0);
        let [a, b, c, d] = regular;
        assert!(roundness([b, a, c, d]) < 0.0);
    }
}
