//! The interface of an energy term's data, and lists of terms.

use super::branches::BranchNumbers;
use super::image::{ModelError, Sections};
use super::layout::Layout;

/// The end of the list: an empty term.
#[derive(Clone, Copy)]
pub(crate) struct NoTerm;

/// The state that a term keeps of each cell between passes, in rows of eight numbers, one of each cell of a
/// slice.
pub(crate) trait Keeps: Copy {
    /// Rows of what lasts from pass to pass. Its numbers are never -0.0, so that equal states have equal
    /// words.
    const LASTING: usize = 0;
    /// Returns the number of a row of what lasts in the rest shape.
    fn at_rest(_row: usize) -> f32 {
        0.0
    }
}

impl Keeps for NoTerm {}

impl<A: Keeps, B: Keeps> Keeps for (A, B) {
    const LASTING: usize = A::LASTING + B::LASTING;

    fn at_rest(row: usize) -> f32 {
        row.checked_sub(A::LASTING).map_or_else(|| A::at_rest(row), B::at_rest)
    }
}

/// The data of a term in an image, and its part of the bound L of the energy's curvature, see
/// [`terms`](crate::energy).
pub(crate) trait TermData<'a>: Keeps {
    /// Reads the term's sections; without them the term is empty.
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError>;
    /// Checks the sections against the cells of the body, and the body's largest step against
    /// the term.
    fn check(&self, layout: &Layout<'_>) -> Result<(), ModelError>;
    /// Adds twice the diagonal of L at a cell, or the sum of the magnitudes of its row where that is larger,
    /// to the sum of the previous terms.
    fn add_bound(&self, cell: usize, sum: f32) -> f32;
    /// Returns true if the term's energy is 0 in the rest shape.
    fn rests(&self, layout: &Layout<'_>) -> bool;
    /// Returns true if the term keeps states of this body's cells.
    #[inline(always)]
    fn keeps(&self) -> bool {
        false
    }
    /// Calls `visit(other, element)` for each contribution to the row of L at a cell.
    fn each_of_row(&self, _cell: usize, _visit: &mut impl FnMut(usize, f32)) {}
    /// Returns true if a cell without links exerts no force, whatever its position.
    fn is_dormant(&self, _cell: usize) -> bool {
        true
    }
    /// Returns Young's modulus \[Pa\] and Poisson's ratio at a cell, from the unit of stress \[Pa\].
    fn elasticity(&self, _cell: usize, _unit_pa: f32) -> Option<[f32; 2]> {
        None
    }
    /// Returns the stretch at which the band of shapes begins, 0 for no band; `None` without shapes.
    fn stretch_min(&self) -> Option<f32> {
        None
    }
    /// Calls `visit(half_width, modulus_pa)` for each set of stiffening bands, from the unit of stress
    /// \[Pa\].
    fn stiffening(&self, _unit_pa: f32, _visit: &mut impl FnMut(f32, f32)) {}
    /// Returns the branches of relaxation.
    fn branches(&self) -> &'a [BranchNumbers] {
        &[]
    }
    /// Returns true if the term joins cells without a link between them.
    #[inline(always)]
    fn joins_unlinked(&self) -> bool {
        false
    }
    /// Returns true if the term replaces the forces of the links, so that the motion of a cell affects cells
    /// beyond its neighbours.
    #[inline(always)]
    fn replaces_links(&self) -> bool {
        false
    }
}

impl<'a> TermData<'a> for NoTerm {
    #[inline(always)]
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError> {
        #[cfg(not(feature = "nodal"))]
        if sections.optional::<u32>(super::image::kind::NODAL)?.is_some() {
            return Err(ModelError::Unbuilt(super::image::kind::NODAL));
        }
        #[cfg(not(feature = "relax"))]
        super::branches::read(sections)?;
        #[cfg(feature = "relax")]
        let _ = sections;
        Ok(Self)
    }

    #[inline(always)]
    fn check(&self, _: &Layout<'_>) -> Result<(), ModelError> {
        Ok(())
    }

    #[inline(always)]
    fn add_bound(&self, _: usize, sum: f32) -> f32 {
        sum
    }

    #[inline(always)]
    fn rests(&self, _: &Layout<'_>) -> bool {
        true
    }
}

impl<'a, A: TermData<'a>, B: TermData<'a>> TermData<'a> for (A, B) {
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError> {
        Ok((A::read(sections)?, B::read(sections)?))
    }

    fn check(&self, layout: &Layout<'_>) -> Result<(), ModelError> {
        self.0.check(layout)?;
        self.1.check(layout)
    }

    fn add_bound(&self, cell: usize, sum: f32) -> f32 {
        self.1.add_bound(cell, self.0.add_bound(cell, sum))
    }

    fn rests(&self, layout: &Layout<'_>) -> bool {
        self.0.rests(layout) && self.1.rests(layout)
    }

    #[inline(always)]
    fn keeps(&self) -> bool {
        self.0.keeps() || self.1.keeps()
    }

    fn each_of_row(&self, cell: usize, visit: &mut impl FnMut(usize, f32)) {
        self.0.each_of_row(cell, visit);
        self.1.each_of_row(cell, visit);
    }

    fn is_dormant(&self, cell: usize) -> bool {
        self.0.is_dormant(cell) && self.1.is_dormant(cell)
    }

    fn elasticity(&self, cell: usize, unit_pa: f32) -> Option<[f32; 2]> {
        self.0.elasticity(cell, unit_pa).or_else(|| self.1.elasticity(cell, unit_pa))
    }

    fn stretch_min(&self) -> Option<f32> {
        self.0.stretch_min().or_else(|| self.1.stretch_min())
    }

    fn stiffening(&self, unit_pa: f32, visit: &mut impl FnMut(f32, f32)) {
        self.0.stiffening(unit_pa, visit);
        self.1.stiffening(unit_pa, visit);
    }

    #[inline(always)]
    fn branches(&self) -> &'a [BranchNumbers] {
        let first = self.0.branches();
        if first.is_empty() { self.1.branches() } else { first }
    }

    #[inline(always)]
    fn joins_unlinked(&self) -> bool {
        self.0.joins_unlinked() || self.1.joins_unlinked()
    }

    #[inline(always)]
    fn replaces_links(&self) -> bool {
        self.0.replaces_links() || self.1.replaces_links()
    }
}
