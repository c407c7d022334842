//! `f32`: the default.

use super::cell::{Cell, dot};
use super::two_float::{Lanes, Plain, TwoFloat};
use super::{Number, Sum};

impl Number for f32 {
    const NAME: &'static str = "f32";
    const ZERO: Self = 0.0;
    type Product = f32;
    type Sum = Plain;
    type WideSum = Lanes;

    #[inline(always)]
    fn from_single(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn single(self) -> f32 {
        self
    }

    #[inline(always)]
    fn double(self) -> f64 {
        f64::from(self)
    }

    #[inline(always)]
    fn word(self) -> u32 {
        self.to_bits()
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn opposite(self) -> Self {
        -self
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        Self::from_bits(self.to_bits() & 0x7fff_ffff)
    }

    #[inline(always)]
    fn singles(cells: &[Cell]) -> Option<&[Cell]> {
        Some(cells)
    }

    #[inline(always)]
    fn inner(a: [Self; 3], b: [Self; 3]) -> f32 {
        dot(a, b)
    }

    #[inline(always)]
    fn product_single(product: f32) -> f32 {
        product
    }
}

impl Sum<f32> for Lanes {
    #[inline(always)]
    fn add(&mut self, lane: usize, term: f32) {
        self.add_to(lane, term);
    }

    fn total(&self) -> TwoFloat {
        Self::total(self)
    }
}

impl Sum<f32> for Plain {
    #[inline(always)]
    fn add(&mut self, lane: usize, term: f32) {
        self.add_to(lane, term);
    }

    fn total(&self) -> TwoFloat {
        Self::total(self).into()
    }
}
