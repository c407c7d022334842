//! The loops of `track` over the cells: its inner products and its update.

use core::ops;

use super::{Range, part, part_mut};
use crate::backend::slice_set::{Iter, SliceSet};
use crate::backend::slices::cells_of;
use crate::energy::residual::Terms;
use crate::number::Sum;
use crate::number::cell::{Cell, add, scale, sub};
use crate::number::two_float::TwoFloat;
use crate::solver::awake::Awake;
use crate::solver::loops::{Loops, Moved, Points};

/// See `Loops::track_residual` and, with five sums, `Loops::elastic_residual`.
pub(crate) fn residual<N: Loops, const SUMS: usize>(
    terms: Terms<'_, '_, N>,
    awake: &SliceSet,
    points: &mut Points<'_, N>,
) -> [TwoFloat; SUMS] {
    let model = terms.model;
    terms.update(awake, points.at);
    let tally = terms.residuals::<false>(awake, points.at, points.residual);
    if awake.is_empty(model.slice_count()) {
        return [TwoFloat::ZERO; SUMS];
    }
    if model.thread_parts().count() > 1 {
        return in_parts(terms, awake, points, tally);
    }
    sums(terms, awake.iter(model.slice_count()), points, tally)
}

/// The sums of a body of several parts. Not inlined: bodies in firmware have one part.
#[cold]
#[inline(never)]
fn in_parts<N: Loops, const SUMS: usize>(
    terms: Terms<'_, '_, N>,
    awake: &SliceSet,
    points: &Points<'_, N>,
    mut tally: N::Tally,
) -> [TwoFloat; SUMS] {
    let mut totals = [TwoFloat::ZERO; SUMS];
    let parts = terms.model.thread_parts();
    for part in 0..parts.count() {
        let slices = awake.iter_in(parts.slices(part));
        totals = plus(totals, sums(terms, slices, points, tally));
        // The tally is that of the whole body: count it once.
        tally = N::Tally::default();
    }
    totals
}

/// Adds the totals of two parts.
pub(crate) fn plus<const SUMS: usize>(
    mut one: [TwoFloat; SUMS],
    other: [TwoFloat; SUMS],
) -> [TwoFloat; SUMS] {
    for (one, other) in one.iter_mut().zip(other) {
        *one = one.plus(other);
    }
    one
}

/// The sums of some slices.
#[inline(never)]
fn sums<N: Loops, const SUMS: usize>(
    terms: Terms<'_, '_, N>,
    slices: Iter<'_>,
    points: &Points<'_, N>,
    tally: N::Tally,
) -> [TwoFloat; SUMS] {
    let is_elastic = SUMS > 4;
    let (mobility, factors) = (terms.mobility(), terms.factors());
    let mut energy = N::WideSum::default();
    let (mut squared, mut way, mut direction, mut own) =
        (N::Sum::default(), N::Sum::default(), N::Sum::default(), N::Sum::default());
    // Sum over the cells of each slice.
    for slice in slices {
        let cells = cells_of(slice, mobility.len());
        let here = part(points.residual, &cells).zip(part(points.at, &cells));
        let there = part(points.published, &cells).zip(part(points.before, &cells));
        let all = here.zip(there).zip(part(mobility, &cells)).enumerate();
        for (lane, (((r, at), (published, before)), &mobility)) in all {
            let (residual, before) = (r.xyz(), before.xyz());
            let z = scale(N::from_single(mobility), residual);
            let mut last = sub(published.xyz(), before);
            energy.add(lane, N::energy_term(r.w()));
            squared.add(lane, N::inner(residual, z));
            way.add(lane, N::inner(residual, sub(at.xyz(), before)));
            if is_elastic {
                let factor = N::from_single(factor(factors, cells.start + lane));
                own.add(lane, N::inner(residual, scale(factor, z)));
                last = scale(factor, last);
            }
            direction.add(lane, N::inner(residual, last));
        }
    }
    // Total the sums in the order of the interface.
    let energy = N::energy(&energy, tally).times_power_of_two(0.125);
    let found = [energy, squared.total(), way.total(), direction.total(), own.total()];
    let mut sums = [TwoFloat::ZERO; SUMS];
    for (sum, found) in sums.iter_mut().zip(found) {
        *sum = found;
    }
    sums
}

/// The local part of a cell's direction over r / W.
pub(crate) fn factor(factors: &[f32], cell: usize) -> f32 {
    factors.get(cell).copied().unwrap_or(1.0)
}

/// See `Loops::track_step`.
pub(crate) fn step<N: Loops>(
    terms: Terms<'_, '_, N>,
    awake: &Awake,
    points: &mut Points<'_, N>,
    factors: [f32; 2],
    moved: &mut Moved,
) {
    let model = terms.model;
    for slice in awake.set.iter(model.slice_count()) {
        let cells = cells_of(slice, model.cells());
        // The neighbours of cells that already moved are awake.
        let started = if awake.spread.contains(slice) {
            update::<N, false>(terms, &cells, points, factors, &mut moved.beyond)
        } else {
            update::<N, true>(terms, &cells, points, factors, &mut moved.beyond)
        };
        if started {
            moved.slices.insert(slice);
        }
    }
}

/// Updates some cells. With `WATCHED`, returns true if one of them started to move.
pub(crate) fn update<N: Loops, const WATCHED: bool>(
    terms: Terms<'_, '_, N>,
    cells: &ops::Range<usize>,
    points: &mut Points<'_, N>,
    factors: [f32; 2],
    beyond: &mut bool,
) -> bool {
    let [alpha, beta] = factors.map(N::from_single);
    let range = Range::new(terms.model.saturation());
    let mut started = false;
    let from = part(points.residual, cells).zip(part(terms.mobility(), cells));
    let to = part_mut(points.published, cells)
        .zip(part_mut(points.at, cells))
        .zip(part_mut(points.before, cells));
    for ((r, &mobility), ((published, at), before)) in from.zip(to) {
        let (y, last) = (at.xyz(), before.xyz());
        let z = scale(N::from_single(mobility), r.xyz());
        let way = sub(y, last);
        let next = add(y, z);
        let ahead = add(add(y, scale(alpha, z)), scale(beta, way));
        if WATCHED {
            started |= starts(way, y, next, ahead);
        }
        *beyond |= range.is_left(next, ahead);
        *published = Cell::at(next);
        *before = Cell::at(y);
        *at = Cell::at(ahead);
    }
    started
}

/// Returns true if some coordinate that was at rest moves.
fn starts<N: Loops>(way: [N; 3], y: [N; 3], next: [N; 3], ahead: [N; 3]) -> bool {
    let each = way.iter().zip(y).zip(next).zip(ahead);
    each.into_iter().any(|(((way, y), next), ahead)| *way == N::ZERO && (next != y || ahead != y))
}
