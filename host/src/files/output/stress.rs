//! Strain and stress of the tissue at its nodes.

use chaincell_kernel::Stress;

use crate::engine::Engine;

/// Returns strain and stress at each cell of the body and at the first `copies` of its spare ones; `None` in a body
/// of links. Tissue has no embedded mesh: its nodes are its cells.
pub(super) fn stresses(engine: &mut Engine<'_>, copies: usize) -> Option<Vec<Stress>> {
    let cells = engine.network().model().body_cells() + copies;
    (0..cells).map(|cell| engine.stress(cell)).collect()
}

/// The elements of the Cauchy stress in VTK's order \[Pa\]: xx, yy, zz, xy, yz, xz.
pub(super) fn elements_pa(stress: &Stress) -> [f64; 6] {
    let [[xx, xy, xz], [_, yy, yz], [.., zz]] = stress.cauchy_pa;
    [xx, yy, zz, xy, yz, xz].map(f64::from)
}
