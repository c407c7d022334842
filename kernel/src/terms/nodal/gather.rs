//! Sums over the half-links of a cell, or of eight cells side by side.

use super::matrix::{Matrix, pairs, three};
use super::state::chunk;
use crate::backend::f32x8::F32x8;
use crate::backend::lane::{Lane, Real};
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

impl<V: F32x8> Gathered<V> {
    /// The sums of the cells of a slice.
    #[inline(always)]
    pub fn of_slice(shapes: Nodal<'_>, slice: usize, at: &[Cell]) -> Self {
        let last = at.len().saturating_sub(1);
        let place = |cell: usize| at.get(cell).map_or([0.0; 4], |cell| cell.0);
        let here = places::<V>(|lane| place((slice * LANES + lane).min(last)));
        let mut sums = Self::none();
        for group in range(shapes.rows, slice) {
            let slots = shapes.slots.get(group).zip(shapes.ids.get(group));
            let Some((slots, ids)) = slots else { continue };
            let there = places::<V>(|lane| place(ids.get(lane).copied().map_or(0, usize::from)));
            sums.add(here, there, |row| load(slots, row));
        }
        sums
    }
}
