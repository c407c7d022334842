//! Links that relax: the half-links of a body of links by slices, with what they remember.

use super::nodal::HalfLinkMemory;
use super::{Model, Slices};
use crate::model::others;

/// The links of a body of links that relaxes. It borrows the whole body, so that another one copies nothing for it.
#[derive(Clone, Copy)]
pub(crate) struct RelaxingLinks<'a, 'm>(pub &'a Model<'m>);

impl<'m> RelaxingLinks<'_, 'm> {
    /// The body's half-links.
    #[inline(always)]
    pub fn slices(self) -> Slices<'m> {
        self.0.slices.unwrap_or(Slices::NONE)
    }

    /// Alpha of all links that have none of their own.
    #[inline(always)]
    pub fn alpha(self) -> f32 {
        self.0.alpha
    }

    /// Rest positions of the cells.
    #[inline(always)]
    pub fn rest(self) -> &'m [[f32; 3]] {
        self.0.rest
    }

    /// The memory by group of half-links, constant in a tick; none outside a tick, and in another body.
    #[inline(always)]
    pub fn memory(self) -> &'m [HalfLinkMemory] {
        others::shapes(&self.0.others).memory.links
    }

    /// The part of the stiffness that does not act in this tick.
    #[inline(always)]
    pub fn faded(self) -> f32 {
        1.0 - others::shapes(&self.0.others).memory.part
    }
}
