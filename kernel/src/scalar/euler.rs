//! The loop of `euler` over the cells.

use super::{Range, cells_of, part, part_mut};
use crate::awake::Awake;
use crate::cell::{Cell, add, scale};
use crate::model::Model;
use crate::number::Number;
use crate::slice::Moved;

/// See `Loops::euler_step`.
pub(crate) fn step<N: Number>(
    model: &Model<'_>,
    awake: &Awake,
    state: &mut [Cell<N>],
    residual: &[Cell<N>],
    step: f32,
) -> Moved {
    let step = N::from_single(step);
    let mut moved = Moved::NOTHING;
    let range = Range::new(model.saturation());
    for slice in awake.set.iter(model.slice_count()) {
        let cells = cells_of(slice, model.cells());
        let watched = !awake.spread.contains(slice);
        let mut changed = false;
        let from = part(residual, &cells).zip(part(model.mobility, &cells));
        for ((r, &mobility), v) in from.zip(part_mut(state, &cells)) {
            if mobility > 0.0 {
                let next = add(v.xyz(), scale(step, r.xyz()));
                changed |= watched && next != v.xyz();
                *v = Cell::at(next);
            }
            moved.beyond |= range.is_left(v.xyz(), v.xyz());
        }
        if changed {
            moved.slices.insert(slice);
        }
    }
    moved
}
