//! Sharp edges and corners of a surface: nodes of the filled body are moved onto them, so that they are
//! not cut off. A move that would spoil the tetrahedra around a node is left out; tetrahedra at a corner
//! may be flatter until smoothing has moved the nodes around it.

use super::closed::Closed;
use super::distance::Solid;
use super::near::Near;
use super::tree::Tree;
use crate::mesh::geometry::{corners, distance, dot, minus};
use crate::mesh::stuffing::TetMesh;
use crate::mesh::stuffing::smooth::{roundness, smooth};
use crate::mesh::stuffing::web::{Lengths, Web};

/// Cosine of 40 degrees: a larger angle between two normals, or between an edge and the next, is sharp.
const SHARP: f64 = 0.766;
/// Rounds of moving nodes onto creases and smoothing.
const ROUNDS: usize = 3;
/// Largest distance by which a node is moved, in sizes.
const REACH: f64 = 0.8;
/// Smallest distance between nodes on creases, in sizes.
const APART: f64 = 0.25;
/// Least roundness that a move may leave.
const ROUND: f64 = 0.3;
/// The same for a move onto a corner, before smoothing moves the nodes around it.
const ROUND_AT_FIRST: f64 = 0.1;

/// The creases of a surface.
pub(super) struct Creases {
    /// Sharp edges as triangles of two corners; none if there is no sharp edge.
    edges: Option<Tree>,
    /// Points at which creases end, meet or turn sharply.
    corners_m: Vec<[f64; 3]>,
}

impl Creases {
    /// Finds the creases of a surface.
    pub(super) fn new(closed: &Closed, solid: &Solid) -> Self {
        // Sharp edges, each once, and the other ends at each point.
        let mut edges = Vec::new();
        let mut ends: Vec<Vec<u32>> = vec![Vec::new(); closed.points_m.len()];
        for (triangle, (ids, across)) in (0..).zip(closed.triangles.iter().zip(&closed.across)) {
            for k in 0..3 {
                let normals = [triangle, across[k]].map(|triangle| solid.normal(triangle));
                let [i, j] = [ids[k], ids[(k + 1) % 3]];
                if triangle < across[k] && dot(normals[0], normals[1]) < SHARP {
                    edges.push([i, j, j].map(|id| closed.points_m[id as usize]));
                    ends[i as usize].push(j);
                    ends[j as usize].push(i);
                }
            }
        }
        // Corners: points of sharp edges at which the crease does not go straight on.
        let place = |id: u32| closed.points_m[id as usize];
        let is_corner = |(own, others): (u32, &Vec<u32>)| match others[..] {
            [] => false,
            [i, j] => {
                let (to, from) = (minus(place(j), place(own)), minus(place(own), place(i)));
                dot(to, from) < SHARP * (dot(to, to) * dot(from, from)).sqrt()
            }
            _ => true,
        };
        let found = (0..).zip(&ends).filter(|entry| is_corner(*entry));
        let corners_m = found.map(|(own, _)| place(own)).collect();
        Self { edges: (!edges.is_empty()).then(|| Tree::new(edges)), corners_m }
    }

    /// Smooths a body that fills the surface, with nodes on the creases: of even tetrahedra of `size_m`, or of
    /// graded ones, of which that is the largest size.
    pub(super) fn smooth(&self, solid: &Solid, body: &mut TetMesh, size_m: f64, is_graded: bool) {
        let (web, mut held) = (Web::new(body), vec![false; body.nodes_m.len()]);
        let (sizes, relative) = match is_graded {
            true => Sizes::graded(&web, body),
            false => (Sizes::even(size_m, body.nodes_m.len()), Vec::new()),
        };
        let smoothed =
            |body: &mut TetMesh, held: &[bool]| smooth(solid, &web, body, held, &relative);
        let Some(edges) = &self.edges else { return smoothed(body, &held) };
        for _ in 0..ROUNDS {
            self.align(edges, (solid, &web), body, &mut held, &sizes);
            smoothed(body, &held);
        }
        // Nodes that still spoil a tetrahedron are released.
        let bad: Vec<u32> = web
            .skin()
            .filter(|&node| held[node as usize] && !is_round(&web, body, node, ROUND))
            .collect();
        bad.iter().for_each(|&node| held[node as usize] = false);
        if !bad.is_empty() {
            smoothed(body, &held);
        }
    }

