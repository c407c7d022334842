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

use super::law::{COINCIDENT, RIM};
use super::number::LinkNumber;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::lane::{Lane, Real};
use crate::energy::held::{Contact, Touched, is_among};
use crate::energy::nodal::places;
use crate::energy::state::StatesOf;
use crate::energy::term::{Here, Pass, Term, change_lane};
use crate::model::relaxing_links::RelaxingLinks;
use crate::model::terms::Keeps;
use crate::model::{Slices, range};
use crate::number::cell::{Cell, add, dot, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

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

/// The change of links by the memory: the factor of the vector between the ends, and the sum of w d^2.
struct Pull<V> {
    factor: Lane<V>,
    wd2: Lane<V>,
}

/// Half-links of these rest lengths, bands, weights and memories.
#[derive(Clone, Copy)]
pub(super) struct HalfLinks<V> {
    pub l0: Lane<V>,
    pub alpha: Lane<V>,
    pub weight: Lane<V>,
}

impl<V: Real> HalfLinks<V> {
    /// The change by the memory, M and K, at these squared lengths.
    #[inline(always)]
    fn pull(self, u2: Lane<V>, faded: f32, memory: [Lane<V>; 2]) -> Pull<V> {
        let [sum, constant] = memory;
        let (zero, faded) = (Lane::of(0.0), Lane::of(faded));
        let Stretch { length, distance, .. } = Stretch::of(u2, self.l0, self.alpha);
        let tension = faded * distance + sum;
        let stored =
            (constant + constant) - (sum + sum) * (length - self.l0) - faded * distance * distance;
        // A link of zero length takes the rest shape's vector, which is l0 long; padding has no vector.
        let is_void = (self.l0 * self.l0 * Lane::of(COINCIDENT)).above(u2);
        let along = Lane::select(is_void, self.l0 + self.l0, length + length);
        let along = Lane::select(along.above(zero), along, Lane::of(1.0));
        Pull { factor: (zero - self.weight * tension) / along, wd2: self.weight * stored }
    }
}

impl RelaxingLinks<'_> {
    /// True if the body is one of links that relaxes, in a tick.
    #[inline(always)]
    fn is_any(self) -> bool {
        !self.memory.is_empty()
    }

    /// The half-links of a group, eight side by side.
    #[inline(always)]
    pub(super) fn group<V: F32x8>(self, group: usize) -> HalfLinks<V> {
        let Slices { lengths, alphas, weights, .. } = self.slices.unwrap_or(Slices::NONE);
        let of = |rows: Option<&[[f32; LANES]]>, otherwise: f32| {
            let row = rows.and_then(|rows| rows.get(group));
            row.map_or(Lane::of(otherwise), |row| Lane(V::load(row)))
        };
        HalfLinks {
            l0: of(Some(lengths), 0.0),
            alpha: of(alphas, self.alpha),
            weight: of(weights, 1.0),
        }
    }

    /// The half-link of a lane of a group.
    fn half_link(self, group: usize, lane: usize) -> HalfLinks<f32> {
        let Slices { lengths, alphas, weights, .. } = self.slices.unwrap_or(Slices::NONE);
        let of = |rows: Option<&[[f32; LANES]]>, otherwise: f32| {
            let number = rows.and_then(|rows| rows.get(group)?.get(lane));
            Lane(number.copied().unwrap_or(otherwise))
        };
        HalfLinks {
            l0: of(Some(lengths), 0.0),
            alpha: of(alphas, self.alpha),
            weight: of(weights, 1.0),
        }
    }

    /// The half-links of a cell: their groups and other ends.
    fn slots_of(self, cell: usize) -> impl Iterator<Item = (usize, usize)> {
        let Slices { rows, neighbours, .. } = self.slices.unwrap_or(Slices::NONE);
        range(rows, cell / LANES).filter_map(move |group| {
            let other = usize::from(*neighbours.get(group)?.get(cell % LANES)?);
            (other != cell).then_some((group, other))
        })
    }

    /// The change of the force of one link on `cell`, and of w d^2, by the memory.
    fn force(
        self,
        group: usize,
        cell: usize,
        other: usize,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> ([f32; 3], f32) {
        let lane = cell % LANES;
        let [sum, constant] = self.memory.get(group).copied().unwrap_or_default();
        let number = |row: [f32; LANES]| Lane(row.get(lane).copied().unwrap_or(0.0));
        let (way, half) = (sub(at(other), at(cell)), self.half_link(group, lane));
        let u2 = dot(way, way);
        let Pull { factor, wd2 } = half.pull(Lane(u2), self.faded, [number(sum), number(constant)]);
        let place = |cell: usize| self.rest.get(cell).copied().unwrap_or([0.0; 3]);
        let is_void = u2 < COINCIDENT * (half.l0.0 * half.l0.0);
        let way = if is_void { sub(place(other), place(cell)) } else { way };
        (scale(factor.0, way), wd2.0)
    }

    /// Adds what the memory changes at a cell to its residual.
    fn residual(self, cell: usize, at: &impl Fn(usize) -> [f32; 3], sum: Cell) -> Cell {
        let slots = self.slots_of(cell);
        let forces = slots.map(|(group, other)| self.force(group, cell, other, at));
        forces.fold(sum, |sum, ([x, y, z], wd2)| sum.plus(Cell([x, y, z, wd2])))
    }

    /// The same in a slice that has a link of zero length.
    #[cold]
    #[inline(never)]
    fn one_by_one(self, cell: usize, at: &[Cell], sum: Cell) -> Cell {
        self.residual(cell, &|cell| at.get(cell).map_or([0.0; 3], |cell| cell.xyz()), sum)
    }

    /// Adds the groups of a slice, whose cells are at `here`. Returns where a link has zero length.
    #[inline(always)]
    fn add_groups<V: F32x8>(
        self,
        slice: usize,
        here: [Lane<V>; 3],
        at: &[Cell],
        sum: &mut [V; 4],
    ) -> V::Mask {
        let place = |cell: usize| at.get(cell).map_or([0.0; 4], |cell| cell.0);
        let mut is_void = V::splat(0.0).below(V::splat(0.0));
        let Slices { rows, neighbours, .. } = self.slices.unwrap_or(Slices::NONE);
        for group in range(rows, slice) {
            let Some((ids, memory)) = neighbours.get(group).zip(self.memory.get(group)) else {
                continue;
            };
            let there = places::<V>(|lane| place(ids.get(lane).copied().map_or(0, usize::from)));
            let ([a, b, c], [p, q, r]) = (here, there);
            let [x, y, z] = [p - a, q - b, r - c];
            let (u2, half) = (x * x + y * y + z * z, self.group(group));
            let pull = half.pull(u2, self.faded, memory.each_ref().map(|row| Lane(V::load(row))));
            let void = (Lane::of(COINCIDENT) * (half.l0 * half.l0)).above(u2);
            is_void = V::either(is_void, void);
            let [sx, sy, sz, wd2] = *sum;
            let [fx, fy, fz] = [pull.factor * x, pull.factor * y, pull.factor * z];
            *sum = [sx.plus(fx.0), sy.plus(fy.0), sz.plus(fz.0), wd2.plus(pull.wd2.0)];
        }
        is_void
    }
}

impl Keeps for RelaxingLinks<'_> {}

impl<N: LinkNumber> Term<N> for RelaxingLinks<'_> {
    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        _: &mut N::Tally,
        _: StatesOf<'_>,
    ) {
        if !self.is_any() {
            return;
        }
        let place = |cell: usize| single(pass.at(cell));
        for cell in pass.cells() {
            let Some(r) = residual.get_mut(cell) else { continue };
            let before = Cell(r.0.map(N::single));
            *r = Cell(self.residual(cell, &place, before).0.map(N::from_single));
        }
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        if !self.is_any() {
            return;
        }
        let (before, Here { slice, at, cells }) = (*sum, here);
        let is_void = self.add_groups(slice, cells.map(Lane), at, sum);
        // A link of zero length: compute the slice cell by cell.
        if V::any(is_void) {
            *sum = before;
            for lane in 0..LANES {
                change_lane(sum, lane, |r| self.one_by_one(slice * LANES + lane, at, r));
            }
        }
    }

    fn cell(
        self,
        cell: usize,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sum: [f32; 3],
    ) -> [f32; 3] {
        if !self.is_any() {
            return sum;
        }
        // Links between two held cells cancel.
        let outer = self.slots_of(cell).filter(|&(_, other)| !is_among(held, other));
        let at = |cell: usize| single(at(cell));
        let forces = outer.map(|(group, other)| self.force(group, cell, other, &at));
        forces.fold(sum, |sum, (force, _)| add(sum, force))
    }

    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        if !self.is_any() {
            return;
        }
        let at = |cell: usize| single(at(cell));
        for cell in held.iter().map(Contact::cell) {
            for (group, other) in self.slots_of(cell) {
                // A link between two held cells counts once.
                if other < cell && is_among(held, other) {
                    continue;
                }
                let (force, wd2) = self.force(group, cell, other, &at);
                let (wd, way) = (2.0 * sqrt(dot(force, force)), sub(at(other), at(cell)));
                sums.wd2 = sums.wd2.plus(wd2.into());
                sums.scale += wd2.abs() + wd * sqrt(dot(way, way));
            }
        }
    }
}
