//! Shapes cell by cell, in a pass and at any positions.

use core::ops::Range;

use super::gather::{Gathered, Own};
use super::law::{stay, step};
use super::matrix::{each, three, times};
use super::state::{ShapeState, Step};
use crate::backend::lane::Lane;
use crate::energy::held::Touched;
use crate::energy::state::{Quads, SliceMemory, StatesOf};
use crate::model::image::nodal;
use crate::model::nodal::Nodal;
use crate::model::range;
use crate::number::cell::{Cell, sub};
use crate::number::two_float::LANES;

impl Nodal<'_> {
    /// The cells linked to a cell, ascending.
    fn others(self, cell: usize) -> impl Iterator<Item = usize> {
        self.slots_of(cell).map(|(other, _)| other).filter(move |&other| other != cell)
    }

    /// Sums over the half-links of a cell, from the displacements of any cells.
    #[inline(always)]
    fn gathered(self, cell: usize, displaced: impl Fn(usize) -> [f32; 3]) -> Gathered<f32> {
        let (here, mut sums) = (displaced(cell).map(Lane), Gathered::none());
        for (other, slot) in self.slots_of(cell) {
            sums.add(here, displaced(other).map(Lane), |row| Lane(slot.number(row)));
        }
        sums
    }

    fn own(self, cell: usize) -> Own<f32> {
        Own::of(|row| Lane(self.number(cell, row)))
    }

    /// Stores the states of the cells of a slice for a pass, and adds its forces to the cells' and their
    /// neighbours'.
    pub(super) fn stepped(self, cells: Range<usize>, from: SliceMemory<'_>, to: SliceMemory<'_>) {
        let slice = cells.start / LANES;
        let (Quads { displacements, .. }, forces) = (from.quads, from.quads.by_slice(slice));
        let displaced = |cell: usize| displacements.get(cell).map_or([0.0; 3], |u| u.get().xyz());
        let add_to = |cell: usize, [x, y, z, w]: [f32; 4]| {
            if let Some(sum) = forces.get(cell) {
                sum.set(sum.get().plus(Cell([x, y, z, w])));
            }
        };
        // The states, and the opposite of the stresses.
        let zero = Lane(0.0);
        let mut pulls = [([[zero; 3]; 3], [zero; 4]); LANES];
        for (lane, (cell, pull)) in cells.clone().zip(&mut pulls).enumerate() {
            let (turn, unit) = variables(ShapeState::load(lane, from));
            let sums = self.gathered(cell, displaced);
            let step = step(self.stretch_min, &sums, &self.own(cell), turn, unit);
            *pull = (each(step.stress, |x| zero - x), step.pull);
            let (turn, unit) = (step.turn.map(|x| x.0), each(step.unit, |x| x.0));
            ShapeState { turn, unit }.store(lane, to);
        }
        // The neighbours' forces, in the order of groups and lanes, then the cells' own.
        for group in range(self.rows, slice) {
            for (lane, (opposite, _)) in pulls.iter().enumerate() {
                let Some((other, slot)) = self.slot(group, lane) else { continue };
                let [x, y, z] = times(*opposite, three(slot.three(nodal::AREA), Lane));
                add_to(other, [x.0, y.0, z.0, 0.0]);
            }
        }
        for (cell, (_, pull)) in cells.zip(pulls) {
            add_to(cell, pull.map(|x| x.0));
        }
    }

    /// The shape of a cell at these positions, with unchanged rotation and shape of unit volume.
    fn here(self, cell: usize, state: ShapeState, at: &impl Fn(usize) -> [f32; 3]) -> Step<f32> {
        let (turn, unit) = variables(state);
        let sums = self.gathered(cell, |cell| sub(at(cell), self.rest_position(cell)));
        stay(self.stretch_min, &sums, &self.own(cell), turn, unit)
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
        for (other, _) in self.slots_of(cell).filter(|(other, _)| *other != cell) {
            let stress = self.here(other, states.shape(other), at).stress;
            let area = three(self.back_area(cell, other), Lane);
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
        // A displacement is rounded, and so is the difference of two.
        let displaced = |cell: usize| sub(at(cell), self.rest_position(cell));
        let sum = |[x, y, z]: [f32; 3]| x.abs() + y.abs() + z.abs();
        let (place, far) = (displaced(cell), sum(displaced(cell)));
        for (other, slot) in self.slots_of(cell) {
            let there = displaced(other);
            let stiffness = slot.number(nodal::SPREAD).abs() * sum(sub(there, place));
            scale += 4.0 * (sum(there) + far) * (size * sum(slot.three(nodal::AREA)) + stiffness);
        }
        sums.scale += scale;
    }
}

/// R and Q of a state.
#[inline(always)]
fn variables(state: ShapeState) -> ([Lane<f32>; 4], [[Lane<f32>; 3]; 3]) {
    (state.turn.map(Lane), three(state.unit, |row| three(row, Lane)))
}
