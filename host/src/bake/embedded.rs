//! The embedded mesh: sections of the image for viewers that show every node.

use chaincell_kernel::image::{FINE_CELLS, NO_CELL, kind};

use super::image::Sections;
use super::layout::{OrderedCells, internal};
use super::network::Plan;

/// Adds rest positions, weights and elements of the mesh, if cells are groups of its nodes.
pub fn push(sections: &mut Sections, plan: &Plan<'_>, body: &OrderedCells) {
    let Some(coarse) = plan.coarse() else { return };
    let mesh = plan.mesh();
    let embedding = &coarse.embedding;
    let rest: Vec<[f32; 3]> = (mesh.nodes_m.iter().zip(&embedding.groups))
        .map(|(&at, groups)| match groups[0] {
            // An unused node may have any position.
            NO_CELL => [0.0; 3],
            _ => internal(at, body.centre_m, body.unit_m),
        })
        .collect();
    let cell_of = |group: u16| match group {
        NO_CELL => NO_CELL,
        group => body.cell_of[usize::from(group)],
    };
    let cells: Vec<[u16; FINE_CELLS]> =
        embedding.groups.iter().map(|groups| groups.map(cell_of)).collect();
    sections.push(kind::FINE_REST, rest.as_flattened());
    sections.push(kind::FINE_CELLS, cells.as_flattened());
    sections.push(kind::FINE_WEIGHTS, embedding.weights.as_flattened());
    if !mesh.triangles.is_empty() {
        sections.push(kind::FINE_TRIANGLES, mesh.triangles.as_flattened());
    }
    if !mesh.tetrahedra.is_empty() {
        sections.push(kind::FINE_TETRAHEDRA, mesh.tetrahedra.as_flattened());
    }
}
