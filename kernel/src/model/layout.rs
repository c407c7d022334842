//! The part of a body that its terms are checked against.

use crate::number::two_float::LANES;

/// Cells and bounds of a body as its image has them.
#[cfg_attr(not(any(test, feature = "nodal")), expect(dead_code, reason = "only links to check"))]
#[derive(Clone, Copy)]
pub(crate) struct Layout<'a> {
    /// Rest positions.
    pub rest: &'a [[f32; 3]],
    /// Inverse of the curvature bound of each cell, 0 for a fixed one.
    #[cfg(test)]
    pub mobility: &'a [f32],
    /// True if links differ in weight.
    pub has_weights: bool,
    /// True if a link has slack.
    pub has_slack: bool,
    /// Largest K [mean link lengths].
    pub saturation: f32,
    /// Bound of the curvature that the step relies on.
    pub degree_bound: f32,
}

#[cfg_attr(not(any(test, feature = "nodal")), expect(dead_code, reason = "only links to check"))]
impl Layout<'_> {
    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.rest.len()
    }

    /// Number of slices.
    pub fn slices(&self) -> usize {
        self.rest.len().div_ceil(LANES)
    }

    /// Rest position of a cell, zeros beyond the last one.
    #[cfg(test)]
    pub fn rest_position(&self, cell: usize) -> [f32; 3] {
        self.rest.get(cell).copied().unwrap_or_default()
    }
}
