//! Shapes cell by cell, in a pass and at any positions.

use core::ops::Range;

use super::gather::{Ends, number};
use super::law::{self, shape, shifted};
use super::matrix::{Matrix, each, inner, minus, three, times};
use super::nearest::{self, Turn};
use super::state::ShapeState;
use super::strain::step_turn;
use super::sums::{Gathered, Kept, Own};
use crate::backend::lane::Lane;
use crate::energy::held::Touched;
use crate::energy::state::{Quads, SliceMemory, StatesOf};
use crate::model::image::nodal;
use crate::model::nodal::Nodal;
use crate::number::cell::{Cell, add, sub};
#[cfg(feature = "cut")]
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

impl Nodal<'_> {
    /// The cells linked to a cell, ascending.
    pub(super) fn others(self, cell: usize) -> impl Iterator<Item = usize> {
        self.half_links_of(cell).map(|(other, _)| other)
    }

    /// Material numbers of a cell.
    pub(super) fn own(self, cell: usize) -> Own<'static, f32> {
        let (slice, lane) = (cell / LANES, cell % LANES);
        let numbers = self.cells.get(slice);
        Own::of(|row| Lane(numbers.map_or(0.0, |numbers| number(numbers, row, lane))))
    }

    /// Offset and memory of a cell with this displacement.
    pub(super) fn kept(self, cell: usize, displacement: [f32; 3]) -> Kept {
        Kept::of_cell(self, cell, displacement.map(Lane))
    }

    /// The shape F of a cell at these positions, without its offset.
    pub(crate) fn shape_at(self, cell: usize, at: &impl Fn(usize) -> [f32; 3]) -> [[f32; 3]; 3] {
        let displaced = |cell: usize| sub(at(cell), self.rest_position(cell)).map(Lane);
        let (here, mut sums) = (displaced(cell), Gathered::none());
        for (other, slot) in self.slots_of(cell) {
            sums.add(here, displaced(other), |row| Lane(slot.number(row)));
        }
        each(shape(&sums, &self.own(cell)), |x| x.0)
    }

    /// Four times the energy of these cells at these positions, with a bound of its rounding error: that of
    /// [`Self::add_stored`], and 4 eps V |P| |F| for the shape, whose elements are near 1.
    #[cfg(feature = "cut")]
    pub(crate) fn stored(
        self,
        cells: impl Iterator<Item = usize>,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
    ) -> Touched {
        let mut sums = Touched::NONE;
        for cell in cells {
            let before = sums.wd2;
            self.add_stored(cell, &|_| false, at, states, &mut sums);
            let own = self.own(cell);
            let stiffness = own.volume.0 * (2.0 * own.mu.0 + own.lambda_3.0 + own.band.0);
            sums.scale += 8.0 * sqrt(0.5 * sums.wd2.minus(before).hi.abs() * stiffness);
        }
        sums
    }

    /// Stores the states of the cells of a slice for a pass, and adds its forces to the cells' and their
    /// neighbours'.
    pub(super) fn stepped(self, cells: Range<usize>, from: SliceMemory<'_>, to: SliceMemory<'_>) {
        let slice = cells.start / LANES;
        let (Quads { displacements, .. }, forces) = (from.quads, from.quads.by_slice(slice));
        let ends = Ends::of(self, displacements).zip(Ends::of(self, forces));
        let (Some(numbers), Some((displacements, forces))) = (self.cells.get(slice), ends) else {
            return;
        };
        let (offset, memory) = (self.offset_of(slice), self.memory_of(slice));
        // The states and the stresses.
        let zero = Lane(0.0);
        let (mut stresses, mut pulls) = ([[[zero; 3]; 3]; LANES], [[zero; 4]; LANES]);
        let each_lane = stresses.iter_mut().zip(&mut pulls).enumerate().take(cells.len());
        for (lane, (stress, pull)) in each_lane {
            let Some(sums) = Gathered::of_lane(displacements, slice, lane) else { return };
            let kept;
            let mut own = Own::of(|row| Lane(number(numbers, row, lane)));
            if offset.is_some() || memory.is_some() {
                let here = displacements.own(slice).and_then(|own| own.get(lane));
                let here = here.map_or([zero; 3], |here| here.get().xyz().map(Lane));
                kept = Kept::of_lane(lane, offset, memory, here);
                own = own.keeping(&kept);
            }
            let (mut turn, mut unit) = variables(ShapeState::load(lane, from));
            let f = shifted(shape(&sums, &own), &own);
            turned(self.stretch_min, &f, &own, &mut turn);
            let squared = of_unit_volume(&f, &mut unit);
            let state = ShapeState { turn: turn.map(|x| x.0), unit: each(unit, |x| x.0) };
            state.store(lane, to);
            *pull = respond(stress, self.stretch_min, &sums, &own, &turn, &unit, squared);
        }
        // The neighbours' forces, in the order of groups and lanes, then the cells' own.
        forces.push_each(slice, &stresses);
        let own = forces.own(slice).map_or(&[][..], |own| own);
        for (sum, pull) in own.iter().zip(pulls).take(cells.len()) {
            sum.set(sum.get().plus(Cell(pull.map(|x| x.0))));
        }
    }

    /// Adds force, energy and rounding of the cells `held`, ascending, and of all cells linked to them, each
    /// once.
    pub(super) fn stored_around(
        self,
        held: impl Iterator<Item = usize>,
        is_held: &impl Fn(usize) -> bool,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        for (index, cell) in held.enumerate() {
            self.add_stored(cell, is_held, at, states, sums);
            for other in self.others(cell) {
                // A cell that is linked to several held ones counts with the first of them.
                let is_earlier = |next: usize| next < cell && is_held(next);
                let is_known = || index > 0 && self.others(other).any(is_earlier);
                if !is_held(other) && !is_known() {
                    self.add_stored(other, is_held, at, states, sums);
                }
            }
        }
    }

    /// Adds four times the energy of a cell at these positions, with unchanged rotation and shape of unit volume,
    /// a bound of that value's rounding error, and the cell's force on held cells.
    fn add_stored(
        self,
        cell: usize,
        is_held: &impl Fn(usize) -> bool,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        // Sums over the half-links. A displacement is rounded, and so is the difference of two.
        let displaced = |cell: usize| sub(at(cell), self.rest_position(cell));
        let sum = |[x, y, z]: [f32; 3]| x.abs() + y.abs() + z.abs();
        let here = displaced(cell);
        let (far, mut gathered, mut of_areas, mut of_spread) =
            (sum(here), Gathered::none(), 0.0, 0.0);
        for (other, slot) in self.half_links_of(cell) {
            let there = displaced(other);
            gathered.add(here.map(Lane), there.map(Lane), |row| Lane(slot.number(row)));
            let far = sum(there) + far;
            of_areas += far * sum(slot.three(nodal::AREA));
            of_spread += far * slot.number(nodal::SPREAD).abs() * sum(sub(there, here));
        }
        // Stress and energy.
        let ((turn, unit), kept) = (variables(states.shape(cell)), self.kept(cell, here));
        let own = self.own(cell).keeping(&kept);
        let off = minus(shifted(shape(&gathered, &own), &own), unit);
        let (mut stress, squared) = ([[Lane(0.0); 3]; 3], inner(off, off));
        let pull = respond(&mut stress, self.stretch_min, &gathered, &own, &turn, &unit, squared);
        let [x, y, z, energy] = pull.map(|x| x.0);
        sums.wd2 = sums.wd2.plus((0.5 * energy).into());
        let [a, b, c] = stress.map(|row| sum(row.map(|x| x.0)));
        sums.scale += 0.5 * energy.abs() + 4.0 * ((a + b + c) * of_areas + of_spread);
        sums.scale += own.memory.map_or(0.0, |memory| memory.scale());
        // Forces on held cells.
        if is_held(cell) {
            sums.force = add(sums.force, [x, y, z]);
        }
        for (_, slot) in self.half_links_of(cell).filter(|&(other, _)| is_held(other)) {
            let push = times(stress, three(slot.three(nodal::AREA), Lane));
            sums.force = sub(sums.force, push.map(|x| x.0));
        }
    }
}

