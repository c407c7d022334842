//! Sums to twice the precision of `f32`, in an order that every loop shape keeps.
//!
//! A two-float is an unevaluated sum `hi + lo` with `|lo|` at most half a unit in the last place
//! of `hi`. Under load and near equilibrium the decrease of energy in a sweep falls below the
//! rounding of one `f32`; the guard compares energies as two-floats.
//!
//! Source: D. E. Knuth, The Art of Computer Programming 2, section 4.2.2 (error-free addition).

use crate::number::kept::kept;

/// Number of interleaved partial sums; part of the bit-exact definition, not the machine's width.
pub const LANES: usize = 8;

/// Eight values of `f32`.
pub type Eight = [f32; LANES];

kept! {
    /// The unevaluated sum `hi + lo`.
    ///
    /// ```
    /// use chaincell_kernel::number::two_float::TwoFloat;
    ///
    /// let energy = TwoFloat::from(1.0).plus(TwoFloat::from(1e-9)); // one `f32` would lose the second
    /// assert!(energy.exceeds(TwoFloat::from(1.0)));
    /// assert_eq!(energy.minus(TwoFloat::from(1.0)).hi, 1e-9);
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub struct TwoFloat {
        /// Leading part.
        pub hi: f32,
        /// Trailing part.
        pub lo: f32,
    }
}

/// Returns `a + b` as rounded, and its exact rounding error.
#[inline(always)]
fn two_sum(a: f32, b: f32) -> (f32, f32) {
    let sum = a + b;
    let of_b = sum - a;
    let of_a = sum - of_b;
    (sum, (a - of_a) + (b - of_b))
}

impl TwoFloat {
    /// Zero.
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    /// `self + other`, error about 2^-46 of |self| + |other|.
    #[must_use]
    #[inline]
    pub fn plus(self, other: Self) -> Self {
        let (sum, error) = two_sum(self.hi, other.hi);
        let (hi, lo) = two_sum(sum, error + (self.lo + other.lo));
        Self { hi, lo }
    }

    /// `self - other`.
    #[must_use]
    #[inline]
    pub fn minus(self, other: Self) -> Self {
        self.plus(Self { hi: -other.hi, lo: -other.lo })
    }

    /// `self` times a power of two, exactly.
    #[must_use]
    #[inline]
    pub fn times_power_of_two(self, factor: f32) -> Self {
        Self { hi: self.hi * factor, lo: self.lo * factor }
    }

    /// Returns true if `self > other`.
    #[must_use]
    #[inline]
    pub fn exceeds(self, other: Self) -> bool {
        self.minus(other).hi > 0.0
    }

    /// The smaller of the two.
    #[must_use]
    #[inline]
    pub fn min(self, other: Self) -> Self {
        if self.exceeds(other) { other } else { self }
    }
}

impl From<TwoFloat> for f64 {
    fn from(sum: TwoFloat) -> Self {
        Self::from(sum.hi) + Self::from(sum.lo)
    }
}

impl From<f32> for TwoFloat {
    fn from(value: f32) -> Self {
        Self { hi: value, lo: 0.0 }
    }
}

/// Eight interleaved two-float sums: term `i` goes to lane `i mod 8`, in ascending order.
#[derive(Debug, Clone, Copy, Default)]
pub struct Lanes {
    pub(crate) hi: [f32; LANES],
    pub(crate) lo: [f32; LANES],
}

impl Lanes {
    /// Empty sums, all +0.0.
    pub const ZERO: Self = Self { hi: [0.0; LANES], lo: [0.0; LANES] };

    /// Adds one cell's term.
    #[inline(always)]
    pub(crate) fn add_to(&mut self, lane: usize, term: f32) {
        if let (Some(hi), Some(lo)) = (self.hi.get_mut(lane % LANES), self.lo.get_mut(lane % LANES))
        {
            let (sum, error) = two_sum(*hi, term);
            *hi = sum;
            *lo += error;
        }
    }

    /// Returns the sum of the lanes, in a fixed tree: (0+4, 1+5, 2+6, 3+7), then (+2), then (+1).
    #[must_use]
    pub fn total(&self) -> TwoFloat {
        let [h0, h1, h2, h3, h4, h5, h6, h7] = self.hi;
        let [l0, l1, l2, l3, l4, l5, l6, l7] = self.lo;
        let pair = |ha, la, hb, lb| TwoFloat { hi: ha, lo: la }.plus(TwoFloat { hi: hb, lo: lb });
        let (a, b) = (pair(h0, l0, h4, l4), pair(h1, l1, h5, l5));
        let (c, d) = (pair(h2, l2, h6, l6), pair(h3, l3, h7, l7));
        a.plus(c).plus(b.plus(d))
    }
}

/// Eight interleaved sums in single precision, lanes and tree as in [`Lanes`]: for products that control a
/// step and certify no energy.
#[derive(Debug, Clone, Copy, Default)]
pub struct Plain(pub(crate) [f32; LANES]);

impl Plain {
    /// Empty sums, all +0.0.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// Adds one cell's term.
    #[inline(always)]
    pub(crate) fn add_to(&mut self, lane: usize, term: f32) {
        if let Some(slot) = self.0.get_mut(lane % LANES) {
            *slot += term;
        }
    }

    /// Returns the sum of the lanes.
    #[must_use]
    pub fn total(&self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.0;
        ((a + e) + (c + g)) + ((b + f) + (d + h))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn keeps_what_a_single_float_loses() {
        let big = TwoFloat::from(1.0e6);
        let sum = (0..1000).fold(big, |sum, _| sum.plus(1.0e-3.into()));
        let kept = f64::from(sum) - 1.0e6;
        assert!((kept - 1.0).abs() < 1e-6, "{kept}");
        assert_eq!(1.0e6_f32 + 1.0e-3, 1.0e6);
        assert!(sum.exceeds(big) && !big.exceeds(sum) && sum.min(big) == big);
    }

    #[test]
    fn lanes_agree_with_double_precision() {
        let mut lanes = Lanes::ZERO;
        let mut exact = 0.0_f64;
        for block in 0..500_u16 {
            let terms: [f32; LANES] = core::array::from_fn(|lane| {
                let n = f32::from(block) * 8.0 + lane as f32;
                1.0 / (1.0 + n) * if lane % 3 == 0 { 1.0e4 } else { 1.0 }
            });
            exact += terms.iter().map(|&term| f64::from(term)).sum::<f64>();
            for (lane, &term) in terms.iter().enumerate() {
                lanes.add_to(lane, term);
            }
        }
        let total = lanes.total();
        let error = f64::from(total) - exact;
        assert!(error.abs() < 1e-12 * exact, "{error:e}");
    }
}
