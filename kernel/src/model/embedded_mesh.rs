//! The embedded mesh: nodes of a mesh finer than the network, which move with the cells around
//! them.
//!
//! The position of a node is x = X + sum of w (y - Y) over its cells, with X and Y at rest and y as
//! published. A tick does not compute it; each query costs a step per weight of the node.

use super::image::{FINE_CELLS, ModelError, NO_CELL, Sections, kind};

/// Nodes with their weights, and the elements over them.
#[derive(Clone, Copy)]
pub(crate) struct EmbeddedMesh<'a> {
    /// Rest positions, by input id.
    pub rest: &'a [[f32; 3]],
    /// Cells of each node, its own first; [`NO_CELL`] for a node that is left out.
    pub cells: &'a [[u16; FINE_CELLS]],
    /// Weights of those cells.
    pub weights: &'a [[f32; FINE_CELLS]],
    /// Surface triangles.
    pub triangles: &'a [[u32; 3]],
    /// Tetrahedra.
    pub tetrahedra: &'a [[u32; 4]],
}

impl<'a> EmbeddedMesh<'a> {
    /// Reads the embedded mesh of an image, `None` if it has none. `nodes` is the number of nodes of the
    /// input's numbering.
    pub fn read(sections: &Sections<'a>, nodes: usize) -> Result<Option<Self>, ModelError> {
        if sections.optional::<[f32; 3]>(kind::FINE_REST)?.is_none() {
            return Ok(None);
        }
        Ok(Some(Self {
            rest: sections.sized(kind::FINE_REST, nodes)?,
            cells: sections.sized(kind::FINE_CELLS, nodes)?,
            weights: sections.sized(kind::FINE_WEIGHTS, nodes)?,
            triangles: sections.optional(kind::FINE_TRIANGLES)?.unwrap_or(&[]),
            tetrahedra: sections.optional(kind::FINE_TETRAHEDRA)?.unwrap_or(&[]),
        }))
    }

    /// Returns the cell whose group holds a node; `None` for a node that is left out.
    pub fn own_cell(&self, node: usize) -> Option<u16> {
        let own = self.cells.get(node)?.first().copied()?;
        if own == NO_CELL { None } else { Some(own) }
    }
}
