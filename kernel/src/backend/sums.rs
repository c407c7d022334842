//! Adding eight terms at a time to interleaved sums.

use super::f32x8::F32x8;
use crate::number::two_float::{Lanes, Plain};

impl Lanes {
    /// Adds the terms of up to eight consecutive cells, the first of them in lane 0.
    #[inline(always)]
    pub(crate) fn add<V: F32x8>(&mut self, terms: V) {
        let (hi, lo) = (V::load(&self.hi), V::load(&self.lo));
        let sum = hi.plus(terms);
        let of_terms = sum.minus(hi);
        let of_hi = sum.minus(of_terms);
        let error = hi.minus(of_hi).plus(terms.minus(of_terms));
        sum.store(&mut self.hi);
        lo.plus(error).store(&mut self.lo);
    }
}

impl Plain {
    /// Adds the terms of up to eight consecutive cells, the first of them in lane 0.
    #[inline(always)]
    pub(crate) fn add<V: F32x8>(&mut self, terms: V) {
        V::load(&self.0).plus(terms).store(&mut self.0);
    }
}
