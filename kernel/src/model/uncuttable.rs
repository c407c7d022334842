//! In place of `cuttable` in a kernel that is built without cuts: an image of a body that can be cut is refused.

use core::marker::PhantomData;

use super::image::{ModelError, Sections, kind};
use super::loose::Loose;
use super::tearing::TearLimit;

/// The tetrahedra of a body that a blade may part: none.
#[derive(Clone, Copy)]
pub(crate) struct Cuttable<'a>(PhantomData<&'a ()>);

impl<'a> Cuttable<'a> {
    #[cfg(test)]
    pub const NONE: Self = Self(PhantomData);

    pub fn is_any(&self) -> bool {
        false
    }

    pub fn corners(&self) -> &'a [[u16; 4]] {
        &[]
    }

    pub fn star(&self, _: usize) -> &'a [u32] {
        &[]
    }

    pub fn face(&self, _: usize, _: usize) -> Option<[u16; 3]> {
        None
    }

    pub fn spare_cells(&self) -> usize {
        0
    }

    pub fn toughness_j_per_m2(&self) -> f32 {
        0.0
    }

    pub fn cell_toughness_j_per_m2(&self, _: usize) -> f32 {
        0.0
    }

    pub fn tear_limit(&self) -> Option<TearLimit> {
        None
    }

    pub fn loose(&self) -> Loose {
        Loose::Leave
    }

    /// Refuses the section.
    pub fn read(sections: &Sections<'a>, _: usize) -> Result<Self, ModelError> {
        match sections.optional::<u32>(kind::CUTTING)? {
            Some(_) => Err(ModelError::Unbuilt(kind::CUTTING)),
            None => Ok(Self(PhantomData)),
        }
    }

    pub fn check(&self, _: &[[f32; 3]]) -> Result<(), ModelError> {
        Ok(())
    }
}
