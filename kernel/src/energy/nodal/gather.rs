//! Sums over the half-links of a cell, or of eight cells side by side.

#![allow(unsafe_code)]

use core::cell::Cell as Shared;

use super::matrix::{Matrix, pairs, three};
use super::state::{chunk, stress};
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::lane::{Lane, Real};
use crate::energy::state::TermState;
use crate::model::image::nodal;
use crate::model::nodal::{CellNumbers, Nodal, SlotNumbers};
use crate::model::range;
use crate::number::cell::Cell;
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

/// `a_ji` of eight half-links.
#[inline(always)]
pub(super) fn back<V: F32x8>(slots: &SlotNumbers) -> [V; 3] {
    three(rows(|row| load::<V>(slots, row), nodal::BACK_AREA), |x| x.0)
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

    /// Adds half-links with these numbers between `here` and `there`.
    #[inline(always)]
    pub fn add(
        &mut self,
        here: [Lane<V>; 3],
        there: [Lane<V>; 3],
        row: impl Fn(usize) -> Lane<V> + Copy,
    ) {
        let ([x, y, z], [a, b, c]) = (here, there);
        let [p, q, r] = rows(row, nodal::REST);
        let [dx, dy, dz] = [a - x - p, b - y - q, c - z - r];
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
pub(super) struct Ends<'a, T> {
    shapes: Nodal<'a>,
    array: &'a [T],
}

impl<'a, T> Ends<'a, T> {
    /// `None` if the array is too short.
    #[inline(always)]
    pub fn of(shapes: Nodal<'a>, array: &'a [T]) -> Option<Self> {
        (array.len() >= shapes.count).then_some(Self { shapes, array })
    }

    /// The groups of half-links of a slice: their numbers, and the elements of their other ends.
    #[inline(always)]
    pub fn groups(self, slice: usize) -> impl Iterator<Item = (&'a SlotNumbers, [&'a T; LANES])> {
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
}

/// Positions of eight cells.
#[inline(always)]
fn gathered<V: F32x8>([a, b, c, d, e, f, g, h]: [&Cell; LANES]) -> [Lane<V>; 3] {
    let [x, y, z, _] = V::transposed(&[*a, *b, *c, *d, *e, *f, *g, *h]);
    [Lane(x), Lane(y), Lane(z)]
}

/// Stresses in the lines of eight cells, by rows.
#[inline(always)]
pub(super) fn stresses<V: F32x8>(lines: [&Shared<TermState>; LANES]) -> [[V; 3]; 3] {
    let [a, b, c, d, e, f, g, h] = lines;
    let ([a, i, q], [b, j, r], [c, k, s]) = (stress(a), stress(b), stress(c));
    let ([d, l, t], [e, m, u], [f, n, v]) = (stress(d), stress(e), stress(f));
    let ([g, o, w], [h, p, x]) = (stress(g), stress(h));
    [row([a, b, c, d, e, f, g, h]), row([i, j, k, l, m, n, o, p]), row([q, r, s, t, u, v, w, x])]
}

/// The lanes of eight times three numbers.
#[inline(always)]
fn row<V: F32x8>([a, b, c, d, e, f, g, h]: [[f32; 4]; LANES]) -> [V; 3] {
    let chunk = [Cell(a), Cell(b), Cell(c), Cell(d), Cell(e), Cell(f), Cell(g), Cell(h)];
    let [x, y, z, _] = V::transposed(&chunk);
    [x, y, z]
}

impl<V: F32x8> Gathered<V> {
    /// The sums of the cells of a slice, which are at `here`.
    #[inline(always)]
    pub fn of_slice(ends: Ends<'_, Cell>, slice: usize, here: &Chunk) -> Self {
        let [x, y, z, _] = V::transposed(here);
        let here = [Lane(x), Lane(y), Lane(z)];
        let mut sums = Self::none();
        for (slots, there) in ends.groups(slice) {
            sums.add(here, gathered(there), |row| load(slots, row));
        }
        sums
    }
}
