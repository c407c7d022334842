//! The loop of `euler` over slices.

use crate::backend::Work;
use crate::backend::f32x8::F32x8;
use crate::backend::slices::{Chunks, ChunksMut};
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
        let mobility = Chunks::new(self.model.mobility, 0.0);
        let residual = Chunks::new(self.residual, Cell::ZERO);
        let mut state = ChunksMut::new(self.state);
        let mut peak = zero;
        for slice in self.awake.set.iter(self.model.slice_count()) {
            let (mobility, residual) = (mobility.at(slice), residual.at(slice));
            let state = state.at(slice);
            let mut changed = zero;
            for pair in 0..4 {
                let v = V::pair(state, pair);
                let free = V::spread(mobility, pair).above(zero);
                let way = V::pair(residual, pair).times(step).keep(free).positions();
                let next = v.plus(way);
                changed = changed.larger_magnitude(next.minus(v));
                peak = peak.larger_magnitude(next);
                next.put_pair(state, pair);
            }
            if !self.awake.spread.contains(slice) && V::any(changed.above(zero)) {
                self.moved.slices.insert(slice);
            }
        }
        state.finish();
        self.moved.reach(peak, self.model.saturation());
    }
}
