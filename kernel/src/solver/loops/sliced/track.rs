//! The loops of `track` over slices: its inner products and its update.

use crate::backend::Work;
use crate::backend::f32x8::F32x8;
use crate::backend::slices::{eight, eight_or_zero, eight_values, put_pairs};
use crate::model::Model;
use crate::number::cell::Cell;
use crate::number::two_float::{Lanes, Plain, TwoFloat};
use crate::solver::awake::Awake;
use crate::solver::loops::{Moved, Points};
use crate::terms::sliced::Reduce;

/// The sums of a pass: sum of w d^2, r . r / W, r . s, r . `z_last`.
pub(crate) struct Sums<'a, 'm> {
    model: &'a Model<'m>,
    published: &'a [Cell],
    before: &'a [Cell],
    energy: Lanes,
    products: [Plain; 3],
}

impl<'a, 'm> Sums<'a, 'm> {
    pub fn new(model: &'a Model<'m>, published: &'a [Cell], before: &'a [Cell]) -> Self {
        Self { model, published, before, energy: Lanes::ZERO, products: [Plain::ZERO; 3] }
    }

    /// Energy in internal units, and the products.
    pub fn totals(&self) -> [TwoFloat; 4] {
        let [squared, way, direction] = self.products.map(|sum| sum.total().into());
        [self.energy.total().times_power_of_two(0.125), squared, way, direction]
    }
}

impl Reduce for Sums<'_, '_> {
    #[inline(always)]
    fn slice<V: F32x8>(&mut self, slice: usize, at: [V; 3], [x, y, z, wd2]: [V; 4]) {
        let (mut here, mut there) = ([Cell::ZERO; 8], [Cell::ZERO; 8]);
        let published = V::transposed(eight(self.published, slice, &mut here));
        let before = V::transposed(eight(self.before, slice, &mut there));
        let m = V::load(&eight_values(self.model.mobility, slice));
        let squared = x.times(x.times(m)).plus(y.times(y.times(m))).plus(z.times(z.times(m)));
        let way = x
            .times(at[0].minus(before[0]))
            .plus(y.times(at[1].minus(before[1])))
            .plus(z.times(at[2].minus(before[2])));
        let direction = x
            .times(published[0].minus(before[0]))
            .plus(y.times(published[1].minus(before[1])))
            .plus(z.times(published[2].minus(before[2])));
        self.energy.add(wd2);
        for (sum, term) in self.products.iter_mut().zip([squared, way, direction]) {
            sum.add(term);
        }
    }
}

/// The update of awake slices without a coarse level.
pub(crate) struct Step<'a, 'b, 'm> {
    pub model: &'a Model<'m>,
    pub awake: &'a Awake,
    pub points: &'a mut Points<'b, f32>,
    pub factors: [f32; 2],
    pub moved: &'a mut Moved,
}

impl Work for Step<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let [alpha, beta] = self.factors.map(|factor| V::splat(factor));
        let points = self.points;
        let (zero, least) = (V::splat(0.0), V::splat(f32::from_bits(1)));
        let mut peak = zero;
        for slice in self.awake.set.iter(self.model.slice_count()) {
            let mut buffers = [[Cell::ZERO; 8]; 3];
            let [here, there, other] = &mut buffers;
            let residual = eight_or_zero(points.residual, slice, here);
            let at = eight_or_zero(points.at, slice, there);
            let before = eight_or_zero(points.before, slice, other);
            let mobility = eight_values(self.model.mobility, slice);
            let (mut last, mut next, mut ahead) = ([zero; 4], [zero; 4], [zero; 4]);
            let mut started = zero;
            let slots = last.iter_mut().zip(&mut next).zip(&mut ahead);
            for (pair, ((last, next), ahead)) in slots.enumerate() {
                let z = V::pair(residual, pair).times(V::spread(&mobility, pair)).positions();
                let y = V::pair(at, pair);
                let way = y.minus(V::pair(before, pair));
                *last = y;
                *next = y.plus(z);
                *ahead = y.plus(alpha.times(z)).plus(beta.times(way));
                // The neighbours of cells that moved before are awake.
                let still = zero.larger_magnitude(way).below(least);
                let moves = zero.larger_magnitude(ahead.minus(y)).larger_magnitude(next.minus(y));
                started = started.larger_magnitude(moves.keep(still));
                peak = peak.larger_magnitude(*next).larger_magnitude(*ahead);
            }
            put_pairs(points.published, slice, next);
            put_pairs(points.before, slice, last);
            put_pairs(points.at, slice, ahead);
            if V::any(started.above(zero)) && !self.awake.spread.contains(slice) {
                self.moved.slices.insert(slice);
            }
        }
        self.moved.reach(peak, self.model.saturation());
    }
}
