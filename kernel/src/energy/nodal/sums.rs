//! Sums over the half-links of a cell, and its material.

use super::matrix::{Matrix, pairs};
use super::memory::Memory;
use crate::backend::lane::{Lane, Real};
use crate::model::image::nodal;

/// Material numbers of a cell, the offset of its shape, and its memory. The last two are borrowed: copies of the
/// numbers do not copy them.
#[derive(Clone, Copy)]
pub(super) struct Own<'k, V> {
    pub volume: Lane<V>,
    pub mu: Lane<V>,
    pub lambda_3: Lane<V>,
    pub band: Lane<V>,
    pub area: [Lane<V>; 3],
    /// C, if a cell has one.
    pub offset: Option<&'k Matrix<V>>,
    /// The memory of a cell of a body that relaxes.
    pub memory: Option<&'k Memory<V>>,
}

/// Offset and memory of one cell.
pub(super) struct Kept {
    pub offset: Option<Matrix<f32>>,
    pub memory: Option<Memory<f32>>,
}

impl<'k, V: Real> Own<'k, V> {
    #[inline(always)]
    pub fn of(row: impl Fn(usize) -> Lane<V>) -> Self {
        Self {
            volume: row(nodal::VOLUME),
            mu: row(nodal::MU),
            lambda_3: row(nodal::LAMBDA_3),
            band: row(nodal::BAND),
            area: rows(row, nodal::OWN),
            offset: None,
            memory: None,
        }
    }

    /// The same with this memory.
    #[inline(always)]
    pub fn remembering(self, memory: &'k Memory<V>) -> Self {
        Self { mu: self.mu * memory.part, memory: Some(memory), ..self }
    }
}

impl<'k> Own<'k, f32> {
    /// The same with what the cell keeps.
    #[inline(always)]
    pub fn keeping(self, kept: &'k Kept) -> Self {
        let own = Self { offset: kept.offset.as_ref(), ..self };
        kept.memory.as_ref().map_or(own, |memory| own.remembering(memory))
    }
}

/// Sums over the half-links of a cell.
#[derive(Clone, Copy)]
#[repr(C)]
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

/// Three rows.
#[inline(always)]
pub(super) fn rows<V>(row: impl Fn(usize) -> Lane<V>, first: usize) -> [Lane<V>; 3] {
    [row(first), row(first + 1), row(first + 2)]
}
