//! The energy terms besides the links in an image: their static list, and the data of each.

use super::Model;
use super::image::{ModelError, Sections};
#[cfg(feature = "nodal")]
use super::nodal::Nodal;
#[cfg(test)]
use super::pin::Pins;
#[cfg(feature = "nodal")]
use super::stiffening::Stiffening;

/// The end of the list: an empty term.
#[derive(Clone, Copy)]
pub(crate) struct NoTerm;

/// The terms besides the links: nested pairs that end in [`NoTerm`].
#[cfg(not(test))]
pub(crate) type Others<'a> = Built<'a>;
/// In this crate's tests the list has a further term, to show that one can be added.
#[cfg(test)]
pub(crate) type Others<'a> = (Pins<'a>, Built<'a>);

/// The terms that the features of this crate build.
#[cfg(feature = "nodal")]
type Built<'a> = (Nodal<'a>, (Stiffening<'a>, NoTerm));
#[cfg(not(feature = "nodal"))]
type Built<'a> = NoTerm;

/// All terms empty.
#[cfg(all(test, feature = "nodal"))]
pub(crate) const NONE: Built<'static> = (Nodal::NONE, (Stiffening::NONE, NoTerm));
#[cfg(all(test, not(feature = "nodal")))]
pub(crate) const NONE: Built<'static> = NoTerm;

/// The data of a term in an image, and its part of the bound L of the energy's curvature, see
/// [`terms`](crate::terms).
pub(crate) trait TermData<'a>: Copy {
    /// Reads the term's sections; without them the term is empty.
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError>;
    /// Checks the sections against the links of the model, and the model's largest step against
    /// the term.
    fn check(&self, model: &Model<'_>) -> Result<(), ModelError>;
    /// Adds twice the diagonal of L at a cell, or the sum of the magnitudes of its row where that is larger,
    /// to the sum of the previous terms.
    fn add_bound(&self, cell: usize, sum: f32) -> f32;
    /// Returns true if the term's energy is 0 in the rest shape.
    fn rests(&self, model: &Model<'_>) -> bool;
    /// Returns true if the term keeps states of this body's cells.
    #[inline(always)]
    fn keeps(&self) -> bool {
        false
    }
    /// Calls `visit(other, element)` for each contribution to the row of L at a cell, in a body in which a
    /// term replaces the links.
    fn each_of_row(&self, _cell: usize, _visit: &mut impl FnMut(usize, f32)) {}
    /// Returns Young's modulus \[Pa\] and Poisson's ratio at a cell, from the unit of stress \[Pa\].
    fn elasticity(&self, _cell: usize, _unit_pa: f32) -> Option<[f32; 2]> {
        None
    }
    /// Returns the law of the shapes, [`LAW_DET1`](super::image::LAW_DET1) or
    /// [`LAW_TRACE`](super::image::LAW_TRACE), and the stretch at which the band begins, 0 for none.
    fn shape_law(&self) -> Option<(u32, f32)> {
        None
    }
    /// Calls `visit(half_width, modulus_pa)` for each set of stiffening bands, from the unit of stress
    /// \[Pa\].
    fn stiffening(&self, _unit_pa: f32, _visit: &mut impl FnMut(f32, f32)) {}
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
        #[cfg(feature = "nodal")]
        let _ = sections;
        Ok(Self)
    }

    #[inline(always)]
    fn check(&self, _: &Model<'_>) -> Result<(), ModelError> {
        Ok(())
    }

    #[inline(always)]
    fn add_bound(&self, _: usize, sum: f32) -> f32 {
        sum
    }

    #[inline(always)]
    fn rests(&self, _: &Model<'_>) -> bool {
        true
    }
}

impl<'a, A: TermData<'a>, B: TermData<'a>> TermData<'a> for (A, B) {
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError> {
        Ok((A::read(sections)?, B::read(sections)?))
    }

    fn check(&self, model: &Model<'_>) -> Result<(), ModelError> {
        self.0.check(model)?;
        self.1.check(model)
    }

    fn add_bound(&self, cell: usize, sum: f32) -> f32 {
        self.1.add_bound(cell, self.0.add_bound(cell, sum))
    }

    fn rests(&self, model: &Model<'_>) -> bool {
        self.0.rests(model) && self.1.rests(model)
    }

    #[inline(always)]
    fn keeps(&self) -> bool {
        self.0.keeps() || self.1.keeps()
    }

    fn each_of_row(&self, cell: usize, visit: &mut impl FnMut(usize, f32)) {
        self.0.each_of_row(cell, visit);
        self.1.each_of_row(cell, visit);
    }

    fn elasticity(&self, cell: usize, unit_pa: f32) -> Option<[f32; 2]> {
        self.0.elasticity(cell, unit_pa).or_else(|| self.1.elasticity(cell, unit_pa))
    }

    fn shape_law(&self) -> Option<(u32, f32)> {
        self.0.shape_law().or_else(|| self.1.shape_law())
    }

    fn stiffening(&self, unit_pa: f32, visit: &mut impl FnMut(f32, f32)) {
        self.0.stiffening(unit_pa, visit);
        self.1.stiffening(unit_pa, visit);
    }

    #[inline(always)]
    fn replaces_links(&self) -> bool {
        self.0.replaces_links() || self.1.replaces_links()
    }
}

impl Model<'_> {
    /// Returns the curvature bound of a cell, the inverse of its mobility and twice the diagonal of L: W, the
    /// sum of its links' weights, plus the parts of the other terms.
    #[must_use]
    #[inline]
    pub fn cell_bound(&self, cell: usize) -> f32 {
        self.others.add_bound(cell, self.cell_weight(cell))
    }
}
