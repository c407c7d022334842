//! Fixed point for targets without an FPU: [`I8F24`], one unit = one mean link length.
//!
//! | quantity | format |
//! |---|---|
//! | number | 8.24 bits, saturating |
//! | product | 24.40 bits, rounded down; sums of them in 88.40 bits |
//!
//! A product of two numbers is rounded to nearest when it is stored as a number. Integer sums are exact,
//! so their order does not matter.

use fixed::types::I8F24;

use super::two_float::TwoFloat;
use super::{Number, Sum};

/// One unit.
pub(crate) const ONE: i32 = 1 << 24;

/// A sum of products, 88.40 bits: no body is large enough to overflow it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Products(pub(crate) i128);

/// Saturates to the format.
#[inline(always)]
pub(crate) fn narrow(bits: i64) -> I8F24 {
    I8F24::from_bits(bits.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32)
}

/// Returns the two-float of 88.40 bits.
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

impl Number for I8F24 {
    const NAME: &'static str = "fixed";
    const ZERO: Self = Self::ZERO;
    type Product = i64;
    type Sum = Products;
    type WideSum = Products;

    /// This works on the bits, which takes a tenth of the instructions on a target without an FPU.
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
    fn word(self) -> u32 {
        self.to_bits() as u32
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
}
