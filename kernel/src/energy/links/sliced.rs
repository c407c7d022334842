//! The links over slices: eight cells side by side, one neighbour of each at a time.
//!
//! Every lane computes [`link_force`](super::law::link_force) in its order. A cell's links are added in
//! ascending order of its neighbours, as link by link, and the force that a cell gets from a lower one is
//! exactly the opposite of the force computed for the other end.

#![allow(unsafe_code)]

use super::bands::Links;
use super::law::{Band, COINCIDENT, LinkForce, RIM};
use crate::backend::f32x8::F32x8;
use crate::model::{Model, Slices, range};
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

impl Links<'_, '_> {
    /// Residual and sum of w d^2 of the cells of a slice, which are at `here`, and all cells at `at`. `None`
    /// without forces or slices, or for another number of cells.
    #[inline(always)]
    pub fn of_slice<V: F32x8>(self, slice: usize, here: [V; 3], at: &[Cell]) -> Option<[V; 4]> {
        let Slices { weights, alphas, .. } = self.slices?;
        let (mut sum, void) = if weights.is_some() || !self.closed && alphas.is_some() {
            self.sums::<V, true>(slice, here, at)?
        } else {
            self.sums::<V, false>(slice, here, at)?
        };
        // A coincident pair in the slice: compute it link by link.
        if V::any(void) {
            sum = [V::splat(0.0); 4];
            for (sum, lanes) in sum.iter_mut().zip(&one_by_one(self.model, self.closed, slice, at))
            {
                *sum = V::load(lanes);
            }
        }
        Some(sum)
    }

    /// The sums, and where the direction of a link is undefined; `VARIED` if links differ.
    #[inline(always)]
    fn sums<V: F32x8, const VARIED: bool>(
        self,
        slice: usize,
        here: [V; 3],
        at: &[Cell],
    ) -> Option<([V; 4], V::Mask)> {
        let slices = self.slices.filter(|_| at.len() == self.model.cells())?;
        let (mut sum, mut law) = ([V::splat(0.0); 4], Law::uniform(self.even));
        let mut void = V::splat(0.0).below(V::splat(0.0));
        for group in range(slices.rows, slice) {
            // SAFETY: the last row start is the number of groups; a model's slices name only its
            // cells, and `at` has as many.
            let (there, l0) = unsafe {
                let ids = slices.neighbours.get_unchecked(group);
                (V::gather(at, ids), V::load(slices.lengths.get_unchecked(group)))
            };
            if VARIED {
                let alphas = slices.alphas.filter(|_| !self.closed);
                let otherwise = if self.closed { 0.0 } else { self.model.alpha() };
                let alpha = of_group(alphas, group, otherwise);
                law = Law::varied(alpha, of_group(slices.weights, group, 1.0));
            }
            add_links(&law, here, there, l0, &mut void, &mut sum);
        }
        Some((sum, void))
    }
}

/// The sums of a slice with coincident cells, link by link.
#[cold]
#[inline(never)]
fn one_by_one(model: &Model<'_>, closed: bool, slice: usize, at: &[Cell]) -> [[f32; LANES]; 4] {
    let (links, mut lanes) = (Links::of(model, closed), [[0.0_f32; LANES]; 4]);
    // Positions unclamped, also beyond K: a stage of a super-step may be there.
    let at = |cell: usize| at.get(cell).map_or([0.0; 3], |v| v.xyz());
    for lane in 0..LANES {
        let cell = slice * LANES + lane;
        for (link, other) in model.neighbours(cell) {
            let on: Option<LinkForce> = links.force_at(&at, link, cell, other);
            let Some(LinkForce { force: [x, y, z], wd2 }) = on else { continue };
            for (lanes, term) in lanes.iter_mut().zip([x, y, z, wd2]) {
                if let Some(sum) = lanes.get_mut(lane) {
                    *sum += term;
                }
            }
        }
    }
    lanes
}

/// Bands and weights of eight links.
#[derive(Clone, Copy)]
struct Law<V> {
    low: V,
    high: V,
    low_squared: V,
    high_squared: V,
    coincident: V,
    weight: Option<V>,
}

impl<V: F32x8> Law<V> {
    /// One band for all, weight 1.
    #[inline(always)]
    fn uniform(band: Band) -> Self {
        Self {
            low: V::splat(band.low),
            high: V::splat(band.high),
            low_squared: V::splat(band.low_squared),
            high_squared: V::splat(band.high_squared),
            coincident: V::splat(COINCIDENT),
            weight: None,
        }
    }

    /// The arithmetic of [`Band::new`].
    #[inline(always)]
    fn varied(alpha: V, weight: V) -> Self {
        let one = V::splat(1.0);
        let (low, high) = (one.minus(alpha), one.plus(alpha));
        Self {
            low,
            high,
            low_squared: low.times(low).times(V::splat(1.0 - RIM)),
            high_squared: high.times(high).times(V::splat(1.0 + RIM)),
            coincident: V::splat(COINCIDENT),
            weight: Some(weight),
        }
    }
}

/// The values of a group, or one value for all if they are not stored.
#[inline(always)]
fn of_group<V: F32x8>(values: Option<&[[f32; LANES]]>, group: usize, otherwise: f32) -> V {
    match values.and_then(|values| values.get(group)) {
        Some(values) => V::load(values),
        None => V::splat(otherwise),
    }
}

/// Adds the forces of eight links to the sums. `void` becomes true in the lane of a link with undefined
/// direction.
#[inline(always)]
fn add_links<V: F32x8>(
    law: &Law<V>,
    here: [V; 3],
    there: [V; 3],
    l0: V,
    void: &mut V::Mask,
    sum: &mut [V; 4],
) {
    let dx = there[0].minus(here[0]);
    let dy = there[1].minus(here[1]);
    let dz = there[2].minus(here[2]);
    let u2 = dx.times(dx).plus(dy.times(dy)).plus(dz.times(dz));
    let l02 = l0.times(l0);
    let above = u2.above(l02.times(law.high_squared));
    let taut = V::either(above, u2.below(l02.times(law.low_squared)));
    if !V::any(taut) {
        return;
    }
    *void = V::either(*void, u2.below(l02.times(law.coincident)));
    let u = u2.root();
    let d = u.minus(l0.times(V::select(above, law.high, law.low)));
    let wd = match law.weight {
        Some(weight) => weight.times(d),
        None => d,
    };
    let [x, y, z, wd2] = sum;
    *wd2 = wd2.plus(wd.times(d).keep(taut));
    let factor = wd.over(u.plus(u)).keep(taut);
    *x = x.plus(factor.times(dx));
    *y = y.plus(factor.times(dy));
    *z = z.plus(factor.times(dz));
}
