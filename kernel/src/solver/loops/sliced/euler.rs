//! The loop of `euler` over slices.

use crate::backend::Work;
use crate::backend::f32x8::F32x8;
use crate::backend::slices::{eight_or_zero, eight_values, put_pairs};
use crate::model::Model;
use crate::number::cell::Cell;
use crate::solver::awake::Awake;
use crate::solver::loops::Moved;

/// v += step r of the free cells in awake slices.
pub(crate) struct Step<'a, 'm> {
    pub model: &'a Model<'m>,
    pub awake: &'a Awake,
    pub state: &'a mut [Cell],
    pub residual: &'a [Cell],
    pub step: f32,
    pub moved: &'a mut Moved,
}

impl Work for Step<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let (step, zero) = (V::splat(self.step), V::splat(0.0));
        let mut peak = zero;
        for slice in self.awake.set.iter(self.model.slice_count()) {
            let (mut here, mut there) = ([Cell::ZERO; 8], [Cell::ZERO; 8]);
            let residual = eight_or_zero(self.residual, slice, &mut here);
            let state = eight_or_zero(self.state, slice, &mut there);
            let mobility = eight_values(self.model.mobility, slice);
            let mut pairs = [zero; 4];
            let mut changed = zero;
            for (pair, slot) in pairs.iter_mut().enumerate() {
                let v = V::pair(state, pair);
                let free = V::spread(&mobility, pair).above(zero);
                let way = V::pair(residual, pair).times(step).keep(free).positions();
                *slot = v.plus(way);
                changed = changed.larger_magnitude(slot.minus(v));
                peak = peak.larger_magnitude(*slot);
            }
            put_pairs(self.state, slice, pairs);
            if !self.awake.spread.contains(slice) && V::any(changed.above(zero)) {
                self.moved.slices.insert(slice);
            }
        }
        self.moved.reach(peak, self.model.saturation());
    }
}