// The steps of one shape, not inlined and in place: each has the registers for itself.

#[inline(never)]
fn turned(stretch_min: f32, f: &Matrix<f32>, own: &Own<'_, f32>, turn: &mut Turn<f32>) {
    *turn = step_turn(stretch_min, *f, own, *turn);
}

#[inline(never)]
fn of_unit_volume(f: &Matrix<f32>, unit: &mut Matrix<f32>) -> Lane<f32> {
    let (next, squared) = nearest::of_unit_volume(*f, *unit);
    *unit = next;
    squared
}

/// Sets P from R, Q and the squared distance of F and Q. Returns force and energy.
#[inline(never)]
fn respond(
    stress: &mut Matrix<f32>,
    stretch_min: f32,
    sums: &Gathered<f32>,
    own: &Own<'_, f32>,
    turn: &Turn<f32>,
    unit: &Matrix<f32>,
    squared: Lane<f32>,
) -> [Lane<f32>; 4] {
    let step = law::respond(stretch_min, sums, own, *turn, *unit, squared);
    *stress = step.stress;
    step.pull
}

/// R and Q of a state.
#[inline(always)]
fn variables(state: ShapeState) -> ([Lane<f32>; 4], [[Lane<f32>; 3]; 3]) {
    (state.turn.map(Lane), three(state.unit, |row| three(row, Lane)))
}
