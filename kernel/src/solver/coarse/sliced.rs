//! The loops between cells and basis functions, two cells side by side: restriction and the coarse
//! update.
//!
//! Sums over basis functions interleave the two cells: x of one, x of the other, and so on, so that a single
//! load gets the weights of both. The eight basis functions of a box stay in registers for all its cells. A
//! box with an odd number of cells lists its last one twice, the second time without weights.

#![allow(unsafe_code)]

use core::ops::Range;

use super::scalar::{direction, step_sides};
use super::sides;
use crate::backend::f32x8::F32x8;
use crate::backend::{Work, run};
use crate::energy::residual::Terms;
use crate::model::coarse_basis::CoarseBasis;
use crate::model::image::NO_FUNCTION;
use crate::model::parts::PARTS;
use crate::model::range;
use crate::number::cell::Cell;
use crate::number::two_float::{Eight, LANES};
use crate::solver::loops::Points;

/// The pairs of cells of a box, with their weights.
#[inline(always)]
fn pairs<'m>(basis: &CoarseBasis<'m>, at_box: usize) -> (&'m [[u16; 2]], &'m [[Eight; 2]]) {
    let pairs = range(basis.rows, at_box);
    (basis.cells.get(pairs.clone()).unwrap_or(&[]), basis.weights.get(pairs).unwrap_or(&[]))
}

/// P' r of the masked residuals, into the first three vectors of the coarse memory.
pub(crate) struct Restrict<'a, 'm> {
    pub basis: CoarseBasis<'m>,
    pub residual: &'a [Cell],
    pub room: &'a mut [Eight],
}

impl Work for Restrict<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let blocks = self.basis.blocks();
        let Some(sums) = self.room.get_mut(..3 * blocks) else { return };
        sums.fill([0.0; LANES]);
        if self.residual.len() != self.basis.entry.len() {
            return;
        }
        // Sum each box over its pairs of cells.
        for (at_box, corners) in self.basis.corners.iter().enumerate() {
            let (cells, weights) = pairs(&self.basis, at_box);
            let mut sum = [V::splat(0.0); LANES];
            for (&ids, weights) in cells.iter().zip(weights) {
                // SAFETY: the model's boxes name only its cells, and there are as many residuals.
                let r = unsafe { V::couple(self.residual, ids) }.woven();
                let [a, b, c, d, e, f, g, h] = sum;
                let [low, high] = weights;
                sum = [
                    a.plus(V::in_turn(low, 0).times(r)),
                    b.plus(V::in_turn(low, 1).times(r)),
                    c.plus(V::in_turn(low, 2).times(r)),
                    d.plus(V::in_turn(low, 3).times(r)),
                    e.plus(V::in_turn(high, 0).times(r)),
                    f.plus(V::in_turn(high, 1).times(r)),
                    g.plus(V::in_turn(high, 2).times(r)),
                    h.plus(V::in_turn(high, 3).times(r)),
                ];
            }
            // Add its corners to the basis functions.
            let flat = sums.as_flattened_mut();
            for (&function, sum) in corners.iter().zip(sum) {
                if function == NO_FUNCTION {
                    continue;
                }
                for (axis, term) in sum.unwoven().folded().xyz().into_iter().enumerate() {
                    if let Some(slot) = flat.get_mut(axis * blocks * LANES + usize::from(function))
                    {
                        *slot += term;
                    }
                }
            }
        }
        sides::restrict(&self.basis, self.residual, self.room);
    }
}

/// Updates all free cells, part by part if there are several. Returns true if some coordinate is beyond K.
pub(crate) fn step(
    terms: Terms<'_, '_>,
    basis: &CoarseBasis<'_>,
    room: &[Eight],
    points: &mut Points<'_, f32>,
    factors: [f32; 2],
) -> bool {
    match basis.elastic() {
        None => steps::<false>(terms, basis, (room, terms.mobility()), points, factors),
        Some(_) => steps::<true>(terms, basis, (room, terms.factors()), points, factors),
    }
}

/// The same; `own` are the factors of the cells' local parts, used only with an elastic level.
fn steps<const ELASTIC: bool>(
    terms: Terms<'_, '_>,
    basis: &CoarseBasis<'_>,
    (room, own): (&[Eight], &[f32]),
    points: &mut Points<'_, f32>,
    factors: [f32; 2],
) -> bool {
    let (model, k) = (terms.model, terms.model.saturation());
    let mobility = terms.mobility();
    // One part.
    if !basis.is_in_parts {
        let (boxes, mut beyond) = (0..basis.corners.len(), false);
        let (of_boxes, beyond_k) = (points.reborrow(), &mut beyond);
        #[rustfmt::skip]
        let step = CoarseStep::<ELASTIC> { basis: *basis, boxes, first: 0, mobility, own, room, points: of_boxes, factors, k, beyond_k };
        run(terms.vectors, step);
        return beyond | step_sides(basis, room, points, factors[0], k);
    }
    // Several parts: the team runs them.
    let mut beyond = [false; PARTS];
    let parts = model.thread_parts();
    let mut each = beyond.iter_mut().zip(parts.split(mobility)).zip(parts.split(own));
    let steps = points.parts(parts).map(|points| {
        let ((part, points), ((beyond_k, mobility), own)) = (points?, each.next()?);
        let (boxes, first) = (basis.boxes_of(part), parts.cells(part).start);
        #[rustfmt::skip]
        let step = CoarseStep::<ELASTIC> { basis: *basis, boxes, first, mobility, own, room, points, factors, k, beyond_k };
        Some(step)
    });
    terms.team.run(terms.vectors, steps);
    beyond.contains(&true)
}

