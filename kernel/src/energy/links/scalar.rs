//! The links one by one, with unchecked access to the cells in sequence.
//!
//! A [`Model`] is only created by the validation of its image, its fields are private to this crate and never
//! change, and it guarantees: row starts never descend and end at the number of links; every upper end is
//! larger than its row's cell and smaller than the number of cells. Only the length of the caller's arrays is
//! left to check, once per pass.

#![allow(unsafe_code)]

use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::energy::links::bands::{Links, rest_difference};
use crate::energy::links::law::LinkForce;
use crate::energy::links::number::LinkNumber;
use crate::energy::number::TermNumber;
use crate::model::Model;
use crate::number::cell::Cell;

/// Adds every link's force to both its ends: `sum[i] += f`, `sum[j] -= f`, and w d^2 to both in the fourth
/// lane. The links of slices that sleep are slack and are skipped.
///
/// Links run in ascending order of (i, j), so each cell's terms are added in ascending order of its
/// neighbours, as in a loop over cells. `law(link, i, j, P_i, P_j, l0)` returns the force. Does nothing if
/// `at` or `sum` are shorter than the model.
#[inline(always)]
pub(crate) fn accumulate<N: TermNumber>(
    model: &Model<'_>,
    awake: &SliceSet,
    at: &[Cell<N>],
    sum: &mut [Cell<N>],
    mut law: impl FnMut(usize, usize, usize, [N; 3], [N; 3], f32) -> Option<LinkForce<N>>,
) {
    let cells = model.cells();
    if at.len() < cells || sum.len() < cells {
        return;
    }
    for i in awake.iter(model.slice_count()).flat_map(|slice| cells_of(slice, cells)) {
        let row = model.row(i);
        // SAFETY: i < cells, and both slices hold at least that many; rows end at the number of
        // links, the length of both sections.
        let (here, mut total, uppers, lengths) = unsafe {
            let (uppers, lengths) = (model.upper, model.rest_length);
            (
                at.get_unchecked(i).xyz(),
                *sum.get_unchecked(i),
                uppers.get_unchecked(row.clone()),
                lengths.get_unchecked(row.clone()),
            )
        };
        for ((link, &upper), &l0) in row.zip(uppers).zip(lengths) {
            let j = usize::from(upper);
            // SAFETY: the model's upper ends are smaller than the number of cells.
            let there = unsafe { at.get_unchecked(j).xyz() };
            let Some(of) = law(link, i, j, here, there, l0) else { continue };
            let ([x, y, z], mark) = (of.force, N::mark(of.wd2));
            total = total.plus(Cell([x, y, z, mark]));
            // SAFETY: as above; j > i, so the running total of i is not touched.
            let other = unsafe { sum.get_unchecked_mut(j) };
            *other = other.plus(Cell([x.opposite(), y.opposite(), z.opposite(), mark]));
        }
        // SAFETY: i < cells.
        unsafe { *sum.get_unchecked_mut(i) = total };
    }
}

impl Links<'_, '_> {
    /// The force of one link on its end `cell`, in single precision; the other end is `other`, and cells are
    /// at the positions `at`.
    pub fn force_at<N: LinkNumber>(
        self,
        at: &impl Fn(usize) -> [N; 3],
        link: usize,
        cell: usize,
        other: usize,
    ) -> Option<LinkForce> {
        let (i, j) = if cell < other { (cell, other) } else { (other, cell) };
        let (yi, yj) = (at(i), at(j));
        let l0 = self.model.rest_length.get(link).copied()?;
        let (w, band) = (self.model.link_weight(link), N::band(self.alpha(link)));
        let on_i = N::link_force_single(yi, yj, l0, w, band, || rest_difference(self.model, i, j))?;
        Some(if cell == i { on_i } else { LinkForce { force: on_i.force.map(|f| -f), ..on_i } })
    }
}
