//! Nodes and the edges along which a group may spread.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Label of a node that belongs to nothing.
pub const NONE: u32 = u32::MAX;

/// Edges with their lengths, stored at both ends.
pub struct Graph {
    rows: Vec<u32>,
    ends: Vec<(u32, f64)>,
}

impl Graph {
    /// Makes a graph over the nodes at `nodes_m` \[m\].
    pub fn new(nodes_m: &[[f64; 3]], edges: &[[u32; 2]]) -> Self {
        let mut rows = vec![0_u32; nodes_m.len() + 1];
        for &node in edges.as_flattened() {
            rows[node as usize + 1] += 1;
        }
        for node in 0..nodes_m.len() {
            rows[node + 1] += rows[node];
        }
        let mut next = rows.clone();
        let mut ends = vec![(0, 0.0); 2 * edges.len()];
        for &[i, j] in edges {
            let length = squared(nodes_m[i as usize], nodes_m[j as usize]).sqrt();
            for (from, to) in [(i, j), (j, i)] {
                let half = &mut next[from as usize];
                ends[*half as usize] = (to, length);
                *half += 1;
            }
        }
        Self { rows, ends }
    }

    /// Returns the other ends of a node's edges with the edges' lengths \[m\].
    pub fn around(&self, node: u32) -> &[(u32, f64)] {
        let node = node as usize;
        &self.ends[self.rows[node] as usize..self.rows[node + 1] as usize]
    }

    /// Returns the connected parts among `nodes`, each ascending, in the order of their first nodes.
    pub fn parts(&self, nodes: &[u32]) -> Vec<Vec<u32>> {
        let mut seen = vec![true; self.rows.len() - 1];
        for &node in nodes {
            seen[node as usize] = false;
        }
        let mut parts = Vec::new();
        for &first in nodes {
            if std::mem::replace(&mut seen[first as usize], true) {
                continue;
            }
            let mut part = vec![first];
            let mut at = 0;
            while let Some(&node) = part.get(at) {
                at += 1;
                for &(other, _) in self.around(node) {
                    if !std::mem::replace(&mut seen[other as usize], true) {
                        part.push(other);
                    }
                }
            }
            part.sort_unstable();
            parts.push(part);
        }
        parts
    }

    /// Returns the seed nearest to each node along the edges, the lower one of equally near ones; [`NONE`]
    /// if none is reached. The nodes of a seed are connected (Dijkstra from all seeds at once).
    pub fn nearest(&self, seeds: &[u32]) -> Vec<u32> {
        let mut label = vec![NONE; self.rows.len() - 1];
        // Lengths are not negative: their bits are in the order of their values.
        let start = (0_u32..).zip(seeds).map(|(at, &seed)| Reverse((0_u64, at, seed)));
        let mut queue: BinaryHeap<_> = start.collect();
        while let Some(Reverse((way, of, node))) = queue.pop() {
            if label[node as usize] != NONE {
                continue;
            }
            label[node as usize] = of;
            for &(other, length) in self.around(node) {
                if label[other as usize] == NONE {
                    let way = (f64::from_bits(way) + length).to_bits();
                    queue.push(Reverse((way, of, other)));
                }
            }
        }
        label
    }

    /// Returns `count` nodes of a connected part, each the one farthest along the edges from those before
    /// it, the lowest of equally far ones (Gonzalez 1985); the first is the one farthest from the middle.
    pub fn spread(&self, nodes_m: &[[f64; 3]], part: &[u32], count: usize) -> Vec<u32> {
        let middle = mean(part.iter().map(|&node| nodes_m[node as usize]));
        let away = |node: u32| squared(nodes_m[node as usize], middle);
        let further = |a: &u32, b: &u32| away(*a).total_cmp(&away(*b)).then(b.cmp(a));
        let Some(first) = part.iter().copied().max_by(further) else { return Vec::new() };
        // Distances only shrink: an outdated entry of the queue is pushed again with its new distance.
        let mut way = vec![f64::INFINITY; nodes_m.len()];
        let mut seeds = Vec::with_capacity(count);
        let mut farthest: BinaryHeap<(u64, Reverse<u32>)> = BinaryHeap::new();
        let mut next = Some(first);
        while let Some(seed) = next.take() {
            self.approach(&mut way, seed);
            seeds.push(seed);
            if seeds.len() == 1 {
                farthest.extend(part.iter().map(|&n| (way[n as usize].to_bits(), Reverse(n))));
            }
            while seeds.len() < count
                && let Some((bits, Reverse(node))) = farthest.pop()
            {
                let now = way[node as usize];
                if now.to_bits() == bits {
                    next = (now > 0.0).then_some(node);
                    break;
                }
                farthest.push((now.to_bits(), Reverse(node)));
            }
        }
        seeds
    }

    /// Lowers the distances in `way` of the nodes that are nearer to `seed` than to the earlier seeds.
    fn approach(&self, way: &mut [f64], seed: u32) {
        way[seed as usize] = 0.0;
        let mut queue = BinaryHeap::from([Reverse((0_u64, seed))]);
        while let Some(Reverse((bits, node))) = queue.pop() {
            let so_far = f64::from_bits(bits);
            if so_far > way[node as usize] {
                continue;
            }
            for &(other, length) in self.around(node) {
                if so_far + length < way[other as usize] {
                    way[other as usize] = so_far + length;
                    queue.push(Reverse(((so_far + length).to_bits(), other)));
                }
            }
        }
    }
}

/// Squared distance of two points.
pub fn squared(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis])).sum()
}

/// Mean of points.
pub fn mean(points: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for point in points {
        sum = std::array::from_fn(|axis| sum[axis] + point[axis]);
        count += 1.0;
    }
    sum.map(|x| x / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes 0 to 8 on a line, 1 m apart.
    fn line() -> (Vec<[f64; 3]>, Graph) {
        let nodes_m: Vec<[f64; 3]> = (0..9).map(|x| [f64::from(x), 0.0, 0.0]).collect();
        let edges: Vec<[u32; 2]> = (0..8).map(|i| [i, i + 1]).collect();
        let graph = Graph::new(&nodes_m, &edges);
        (nodes_m, graph)
    }

    #[test]
    fn seeds_spread_from_the_ends_inwards() {
        let (nodes_m, graph) = line();
        let all: Vec<u32> = (0..9).collect();
        assert_eq!(graph.spread(&nodes_m, &all, 5), [0, 8, 4, 2, 6]);
        assert_eq!(graph.spread(&nodes_m, &all, 20).len(), 9);
    }

    #[test]
    fn the_lower_seed_takes_a_node_halfway() {
        let (_, graph) = line();
        assert_eq!(graph.nearest(&[6, 2]), [1, 1, 1, 1, 0, 0, 0, 0, 0]);
        let cut = Graph::new(&[[0.0; 3]; 4], &[[0, 1], [2, 3]]);
        assert_eq!(cut.nearest(&[1]), [0, 0, NONE, NONE]);
        assert_eq!(cut.parts(&[0, 1, 2, 3]), [[0, 1], [2, 3]]);
    }
}
