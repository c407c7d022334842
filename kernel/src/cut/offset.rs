//! The offsets of copies, and their decay.

use super::body::CutBody;
use crate::energy::state::{States, StatesOf};
use crate::number::two_float::{LANES, TwoFloat};

/// Shares of the offsets that may stay in a tick; a step that costs too much is halved, at most three times.
const KEPT: [f32; 4] = [0.9, 0.95, 0.975, 0.9875];
/// Below this magnitude an element of an offset is 0.
const LEAST: f32 = 1.0e-6;

/// An offset, by rows.
pub(super) type Offset = [[f32; 3]; 3];

/// The shapes' part of the states.
pub(super) fn of_shapes(states: States<'_>) -> StatesOf<'_> {
    #[cfg(test)]
    return states.all().after::<crate::model::pin::Pins<'_>>();
    #[cfg(not(test))]
    states.all()
}

/// A change of the energy of at most this size: rounded up, in internal units.
pub(crate) fn at_most(change: TwoFloat, rounding: f32) -> f64 {
    let change = change.times_power_of_two(0.25);
    f64::from(change) + f64::from(f32::EPSILON) * f64::from(rounding)
}

impl CutBody<'_, '_> {
    /// The offset of a cell.
    pub(super) fn offset(&self, cell: usize) -> Offset {
        let rows = self.arrays.offsets.get(cell / LANES);
        let number = |row: usize| {
            let lanes = rows.and_then(|rows| rows.get(row));
            lanes.and_then(|lanes| lanes.get(cell % LANES)).copied().unwrap_or(0.0)
        };
        [0, 3, 6].map(|row| [number(row), number(row + 1), number(row + 2)])
    }

    /// Sets the offset of a cell; it is 0 if all its elements are small.
    pub(super) fn set_offset(&mut self, cell: usize, offset: Offset) {
        let is_small = offset.as_flattened().iter().all(|x| x.abs() < LEAST);
        let rows = self.arrays.offsets.get_mut(cell / LANES).into_iter().flatten();
        for (lanes, &number) in rows.zip(offset.as_flattened()) {
            if let Some(slot) = lanes.get_mut(cell % LANES) {
                *slot = if is_small { 0.0 } else { number + 0.0 };
            }
        }
        let is_any = self
            .arrays
            .offsets
            .get(cell / LANES)
            .is_some_and(|rows| rows.as_flattened().iter().any(|&x| x != 0.0));
        if let Some(slot) = self.arrays.is_offset.get_mut(cell / LANES) {
            *slot = is_any.into();
        }
    }

    /// Lowers all offsets for a tick by the longest step that raises the energy by at most `most`, in internal units.
    /// Returns its change, rounded up; `None` without an offset, and if every step raises it by more.
    pub fn decay(
        &mut self,
        most: f64,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> Option<f64> {
        for kept in KEPT {
            // A cell's energy depends on its own offset alone, so the changes add up.
            let mut change = None;
            self.each_offset(|body, cell, offset| {
                *change.get_or_insert(0.0) += body.change(cell, offset, kept, at, states);
            });
            if change? <= most {
                self.each_offset(|body, cell, offset| body.set_offset(cell, shrunk(offset, kept)));
                return change;
            }
        }
        None
    }

    /// Calls `visit(body, cell, offset)` for each cell with an offset, ascending.
    fn each_offset(&mut self, mut visit: impl FnMut(&mut Self, usize, Offset)) {
        for slice in 0..self.arrays.is_offset.len() {
            if self.arrays.is_offset.get(slice) == Some(&0) {
                continue;
            }
            for cell in slice * LANES..self.arrays.rest.len().min((slice + 1) * LANES) {
                let offset = self.offset(cell);
                if offset != [[0.0; 3]; 3] {
                    visit(self, cell, offset);
                }
            }
        }
    }

    /// The change of the energy if a cell keeps this share of its offset, rounded up.
    fn change(
        &mut self,
        cell: usize,
        offset: Offset,
        kept: f32,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> f64 {
        let stored =
            |body: &Self| body.shapes().stored(core::iter::once(cell), at, of_shapes(states));
        let before = stored(self);
        self.set_offset(cell, shrunk(offset, kept));
        let after = stored(self);
        self.set_offset(cell, offset);
        at_most(after.wd2.minus(before.wd2), before.scale + after.scale)
    }
}

/// A share of an offset.
fn shrunk(offset: Offset, kept: f32) -> Offset {
    offset.map(|row| row.map(|x| kept * x))
}
