//! Links between groups, as stiff as the links of the mesh that they replace.
//!
//! A link of stiffness k, rest length l and direction n holds k l^2 (n e n)^2 / 2 in a body under
//! the homogeneous strain e, and acts on its ends with the force k l (n e n) n. Summed over the
//! links of a cell, half of each for the energy, these are a moment of fourth and one of third
//! order. Both are fitted to those of its group: the energy for the same stiffness, the force because
//! a cell with a net force leaves the strain and yields. First the k l^2 of the cells are scaled to
//! those of their groups (iterative proportional fitting, Deming and Stephan 1940), starting from
//! the number of edges between two groups; then bounded least squares, a coordinate at a time.

use super::moments::{Fourth, Third, add, dot, fourth, third};
use super::{Groups, NONE, squared};
use crate::mesh::Mesh;

/// Rounds of proportional fitting.
const SCALINGS: usize = 40;
/// Rounds of least squares.
const ROUNDS: usize = 240;
/// Rounds after which the targets are corrected.
const ROUNDS_EACH: usize = 5;
/// Weight of the tie to the start in the least squares.
const TIE: f64 = 0.02;
/// Weight of the forces on the cells in the least squares.
const FORCES: f64 = 2.5;
/// Least energy of a link, as a share of its start value from the edges: no link becomes slack.
const LEAST: f64 = 0.05;

/// Links between groups.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseLinks {
    /// Groups of each link, lower first, sorted.
    pub links: Vec<[u32; 2]>,
    /// Stiffness of each \[N/m\].
    pub stiffness_n_per_m: Vec<f64>,
    /// Half-width of the band of each, a mean over the mesh's links of its groups \[rest lengths\].
    pub alpha: Vec<f64>,
}

/// Moments of the links of a mesh, for each group.
struct Targets {
    energy: Vec<Fourth>,
    force: Vec<Third>,
    /// Sum of k l^2, halves.
    whole: Vec<f64>,
    /// The same times alpha.
    slack: Vec<f64>,
}

/// Links groups that a link of the mesh joins; `stiffness` and `alpha` are those of the mesh's links.
pub fn couple(mesh: &Mesh, groups: &Groups, stiffness: &[f64], alpha: &[f64]) -> CoarseLinks {
    let mut joined: Vec<[u32; 2]> = Vec::new();
    let count = groups.node.len();
    let mut targets = Targets {
        energy: vec![[0.0; 15]; count],
        force: vec![[0.0; 10]; count],
        whole: vec![0.0; count],
        slack: vec![0.0; count],
    };
    // Moments of each group, and the pairs of joined groups.
    for ((&[i, j], k), alpha) in mesh.links.iter().zip(stiffness).zip(alpha) {
        let (direction, length) = between(mesh, i, j);
        let (share, energy) = (0.5 * k * length * length, fourth(direction));
        let of = [groups.of[i as usize], groups.of[j as usize]];
        for group in of {
            debug_assert!(group != NONE, "a node with a link has a group");
            add(&mut targets.energy[group as usize], share, &energy);
            targets.whole[group as usize] += share;
            targets.slack[group as usize] += share * alpha;
        }
        if of[0] != of[1] {
            let [a, b] = of.map(|group| group as usize);
            add(&mut targets.force[a], k * length, &third(direction));
            add(&mut targets.force[b], -k * length, &third(direction));
            joined.push([of[0].min(of[1]), of[0].max(of[1])]);
        }
    }
    // The links between groups, each with its number of links of the mesh.
    joined.sort_unstable();
    let (links, crossings): (Vec<[u32; 2]>, Vec<f64>) =
        joined.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as f64)).unzip();
    let geometry: Vec<([f64; 3], f64)> =
        links.iter().map(|link| link_between(mesh, groups, *link)).collect();
    // The force across a face scales with its area, so k l^2 with the area times the length.
    let mut share: Vec<f64> =
        crossings.iter().zip(&geometry).map(|(edges, (_, length))| edges * length).collect();
    scale(&links, &mut share, &targets.whole);
    fit(&links, &geometry, &mut share, &targets);
    let mean_alpha = |&[a, b]: &[u32; 2]| {
        let of = |group: u32| targets.slack[group as usize] / targets.whole[group as usize];
        0.5 * (of(a) + of(b))
    };
    CoarseLinks {
        stiffness_n_per_m: share
            .iter()
            .zip(&geometry)
            .map(|(x, (_, l))| 2.0 * x / (l * l))
            .collect(),
        alpha: links.iter().map(mean_alpha).collect(),
        links,
    }
}

/// Returns the unit vector and the distance between two nodes \[m\].
fn between(mesh: &Mesh, i: u32, j: u32) -> ([f64; 3], f64) {
    let (a, b) = (mesh.nodes_m[i as usize], mesh.nodes_m[j as usize]);
    let length = squared(a, b).sqrt();
    (std::array::from_fn(|axis| (b[axis] - a[axis]) / length), length)
}

