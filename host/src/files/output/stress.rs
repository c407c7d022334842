//! Strain and stress of the tissue at its nodes.

use chaincell_kernel::Stress;

use crate::engine::Engine;

/// Returns strain and stress at each cell of the body and at the first `copies` of its spare ones; `None` in a body
/// of links. Tissue has no embedded mesh: its nodes are its cells.
pub(super) fn stresses(engine: &mut Engine<'_>, copies: usize) -> Option<Vec<Stress>> {
    let cells = engine.network().model().body_cells() + copies;
    engine.stresses(0..cells)
}