/// The update of all free cells of some boxes with the coarse direction: z = r / W + P c, then x = y + z,
/// `y_last` = y, y = y + alpha z + beta (y - `y_last`). With an elastic level z has the cell's local part in
/// place of r / W, and x = y + r / W.
struct CoarseStep<'a, 'm, const ELASTIC: bool> {
    basis: CoarseBasis<'m>,
    /// The boxes of the arrays' cells, which start at cell `first`.
    boxes: Range<usize>,
    first: usize,
    mobility: &'a [f32],
    /// Factors of the local parts.
    own: &'a [f32],
    room: &'a [Eight],
    points: Points<'a, f32>,
    factors: [f32; 2],
    /// Saturation K.
    k: f32,
    /// Set to true if some coordinate is beyond K.
    beyond_k: &'a mut bool,
}

impl<const ELASTIC: bool> Work for CoarseStep<'_, '_, ELASTIC> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Points { published, at, before, residual } = self.points;
        let cells = self.mobility.len();
        let lengths = [published.len(), at.len(), before.len(), residual.len(), self.own.len()];
        if lengths != [cells; 5] {
            return;
        }
        let [alpha, beta] = self.factors.map(|factor| V::splat(factor));
        let mut peak = V::splat(0.0);
        // Update the pairs of cells of each box.
        for at_box in self.boxes {
            let corners = corners::<V>(&self.basis, self.room, at_box);
            let (cells, weights) = pairs(&self.basis, at_box);
            for (ids, weights) in cells.iter().zip(weights) {
                let ids = ids.map(|id| id.wrapping_sub(self.first as u16));
                // SAFETY: the boxes name only cells of these arrays, which are as long as each
                // other, and the first of them is `first`.
                let (r, m, y, last) = unsafe {
                    (
                        V::couple(residual, ids),
                        V::couple_values(self.mobility, ids),
                        V::couple(at, ids),
                        V::couple(before, ids),
                    )
                };
                let sure = r.times(m).positions();
                let own = if ELASTIC {
                    // SAFETY: as above.
                    sure.times(unsafe { V::couple_values(self.own, ids) })
                } else {
                    sure
                };
                let z = own.plus(along(&corners, weights));
                let next = if ELASTIC { y.plus(sure) } else { y.plus(z) };
                let ahead = y.plus(z.times(alpha)).plus(y.minus(last).times(beta));
                peak = peak.larger_magnitude(next).larger_magnitude(ahead);
                // SAFETY: as above.
                unsafe {
                    y.uncouple(before, ids);
                    next.uncouple(published, ids);
                    ahead.uncouple(at, ids);
                }
            }
        }
        *self.beyond_k = V::any(peak.above(V::splat(self.k)));
    }
}

/// The coarse direction at the corners of a box, each twice, interleaved.
#[inline(always)]
fn corners<V: F32x8>(basis: &CoarseBasis<'_>, room: &[Eight], at_box: usize) -> [V; LANES] {
    let value = direction(basis, room);
    let mut twice = [V::splat(0.0); LANES];
    if let Some(corners) = basis.corners.get(at_box) {
        for (twice, &function) in twice.iter_mut().zip(corners) {
            if function != NO_FUNCTION {
                *twice = V::twice(Cell::at(value(usize::from(function)))).woven();
            }
        }
    }
    twice
}

/// The coarse direction at two cells, summed over the corners in their order.
#[inline(always)]
fn along<V: F32x8>(corners: &[V; LANES], [low, high]: &[Eight; 2]) -> V {
    let [a, b, c, d, e, f, g, h] = *corners;
    let sum = V::in_turn(low, 0).times(a);
    let sum = sum.plus(V::in_turn(low, 1).times(b));
    let sum = sum.plus(V::in_turn(low, 2).times(c));
    let sum = sum.plus(V::in_turn(low, 3).times(d));
    let sum = sum.plus(V::in_turn(high, 0).times(e));
    let sum = sum.plus(V::in_turn(high, 1).times(f));
    let sum = sum.plus(V::in_turn(high, 2).times(g));
    sum.plus(V::in_turn(high, 3).times(h)).unwoven()
}
