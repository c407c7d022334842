//! The memory of links that relax follows their tension, at the start of a tick.
//!
//! With b the part that a branch forgets until the next tick, at the published positions m <- m + b (d - m), d the
//! signed distance of the link's length to its band; [`following`](crate::energy) has the rule of rest, [`memory`] the
//! energy. It falls: the gap between d^2 / 2 and its tangent at m does as m goes towards d. Within 2^-20 rest
//! lengths of d a memory stays as it is.
//!
//! Cost: a gather and a root for each half-link, and some 15 operations for each branch.

use super::memory::Stretch;
use crate::backend::Work;
use crate::backend::f32x8::{F32x8, Lanes8};
use crate::backend::lane::Lane;
use crate::energy::following::{Course, NEAR, Near, Parts, Sums, follow};
use crate::energy::nodal::places;
use crate::model::nodal::HalfLinkMemory;
use crate::model::relaxing_links::RelaxingLinks;
use crate::model::{Slices, range};
use crate::number::two_float::LANES;

/// The memory of eight half-links in a branch [mean link lengths].
pub(crate) type HalfLinkRow = [f32; LANES];

/// The memory of all links follows their tension; the cells are `at` these positions.
pub(crate) struct FollowLinks<'a, 'm, 's, A> {
    pub links: RelaxingLinks<'a, 'm>,
    pub at: A,
    pub courses: &'s [Course],
    pub parts: Parts,
    /// By group, a branch after the other.
    pub rows: &'s mut [HalfLinkRow],
    /// The numbers for this tick, by group.
    pub numbers: &'s mut [HalfLinkMemory],
    pub sums: &'s mut Sums,
}

impl<A: Fn(usize) -> [f32; 3]> Work for FollowLinks<'_, '_, '_, A> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(mut self) {
        for slice in 0..self.links.rest().len().div_ceil(LANES) {
            self.slice::<V>(slice);
        }
    }
}

impl<A: Fn(usize) -> [f32; 3]> FollowLinks<'_, '_, '_, A> {
    #[inline(always)]
    fn slice<V: F32x8>(&mut self, slice: usize) {
        // Padding repeats the last cell.
        let Slices { rows, neighbours, .. } = self.links.slices();
        let (cells, count) = (self.links.rest().len(), self.courses.len());
        let place = |cell: usize| {
            let [x, y, z] = (self.at)(cell.min(cells.saturating_sub(1)));
            [x, y, z, 0.0]
        };
        let [a, b, c] = places::<V>(|lane| place(slice * LANES + lane));
        for group in range(rows, slice) {
            let Some(ids) = neighbours.get(group) else { continue };
            // The links as they are.
            let [p, q, r] =
                places::<V>(|lane| place(ids.get(lane).copied().map_or(0, usize::from)));
            let ([x, y, z], half) =
                ([p - a, q - b, r - c], self.links.half_links(group, |row| Lane(V::load(row))));
            let stretch = Stretch::of(x * x + y * y + z * z, half.l0, half.alpha);
            let near = Near::of(Lane::of(NEAR) * half.l0, self.parts.lasting);
            // Follow them, branch by branch.
            let zero = Lane::of(0.0);
            let (mut rise, mut scale) = (zero, zero);
            let rows = self.rows.get_mut(group * count..(group + 1) * count).unwrap_or_default();
            for (course, row) in self.courses.iter().zip(&mut *rows) {
                let old = Lane(V::load(row));
                let stored = gap(&stretch, old);
                let before = Lane::of(course.before) * stored;
                let mut after = Lane::of(course.weight) * stored;
                if course.faded > 0.0 {
                    let next = follow(stretch.distance, old, course.faded, near);
                    after = Lane::of(course.weight) * gap(&stretch, next);
                    let way = (next - old).magnitude();
                    self.sums.moved = self.sums.moved || V::any(way.above(zero));
                    next.0.store(row);
                }
                // Half of a link's energy.
                let stiffness = Lane::of(0.125 * course.share) * half.weight;
                rise = rise + stiffness * (after - before);
                scale = scale + stiffness * size(&stretch, old);
            }
            self.sums.rise.add(rise.0);
            self.sums.scale.add(scale.0);
            let rows = self.courses.iter().zip(&*rows);
            if let Some(numbers) = self.numbers.get_mut(group) {
                derive::<V>(self.links, group, rows, numbers);
            }
        }
    }
}

/// The numbers of a group for a tick, from what its branches remember; of a restored body.
pub(crate) fn remember(
    links: RelaxingLinks<'_, '_>,
    group: usize,
    courses: &[Course],
    rows: &[HalfLinkRow],
    numbers: &mut HalfLinkMemory,
) {
    derive::<Lanes8>(links, group, courses.iter().zip(rows), numbers);
}

/// d^2 + m^2 - 2 m (u - l).
#[inline(always)]
fn gap<V: F32x8>(stretch: &Stretch<V>, memory: Lane<V>) -> Lane<V> {
    let [over, under] = stretch.sides;
    let side = Lane::select(memory.above(Lane::of(0.0)), over, under);
    stretch.distance * stretch.distance + memory * (memory - (side + side))
}

/// A bound of the terms of that.
#[inline(always)]
fn size<V: F32x8>(stretch: &Stretch<V>, memory: Lane<V>) -> Lane<V> {
    let two = stretch.distance * stretch.distance + memory * memory;
    two + two + two + memory.magnitude() * stretch.length
}

/// Stores M and K of eight half-links.
#[inline(always)]
fn derive<'r, V: F32x8>(
    links: RelaxingLinks<'_, '_>,
    group: usize,
    branches: impl Iterator<Item = (&'r Course, &'r HalfLinkRow)>,
    numbers: &mut HalfLinkMemory,
) {
    let (half, zero) = (links.half_links(group, |row| Lane(V::load(row))), Lane::of(0.0));
    let slack = half.alpha * half.l0;
    let (mut sum, mut constant) = (zero, zero);
    for (course, row) in branches {
        let (weight, memory) = (Lane::of(course.share * course.weight), Lane(V::load(row)));
        sum = sum + weight * memory;
        // The side of the band, from the rest length.
        let stored = Lane::of(0.5) * memory * memory + memory.magnitude() * slack;
        constant = constant + weight * stored;
    }
    let [first, second] = numbers;
    (sum + zero).0.store(first);
    (constant + zero).0.store(second);
}
