//! Neighbours of the cells, and the weights that follow from them.

use super::layout::{Link, OrderedCells};

/// Adjacency in the two halves that the kernel reads.
pub(super) struct Adjacency {
    pub rows: Vec<u32>,
    pub back_rows: Vec<u32>,
    pub lower: Vec<u16>,
    pub back_link: Vec<u32>,
}

/// Returns the adjacency of links in their order.
pub(super) fn adjacency(cells: usize, links: &[Link]) -> Adjacency {
    let mut rows = vec![0_u32; cells + 1];
    let mut back_rows = vec![0_u32; cells + 1];
    for &([i, j], _) in links {
        rows[usize::from(i) + 1] += 1;
        back_rows[usize::from(j) + 1] += 1;
    }
    for cell in 0..cells {
        rows[cell + 1] += rows[cell];
        back_rows[cell + 1] += back_rows[cell];
    }
    let mut next = back_rows.clone();
    let (mut lower, mut back_link) = (vec![0; links.len()], vec![0; links.len()]);
    for (link, &([i, j], _)) in links.iter().enumerate() {
        let half = &mut next[usize::from(j)];
        lower[*half as usize] = i;
        back_link[*half as usize] = link as u32;
        *half += 1;
    }
    Adjacency { rows, back_rows, lower, back_link }
}

/// Returns W of every cell, added in ascending order of the other end, as in the kernel.
pub(super) fn cell_weights(cells: usize, adjacency: &Adjacency, weight: &[f32]) -> Vec<f32> {
    let range = |rows: &[u32], cell: usize| rows[cell] as usize..rows[cell + 1] as usize;
    (0..cells)
        .map(|cell| {
            let below = range(&adjacency.back_rows, cell)
                .map(|half| weight[adjacency.back_link[half] as usize]);
            let above = range(&adjacency.rows, cell).map(|link| weight[link]);
            below.chain(above).fold(0.0, |sum, w| sum + w)
        })
        .collect()
}

/// 1 / W of the free cells, 0 of the others and of the spare ones.
pub(super) fn mobilities(body: &OrderedCells, weights: &[f32]) -> Vec<f32> {
    (weights.iter().enumerate())
        .map(|(cell, &w)| {
            let held = w == 0.0 || body.fixed.binary_search(&(cell as u16)).is_ok();
            if held { 0.0 } else { 1.0 / w }
        })
        .chain(std::iter::repeat_n(0.0, body.spare))
        .collect()
}
