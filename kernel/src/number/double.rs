//! `f64`: what the network would do with numbers as good as exact; for references and tests.

use super::{Loops, Number, RangeError, Sum};
use crate::link::{COINCIDENT, Pull};
use crate::model::Model;
use crate::two_float::{LANES, TwoFloat};

/// Sums by lane.
#[derive(Default)]
pub struct Doubles([f64; LANES]);

impl Sum<f64> for Doubles {
    #[inline(always)]
    fn add(&mut self, lane: usize, term: f64) {
        if let Some(slot) = self.0.get_mut(lane % LANES) {
            *slot += term;
        }
    }

    fn total(&self) -> TwoFloat {
        let [a, b, c, d, e, f, g, h] = self.0;
        let sum = ((a + e) + (c + g)) + ((b + f) + (d + h));
        let hi = sum as f32;
        TwoFloat { hi, lo: (sum - f64::from(hi)) as f32 }
    }
}

/// The band in rest lengths, and of the squared lengths; widened by the rounding of rest lengths
/// that are stored in single precision.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    low: f64,
    high: f64,
}

/// Rest lengths are stored in single precision.
const RIM: f64 = 4.0 / 16_777_216.0;

impl Number for f64 {
    const NAME: &'static str = "f64";
    const ZERO: Self = 0.0;
    const HATS: bool = false;
    type Words = [u32; 2];
    type Product = f64;
    type Sum = Doubles;
    type Energy = Doubles;
    type Tally = ();
    type Band = Band;

    fn from_single(value: f32) -> Self {
        Self::from(value)
    }

    fn single(self) -> f32 {
        self as f32
    }

    fn double(self) -> f64 {
        self
    }

    fn words(self) -> [u32; 2] {
        [self.to_bits() as u32, (self.to_bits() >> 32) as u32]
    }

    fn plus(self, other: Self) -> Self {
        self + other
    }

    fn minus(self, other: Self) -> Self {
        self - other
    }

    fn times(self, other: Self) -> Self {
        self * other
    }

    fn opposite(self) -> Self {
        -self
    }

    fn magnitude(self) -> Self {
        Self::from_bits(self.to_bits() & !(1 << 63))
    }

    fn inner(a: [Self; 3], b: [Self; 3]) -> f64 {
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    fn product_single(product: f64) -> f32 {
        product as f32
    }

    fn mark(wd2: f64) -> Self {
        wd2
    }

    fn count((): &mut (), _wd2: f64) {}

    fn energy(lanes: &Doubles, (): ()) -> TwoFloat {
        lanes.total()
    }

    fn energy_term(lane: Self) -> f64 {
        lane
    }

    fn band(alpha: f32) -> Band {
        Band { low: 1.0 - f64::from(alpha), high: 1.0 + f64::from(alpha) }
    }

    fn pull(
        pi: [Self; 3],
        pj: [Self; 3],
        l0: f32,
        w: f32,
        band: Band,
        rest_difference: impl FnOnce() -> [f32; 3],
    ) -> Option<Pull<Self>> {
        let difference = [pj[0] - pi[0], pj[1] - pi[1], pj[2] - pi[2]];
        let l0 = f64::from(l0);
        let u = libm::sqrt(Self::inner(difference, difference));
        let d = if u > l0 * band.high * (1.0 + RIM) {
            u - l0 * band.high
        } else if u < l0 * band.low * (1.0 - RIM) {
            u - l0 * band.low
        } else {
            return None;
        };
        let wd = f64::from(w) * d;
        let force = if u * u < f64::from(COINCIDENT) * l0 * l0 {
            rest_difference().map(|x| wd / (2.0 * l0) * f64::from(x))
        } else {
            difference.map(|x| wd / (2.0 * u) * x)
        };
        Some(Pull { force, wd2: wd * d })
    }

    fn admits(_model: &Model<'_>) -> Result<(), RangeError> {
        Ok(())
    }
}

impl Loops for f64 {}
