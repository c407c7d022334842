//! Colours of the free cells, for schemes that move cells in place: no two linked cells share one.

use chaincell_kernel::image::kind;

use super::image::Sections;
use super::{Adjacency, Link};

/// Adds the sections of the colours: greedy, each cell taking the lowest that no linked cell before
/// it has.
pub(super) fn push(
    sections: &mut Sections,
    adjacency: &Adjacency,
    links: &[Link],
    mobility: &[f32],
) {
    let mut of_cell = vec![usize::MAX; mobility.len()];
    let mut cells: Vec<Vec<u16>> = Vec::new();
    for (cell, _) in mobility.iter().enumerate().filter(|(_, mobility)| **mobility > 0.0) {
        let range = |rows: &[u32]| rows[cell] as usize..rows[cell + 1] as usize;
        let below = adjacency.lower[range(&adjacency.back_rows)].iter().copied();
        let above = links[range(&adjacency.rows)].iter().map(|(ends, _)| ends[1]);
        let taken: Vec<usize> = below.chain(above).map(|id| of_cell[usize::from(id)]).collect();
        let colour = (0..=taken.len()).find(|colour| !taken.contains(colour)).unwrap_or_default();
        of_cell[cell] = colour;
        cells.resize_with(cells.len().max(colour + 1), Vec::new);
        cells[colour].push(cell as u16);
    }
    let mut rows = vec![0_u32];
    rows.extend(cells.iter().scan(0, |end, colour| {
        *end += colour.len() as u32;
        Some(*end)
    }));
    sections.push(kind::COLOUR_ROWS, &rows);
    sections.push(kind::COLOUR_CELLS, &cells.concat());
}
