//! The embedded mesh: nodes of a mesh finer than the network, which move with the cells around
//! them.
//!
//! The position of a node is x = X + sum of w (y - Y) over its cells, with X and Y at rest and y as
//! published. A tick does not compute it; each query costs a step per weight of the node.

use super::Model;
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

impl<'a> Model<'a> {
    /// Number of nodes of the embedded mesh, by input id; 0 for a model in which every node is a cell. A node
    /// may be left out: it has no position.
    #[must_use]
    pub fn fine_nodes(&self) -> usize {
        self.embedded.map_or(0, |mesh| mesh.rest.len())
    }

    /// Rest position of a node of the embedded mesh [mean link lengths from the centre].
    #[must_use]
    pub fn fine_rest(&self, node: usize) -> Option<[f32; 3]> {
        let mesh = self.embedded?;
        mesh.own_cell(node)?;
        mesh.rest.get(node).copied()
    }

    /// Cells of a node of the embedded mesh, with their weights; its own cell first. Empty for a
    /// node that is left out.
    pub fn fine_weights(&self, node: usize) -> impl Iterator<Item = (u16, f32)> + use<'a> {
        let of = self.embedded.and_then(|mesh| {
            mesh.own_cell(node)?;
            Some((mesh.cells.get(node)?, mesh.weights.get(node)?))
        });
        of.into_iter()
            .flat_map(|(cells, weights)| cells.iter().copied().zip(weights.iter().copied()))
    }

    /// Surface triangles of the embedded mesh, outward, for display.
    #[must_use]
    pub fn fine_triangles(&self) -> &'a [[u32; 3]] {
        self.embedded.map_or(&[], |mesh| mesh.triangles)
    }

    /// Tetrahedra of the embedded mesh, for display.
    #[must_use]
    pub fn fine_tetrahedra(&self) -> &'a [[u32; 4]] {
        self.embedded.map_or(&[], |mesh| mesh.tetrahedra)
    }

    /// Returns the position of a node of the embedded mesh for cells at `position_of`
    /// [mean link lengths from the centre]; `None` beyond the last node, for a node that is left out, and in
    /// a model without an embedded mesh. Cost: at most [`FINE_CELLS`] positions.
    #[must_use]
    pub fn fine_position(
        &self,
        node: usize,
        position_of: impl Fn(usize) -> Option<[f32; 3]>,
    ) -> Option<[f32; 3]> {
        let mut place = self.fine_rest(node)?;
        for (cell, weight) in self.fine_weights(node).filter(|&(_, weight)| weight != 0.0) {
            let cell = usize::from(cell);
            let (now, rest) = (position_of(cell)?, self.rest_position(cell));
            for ((x, now), rest) in place.iter_mut().zip(now).zip(rest) {
                *x += weight * (now - rest);
            }
        }
        Some(place)
    }
}
