//! Moves the points of `track` with the tool.

use super::{ARRAYS, TRACK};
use crate::model::Model;
use crate::number::cell::{Cell, add, peak, scale};
use crate::solver::awake::Awake;

/// Moves the points of the next pass and of the last one along the fields, for a motion of the tool by `way`.
/// Returns true if some coordinate is beyond K.
pub(super) fn follow(
    model: &Model<'_>,
    own: &mut [Cell],
    awake: &mut Awake,
    way: [f32; 3],
) -> bool {
    let cells = model.cells();
    if own.len() != ARRAYS * cells {
        return false;
    }
    let Some((points, fields)) = own.split_at_mut_checked(TRACK * cells) else { return false };
    let Some((at, before)) = points.split_at_mut_checked(cells) else { return false };
    let Some((x, rest)) = fields.split_at_checked(cells) else { return false };
    let Some((y, z)) = rest.split_at_checked(cells) else { return false };
    awake.wake_all(model);
    let mut highest = 0.0;
    for ((at, before), ((x, y), z)) in at.iter_mut().zip(before).zip(x.iter().zip(y).zip(z)) {
        let along = add(scale(way[0], x.xyz()), scale(way[1], y.xyz()));
        let along = add(along, scale(way[2], z.xyz()));
        *at = Cell::at(add(at.xyz(), along));
        *before = Cell::at(add(before.xyz(), along));
        let here = peak(at.xyz());
        highest = if here > highest { here } else { highest };
    }
    highest > model.saturation()
}
