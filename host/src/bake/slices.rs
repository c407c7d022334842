//! A second copy of the links for vector units: slices of eight consecutive cells, lane by lane.

use chaincell_kernel::image::kind;
use chaincell_kernel::number::two_float::LANES;

use super::adjacency::Adjacency;
use super::image::Sections;
use super::layout::Link;

/// Values of the links for the sweep, in the links' order.
pub(super) struct Values<'a> {
    pub rest_lengths: &'a [f32],
    /// If links differ.
    pub alphas: Option<&'a [f32]>,
    /// If links differ.
    pub weights: Option<&'a [f32]>,
}

/// Adds the sections of the sliced links; returns the starts of the slices and the other ends.
pub(super) fn push(
    sections: &mut Sections,
    cells: usize,
    adjacency: &Adjacency,
    links: &[Link],
    values: &Values<'_>,
) -> (Vec<u32>, Vec<u16>) {
    // Slots of the slices; a lane without a further link gets a slot to itself.
    let (mut rows, mut neighbours, mut slots) = (vec![0_u32], Vec::new(), Vec::new());
    for slice in 0..cells.div_ceil(LANES) {
        let lanes: Vec<Vec<(u16, usize)>> = (slice * LANES..(slice + 1) * LANES)
            .map(|cell| of_cell(cell, cells, adjacency, links))
            .collect();
        let groups = lanes.iter().map(Vec::len).max().unwrap_or(0);
        for group in 0..groups {
            for (lane, links) in lanes.iter().enumerate() {
                let itself = (slice * LANES + lane).min(cells - 1) as u16;
                let slot = links.get(group).copied();
                neighbours.push(slot.map_or(itself, |(id, _)| id));
                slots.push(slot.map(|(_, link)| link));
            }
        }
        rows.push((neighbours.len() / LANES) as u32);
    }
    // The values in the order of the slots.
    let of_slots = |values: &[f32], padding: f32| -> Vec<f32> {
        slots.iter().map(|slot| slot.map_or(padding, |link| values[link])).collect()
    };
    sections.push(kind::SLICE_ROWS, &rows);
    sections.push(kind::SLICE_NEIGHBOURS, &neighbours);
    sections.push(kind::SLICE_LENGTHS, &of_slots(values.rest_lengths, 0.0));
    if let Some(alphas) = values.alphas {
        sections.push(kind::SLICE_ALPHAS, &of_slots(alphas, 0.0));
    }
    if let Some(weights) = values.weights {
        sections.push(kind::SLICE_WEIGHTS, &of_slots(weights, 1.0));
    }
    (rows, neighbours)
}

/// Returns a cell's other ends in ascending order, with their links; none beyond the last cell.
fn of_cell(cell: usize, cells: usize, adjacency: &Adjacency, links: &[Link]) -> Vec<(u16, usize)> {
    if cell >= cells {
        return Vec::new();
    }
    let range = |rows: &[u32]| rows[cell] as usize..rows[cell + 1] as usize;
    let below = range(&adjacency.back_rows)
        .map(|half| (adjacency.lower[half], adjacency.back_link[half] as usize));
    let above = range(&adjacency.rows).map(|link| (links[link].0[1], link));
    below.chain(above).collect()
}
