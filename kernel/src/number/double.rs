//! `f64`: what the network would do with numbers as good as exact; for references and tests.

use super::two_float::{LANES, TwoFloat};
use super::{Number, Sum};

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

impl Number for f64 {
    const NAME: &'static str = "f64";
    const ZERO: Self = 0.0;
    type Words = [u32; 2];
    type Product = f64;
    type Sum = Doubles;
    type WideSum = Doubles;

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
}
