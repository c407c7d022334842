//! The links in sequence, with unchecked access to the cells.
//!
//! A [`Model`] is only created by the validation of its image, its fields are private to this crate and never
//! change, and it guarantees: row starts never descend and end at the number of links; every upper end is
//! larger than its row's cell and smaller than the number of cells. Only the length of the caller's arrays is
//! left to check, once per pass.

#![allow(unsafe_code)]

use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{cells_of, clear};
use crate::energy::links::law::LinkForce;
use crate::energy::number::TermNumber;
use crate::model::Model;
use crate::number::cell::Cell;

/// Adds every link's force to both its ends: `sum[i] += f`, `sum[j] -= f`, and w d^2 to both in the fourth
/// lane. Starts from +0.0 in awake slices; the links of all others are slack and are skipped.
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
    let slices = model.slice_count();
    clear(sum, awake.iter(slices));
    for i in awake.iter(slices).flat_map(|slice| cells_of(slice, cells)) {
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
