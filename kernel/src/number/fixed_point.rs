//! Fixed point for targets without an FPU: [`I8F24`], one unit = one mean link length.
//!
//! | quantity | format | why it does not overflow |
//! |---|---|---|
//! | coordinate | 8.24 bits, saturating | K is at most 63; differences stay below 128 |
//! | residual | 8.24 bits, its sum saturating once | see below |
//! | squared length | 16.48 bits, unsigned | three squares below 2^62 |
//! | products, energies | 24.40 bits, sums in 88.40 | at most 2^63 a cell or link |
//!
//! A saturated residual is shorter, never longer: the step it makes lowers the energy by at least
//! what is counted. Partial sums must not saturate, since the rest of a sum would then go beyond its
//! true value; by Cauchy's inequality a sum of |w d / 2| that reaches 128 needs a sum of w d^2 of
//! 4 * 128^2 / W, W at most 120, which the fourth lane shows by standing at its end. Such cells are
//! summed again in 64 bits. Products are rounded to nearest, lengths down by less than 2^-24.
//! Integer sums are exact, so their order does not matter. Steps of `euler` below 2^-25 vanish.

use fixed::types::I8F24;

use super::{Loops, Number, RangeError, Sum};
use crate::awake::SliceSet;
use crate::cell::{Cell, sub};
use crate::link::Pull;
use crate::model::Model;
use crate::pass::Links;
use crate::slice::cells_of;
use crate::two_float::TwoFloat;

/// Largest K.
const K_MAX: f32 = 63.0;
/// Largest mean weight of two linked cells, so that twice it fits.
const DEGREE_MAX: f32 = 60.0;
/// Smallest weight of a link, so that its inverse fits.
const WEIGHT_MIN: f32 = 1.0 / 64.0;
/// Below this squared length (2^-18 units, where it is known to one part in 64) a link has no
/// direction of its own.
const COINCIDENT: u64 = 1 << 12;
/// One unit.
const ONE: i32 = 1 << 24;

/// A sum of products, 88.40 bits: no body is large enough to reach its end.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Products(i128);

/// Saturates to the format.
#[inline(always)]
fn narrow(bits: i64) -> I8F24 {
    I8F24::from_bits(bits.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
}

/// 88.40 bits in single precision, twice.
fn two_float(bits: i128) -> TwoFloat {
    const UNIT: f32 = 1.0 / (1_u64 << 40) as f32;
    let hi = bits as f32;
    let lo = bits.wrapping_sub(hi as i128) as f32;
    TwoFloat { hi: hi * UNIT, lo: lo * UNIT }
}

impl Sum<i64> for Products {
    #[inline(always)]
    fn add(&mut self, _lane: usize, term: i64) {
        self.0 = self.0.wrapping_add(i128::from(term));
    }

    fn total(&self) -> TwoFloat {
        two_float(self.0)
    }
}

/// Ends of the band in rest lengths.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    low: I8F24,
    high: I8F24,
}

/// What a link outside its band does along its direction.
struct Excess {
    /// d, how far it is outside: 24 fraction bits.
    d: i64,
    /// Its length, or its rest length where the ends coincide.
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
    // Rest lengths and rest positions are rounded on their own.
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

/// What a link does, as wide as it may be: force in 24 fraction bits, w d^2 in 40.
struct Wide {
    force: [i64; 3],
    wd2: i64,
}

/// See [`Number::pull`].
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

impl Number for I8F24 {
    const NAME: &'static str = "fixed";
    const ZERO: Self = Self::ZERO;
    const HATS: bool = false;
    const GRAIN: f32 = 2.0;
    type Words = [u32; 1];
    type Product = i64;
    type Sum = Products;
    type Energy = Products;
    type Tally = Products;
    type Band = Band;

    /// By its bits: a target without an FPU takes a tenth of the instructions for it.
    #[inline(always)]
    fn from_single(value: f32) -> Self {
        let bits = value.to_bits();
        let (exponent, mantissa) = (bits >> 23 & 0xff, (bits & 0x7f_ffff | 0x80_0000) as i32);
        let magnitude = match exponent {
            134.. => i32::MAX,
            126..=133 => mantissa << (exponent - 126),
            101..=125 => (mantissa + (1 << (125 - exponent))) >> (126 - exponent),
            _ => 0,
        };
        Self::from_bits(if bits >> 31 == 0 { magnitude } else { -magnitude })
    }

    fn single(self) -> f32 {
        self.to_bits() as f32 / ONE as f32
    }

    fn double(self) -> f64 {
        f64::from(self.to_bits()) / f64::from(ONE)
    }

    #[inline(always)]
    fn words(self) -> [u32; 1] {
        [self.to_bits() as u32]
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.saturating_add(other)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.saturating_sub(other)
    }

    /// Rounded to nearest, halves up.
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let product = i64::from(self.to_bits()) * i64::from(other.to_bits());
        narrow((product + (1 << 23)) >> 24)
    }

    #[inline(always)]
    fn opposite(self) -> Self {
        self.saturating_neg()
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.saturating_abs()
    }

    #[inline(always)]
    fn inner(a: [Self; 3], b: [Self; 3]) -> i64 {
        let term = |a: Self, b: Self| (i64::from(a.to_bits()) * i64::from(b.to_bits())) >> 8;
        term(a[0], b[0]) + term(a[1], b[1]) + term(a[2], b[2])
    }

    fn product_single(product: i64) -> f32 {
        two_float(i128::from(product)).hi
    }

    #[inline(always)]
    fn mark(wd2: i64) -> Self {
        narrow((wd2 >> 16).saturating_add(1))
    }

    /// At both ends of the link, as the fourth lanes would.
    #[inline(always)]
    fn count(tally: &mut Products, wd2: i64) {
        tally.0 = tally.0.wrapping_add(2 * i128::from(wd2));
    }

    fn energy(_lanes: &Products, tally: Products) -> TwoFloat {
        tally.total()
    }

    #[inline(always)]
    fn energy_term(_lane: Self) -> i64 {
        0
    }

    fn band(alpha: f32) -> Band {
        let alpha = Self::from_single(alpha);
        Band { low: Self::ONE.minus(alpha), high: Self::ONE.plus(alpha) }
    }

    #[inline(always)]
    fn pull(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<Pull<Self>> {
        let Wide { force, wd2 } = wide(pi, pj, l0, w, band, rest_difference)?;
        Some(Pull { force: force.map(narrow), wd2 })
    }

    fn pull_single(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<Pull> {
        let Wide { force, wd2 } = wide(pi, pj, l0, w, band, rest_difference)?;
        let force = force.map(|bits| bits as f32 / ONE as f32);
        Some(Pull { force, wd2: Self::product_single(wd2) })
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
}

#[allow(private_interfaces)]
impl Loops for I8F24 {
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

/// The residual of a cell, its sum saturating in the end alone.
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
        let rest = || sub(links.model.rest_position(j), links.model.rest_position(i));
        let Some(pull) = wide(y(pi.xyz()), y(pj.xyz()), l0, w, band, rest) else { continue };
        for (sum, force) in sum.iter_mut().zip(pull.force) {
            *sum += if cell == i { force } else { -force };
        }
    }
    sum.map(narrow)
}
