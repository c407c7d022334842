//! Strain and stress of the tissue at the nodes.

use chaincell_kernel::{Model, Stress};

use crate::engine::{Engine, Nodes};

/// Returns strain and stress at each node, in the order of the nodes; `None` in a body of links. A node of an
/// embedded mesh has the mean over its cells, by their weights.
pub(super) fn stresses(engine: &mut Engine<'_>, nodes: &Nodes) -> Option<Vec<Stress>> {
    let model = *engine.network().model();
    let cells = (0..model.cells()).map(|cell| engine.stress(cell)).collect::<Option<Vec<_>>>()?;
    if model.fine_nodes() == 0 {
        return Some(cells);
    }
    Some(nodes.ids.iter().map(|&id| mean(&model, id as usize, &cells)).collect())
}

/// The mean over the cells of a node of the embedded mesh.
fn mean(model: &Model<'_>, node: usize, cells: &[Stress]) -> Stress {
    let mut sum = Stress { gradient: [[0.0; 3]; 3], stretches: [0.0; 3], cauchy_pa: [[0.0; 3]; 3] };
    for (cell, weight) in model.fine_weights(node) {
        let Some(of) = cells.get(usize::from(cell)) else { continue };
        add(sum.gradient.as_flattened_mut(), of.gradient.as_flattened(), weight);
        add(&mut sum.stretches, &of.stretches, weight);
        add(sum.cauchy_pa.as_flattened_mut(), of.cauchy_pa.as_flattened(), weight);
    }
    sum
}

fn add(sum: &mut [f32], of: &[f32], weight: f32) {
    sum.iter_mut().zip(of).for_each(|(sum, of)| *sum += weight * of);
}

/// The elements of the Cauchy stress in VTK's order \[Pa\]: xx, yy, zz, xy, yz, xz.
pub(super) fn elements_pa(stress: &Stress) -> [f64; 6] {
    let [[xx, xy, xz], [_, yy, yz], [.., zz]] = stress.cauchy_pa;
    [xx, yy, zz, xy, yz, xz].map(f64::from)
}