fn link_between(mesh: &Mesh, groups: &Groups, [a, b]: [u32; 2]) -> ([f64; 3], f64) {
    between(mesh, groups.node[a as usize], groups.node[b as usize])
}

/// Scales the links' shares until those of each cell add up to the target's.
fn scale(links: &[[u32; 2]], share: &mut [f64], whole: &[f64]) {
    for _ in 0..SCALINGS {
        let mut sums = vec![0.0; whole.len()];
        for (ends, x) in links.iter().zip(&*share) {
            for &end in ends {
                sums[end as usize] += x;
            }
        }
        let ratio = |end: u32| whole[end as usize] / sums[end as usize];
        for (&[a, b], x) in links.iter().zip(&mut *share) {
            *x *= (ratio(a) * ratio(b)).sqrt();
        }
    }
}

/// Moments of the cells minus their targets.
struct Excess {
    energy: Vec<Fourth>,
    force: Vec<Third>,
}

/// Column of a link in the least squares.
struct Column {
    ends: [usize; 2],
    energy: Fourth,
    force: Third,
    /// k l for a unit of k l^2 / 2 \[1/m\].
    per_length: f64,
}

impl Excess {
    /// Adds the change of a link's share.
    fn change(&mut self, column: &Column, by: f64) {
        let Column { ends: [a, b], energy, force, per_length } = column;
        add(&mut self.energy[*a], by, energy);
        add(&mut self.energy[*b], by, energy);
        add(&mut self.force[*a], by * per_length, force);
        add(&mut self.force[*b], -by * per_length, force);
    }
}

/// Fits the moments of the cells to those of the groups, each relative to its own size.
fn fit(links: &[[u32; 2]], geometry: &[([f64; 3], f64)], share: &mut [f64], targets: &Targets) {
    let columns: Vec<Column> = (links.iter().zip(geometry))
        .map(|(ends, &(n, length))| Column {
            ends: ends.map(|end| end as usize),
            energy: fourth(n),
            force: third(n),
            per_length: 2.0 / length,
        })
        .collect();
    let mean_m = geometry.iter().map(|entry| entry.1).sum::<f64>() / geometry.len() as f64;
    let forces = FORCES * mean_m * mean_m;
    // The excess at the start.
    let mut excess = Excess {
        energy: targets.energy.iter().map(|target| target.map(|x| -x)).collect(),
        force: targets.force.iter().map(|target| target.map(|x| -x)).collect(),
    };
    for (column, &x) in columns.iter().zip(&*share) {
        excess.change(column, x);
    }
    let suggested = share.to_vec();
    let importance: Vec<f64> = targets.whole.iter().map(|whole| 1.0 / (whole * whole)).collect();
    // Sum of the corrections of the targets; the true excess is without them.
    let mut shift = vec![[0.0; 15]; targets.energy.len()];
    for round in 0..ROUNDS {
        if round % ROUNDS_EACH == ROUNDS_EACH - 1 {
            correct(links, &targets.whole, &mut excess.energy, &mut shift);
        }
        // Minimize over the share of one link after the other.
        for (column, (x, start)) in columns.iter().zip(share.iter_mut().zip(&suggested)) {
            let [a, b] = column.ends;
            let (p, q) = (importance[a], importance[b]);
            let energy = p * dot(&excess.energy[a], &column.energy)
                + q * dot(&excess.energy[b], &column.energy);
            let force =
                p * dot(&excess.force[a], &column.force) - q * dot(&excess.force[b], &column.force);
            let tie = TIE * (p + q);
            let scaled = forces * column.per_length;
            let slope = energy + scaled * force + tie * (*x - start);
            let curvature = (p + q) * (1.0 + scaled * column.per_length) + tie;
            let now = (*x - slope / curvature).max(LEAST * start);
            excess.change(column, now - *x);
            *x = now;
        }
    }
}

/// Moves the targets by the common error of cells and their neighbours: a single cell cannot match
/// every component, but its neighbours can compensate its error.
fn correct(links: &[[u32; 2]], whole: &[f64], excess: &mut [Fourth], shift: &mut [Fourth]) {
    let mut missed: Vec<Fourth> = excess.to_vec();
    for (missed, shift) in missed.iter_mut().zip(&*shift) {
        add(missed, 1.0, shift);
    }
    for _ in 0..2 {
        let (mut around, mut sizes) = (missed.clone(), whole.to_vec());
        for &[a, b] in links {
            let (a, b) = (a as usize, b as usize);
            add(&mut around[a], 1.0, &missed[b]);
            add(&mut around[b], 1.0, &missed[a]);
            sizes[a] += whole[b];
            sizes[b] += whole[a];
        }
        for ((missed, around), (own, all)) in
            missed.iter_mut().zip(&around).zip(whole.iter().zip(&sizes))
        {
            *missed = around.map(|component| component * own / all);
        }
    }
    for ((excess, shift), missed) in excess.iter_mut().zip(shift).zip(&missed) {
        add(excess, 1.0, missed);
        add(shift, -1.0, missed);
    }
}