    /// Moves surface nodes onto the creases and marks them as held.
    fn align(
        &self,
        edges: &Tree,
        (solid, web): (&Solid, &Web),
        body: &mut TetMesh,
        held: &mut [bool],
        sizes: &Sizes,
    ) {
        // Index the surface nodes: those on creases, and those that may move.
        let [apart_m, reach_m] = [&sizes.apart_m, &sizes.reach_m];
        let most = |of: &[f64]| of.iter().copied().fold(0.0, f64::max);
        let (mut taken, mut free) = (Near::new(most(apart_m)), Near::new(most(reach_m)));
        for node in web.skin() {
            let near = if held[node as usize] { &mut taken } else { &mut free };
            near.add(node, body.nodes_m[node as usize]);
        }
        let mut put = |body: &mut TetMesh, node: u32, place_m: [f64; 3], least: f64| {
            let mut others = taken.around(place_m);
            let apart_m = apart_m[node as usize];
            let is_free = others.all(|(_, other_m)| distance(place_m, other_m) >= apart_m);
            drop(others);
            let is_put = is_free && move_to(web, body, node, place_m, least);
            if is_put {
                taken.add(node, place_m);
            }
            is_put
        };
        // Each corner takes the nearest node that can be moved onto it.
        for corner_m in &self.corners_m {
            let around = free.around(*corner_m).filter(|(node, _)| !held[*node as usize]);
            let near = around.map(|(node, place_m)| (distance(place_m, *corner_m), node));
            let is_near = |near: &(f64, u32)| near.0 < reach_m[near.1 as usize];
            let mut near: Vec<(f64, u32)> = near.filter(is_near).collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if let Some(&(_, node)) =
                near.iter().find(|&&(_, node)| put(body, node, *corner_m, ROUND_AT_FIRST))
            {
                held[node as usize] = true;
            }
        }
        // The other nodes near a crease, the nearest first.
        let mut order: Vec<(f64, u32, [f64; 3])> = Vec::new();
        for node in web.skin().filter(|&node| !held[node as usize]) {
            let near = edges.nearest(body.nodes_m[node as usize]);
            let reach_m = reach_m[node as usize];
            if near.square < reach_m * reach_m {
                order.push((near.square, node, near.place));
            }
        }
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let normals: Vec<Option<[f64; 3]>> = (0..body.nodes_m.len() as u32)
            .map(|node| {
                (!web.on_skin[node as usize].is_empty())
                    .then(|| solid.normal_at(body.nodes_m[node as usize]))
            })
            .collect();
        // A node moves onto the crease if the crease lies between it and a neighbour.
        for (_, node, place_m) in order {
            let cuts = |other: &u32| match (normals[node as usize], normals[*other as usize]) {
                (Some(own), Some(other_normal)) => {
                    !held[*other as usize] && dot(own, other_normal) < SHARP
                }
                _ => false,
            };
            if web.on_skin[node as usize].iter().any(cuts) {
                held[node as usize] = put(body, node, place_m, ROUND);
            }
        }
    }
}

/// Distances at each node \[m\].
struct Sizes {
    /// Smallest distance of nodes on creases.
    apart_m: Vec<f64>,
    /// Largest distance by which the node is moved.
    reach_m: Vec<f64>,
}

impl Sizes {
    /// Of even tetrahedra.
    fn even(size_m: f64, nodes: usize) -> Self {
        Self { apart_m: vec![APART * size_m; nodes], reach_m: vec![REACH * size_m; nodes] }
    }

    /// Of graded ones, by the edges at each node; with the mean edge at each over that of the body.
    fn graded(web: &Web, body: &TetMesh) -> (Self, Vec<f64>) {
        let Lengths { mean_m, longest_m, relative } = web.lengths(&body.nodes_m);
        let apart_m = mean_m.into_iter().map(|mean_m| APART * mean_m).collect();
        let reach_m = longest_m.into_iter().map(|longest_m| REACH * longest_m).collect();
        (Self { apart_m, reach_m }, relative)
    }
}

/// Moves a node unless a tetrahedron around it would be less round than `least`. Returns true if it moved.
fn move_to(web: &Web, body: &mut TetMesh, node: u32, place_m: [f64; 3], least: f64) -> bool {
    let old = std::mem::replace(&mut body.nodes_m[node as usize], place_m);
    let is_sound = is_round(web, body, node, least);
    if !is_sound {
        body.nodes_m[node as usize] = old;
    }
    is_sound
}

/// Returns true if all tetrahedra around a node are at least this round.
fn is_round(web: &Web, body: &TetMesh, node: u32, least: f64) -> bool {
    let mut around = web.around[node as usize].iter();
    around.all(|ids| roundness(corners(&body.nodes_m, *ids)) >= least)
}
