//! Links between groups, as stiff as what they stand for.
//!
//! A link of stiffness k, rest length l and direction n holds k l^2 (n e n)^2 / 2 in a body under
//! the homogeneous strain e, its fourth-order moment. Each cell's share of it, half of that of its
//! links, is fitted to the moment of its group: non-negative least squares, a coordinate at a time,
//! tied weakly to what the number of edges between two groups suggests. Then the k l^2 of each cell
//! are brought to those of its group (iterative proportional fitting, Deming and Stephan 1940):
//! they alone make up the response of a body without a preferred direction.

use super::moments::{COMPONENTS, Moment, add, dot, of_direction};
use super::{Groups, NONE, squared};
use crate::mesh::Mesh;

/// Rounds of proportional fitting.
const SCALINGS: usize = 40;
/// Rounds of least squares.
const ROUNDS: usize = 120;
/// Rounds after which the targets are corrected.
const ROUNDS_EACH: usize = 5;
/// Weight of the tie in the least squares.
const TIE: f64 = 0.02;
/// No link holds less than this share of what the edges suggest: none goes slack.
const LEAST: f64 = 0.1;

/// Links between groups.
#[derive(Debug, Clone, PartialEq)]
pub struct CoarseLinks {
    /// Groups of each link, lower first, sorted.
    pub links: Vec<[u32; 2]>,
    /// Stiffness of each [N/m].
    pub stiffness_n_per_m: Vec<f64>,
    /// Half-width of the band of each, a mean over the links it stands for [rest lengths].
    pub alpha: Vec<f64>,
}

/// What the links of a mesh hold, group by group.
struct Targets {
    moment: Vec<Moment>,
    /// Sum of k l^2, halves.
    whole: Vec<f64>,
    /// The same times alpha.
    slack: Vec<f64>,
}

/// Links groups that an edge of the mesh joins; `stiffness` and `alpha` of every link of the mesh.
pub fn couple(mesh: &Mesh, groups: &Groups, stiffness: &[f64], alpha: &[f64]) -> CoarseLinks {
    let mut joined: Vec<[u32; 2]> = Vec::new();
    let count = groups.node.len();
    let mut targets = Targets {
        moment: vec![[0.0; COMPONENTS]; count],
        whole: vec![0.0; count],
        slack: vec![0.0; count],
    };
    for ((&[i, j], k), alpha) in mesh.links.iter().zip(stiffness).zip(alpha) {
        let (direction, length) = between(mesh, i, j);
        let (share, moment) = (0.5 * k * length * length, of_direction(direction));
        let of = [groups.of[i as usize], groups.of[j as usize]];
        for group in of {
            debug_assert!(group != NONE, "a node with a link has a group");
            add(&mut targets.moment[group as usize], share, &moment);
            targets.whole[group as usize] += share;
            targets.slack[group as usize] += share * alpha;
        }
        if of[0] != of[1] {
            joined.push([of[0].min(of[1]), of[0].max(of[1])]);
        }
    }
    joined.sort_unstable();
    let (links, crossings): (Vec<[u32; 2]>, Vec<f64>) =
        joined.chunk_by(|a, b| a == b).map(|same| (same[0], same.len() as f64)).unzip();
    let geometry: Vec<([f64; 3], f64)> =
        links.iter().map(|link| link_between(mesh, groups, *link)).collect();
    let moments: Vec<Moment> = geometry.iter().map(|&(n, _)| of_direction(n)).collect();
    // The force across a face goes with its area, so k l^2 with the area times the length.
    let mut share: Vec<f64> =
        crossings.iter().zip(&geometry).map(|(edges, (_, length))| edges * length).collect();
    scale(&links, &mut share, &targets.whole);
    fit(&links, &moments, &mut share, &targets);
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

/// Unit vector and distance between two nodes \[m\].
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

/// Brings the moments of the cells to those of the groups, each measured by its own size.
fn fit(links: &[[u32; 2]], moments: &[Moment], share: &mut [f64], targets: &Targets) {
    let mut excess: Vec<Moment> =
        targets.moment.iter().map(|target| target.map(|component| -component)).collect();
    for ((ends, moment), x) in links.iter().zip(moments).zip(&*share) {
        for &end in ends {
            add(&mut excess[end as usize], *x, moment);
        }
    }
    let suggested = share.to_vec();
    let importance: Vec<f64> = targets.whole.iter().map(|whole| 1.0 / (whole * whole)).collect();
    // What has been added to the targets, to be taken off again where the true excess counts.
    let mut shift = vec![[0.0; COMPONENTS]; targets.moment.len()];
    for round in 0..ROUNDS {
        if round % ROUNDS_EACH == ROUNDS_EACH - 1 {
            correct(links, &targets.whole, &mut excess, &mut shift);
        }
        for (link, ends) in links.iter().enumerate() {
            let [p, q] = ends.map(|end| importance[end as usize]);
            let [a, b] = ends.map(|end| dot(&excess[end as usize], &moments[link]));
            let tie = TIE * (p + q);
            let slope = p * a + q * b + tie * (share[link] - suggested[link]);
            let now = (share[link] - slope / (p + q + tie)).max(LEAST * suggested[link]);
            for &end in ends {
                add(&mut excess[end as usize], now - share[link], &moments[link]);
            }
            share[link] = now;
        }
    }
}

/// Moves the targets by what cells and their neighbours miss together: single cells cannot be met
/// in every component, but what one misses another can make up for.
fn correct(links: &[[u32; 2]], whole: &[f64], excess: &mut [Moment], shift: &mut [Moment]) {
    let mut missed: Vec<Moment> = excess.to_vec();
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
