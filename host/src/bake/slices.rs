//! Links once more for vector units: slices of eight consecutive cells, lane by lane.

use chaincell_kernel::image::kind;
use chaincell_kernel::two_float::LANES;

use super::image::Sections;
use super::{Adjacency, Link};

/// Adds the three sections of the sliced links.
pub(super) fn push(
    sections: &mut Sections,
    cells: usize,
    adjacency: &Adjacency,
    links: &[Link],
    rest_lengths: &[f32],
) {
    let (mut rows, mut neighbours, mut lengths) = (vec![0_u32], Vec::new(), Vec::new());
    for slice in 0..cells.div_ceil(LANES) {
        let lanes: Vec<Vec<(u16, f32)>> = (slice * LANES..(slice + 1) * LANES)
            .map(|cell| of_cell(cell, cells, adjacency, links, rest_lengths))
            .collect();
        let groups = lanes.iter().map(Vec::len).max().unwrap_or(0);
        for group in 0..groups {
            for (lane, slots) in lanes.iter().enumerate() {
                let itself = (slice * LANES + lane).min(cells - 1) as u16;
                let (id, length) = slots.get(group).copied().unwrap_or((itself, 0.0));
                neighbours.push(id);
                lengths.push(length);
            }
        }
        rows.push((neighbours.len() / LANES) as u32);
    }
    sections.push(kind::SLICE_ROWS, &rows);
    sections.push(kind::SLICE_NEIGHBOURS, &neighbours);
    sections.push(kind::SLICE_LENGTHS, &lengths);
}

/// A cell's other ends in ascending order, with rest lengths; none beyond the last cell.
fn of_cell(
    cell: usize,
    cells: usize,
    adjacency: &Adjacency,
    links: &[Link],
    rest_lengths: &[f32],
) -> Vec<(u16, f32)> {
    if cell >= cells {
        return Vec::new();
    }
    let range = |rows: &[u32]| rows[cell] as usize..rows[cell + 1] as usize;
    let below = range(&adjacency.back_rows)
        .map(|half| (adjacency.lower[half], rest_lengths[adjacency.back_link[half] as usize]));
    let above = range(&adjacency.rows).map(|link| (links[link].0[1], rest_lengths[link]));
    below.chain(above).collect()
}
