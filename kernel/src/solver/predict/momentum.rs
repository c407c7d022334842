//! A body under tools that move goes on as it went.

use super::{ARRAYS, TRACK};
use crate::model::Model;
use crate::number::cell::{Cell, add, peak, scale, sub};

/// Share of its last way that the body goes on by under tools that go on as they did. Less than all of
/// it damps what the last tick had not yet settled.
const CARRIED: f32 = 0.9;

/// Moves the point of the next pass and that of the last one by a share of the way that the former has
/// gone since the last call, which the first field remembers. Whether some coordinate is beyond K.
pub(super) fn go_on(model: &Model<'_>, own: &mut [Cell], share: f32) -> bool {
    let cells = model.cells();
    if own.len() != ARRAYS * cells {
        return false;
    }
    let Some((points, fields)) = own.split_at_mut_checked(TRACK * cells) else { return false };
    let Some((at, before)) = points.split_at_mut_checked(cells) else { return false };
    let (mut highest, share) = (0.0, CARRIED * share);
    for ((at, before), mark) in at.iter_mut().zip(before).zip(fields) {
        let here = at.xyz();
        let way = scale(share, sub(here, mark.xyz()));
        *mark = Cell::at(here);
        if share > 0.0 {
            *at = Cell::at(add(here, way));
            *before = Cell::at(add(before.xyz(), way));
            let here = peak(at.xyz());
            highest = if here > highest { here } else { highest };
        }
    }
    highest > model.saturation()
}
