//! Requirements of a link on a number type; the links of `f32`.

use super::bands::Links;
use super::law::{self, Band, LinkForce};
use super::range::RangeError;
use crate::backend::slice_set::SliceSet;
use crate::energy::number::TermNumber;
use crate::model::Model;
use crate::number::cell::{Cell, single};

/// A number type that links can be computed in.
#[allow(private_interfaces)]
pub trait LinkNumber: TermNumber {
    /// Absolute error of a length due to rounding, in units of the `f32` epsilon [mean link lengths].
    const GRAIN: f32 = 0.0;
    /// The band of a link in rest lengths, in the form that a pass uses.
    type Band: Copy;

    /// The band `1 - alpha` to `1 + alpha` (Eq. 5).
    fn band(alpha: f32) -> Self::Band;
    /// The force of a link of rest length `l0` and weight `w` on its end `pi`; the other end is `pj`. `None`
    /// or zero inside its band. `rest_difference` returns `P_j` - `P_i` of the rest shape; it is called only
    /// if the ends coincide.
    fn link_force(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Self::Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<LinkForce<Self>>;
    /// The same in single precision, also outside the number's range: for the few links of the cells that the
    /// tool holds.
    fn link_force_single(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Self::Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<LinkForce> {
        let of = Self::link_force(pi, pj, l0, w, band, rest_difference)?;
        Some(LinkForce { force: single(of.force), wd2: Self::product_single(of.wd2) })
    }
    /// Adds the links to the residuals of awake slices at states within K by a loop of this number's own.
    /// Returns false if it has none for these links.
    fn accumulate(
        links: Links<'_, '_>,
        awake: &SliceSet,
        v: &[Cell<Self>],
        residual: &mut [Cell<Self>],
    ) -> bool {
        let _ = (links, awake, v, residual);
        false
    }
    /// Recomputes residuals whose partial sums may have left the number's range, after the links at the
    /// outputs `y` of the states.
    fn mend(
        links: Links<'_, '_>,
        awake: &SliceSet,
        v: &[Cell<Self>],
        residual: &mut [Cell<Self>],
        y: impl Fn([Self; 3]) -> [Self; 3],
    ) {
        let _ = (links, awake, v, residual, y);
    }
    /// Checks that the number's range supports the model.
    ///
    /// # Errors
    /// The parameter that is out of range.
    fn admits(model: &Model<'_>) -> Result<(), RangeError> {
        let _ = model;
        Ok(())
    }
}

#[allow(private_interfaces)]
impl LinkNumber for f32 {
    type Band = Band;

    #[inline(always)]
    fn band(alpha: f32) -> Band {
        Band::new(alpha)
    }

    #[inline(always)]
    fn link_force(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<LinkForce<Self>> {
        law::link_force(pi, pj, l0, w, band, rest_difference)
    }

    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    fn accumulate(
        links: Links<'_, '_>,
        awake: &SliceSet,
        v: &[Cell],
        residual: &mut [Cell],
    ) -> bool {
        if !links.differ() {
            super::vfp::accumulate(links.model, Band::new(links.alpha(0)), awake, v, residual);
        }
        !links.differ()
    }
}
