//! Sums over the half-links of a cell, or of eight cells side by side.

#![allow(unsafe_code)]

use super::matrix::{Matrix, each, pairs, times};
use crate::backend::f32x8::{Chunk, F32x8, chunk};
use crate::backend::lane::{Lane, Real};
use crate::energy::state::Quad;
use crate::model::image::nodal;
use crate::model::nodal::{CellNumbers, Nodal, SlotNumbers};
use crate::model::range;
use crate::number::cell::{Cell, sub};
use crate::number::two_float::LANES;

/// Material numbers of a cell.
#[derive(Clone, Copy)]
pub(super) struct Own<V> {
    pub volume: Lane<V>,
    pub mu: Lane<V>,
    pub lambda_3: Lane<V>,
    pub band: Lane<V>,
    pub area: [Lane<V>; 3],
}

/// A row of numbers of eight cells or half-links.
#[inline(always)]
fn load<V: F32x8>(rows: &[[f32; LANES]], row: usize) -> Lane<V> {
    Lane(rows.get(row).map_or(V::splat(0.0), V::load))
}

/// Three rows.
#[inline(always)]
fn rows<V>(row: impl Fn(usize) -> Lane<V>, first: usize) -> [Lane<V>; 3] {
    [row(first), row(first + 1), row(first + 2)]
}

impl<V: Real> Own<V> {
    #[inline(always)]
    pub fn of(row: impl Fn(usize) -> Lane<V>) -> Self {
        Self {
            volume: row(nodal::VOLUME),
            mu: row(nodal::MU),
            lambda_3: row(nodal::LAMBDA_3),
            band: row(nodal::BAND),
            area: rows(row, nodal::OWN),
        }
    }
}

/// Numbers of eight cells.
#[inline(always)]
pub(super) fn own<V: F32x8>(numbers: &CellNumbers) -> Own<V> {
    Own::of(|row| load(numbers, row))
}

/// Sums over the half-links of a cell.
#[derive(Clone, Copy)]
pub(super) struct Gathered<V> {
    /// Sum of (`u_j` - `u_i`) `a_ij'`.
    pub slope: Matrix<V>,
    /// Sum of `s_ij` (`u_j` - `u_i`).
    pub pull: [Lane<V>; 3],
    /// Sum of `s_ij` |`u_j` - `u_i`|^2.
    pub spread: Lane<V>,
}

impl<V: Real> Gathered<V> {
    #[inline(always)]
    pub fn none() -> Self {
        let zero = Lane::of(0.0);
        Self { slope: [[zero; 3]; 3], pull: [zero; 3], spread: zero }
    }

    /// Adds half-links with these numbers between the displacements `here` and `there`.
    #[inline(always)]
    pub fn add(
        &mut self,
        here: [Lane<V>; 3],
        there: [Lane<V>; 3],
        row: impl Fn(usize) -> Lane<V> + Copy,
    ) {
        let [dx, dy, dz] = pairs(there, here, |there, here| there - here);
        let (area, s) = (rows(row, nodal::AREA), row(nodal::SPREAD));
        let [first, second, third] = self.slope;
        self.slope = [
            pairs(first, area, |sum, area| sum + dx * area),
            pairs(second, area, |sum, area| sum + dy * area),
            pairs(third, area, |sum, area| sum + dz * area),
        ];
        let [sx, sy, sz] = [s * dx, s * dy, s * dz];
        self.pull = pairs(self.pull, [sx, sy, sz], |sum, pull| sum + pull);
        self.spread = self.spread + (sx * dx + sy * dy + sz * dz);
    }
}

/// Positions of eight cells.
#[inline(always)]
pub(crate) fn places<V: F32x8>(of: impl Fn(usize) -> [f32; 4]) -> [Lane<V>; 3] {
    let [x, y, z, _] = V::transposed(&chunk(of));
    [Lane(x), Lane(y), Lane(z)]
}

/// The half-links of a body, with an array that has an element for each cell.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    shapes: Nodal<'a>,
    array: &'a [Quad],
}

impl<'a> Ends<'a> {
    /// `None` if the array is too short.
    #[inline(always)]
    pub fn of(shapes: Nodal<'a>, array: &'a [Quad]) -> Option<Self> {
        (array.len() >= shapes.count).then_some(Self { shapes, array })
    }

    /// The elements of the cells of a slice.
    #[inline(always)]
    pub fn own(self, slice: usize) -> Option<&'a [Quad; LANES]> {
        self.array.as_chunks().0.get(slice)
    }

    /// Stores the displacements of the cells of a slice, which are at `here`.
    #[inline(always)]
    pub fn displace(self, slice: usize, here: &Chunk) {
        let Some(own) = self.own(slice) else { return };
        let mut last = [[0.0; 3]; LANES];
        let rest = self.shapes.rest.as_chunks().0.get(slice).unwrap_or_else(|| {
            let rest = self.shapes.rest.as_chunks::<LANES>().1;
            last.iter_mut().zip(rest).for_each(|(slot, rest)| *slot = *rest);
            &last
        });
        for ((slot, here), rest) in own.iter().zip(here).zip(rest) {
            slot.set(Cell::at(sub(here.xyz(), *rest)));
        }
    }

    /// The groups of half-links of a slice: their numbers, and the elements of their other ends.
    #[inline(always)]
    fn groups(self, slice: usize) -> impl Iterator<Item = (&'a SlotNumbers, [&'a Quad; LANES])> {
        let groups = range(self.shapes.rows, slice);
        let slots = self.shapes.slots.get(groups.clone()).unwrap_or(&[]);
        let ids = self.shapes.ids.get(groups).unwrap_or(&[]);
        slots.iter().zip(ids).map(move |(slots, &[a, b, c, d, e, f, g, h])| {
            let at = |id: u16| {
                // SAFETY: a model's slices name only its cells, and there are as many elements.
                unsafe { self.array.get_unchecked(usize::from(id)) }
            };
            (slots, [at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h)])
        })
    }

    /// Takes the forces P `a_ij` of the cells of a slice from their neighbours, in the order of groups and
    /// lanes, and adds `pull` to the cells' own.
    #[inline(always)]
    pub fn push<V: F32x8>(self, slice: usize, stress: Matrix<V>, pull: [Lane<V>; 4]) {
        let zero = Lane::of(0.0);
        let opposite = each(stress, |x| zero - x);
        for (slots, cells) in self.groups(slice) {
            let [x, y, z] = times(opposite, rows(|row| load(slots, row), nodal::AREA));
            V::add_to([x.0, y.0, z.0, zero.0], cells);
        }
        let [x, y, z, energy] = pull;
        if let Some(own) = self.own(slice) {
            V::add_to([x.0, y.0, z.0, energy.0], own.each_ref());
        }
    }
}

/// Displacements of eight cells.
#[inline(always)]
fn displacements<V: F32x8>([a, b, c, d, e, f, g, h]: [&Quad; LANES]) -> [Lane<V>; 3] {
    let cells = [a.get(), b.get(), c.get(), d.get(), e.get(), f.get(), g.get(), h.get()];
    let [x, y, z, _] = V::transposed(&cells);
    [Lane(x), Lane(y), Lane(z)]
}

impl<V: F32x8> Gathered<V> {
    /// The sums of the cells of a slice; the array is that of the displacements.
    #[inline(always)]
    pub fn of_slice(ends: Ends<'_>, slice: usize) -> Option<Self> {
        let here = displacements(ends.own(slice)?.each_ref());
        let mut sums = Self::none();
        for (slots, there) in ends.groups(slice) {
            sums.add(here, displacements(there), |row| load(slots, row));
        }
        Some(sums)
    }
}
