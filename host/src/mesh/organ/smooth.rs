//! Moves nodes towards the middle of their neighbours where that makes tetrahedra rounder.

use super::super::geometry::{EDGES, corners, distance, edges, volume6};
use super::super::surface::boundary;
use super::shape::{between, project};
use super::stuffing::Body;

/// Rounds over all nodes.
const PASSES: usize = 10;

/// Shares of the way to the middle that are tried.
const SHARES: [f64; 3] = [1.0, 0.5, 0.25];

/// Steps that are probed, as a share of an edge.
const STEP: f64 = 0.05;

/// A node may also move where all its tetrahedra stay at least this round.
const ROUND: f64 = 0.6;

/// Smooths the body in place; surface nodes stay on the surface.
pub(super) fn smooth(body: &mut Body) {
    let count = body.nodes_m.len();
    let mut skin: Vec<[u32; 2]> = boundary(&body.tetrahedra)
        .iter()
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
        .map(|[i, j]| [i.min(j), i.max(j)])
        .collect();
    skin.sort_unstable();
    skin.dedup();
    let on_skin = neighbours(count, &skin);
    let inside = neighbours(count, &edges(&body.tetrahedra));
    let mut around = vec![Vec::new(); count];
    for tetrahedron in &body.tetrahedra {
        tetrahedron.iter().for_each(|id| around[*id as usize].push(*tetrahedron));
    }
    for _ in 0..PASSES {
        for node in 0..count {
            let surface = !on_skin[node].is_empty();
            let ids = if surface { &on_skin[node] } else { &inside[node] };
            let target = middle(&body.nodes_m, ids);
            relax(&mut body.nodes_m, node, target, surface, &around[node]);
            probe(&mut body.nodes_m, node, surface, &around[node]);
        }
    }
}

/// Tries shares of the way to `target` until one is accepted.
fn relax(
    nodes_m: &mut [[f64; 3]],
    node: usize,
    target: [f64; 3],
    surface: bool,
    around: &[[u32; 4]],
) {
    let old = nodes_m[node];
    let enough = worst(nodes_m, around).min(ROUND);
    for share in SHARES {
        let moved = between(old, target, share);
        nodes_m[node] = if surface { project(moved) } else { moved };
        if worst(nodes_m, around) >= enough {
            return;
        }
    }
    nodes_m[node] = old;
}

/// Moves a node with a tetrahedron that is not round by a step along an axis, if that helps.
fn probe(nodes_m: &mut [[f64; 3]], node: usize, surface: bool, around: &[[u32; 4]]) {
    let mut best = worst(nodes_m, around);
    let Some(first) = around.first() else { return };
    if best >= ROUND {
        return;
    }
    let points = corners(nodes_m, *first);
    let step_m = STEP * distance(points[0], points[1]);
    for axis in 0..3 {
        for signed_m in [-step_m, step_m] {
            let old = nodes_m[node];
            let mut moved = old;
            moved[axis] += signed_m;
            nodes_m[node] = if surface { project(moved) } else { moved };
            let now = worst(nodes_m, around);
            if now > best {
                best = now;
            } else {
                nodes_m[node] = old;
            }
        }
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

fn middle(nodes_m: &[[f64; 3]], ids: &[u32]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for id in ids {
        for (axis, x) in nodes_m[*id as usize].into_iter().enumerate() {
            sum[axis] += x;
        }
    }
    sum.map(|x| x / ids.len() as f64)
}

fn worst(nodes_m: &[[f64; 3]], tetrahedra: &[[u32; 4]]) -> f64 {
    let all = tetrahedra.iter().map(|t| roundness(corners(nodes_m, *t)));
    all.fold(f64::INFINITY, f64::min)
}

/// Volume over the cubed root mean square edge: 1 for a regular tetrahedron, 0 for a flat one,
/// negative inside out.
pub(super) fn roundness(points: [[f64; 3]; 4]) -> f64 {
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
