//! Extrapolates the body's last motion while tools move.
//!
//! With `p_i` the point of the next pass at the start of tick i and `v_i` the body's extrapolated motion in
//! it, the body continues by
//!
//! ```text
//! v_i+1 = c share ((1 - k) v_i + k (p_i+1 - p_i))
//! ```
//!
//! share is the part of their last motion that the tools repeat. The motion p_i+1 - p_i is `v_i` plus the
//! correction by the sweeps, so k is the share of a correction that is learnt. The sweep after a push
//! overshoots about as often as not; if all of that is learnt, each tick carries the last overshoot along and
//! adds its own. On nodal shapes k is therefore small, and grows with the number of sweeps in which a tick
//! can correct its own overshoot; c is 1. Links snap from one equilibrium to another under a deep press, and
//! a body with memory moves in the wrong direction for long: there k is 1 and c below 1.

use super::{ARRAYS, TRACK};
use crate::backend::Work;
use crate::backend::f32x8::F32x8;
use crate::backend::slices::ChunksMut;
use crate::energy::residual::Terms;
use crate::model::Model;
use crate::model::parts::PARTS;
use crate::number::cell::{Cell, add, peak, scale, sub};
use crate::number::two_float::LANES;

/// On nodal shapes: k per sweep of a tick, and the largest k.
const LEARNT: f32 = 0.15;
const LEARNT_MOST: f32 = 0.6;
/// c on links: it damps motion that the last tick had not settled.
const CARRIED: f32 = 0.9;

/// Parameters of the extrapolation in a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Going {
    /// Share of their last motion that the tools repeat.
    pub share: f32,
    /// Sweeps of the last tick.
    pub sweeps: u16,
    /// True if the tools moved in the last tick too.
    pub is_marked: bool,
    /// True if the next pass is at a point beyond the published one. Otherwise the guard discarded the
    /// extrapolated point: the motion is dropped, and the body stays.
    pub is_going: bool,
}

/// Moves the points of the next pass and of the last one by the extrapolated motion. The first field holds
/// the former at the start of the last tick, the second one v. Returns true if some coordinate is beyond K.
pub(super) fn go_on(
    terms: Terms<'_, '_>,
    own: &mut [Cell],
    published: &[Cell],
    Going { share, sweeps, is_marked, is_going }: Going,
) -> bool {
    let model = terms.model;
    let cells = model.cells();
    if own.len() != ARRAYS * cells {
        return false;
    }
    let Some((points, fields)) = own.split_at_mut_checked(TRACK * cells) else { return false };
    let Some((at, before)) = points.split_at_mut_checked(cells) else { return false };
    let Some((marks, ways)) = fields.split_at_mut_checked(cells) else { return false };
    // Start anew without a usable last tick.
    if !is_marked || !is_going {
        ways.iter_mut().for_each(|way| *way = Cell::ZERO);
    }
    if !is_going {
        for (mark, here) in marks.iter_mut().zip(published) {
            *mark = *here;
        }
        return false;
    }
    // Update v, and move the points.
    let (learnt, carried) = learning(model, sweeps);
    let (learnt, share) = (if is_marked { learnt } else { 0.0 }, carried * share);
    let ways = ways.get_mut(..cells).unwrap_or_default();
    let saturation = model.saturation();
    let (parts, mut beyond) = (model.thread_parts(), [false; PARTS]);
    if terms.vectors.is_none() {
        let [beyond, ..] = &mut beyond;
        return Onward { at, before, marks, ways, learnt, share, saturation, beyond }.one_by_one();
    }
    let points = parts.split_mut(at).into_iter().zip(parts.split_mut(before));
    let fields = parts.split_mut(marks).into_iter().zip(parts.split_mut(ways));
    let mut arrays = points.zip(fields).zip(&mut beyond);
    let works = parts.each(|_| {
        let (((at, before), (marks, ways)), beyond) = arrays.next()?;
        Some(Onward { at, before, marks, ways, learnt, share, saturation, beyond })
    });
    terms.team.run(terms.vectors, works.map(Option::flatten));
    beyond.contains(&true)
}

/// Updates v, and moves both points by it.
struct Onward<'a> {
    at: &'a mut [Cell],
    before: &'a mut [Cell],
    marks: &'a mut [Cell],
    ways: &'a mut [Cell],
    learnt: f32,
    share: f32,
    saturation: f32,
    /// Set to true if some coordinate of the first point is beyond K.
    beyond: &'a mut bool,
}

impl Onward<'_> {
    /// Cell by cell. Returns true if some coordinate of the first point is beyond K.
    fn one_by_one(self) -> bool {
        let Self { at, before, marks, ways, learnt, share, saturation, .. } = self;
        let mut highest = 0.0;
        for (((at, before), mark), way) in at.iter_mut().zip(before).zip(marks).zip(ways) {
            let (here, last) = (at.xyz(), way.xyz());
            let gone = sub(here, mark.xyz());
            let on = scale(share, add(last, scale(learnt, sub(gone, last))));
            (*mark, *way) = (Cell::at(here), Cell::at(on));
            *at = Cell::at(add(here, on));
            *before = Cell::at(add(before.xyz(), on));
            let here = peak(at.xyz());
            highest = if here > highest { here } else { highest };
        }
        highest > saturation
    }
}

impl Work for Onward<'_> {
    type Output = ();

    /// Two cells at a time.
    #[inline(always)]
    fn run<V: F32x8>(self) {
        let slices = self.at.len().div_ceil(LANES);
        let (learnt, share) = (V::splat(self.learnt), V::splat(self.share));
        let (mut at, mut before) = (ChunksMut::new(self.at), ChunksMut::new(self.before));
        let (mut marks, mut ways) = (ChunksMut::new(self.marks), ChunksMut::new(self.ways));
        let mut highest = V::splat(0.0);
        for slice in 0..slices {
            let (at, before) = (at.at(slice), before.at(slice));
            let (mark, way) = (marks.at(slice), ways.at(slice));
            for pair in 0..LANES / 2 {
                let (here, last) = (V::pair(at, pair).positions(), V::pair(way, pair));
                let gone = here.minus(V::pair(mark, pair));
                let on = share.times(last.plus(learnt.times(gone.minus(last)))).positions();
                here.put_pair(mark, pair);
                on.put_pair(way, pair);
                let next = here.plus(on);
                highest = highest.larger_magnitude(next);
                next.put_pair(at, pair);
                V::pair(before, pair).plus(on).positions().put_pair(before, pair);
            }
        }
        [at, before, marks, ways].into_iter().for_each(ChunksMut::finish);
        *self.beyond = V::any(highest.above(V::splat(self.saturation)));
    }
}

/// k and c after a tick of `sweeps` sweeps.
fn learning(model: &Model<'_>, sweeps: u16) -> (f32, f32) {
    if model.kept_states() == 0 {
        return (1.0, CARRIED);
    }
    let learnt = LEARNT * f32::from(sweeps);
    (if learnt < LEARNT_MOST { learnt } else { LEARNT_MOST }, 1.0)
}
