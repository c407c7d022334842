//! Triangles in reach of the tools.

use super::friction::Anchor;
use super::proxy::PARTS_MAX;
use crate::number::kept::kept;

kept! {
    /// A triangle in reach of a part of a tool, or gripped by it.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct NearTriangle {
        pub(crate) corners: [u16; 3],
        /// Subdivisions of an edge.
        pub(crate) parts: u16,
        /// Stiffness of all samples together [2 `k_ref`].
        pub(crate) weight: f32,
        /// Lower bound of the distance of its points from the part, negative inside; for a gripped triangle
        /// the least number.
        pub(crate) distance: f32,
        /// Name of the triangle, in the model's order.
        pub(crate) index: u32,
        /// Range of its anchors in the list.
        pub(crate) first: u16,
        pub(crate) held: u16,
        /// Code of the part: its index plus [`PARTS_MAX`] times the tool.
        pub(crate) of: u8,
    }
}

impl NearTriangle {
    /// An empty slot.
    pub const NONE: Self = Self {
        corners: [0; 3],
        parts: 0,
        weight: 0.0,
        distance: 0.0,
        index: 0,
        first: 0,
        held: 0,
        of: 0,
    };

    /// The tool.
    pub(crate) fn tool(&self) -> usize {
        usize::from(self.of) / PARTS_MAX
    }

    /// Index of its part.
    pub(crate) fn part(&self) -> usize {
        usize::from(self.of) % PARTS_MAX
    }

    /// Its anchors among all.
    #[inline(always)]
    pub(crate) fn anchors_of<'a>(&self, anchors: &'a [Anchor]) -> &'a [Anchor] {
        let first = usize::from(self.first);
        anchors.get(first..first + usize::from(self.held)).unwrap_or(&[])
    }

    /// Sort key of the list.
    pub(crate) fn key(&self) -> (u32, u8) {
        (self.index, self.of)
    }
}
