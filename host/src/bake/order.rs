//! Order of the cells: along a Morton curve through their rest positions, so that linked cells are
//! close in memory and the order does not depend on the input's numbering; within short windows by
//! valence, so that the eight cells of a slice have about the same number of links.

/// Bits of each coordinate on the curve.
const BITS: u32 = 21;

/// Number of consecutive cells that are sorted by valence.
const WINDOW: usize = 128;

/// Returns `nodes` sorted along the curve through their positions, ties by coordinates, then by id;
/// then, in windows, by `valence` of the node.
pub fn by_place(nodes_m: &[[f64; 3]], valence: &[u32], mut nodes: Vec<u32>) -> Vec<u32> {
    let at = |node: u32| nodes_m[node as usize];
    let (mut low, mut size) = ([f64::INFINITY; 3], 0.0_f64);
    for &node in &nodes {
        for (axis, &x) in at(node).iter().enumerate() {
            low[axis] = low[axis].min(x);
        }
    }
    for &node in &nodes {
        for (axis, &x) in at(node).iter().enumerate() {
            size = size.max(x - low[axis]);
        }
    }
    let scale = f64::from((1_u32 << BITS) - 1) / size;
    let key = |node: u32| {
        let p = at(node);
        (0..3).fold(0, |key, axis| key | spread(((p[axis] - low[axis]) * scale) as u64) << axis)
    };
    nodes.sort_by(|&a, &b| {
        let (pa, pb) = (at(a), at(b));
        let place = |axis: usize| pa[axis].total_cmp(&pb[axis]);
        key(a).cmp(&key(b)).then(place(0)).then(place(1)).then(place(2)).then(a.cmp(&b))
    });
    for window in nodes.chunks_mut(WINDOW) {
        window.sort_by_key(|&node| valence[node as usize]);
    }
    nodes
}

/// Returns the low 21 bits of `x` with two zero bits between neighbours.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_leaves_two_gaps() {
        for bit in 0..BITS {
            assert_eq!(spread(1 << bit), 1 << (3 * bit));
        }
        assert_eq!(spread(0x1f_ffff), 0x1249_2492_4924_9249);
    }

    #[test]
    fn the_curve_visits_octants_one_after_the_other() {
        let nodes_m: Vec<[f64; 3]> = (0..64_u32)
            .map(|i| [f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16)])
            .collect();
        let order = by_place(&nodes_m, &[0; 64], (0..64).rev().collect());
        let octant = |&node: &u32| nodes_m[node as usize].map(|x| x >= 2.0);
        let mut octants: Vec<_> = order.iter().map(octant).collect();
        octants.dedup();
        assert_eq!(octants.len(), 8);
        assert_eq!(order, by_place(&nodes_m, &[0; 64], (0..64).collect()));
    }
}
