//! Stability bounds of the cells under tools.

use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::contact::memory::{TouchArrays, TouchState};
use crate::energy::surface::{NearTriangle, PinSample, Proxies};
use crate::model::Model;
use crate::number::two_float::LANES;

/// Margin for the rounding of the cells' bounds.
const ROUNDED_UP: f32 = 1.001;

/// The factors of an elastic coarse level, if the model has one.
fn factors<'m>(model: &Model<'m>) -> &'m [f32] {
    let elastic = model.coarse_basis.and_then(|basis| basis.elastic());
    elastic.map_or(&[][..], |level| level.factors)
}

/// Adds the part of tools and pins to the bounds of the cells at the triangles in reach and at pinned samples.
pub(super) fn enclose(model: &Model<'_>, arrays: &mut TouchArrays<'_>, count: usize) {
    let pinned = arrays.pins().len();
    let Some(state) = arrays.state.first_mut() else { return };
    let pins = arrays.pins.get(..pinned).unwrap_or(&[]);
    // Start from the model's bounds.
    let slices = model.slice_count();
    if state.is_filled {
        restore(model, state, arrays.mobility, arrays.factors);
    } else if count > 0 || Proxies(arrays.tools).fronts().next().is_some() || pinned > 0 {
        arrays.mobility.copy_from(model.mobility);
        arrays.factors.copy_from(factors(model));
        state.is_filled = true;
    }
    // Find the slices with corners in reach, and clear their cells' bounds.
    state.count = count;
    state.slices = SliceSet::EMPTY;
    let near = arrays.near.get(..count).unwrap_or(&[]);
    for cell in near.iter().flat_map(|near| near.corners) {
        state.slices.insert(usize::from(cell) / LANES);
    }
    for sample in Proxies(arrays.tools).fronts() {
        sample.corners.iter().for_each(|&cell| state.slices.insert(usize::from(cell) / LANES));
    }
    for cell in pins.iter().flat_map(|pin| pin.corners) {
        state.slices.insert(usize::from(cell) / LANES);
    }
    for cell in state.slices.iter(slices).flat_map(|slice| cells_of(slice, model.cells())) {
        if let Some(bound) = arrays.mobility.get_mut(cell) {
            *bound = 0.0;
        }
    }
    // Sum the triangles' parts per cell.
    for near in near {
        let weight = bound(near);
        for cell in near.corners {
            if let Some(bound) = arrays.mobility.get_mut(usize::from(cell)) {
                *bound += weight;
            }
        }
    }
    for sample in Proxies(arrays.tools).fronts() {
        for (&cell, weight) in sample.corners.iter().zip(sample.weights) {
            if let Some(bound) = arrays.mobility.get_mut(usize::from(cell)) {
                *bound += weight * sample.stiffness;
            }
        }
    }
    for (cell, weight) in pins.iter().flat_map(PinSample::bounds) {
        if let Some(bound) = arrays.mobility.get_mut(cell) {
            *bound += weight;
        }
    }
    // Combine them with the cells' bounds in the model.
    for cell in state.slices.iter(slices).flat_map(|slice| cells_of(slice, model.cells())) {
        let (Some(slot), Some(&own)) = (arrays.mobility.get_mut(cell), model.mobility.get(cell))
        else {
            continue;
        };
        let more = ROUNDED_UP * *slot * own;
        *slot = own / (1.0 + more);
        if let Some(factor) = arrays.factors.get_mut(cell) {
            // The cell's part alone, f / W, is reduced by the tools' bound as r / W is.
            *factor *= (1.0 + more) / (1.0 + *factor * more);
        }
    }
}

/// Part of a triangle in the bound of each of its corners: a third of its contact stiffness, and as much
/// again for anchors on its samples.
fn bound(near: &NearTriangle) -> f32 {
    let third = near.weight * (1.0 / 3.0);
    if near.held > 0 { third + third } else { third }
}

/// Corners of triangles and of pinned samples, each with its part in the bound.
pub(super) fn of_corners(
    near: &[NearTriangle],
    pins: &[PinSample],
) -> impl Iterator<Item = (usize, f32)> {
    let of_near = near.iter().flat_map(|near| near.corners.map(|cell| (cell.into(), bound(near))));
    let all = of_near.chain(pins.iter().flat_map(PinSample::bounds));
    all.map(|(cell, part)| (cell, ROUNDED_UP * part))
}

/// Restores the model's bounds at the cells of the last tick's triangles.
fn restore(model: &Model<'_>, state: &TouchState, mobility: &mut [f32], local: &mut [f32]) {
    let factors = factors(model);
    for slice in state.slices.iter(model.slice_count()) {
        for cell in cells_of(slice, model.cells()) {
            if let (Some(slot), Some(&bound)) = (mobility.get_mut(cell), model.mobility.get(cell)) {
                *slot = bound;
            }
            if let (Some(slot), Some(&factor)) = (local.get_mut(cell), factors.get(cell)) {
                *slot = factor;
            }
        }
    }
}

/// `copy_from_slice` that cannot panic.
trait CopyFrom {
    fn copy_from(&mut self, from: &Self);
}

impl CopyFrom for [f32] {
    fn copy_from(&mut self, from: &Self) {
        for (slot, value) in self.iter_mut().zip(from) {
            *slot = *value;
        }
    }
}
