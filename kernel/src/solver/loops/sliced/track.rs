//! The loops of `track` over slices: its inner products and its update.

use core::ops::Range;

use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{Chunks, ChunksMut};
use crate::backend::{Work, run};
use crate::energy::residual::Terms;
use crate::energy::sliced::{self, Reduce};
use crate::model::parts::PARTS;
use crate::number::cell::Cell;
use crate::number::two_float::{Lanes, Plain, TwoFloat};
use crate::solver::awake::Awake;
use crate::solver::loops::scalar::track::plus;
use crate::solver::loops::{Moved, Points};

/// The sums of a pass, see `Loops::track_residual` and, with five sums, `elastic_residual`.
pub(crate) struct Sums<'a, const SUMS: usize> {
    mobility: Chunks<'a, f32>,
    factors: Chunks<'a, f32>,
    published: Chunks<'a, Cell>,
    before: Chunks<'a, Cell>,
    energy: Lanes,
    products: [Plain; 4],
}

impl<'a, const SUMS: usize> Sums<'a, SUMS> {
    pub fn new(terms: Terms<'a, '_>, published: &'a [Cell], before: &'a [Cell]) -> Self {
        Self {
            mobility: Chunks::new(terms.mobility(), 0.0),
            factors: Chunks::new(terms.factors(), 1.0),
            published: Chunks::repeated(published),
            before: Chunks::repeated(before),
            energy: Lanes::ZERO,
            products: [Plain::ZERO; 4],
        }
    }

    /// Energy in internal units, and the products.
    pub fn totals(&self) -> [TwoFloat; SUMS] {
        let mut totals = [self.energy.total().times_power_of_two(0.125); SUMS];
        for (total, sum) in totals.iter_mut().skip(1).zip(&self.products) {
            *total = sum.total().into();
        }
        totals
    }
}

impl<const SUMS: usize> Reduce for Sums<'_, SUMS> {
    #[inline(always)]
    fn slice<V: F32x8>(&mut self, slice: usize, at: [V; 3], [x, y, z, wd2]: [V; 4]) {
        let published = V::transposed(self.published.at(slice));
        let before = V::transposed(self.before.at(slice));
        let m = V::load(self.mobility.at(slice));
        let squared = x.times(x.times(m)).plus(y.times(y.times(m))).plus(z.times(z.times(m)));
        let way = x
            .times(at[0].minus(before[0]))
            .plus(y.times(at[1].minus(before[1])))
            .plus(z.times(at[2].minus(before[2])));
        let [mut a, mut b, mut c] = [
            published[0].minus(before[0]),
            published[1].minus(before[1]),
            published[2].minus(before[2]),
        ];
        if SUMS > 4 {
            let factor = V::load(self.factors.at(slice));
            let mf = [x.times(m).times(factor), y.times(m).times(factor), z.times(m).times(factor)];
            let own = x.times(mf[0]).plus(y.times(mf[1])).plus(z.times(mf[2]));
            let [_, _, _, sum] = &mut self.products;
            sum.add(own);
            [a, b, c] = [a.times(factor), b.times(factor), c.times(factor)];
        }
        let direction = x.times(a).plus(y.times(b)).plus(z.times(c));
        self.energy.add(wd2);
        for (sum, term) in self.products.iter_mut().zip([squared, way, direction]) {
            sum.add(term);
        }
    }
}

/// The pass of a body of one part; `None` if slices cannot be used.
pub(crate) fn residual<const SUMS: usize>(
    terms: Terms<'_, '_>,
    awake: &SliceSet,
    points: &mut Points<'_, f32>,
) -> Option<[TwoFloat; SUMS]> {
    let mut sums = Sums::<SUMS>::new(terms, points.published, points.before);
    sliced::residual(terms, awake, awake, points.at, points.residual, &mut sums)
        .then(|| sums.totals())
}

/// The pass of a body of several parts; `None` if slices cannot be used.
pub(crate) fn residual_in_parts<const SUMS: usize>(
    terms: Terms<'_, '_>,
    awake: &SliceSet,
    points: &mut Points<'_, f32>,
) -> Option<[TwoFloat; SUMS]> {
    let Points { published, at, before, residual } = points;
    let mut sums = [(); PARTS].map(|()| Sums::<SUMS>::new(terms, published, before));
    if !sliced::residual_in_parts(terms, awake, at, residual, &mut sums) {
        return None;
    }
    sums.iter().take(terms.model.thread_parts().count()).map(Sums::totals).reduce(plus)
}

