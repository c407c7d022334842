//! The shape of a single cell at any positions.

use super::gather::{Gathered, Own};
use super::law::{stay, step};
use super::matrix::{three, times};
use super::state::{ShapeState, Step, pull, stress};
use crate::backend::lane::Lane;
use crate::energy::held::Touched;
use crate::energy::state::StatesOf;
use crate::model::image::nodal;
use crate::model::nodal::Nodal;
use crate::number::cell::sub;
use crate::number::two_float::LANES;

impl Nodal<'_> {
    /// The cells linked to a cell, ascending.
    fn others(self, cell: usize) -> impl Iterator<Item = usize> {
        self.slots_of(cell).map(|(other, _)| other).filter(move |&other| other != cell)
    }

    fn gathered(self, cell: usize, at: &impl Fn(usize) -> [f32; 3]) -> Gathered<f32> {
        let (here, mut sums) = (at(cell).map(Lane), Gathered::none());
        for (other, slot) in self.slots_of(cell) {
            sums.add(here, at(other).map(Lane), |row| Lane(slot.number(row)));
        }
        sums
    }

    fn own(self, cell: usize) -> Own<f32> {
        Own::of(|row| Lane(self.number(cell, row)))
    }

    /// The state of a cell for a pass at these positions.
    pub(super) fn stepped(
        self,
        cell: usize,
        state: ShapeState,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> ShapeState {
        let (turn, unit) = variables(state);
        state_of(step(self.stretch_min, &self.gathered(cell, at), &self.own(cell), turn, unit))
    }

    /// The shape of a cell at these positions, with unchanged rotation and shape of unit volume.
    fn here(self, cell: usize, state: ShapeState, at: &impl Fn(usize) -> [f32; 3]) -> Step<f32> {
        let (turn, unit) = variables(state);
        stay(self.stretch_min, &self.gathered(cell, at), &self.own(cell), turn, unit)
    }

    /// Force on a cell in the last pass, and eight times its energy.
    #[inline(always)]
    pub(super) fn pulled(self, cell: usize, states: StatesOf<'_>) -> [f32; 4] {
        let results = states.slice(cell / LANES).map_or(&[][..], |memory| memory.results);
        let [mut x, mut y, mut z, energy] = pull(results, cell % LANES);
        for (other, slot) in self.slots_of(cell) {
            let stress = states.lines().get(other).map_or([[0.0; 4]; 3], stress);
            let stress = three(stress, |[a, b, c, _]| [Lane(a), Lane(b), Lane(c)]);
            let area = three(slot.three(nodal::BACK_AREA), Lane);
            let [Lane(a), Lane(b), Lane(c)] = times(stress, area);
            (x, y, z) = (x - a, y - b, z - c);
        }
        [x, y, z, energy]
    }

    /// Force on a cell at these positions.
    pub(super) fn at_positions(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
    ) -> [f32; 3] {
        let Step { pull: [x, y, z, _], .. } = self.here(cell, states.shape(cell), at);
        let mut force = [x.0, y.0, z.0];
        for (other, slot) in self.slots_of(cell).filter(|(other, _)| *other != cell) {
            let stress = self.here(other, states.shape(other), at).stress;
            let area = three(slot.three(nodal::BACK_AREA), Lane);
            for (sum, part) in force.iter_mut().zip(times(stress, area)) {
                *sum -= part.0;
            }
        }
        force
    }

    /// Adds the energy of the cells `held`, ascending, and of all cells linked to them, each once.
    pub(super) fn stored_around(
        self,
        held: impl Fn(usize) -> Option<usize> + Copy,
        count: usize,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        let cells = || (0..count).filter_map(held);
        for cell in cells() {
            self.add_stored(cell, at, states, sums);
            for other in self.others(cell) {
                // A cell that is linked to several held ones counts with the first of them.
                let is_held = |cell: usize| cells().any(|held| held == cell);
                let is_earlier = |next: usize| next < cell && is_held(next);
                if !is_held(other) && !self.others(other).any(is_earlier) {
                    self.add_stored(other, at, states, sums);
                }
            }
        }
    }

    /// Adds four times the energy of a cell, and a bound of that value's rounding error.
    fn add_stored(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        let here = self.here(cell, states.shape(cell), at);
        let [.., energy] = here.pull;
        sums.wd2 = sums.wd2.plus((0.5 * energy.0).into());
        let mut size = 0.0;
        for row in here.stress {
            for part in row {
                size += part.0.abs();
            }
        }
        let mut scale = 0.5 * energy.0.abs();
        for (other, slot) in self.slots_of(cell) {
            let (mut area, mut way, mut moved) = (0.0, 0.0, 0.0);
            for (axis, difference) in sub(at(other), at(cell)).into_iter().enumerate() {
                area += slot.number(nodal::AREA + axis).abs();
                way += difference.abs();
                moved += (difference - slot.number(nodal::REST + axis)).abs();
            }
            scale += 4.0 * way * (size * area + slot.number(nodal::SPREAD).abs() * moved);
        }
        sums.scale += scale;
    }
}

/// R and Q of a state.
#[inline(always)]
fn variables(state: ShapeState) -> ([Lane<f32>; 4], [[Lane<f32>; 3]; 3]) {
    (state.turn.map(Lane), three(state.unit, |row| three(row, Lane)))
}

#[inline(always)]
fn state_of(step: Step<f32>) -> ShapeState {
    let row = |[a, b, c]: [Lane<f32>; 3]| [a.0, b.0, c.0, 0.0];
    ShapeState {
        turn: step.turn.map(|x| x.0),
        unit: three(step.unit, |row| three(row, |x| x.0)),
        stress: three(step.stress, row),
        pull: step.pull.map(|x| x.0),
    }
}
