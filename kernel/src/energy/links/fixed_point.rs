//! The arithmetic of a link in fixed point ([`I8F24`]), one unit = one mean link length.
//!
//! | quantity | format | why it does not overflow |
//! |---|---|---|
//! | coordinate | 8.24 bits, saturating | K is at most 63; differences stay below 128 |
//! | residual | 8.24 bits, its sum saturating once | see below |
//! | squared length | 16.48 bits, unsigned | three squares below 2^62 |
//! | w d^2 | 24.40 bits, sums in 88.40 | at most 2^63 per link |
//!
//! A saturated residual is shorter, never longer: its step lowers the energy by at least the counted amount.
//! Partial sums must not saturate, since the rest of a sum would then go beyond its true value. By Cauchy's
//! inequality a sum of |w d / 2| that reaches 128 needs a sum of w d^2 of 4 * 128^2 / W, W at most 120; then
//! the fourth lane is saturated. Such cells are summed again in 64 bits. Lengths are rounded down by less
//! than 2^-24. Steps of `euler` below 2^-25 vanish.

use fixed::types::I8F24;

use super::bands::{Links, rest_difference};
use super::law::LinkForce;
use super::number::LinkNumber;
use super::range::RangeError;
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::Cell;
use crate::number::fixed_point::{ONE, narrow};

/// Largest K.
const K_MAX: f32 = 63.0;
/// Largest mean weight of two linked cells; twice this fits the format.
const DEGREE_MAX: f32 = 60.0;
/// Smallest weight of a link; its inverse fits the format.
const WEIGHT_MIN: f32 = 1.0 / 64.0;
/// Below this squared length (2^-18 units, where it is known to one part in 64) a link's direction is
/// undefined.
const COINCIDENT: u64 = 1 << 12;
/// Ends of the band in rest lengths.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    low: I8F24,
    high: I8F24,
}

/// Excess of a link outside its band, along its direction.
struct Excess {
    /// d, the distance to the band: 24 fraction bits.
    d: i64,
    /// Its length, or its rest length if the ends coincide.
    along: u64,
    coincident: bool,
}

/// d of a link with the squared length `u2`.
#[inline(always)]
fn excess(u2: u64, l0: I8F24, band: Band) -> Option<Excess> {
    let bits = |length: I8F24| length.to_bits().unsigned_abs();
    // Unsigned, since a wide band reaches beyond the largest number, and links may be that long.
    let end = |of: I8F24| {
        let product = u64::from(bits(l0)) * u64::from(bits(of));
        u32::try_from((product + (1 << 23)) >> 24).unwrap_or(u32::MAX)
    };
    // Rest lengths and rest positions are rounded independently.
    let rim = 4 + (bits(l0) >> 22);
    let (low, high) = (end(band.low), end(band.high));
    let square = |length: u32| u64::from(length) * u64::from(length);
    let limit = if u2 > square(high.saturating_add(rim)) {
        high
    } else if u2 < square(low.saturating_sub(rim)) {
        low
    } else {
        return None;
    };
    let u = u2.isqrt();
    let d = u as i64 - i64::from(limit);
    let coincident = u2 < COINCIDENT && d < 0;
    let along = if coincident { u64::from(bits(l0)) } else { u };
    Some(Excess { d, along: if along > 0 { along } else { 1 }, coincident })
}

/// Force and energy of a link in wide formats: force in 24 fraction bits, w d^2 in 40.
struct Wide {
    force: [i64; 3],
    wd2: i64,
}

