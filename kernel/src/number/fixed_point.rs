//! Fixed point for targets without an FPU: [`I8F24`], one unit = one mean link length.
//!
//! | quantity | format | why it does not overflow |
//! |---|---|---|
//! | coordinate, residual | 8.24 bits, saturating | K is at most 63; differences stay below 128 |
//! | squared length | 16.48 bits, unsigned | three squares below 2^62 |
//! | products, energies | 24.40 bits, saturating | sums over the cells are at most 8 `E_max` |
//!
//! A saturated coordinate or residual is shorter, never longer: the step it makes lowers the
//! energy by at least what is counted. Products are rounded to nearest, lengths down by less than
//! 2^-24. Integer sums are exact, so their order does not matter.

use fixed::types::I8F24;

use super::{Loops, Number, RangeError, Sum};
use crate::link::Pull;
use crate::model::Model;
use crate::two_float::TwoFloat;

/// Largest K.
const K_MAX: f32 = 63.0;
/// Largest mean weight of two linked cells, so that twice it fits.
const DEGREE_MAX: f32 = 60.0;
/// Smallest weight of a link, so that its inverse fits.
const WEIGHT_MIN: f32 = 1.0 / 64.0;
/// Largest energy: an eighth of what the sums carry.
const ENERGY_MAX: f32 = 1.0e6;
/// Below this squared length (2^-18 units, where it is known to one part in 64) a link has no
/// direction of its own.
const COINCIDENT: u64 = 1 << 12;
/// One unit.
const ONE: i32 = 1 << 24;

/// A sum of products, 24.40 bits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Products(i64);

/// Saturates to the format.
#[inline(always)]
fn narrow(bits: i64) -> I8F24 {
    I8F24::from_bits(bits.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
}

/// 24.40 bits in single precision, twice.
fn two_float(bits: i64) -> TwoFloat {
    const UNIT: f32 = 1.0 / (1_u64 << 40) as f32;
    let hi = bits as f32;
    let lo = bits.saturating_sub(hi as i64) as f32;
    TwoFloat { hi: hi * UNIT, lo: lo * UNIT }
}

impl Sum<i64> for Products {
    #[inline(always)]
    fn add(&mut self, _lane: usize, term: i64) {
        self.0 = self.0.saturating_add(term);
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
    let coincident = u2 < COINCIDENT;
    let along = if coincident { u64::from(bits(l0)) } else { u };
    Some(Excess { d, along: if along > 0 { along } else { 1 }, coincident })
}

impl Number for I8F24 {
    const NAME: &'static str = "fixed";
    const ZERO: Self = Self::ZERO;
    const HATS: bool = false;
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
        two_float(product).hi
    }

    #[inline(always)]
    fn mark(wd2: i64) -> Self {
        narrow((wd2 >> 16).saturating_add(1))
    }

    /// At both ends of the link, as the fourth lanes would.
    #[inline(always)]
    fn count(tally: &mut Products, wd2: i64) {
        tally.add(0, wd2.saturating_mul(2));
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
        let difference = [pj[0].minus(pi[0]), pj[1].minus(pi[1]), pj[2].minus(pi[2])];
        let square = |x: Self| {
            let x = u64::from(x.to_bits().unsigned_abs());
            x * x
        };
        let [x, y, z] = difference.map(square);
        let l0 = Self::from_single(l0);
        let Excess { d, along, coincident } = excess(x + y + z, l0, band)?;
        let way = if coincident { rest_difference().map(Self::from_single) } else { difference };
        // d / 2 u, 30 fraction bits.
        let factor = (d << 29) / along as i64;
        let part = |x: Self| {
            // |x| is at most the length that d was divided by.
            narrow((i64::from(x.to_bits()) * factor + (1 << 29)) >> 30)
        };
        let length = d.unsigned_abs().min(u64::from(u32::MAX));
        let d2 = ((length * length) >> 8) as i64;
        let force = way.map(part);
        if w == 1.0 {
            return Some(Pull { force, wd2: d2 });
        }
        let w = Self::from_single(w);
        let wd2 = (i128::from(d2) * i128::from(w.to_bits())) >> 24;
        let wd2 = wd2.min(i128::from(i64::MAX)) as i64;
        Some(Pull { force: force.map(|f| f.times(w)), wd2 })
    }

    fn admits(model: &Model<'_>) -> Result<(), RangeError> {
        let (k, degree) = (model.saturation(), model.degree_bound);
        if k > K_MAX {
            Err(RangeError::Saturation { k, max: K_MAX })
        } else if degree > DEGREE_MAX {
            Err(RangeError::Degree { degree, max: DEGREE_MAX })
        } else if model.weight_min < WEIGHT_MIN {
            Err(RangeError::Weight { weight: model.weight_min, min: WEIGHT_MIN })
        } else if model.energy_max() > ENERGY_MAX {
            Err(RangeError::Energy { energy: model.energy_max(), max: ENERGY_MAX })
        } else {
            Ok(())
        }
    }
}

impl Loops for I8F24 {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::rest_length;
    use proptest::prelude::*;

    proptest! {
        /// Every bit pattern of a single, those of its range ten times as often.
        #[test]
        fn single_precision_is_rounded_to_nearest(
            value in prop_oneof![10 => -130.0_f32..130.0, 1 => any::<u32>().prop_map(f32::from_bits)],
        ) {
            prop_assume!(!value.is_nan());
            let exact = f64::from(value) * f64::from(ONE);
            let nearest = exact.round().clamp(f64::from(-i32::MAX), f64::from(i32::MAX));
            prop_assert_eq!(f64::from(I8F24::from_single(value).to_bits()), nearest);
        }

        /// The rest length is inside its own band for every alpha, up to the largest K.
        #[test]
        fn rest_is_slack(a in prop::array::uniform3(-31.5_f32..31.5),
                         b in prop::array::uniform3(-31.5_f32..31.5), alpha in 0.0_f32..1.0) {
            let l0 = rest_length(a, b);
            prop_assume!(l0 > 1e-6);
            let [pi, pj] = [a, b].map(crate::cell::from_single::<I8F24>);
            for alpha in [0.0, alpha] {
                let pull = I8F24::pull(pi, pj, l0, 1.0, I8F24::band(alpha), || [l0, 0.0, 0.0]);
                prop_assert_eq!(pull, None);
            }
        }
    }

    #[test]
    fn a_wide_band_reaches_beyond_the_largest_number() {
        let (near, far) = ([-45.0_f32; 3], [45.0_f32; 3]);
        let [pi, pj] = [near, far].map(crate::cell::from_single::<I8F24>);
        let pull = |l0| I8F24::pull(pi, pj, l0, 1.0, I8F24::band(0.9), || [l0, 0.0, 0.0]);
        // 156 lies within 10 to 190, and is 4 beyond 152.
        assert_eq!(pull(100.0), None);
        let expected = (155.8846 - 152.0_f32).powi(2);
        let wd2 = I8F24::product_single(pull(80.0).unwrap().wd2);
        assert!((wd2 - expected).abs() < 1e-3, "{wd2} {expected}");
    }

    #[test]
    fn the_softest_link_of_the_range_has_its_inverse() {
        assert_eq!(I8F24::from_single(1.0 / WEIGHT_MIN).double(), 64.0);
        assert_eq!(I8F24::from_single(127.0).double(), 127.0);
        for (far, bits) in [(128.0, i32::MAX), (f32::INFINITY, i32::MAX), (-1e30, -i32::MAX)] {
            assert_eq!(I8F24::from_single(far).to_bits(), bits);
        }
    }
}
