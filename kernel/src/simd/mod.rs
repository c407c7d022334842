//! The link pass on vector units, chosen at run time; the same bits as the scalar pass.

#[cfg(target_arch = "x86_64")]
mod avx2;

use crate::cell::Cell;
use crate::link::{Band, Pull};
use crate::model::{Model, Slices};

/// A vector unit that this processor and its operating system offer. Its existence is the proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VectorUnit(());

impl VectorUnit {
    /// Asks the processor. Costs a few microseconds in a virtual machine: once, not every tick.
    #[must_use]
    pub fn find() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        let found = avx2::is_offered();
        #[cfg(not(target_arch = "x86_64"))]
        let found = false;
        found.then_some(Self(()))
    }

    /// Residuals of all cells from the sliced links of a model with one band and weight 1.
    ///
    /// `pull(i, j, l0)` gives the pull on i of a link whose ends coincide. Does nothing where `at`
    /// or `residual` are shorter than the model.
    #[cfg_attr(not(target_arch = "x86_64"), allow(unused_variables))]
    pub(crate) fn pass(
        self,
        model: &Model<'_>,
        slices: &Slices<'_>,
        band: Band,
        at: &[Cell],
        residual: &mut [Cell],
        pull: impl Fn(usize, usize, f32) -> Option<Pull>,
    ) {
        #[cfg(target_arch = "x86_64")]
        avx2::pass(self, model, slices, band, at, residual, pull);
    }
}