/// See [`LinkNumber::link_force`].
#[inline(always)]
fn wide(
    pi: [I8F24; 3],
    pj: [I8F24; 3],
    l0: f32,
    w: f32,
    band: Band,
    rest_difference: impl FnOnce() -> [f32; 3],
) -> Option<Wide> {
    let difference = [pj[0].minus(pi[0]), pj[1].minus(pi[1]), pj[2].minus(pi[2])];
    let square = |x: I8F24| {
        let x = u64::from(x.to_bits().unsigned_abs());
        x * x
    };
    let [x, y, z] = difference.map(square);
    let l0 = I8F24::from_single(l0);
    let Excess { d, along, coincident } = excess(x + y + z, l0, band)?;
    let way = if coincident { rest_difference().map(I8F24::from_single) } else { difference };
    // d / 2 u, 30 fraction bits; |x| is at most the length that d is divided by.
    let factor = (d << 29) / along as i64;
    let force = way.map(|x| (i64::from(x.to_bits()) * factor + (1 << 29)) >> 30);
    let length = d.unsigned_abs().min(u64::from(u32::MAX));
    let d2 = ((length * length) >> 8) as i64;
    if w == 1.0 {
        return Some(Wide { force, wd2: d2 });
    }
    let w = i64::from(I8F24::from_single(w).to_bits());
    let wd2 = (i128::from(d2) * i128::from(w)) >> 24;
    let wd2 = wd2.min(i128::from(i64::MAX)) as i64;
    Some(Wide { force: force.map(|f| (f * w + (1 << 23)) >> 24), wd2 })
}

#[allow(private_interfaces)]
impl LinkNumber for I8F24 {
    const GRAIN: f32 = 2.0;
    type Band = Band;

    fn band(alpha: f32) -> Band {
        let alpha = Self::from_single(alpha);
        Band { low: Self::ONE.minus(alpha), high: Self::ONE.plus(alpha) }
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
        let Wide { force, wd2 } = wide(pi, pj, l0, w, band, rest_difference)?;
        Some(LinkForce { force: force.map(narrow), wd2 })
    }

    fn link_force_single(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<LinkForce> {
        let Wide { force, wd2 } = wide(pi, pj, l0, w, band, rest_difference)?;
        let force = force.map(|bits| bits as f32 / ONE as f32);
        Some(LinkForce { force, wd2: Self::product_single(wd2) })
    }

    fn admits(model: &Model<'_>) -> Result<(), RangeError> {
        let (k, degree) = (model.saturation(), model.degree_bound);
        if k > K_MAX {
            Err(RangeError::Saturation { k, max: K_MAX })
        } else if degree > DEGREE_MAX {
            Err(RangeError::Degree { degree, max: DEGREE_MAX })
        } else if model.weight_min < WEIGHT_MIN {
            Err(RangeError::Weight { weight: model.weight_min, min: WEIGHT_MIN })
        } else {
            Ok(())
        }
    }

    fn mend(
        links: Links<'_, '_>,
        awake: &SliceSet,
        v: &[Cell<Self>],
        residual: &mut [Cell<Self>],
        y: impl Fn([Self; 3]) -> [Self; 3],
    ) {
        let cells = links.model.cells();
        for slice in awake.iter(links.model.slice_count()) {
            for cell in cells_of(slice, cells) {
                if let Some(r) = residual.get_mut(cell)
                    && r.w() == Self::MAX
                {
                    let [x, y, z] = sum(links, v, cell, &y);
                    *r = Cell([x, y, z, r.w()]);
                }
            }
        }
    }
}

/// The residual of a cell; its sum saturates only at the end.
#[cold]
fn sum(
    links: Links<'_, '_>,
    v: &[Cell<I8F24>],
    cell: usize,
    y: impl Fn([I8F24; 3]) -> [I8F24; 3],
) -> [I8F24; 3] {
    let mut sum = [0_i64; 3];
    for (link, other) in links.model.neighbours(cell) {
        let (i, j) = if cell < other { (cell, other) } else { (other, cell) };
        let (Some(pi), Some(pj), Some(&l0)) =
            (v.get(i), v.get(j), links.model.rest_length.get(link))
        else {
            continue;
        };
        let (w, band) = (links.model.link_weight(link), I8F24::band(links.alpha(link)));
        let rest = || rest_difference(links.model, i, j);
        let Some(of) = wide(y(pi.xyz()), y(pj.xyz()), l0, w, band, rest) else { continue };
        for (sum, force) in sum.iter_mut().zip(of.force) {
            *sum += if cell == i { force } else { -force };
        }
    }
    sum.map(narrow)
}
