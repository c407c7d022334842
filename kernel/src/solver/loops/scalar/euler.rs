//! The loop of `euler` over the cells.

use core::ops;

use super::{Range, part, part_mut};
use crate::backend::slices::cells_of;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{Cell, add, scale};
use crate::solver::awake::Awake;
use crate::solver::loops::Moved;

/// See `Loops::euler_step`.
pub(crate) fn step<N: Number>(
    model: &Model<'_>,
    awake: &Awake,
    state: &mut [Cell<N>],
    residual: &[Cell<N>],
    step: f32,
    moved: &mut Moved,
) {
    for slice in awake.set.iter(model.slice_count()) {
        let cells = cells_of(slice, model.cells());
        let changed = update(model, &cells, state, residual, step, &mut moved.beyond);
        if changed && !awake.spread.contains(slice) {
            moved.slices.insert(slice);
        }
    }
}

/// Updates some cells. Returns true if one of them moved.
pub(crate) fn update<N: Number>(
    model: &Model<'_>,
    cells: &ops::Range<usize>,
    state: &mut [Cell<N>],
    residual: &[Cell<N>],
    step: f32,
    beyond: &mut bool,
) -> bool {
    let (step, range) = (N::from_single(step), Range::new(model.saturation()));
    let mut changed = false;
    let from = part(residual, cells).zip(part(model.mobility, cells));
    for ((r, &mobility), v) in from.zip(part_mut(state, cells)) {
        if mobility > 0.0 {
            let next = add(v.xyz(), scale(step, r.xyz()));
            changed |= next != v.xyz();
            *v = Cell::at(next);
        }
        *beyond |= range.is_left(v.xyz(), v.xyz());
    }
    changed
}
