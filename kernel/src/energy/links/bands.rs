//! The links of a body in a tick, with their bands or with closed ones.

use super::law::Band;
use crate::model::terms::Keeps;
use crate::model::{Model, Slices};
use crate::number::cell::sub;

/// The links, and whether their bands are closed (unloading).
#[derive(Clone, Copy)]
pub(crate) struct Links<'a, 'm> {
    pub model: &'a Model<'m>,
    pub closed: bool,
    /// The band of all links, if they do not differ.
    pub(super) even: Band,
    /// The links by slices, if the model has these and they carry forces.
    pub(super) slices: Option<Slices<'m>>,
}

impl Keeps for Links<'_, '_> {}

impl<'a, 'm> Links<'a, 'm> {
    #[inline(always)]
    pub fn of(model: &'a Model<'m>, closed: bool) -> Self {
        let even = Band::new(if closed { 0.0 } else { model.link_alpha(0) });
        Self { model, closed, even, slices: model.slices.filter(|_| !model.is_nodal()) }
    }

    /// Alpha of a link, 0 while the bands are closed.
    #[inline]
    pub fn alpha(&self, link: usize) -> f32 {
        if self.closed { 0.0 } else { self.model.link_alpha(link) }
    }

    /// Returns true if links differ in weight, or in band while bands are open.
    #[inline(always)]
    pub fn differ(&self) -> bool {
        self.model.link_weights.is_some() || !self.closed && self.model.link_alphas.is_some()
    }
}

/// `P_j` - `P_i` of the rest shape. Not inlined: ends rarely coincide, and the loop over the links has no
/// registers to spare for the rest shape.
#[cold]
#[inline(never)]
pub(super) fn rest_difference(model: &Model<'_>, i: usize, j: usize) -> [f32; 3] {
    sub(model.rest_position(j), model.rest_position(i))
}
