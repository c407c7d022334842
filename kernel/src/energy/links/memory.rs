//! Links that relax: Fung's quasi-linear law, one number a half-link and branch.
//!
//! The bands ([`law`](super::law)) have the instantaneous weights w. With d the signed distance of a link's length u
//! to its band, and m what a branch remembers of it ([`follow`](super::follow)), the force along the link is
//!
//! ```text
//! w / 2 [ p d - M ],   p = 1 - sum of g' (1 - c),   M = sum of g' c m
//! ```
//!
//! with g' the branch's share of the stiffness and c the part that it carries in a tick. A branch stores the gap
//! between d^2 / 2 and its tangent at m, which is never below 0:
//!
//! ```text
//! E = w / 4 sum of g' c [ d^2 + m^2 - 2 m (u - l) ],   l the side of the band towards which m points
//! ```
//!
//! This term adds to that of the bands what M and p change: K = sum of g' c [ m^2 / 2 + m (l - l0) ] with the rest
//! length l0 is constant in a tick, as M is.
//!
//! **The bound.** m follows d, so it stays in the range of d. The tension then grows by at most w / 2 with the length,
//! and over the length is at most w / 2: W and L are those of the bands.
//!
//! **Order.** By half-links: both ends of a link compute the same bits.
//!
//! Cost: another gather, a root and two divisions for each half-link, for any number of branches.

use super::law::RIM;
use super::number::LinkNumber;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::lane::{Lane, Real};
use crate::energy::half_links::{Groups, Law, Pull, Row};
use crate::energy::held::{Contact, Touched, is_among};
use crate::energy::state::StatesOf;
use crate::energy::term::{Here, Pass, Term};
use crate::model::relaxing_links::RelaxingLinks;
use crate::model::terms::Keeps;
use crate::model::{Slices, slots_of};
use crate::number::cell::{Cell, add, single};

/// Links as they are: their lengths, and the signed distances to their bands.
pub(super) struct Stretch<V> {
    pub length: Lane<V>,
    /// To the band; 0 inside.
    pub distance: Lane<V>,
    /// To the upper and to the lower side.
    pub sides: [Lane<V>; 2],
}

impl<V: Real> Stretch<V> {
    /// Of links of these squared lengths, rest lengths and bands, as [`law`](super::law) has them.
    #[inline(always)]
    pub fn of(u2: Lane<V>, l0: Lane<V>, alpha: Lane<V>) -> Self {
        let (zero, one) = (Lane::of(0.0), Lane::of(1.0));
        let (low, high, l02) = (one - alpha, one + alpha, l0 * l0);
        let is_long = u2.above(l02 * (high * high * Lane::of(1.0 + RIM)));
        let is_short = (l02 * (low * low * Lane::of(1.0 - RIM))).above(u2);
        let length = u2.root();
        let sides = [length - l0 * high, length - l0 * low];
        let [over, under] = sides;
        let distance = Lane::select(is_long, over, Lane::select(is_short, under, zero));
        Self { length, distance, sides }
    }
}

/// Half-links of these rest lengths, bands and weights.
pub(super) struct HalfLinks<V> {
    pub l0: Lane<V>,
    pub alpha: Lane<V>,
    pub weight: Lane<V>,
}

impl RelaxingLinks<'_, '_> {
    /// The half-links of a group.
    #[inline(always)]
    pub(super) fn half_links<V: Real>(
        self,
        group: usize,
        lanes: impl Fn(&Row) -> Lane<V>,
    ) -> HalfLinks<V> {
        let Slices { lengths, alphas, weights, .. } = self.slices();
        let of = |rows: Option<&[Row]>, otherwise: f32| {
            rows.and_then(|rows| rows.get(group)).map_or(Lane::of(otherwise), &lanes)
        };
        HalfLinks {
            l0: of(Some(lengths), 0.0),
            alpha: of(alphas, self.alpha()),
            weight: of(weights, 1.0),
        }
    }
}

impl Law for RelaxingLinks<'_, '_> {
    /// True if the body is one of links that relaxes, in a tick.
    #[inline(always)]
    fn is_there(self) -> bool {
        !self.memory().is_empty()
    }

    #[inline(always)]
    fn groups(&self) -> Groups<'_> {
        let Slices { rows, neighbours, .. } = self.slices();
        Groups { rows, ids: neighbours, rest: self.rest() }
    }

    /// The change by the memory, M and K.
    #[inline(always)]
    fn pull<V: Real>(
        self,
        group: usize,
        u2: Lane<V>,
        lanes: impl Fn(&Row) -> Lane<V>,
    ) -> Option<Pull<V>> {
        let [sum, constant] = self.memory().get(group)?.each_ref().map(&lanes);
        let HalfLinks { l0, alpha, weight } = self.half_links(group, lanes);
        let Stretch { length, distance, .. } = Stretch::of(u2, l0, alpha);
        let (zero, faded) = (Lane::of(0.0), Lane::of(self.faded()));
        let tension = faded * distance + sum;
        let stored =
            (constant + constant) - (sum + sum) * (length - l0) - faded * distance * distance;
        Some(Pull { l0, length, wd: zero - weight * tension, wd2: weight * stored })
    }
}

impl Keeps for RelaxingLinks<'_, '_> {}

impl<N: LinkNumber> Term<N> for RelaxingLinks<'_, '_> {
    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        _: &mut N::Tally,
        _: StatesOf<'_>,
    ) {
        self.add_to_cells(pass, residual);
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        self.add_to_slice(here, sum);
    }

    fn cell(
        self,
        cell: usize,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sum: [f32; 3],
    ) -> [f32; 3] {
        if !self.is_there() {
            return sum;
        }
        // Links between two held cells cancel.
        let (at, Groups { rows, ids, .. }) = (|cell: usize| single(at(cell)), self.groups());
        let outer = slots_of(rows, ids, cell).filter(|&(_, other)| !is_among(held, other));
        let forces = outer.filter_map(|(group, other)| self.force(group, cell, other, &at));
        forces.fold(sum, |sum, (force, _)| add(sum, force))
    }

    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        self.add_touched(held, at, sums);
    }
}
