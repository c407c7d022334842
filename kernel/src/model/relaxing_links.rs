//! Links that relax: the half-links of a body of links by slices, with what they remember.

use super::nodal::HalfLinkMemory;
use super::{Model, Slices};
use crate::model::others;

/// The links of a body of links that relaxes.
#[derive(Clone, Copy)]
pub(crate) struct RelaxingLinks<'a> {
    pub slices: Option<Slices<'a>>,
    /// Alpha of all links that have none of their own.
    pub alpha: f32,
    /// Rest positions of the cells.
    pub rest: &'a [[f32; 3]],
    /// The memory by group of half-links, constant in a tick; none outside a tick, and in another body.
    pub memory: &'a [HalfLinkMemory],
    /// The part of the stiffness that does not act in this tick.
    pub faded: f32,
}

impl<'a> RelaxingLinks<'a> {
    /// The links of a body.
    #[inline(always)]
    pub fn of(model: &Model<'a>) -> Self {
        let memory = others::shapes(&model.others).memory;
        Self {
            slices: model.slices,
            alpha: model.alpha,
            rest: model.rest,
            memory: memory.links,
            faded: 1.0 - memory.part,
        }
    }
}