/// The update of awake slices without a coarse level, part by part if there are several.
pub(crate) fn step(
    terms: Terms<'_, '_>,
    awake: &Awake,
    points: &mut Points<'_, f32>,
    factors: [f32; 2],
    moved: &mut Moved,
) {
    let (mobility, saturation) = (terms.mobility(), terms.model.saturation());
    let parts = terms.model.thread_parts();
    if parts.count() == 1 {
        let (slices, points) = (0..terms.model.slice_count(), points.reborrow());
        let step = Step { awake, slices, mobility, points, factors, saturation, moved };
        return run(terms.vectors, step);
    }
    let mut all = [(); PARTS].map(|()| Moved::NOTHING);
    let mut each = all.iter_mut().zip(parts.split(mobility));
    let steps = points.parts(parts).map(|points| {
        let ((part, points), (moved, of)) = (points?, each.next()?);
        let slices = parts.slices(part);
        Some(Step { awake, slices, mobility: of, points, factors, saturation, moved })
    });
    terms.team.run(terms.vectors, steps);
    all.iter().for_each(|of| moved.unite(of));
}

/// The update of awake slices without a coarse level.
pub(crate) struct Step<'a> {
    pub awake: &'a Awake,
    /// A part of the body; the arrays are those of its cells.
    pub slices: Range<usize>,
    pub mobility: &'a [f32],
    pub points: Points<'a, f32>,
    pub factors: [f32; 2],
    pub saturation: f32,
    pub moved: &'a mut Moved,
}

impl Work for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Points { published, at, before, residual } = self.points;
        let mut slices = Slices {
            mobility: Chunks::new(self.mobility, 0.0),
            residual: Chunks::new(residual, Cell::ZERO),
            published: ChunksMut::new(published),
            at: ChunksMut::new(at),
            before: ChunksMut::new(before),
        };
        let (factors, zero) = (self.factors.map(|factor| V::splat(factor)), V::splat(0.0));
        let mut peak = zero;
        let first = self.slices.start;
        for slice in self.awake.set.iter_in(self.slices) {
            let here = slice - first;
            if self.awake.spread.contains(slice) {
                slices.step::<V, false>(here, factors, &mut peak);
            } else if V::any(slices.step::<V, true>(here, factors, &mut peak).above(zero)) {
                self.moved.slices.insert(slice);
            }
        }
        let Slices { published, at, before, .. } = slices;
        published.finish();
        at.finish();
        before.finish();
        self.moved.reach(peak, self.saturation);
    }
}

/// Arrays that an update reads and writes.
struct Slices<'a> {
    mobility: Chunks<'a, f32>,
    residual: Chunks<'a, Cell>,
    published: ChunksMut<'a>,
    at: ChunksMut<'a>,
    before: ChunksMut<'a>,
}

impl Slices<'_> {
    /// Moves the cells of a slice. With `STARTED`, returns the displacement of cells that were at rest
    /// before; the neighbours of the others are awake.
    #[inline(always)]
    fn step<V: F32x8, const STARTED: bool>(
        &mut self,
        slice: usize,
        [alpha, beta]: [V; 2],
        peak: &mut V,
    ) -> V {
        let (mobility, residual) = (self.mobility.at(slice), self.residual.at(slice));
        let (at, before) = (self.at.at(slice), self.before.at(slice));
        let published = self.published.at(slice);
        let (zero, least) = (V::splat(0.0), V::splat(f32::from_bits(1)));
        let mut started = zero;
        for pair in 0..4 {
            let z = V::pair(residual, pair).times(V::spread(mobility, pair)).positions();
            let y = V::pair(at, pair);
            let way = y.minus(V::pair(before, pair));
            let next = y.plus(z);
            let ahead = y.plus(alpha.times(z)).plus(beta.times(way));
            if STARTED {
                let still = zero.larger_magnitude(way).below(least);
                let moves = zero.larger_magnitude(ahead.minus(y)).larger_magnitude(next.minus(y));
                started = started.larger_magnitude(moves.keep(still));
            }
            *peak = peak.larger_magnitude(next).larger_magnitude(ahead);
            next.put_pair(published, pair);
            y.put_pair(before, pair);
            ahead.put_pair(at, pair);
        }
        started
    }
}
