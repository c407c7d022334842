//! Unchecked access of the scalar sweep: its loop over the links.
//!
//! A [`Model`] can only be made by the validation of its image, its fields are private to this
//! crate and never change, and it guarantees: row starts never descend and end at the number of
//! links; every upper end is larger than its row's cell and smaller than the number of cells. What is left to
//! check, the length of the caller's arrays, is checked once a pass.

#![allow(unsafe_code)]

use crate::awake::SliceSet;
use crate::cell::Cell;
use crate::link::Pull;
use crate::model::Model;
use crate::two_float::LANES;

/// Adds every link's pull to both its ends: `sum[i] += f`, `sum[j] -= f`, and w d^2 to both in
/// the fourth lane. Starts from +0.0 in awake slices; the links of all others are slack, and are
/// left out.
///
/// Links run in ascending order of (i, j), so each cell's terms are added in ascending order of
/// its neighbours, as a loop over cells would. `law(link, i, j, P_i, P_j, l0)` gives the pull.
/// Does nothing where `at` or `sum` are shorter than the model.
#[inline(always)]
pub(crate) fn accumulate(
    model: &Model<'_>,
    awake: &SliceSet,
    at: &[Cell],
    sum: &mut [Cell],
    law: impl Fn(usize, usize, usize, [f32; 3], [f32; 3], f32) -> Option<Pull>,
) {
    let cells = model.cells();
    if at.len() < cells || sum.len() < cells {
        return;
    }
    let slices = model.slice_count();
    for slice in awake.iter(slices) {
        for sum in sum.iter_mut().skip(slice * LANES).take(LANES) {
            *sum = Cell::ZERO;
        }
    }
    let all = awake.iter(slices).flat_map(|slice| slice * LANES..cells.min((slice + 1) * LANES));
    for i in all {
        let row = model.row(i);
        // SAFETY: i < cells, and both slices hold at least that many.
        let (here, mut total) = unsafe { (at.get_unchecked(i).xyz(), *sum.get_unchecked(i)) };
        for link in row {
            // SAFETY: rows end at the number of links, the length of both sections.
            let (j, l0) = unsafe {
                let upper = *model.upper.get_unchecked(link);
                (usize::from(upper), *model.rest_length.get_unchecked(link))
            };
            // SAFETY: the model's upper ends are smaller than the number of cells.
            let there = unsafe { at.get_unchecked(j).xyz() };
            let Some(pull) = law(link, i, j, here, there, l0) else { continue };
            let [x, y, z] = pull.force;
            total = total.plus(Cell([x, y, z, pull.wd2]));
            // SAFETY: as above; j > i, so the running total of i is not touched.
            let other = unsafe { sum.get_unchecked_mut(j) };
            *other = other.plus(Cell([-x, -y, -z, pull.wd2]));
        }
        // SAFETY: i < cells.
        unsafe { *sum.get_unchecked_mut(i) = total };
    }
}
