//! What a cell keeps: its rotation, its shape of unit volume, and what the last pass found.

use super::law::Step;
use super::matrix::Matrix;
use super::nearest::Turn;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::number::cell::Cell;
use crate::number::lane::Lane;
use crate::number::two_float::LANES;
use crate::terms::state::CellState;

/// State of a cell's shape. Rotation and shape of unit volume are what it keeps from pass to pass;
/// stress and pull follow from them and the positions of the last pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShapeState {
    /// R as a unit quaternion, the real part first.
    pub turn: [f32; 4],
    /// Q by rows; the fourth column is 0.
    pub unit: [[f32; 4]; 3],
    /// P by rows; the fourth column is 0.
    pub stress: [[f32; 4]; 3],
    /// Force of the spread and of the own stress, and eight times the energy.
    pub pull: [f32; 4],
}

impl CellState for ShapeState {
    const REST: Self = Self {
        turn: [1.0, 0.0, 0.0, 0.0],
        unit: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        stress: [[0.0; 4]; 3],
        pull: [0.0; 4],
    };
    type Words = core::array::IntoIter<u32, 13>;

    fn words(self) -> Self::Words {
        let [[a, b, c, _], [d, e, f, _], [g, h, i, _]] = self.unit;
        let [p, q, r, s] = self.turn;
        [p, q, r, s, a, b, c, d, e, f, g, h, i].map(f32::to_bits).into_iter()
    }

    fn from_words(words: &mut impl Iterator<Item = u32>) -> Option<Self> {
        let mut next = || words.next().map(|word| f32::from_bits(word) + 0.0);
        let turn = [next()?, next()?, next()?, next()?];
        let mut row = || Some([next()?, next()?, next()?, 0.0]);
        let unit = [row()?, row()?, row()?];
        let size = turn.iter().fold(0.0, |sum, x| sum + x * x);
        let is_state =
            (0.99..1.01).contains(&size) && unit.as_flattened().iter().all(|x| x.is_finite());
        is_state.then_some(Self { turn, unit, ..Self::REST })
    }
}

/// Eight times four numbers.
#[inline(always)]
pub(super) fn chunk(of: impl Fn(usize) -> [f32; 4]) -> Chunk {
    core::array::from_fn(|lane| Cell(of(lane)))
}

/// The lanes of eight times three numbers.
#[inline(always)]
fn rows<V: F32x8>(of: impl Fn(usize, usize) -> [f32; 4]) -> [[V; 3]; 3] {
    let row = |row: usize| {
        let [x, y, z, _] = V::transposed(&chunk(|lane| of(row, lane)));
        [x, y, z]
    };
    [row(0), row(1), row(2)]
}

#[inline(always)]
fn lanes<V>(rows: [[V; 3]; 3]) -> Matrix<V> {
    rows.map(|row| row.map(Lane))
}

/// Rotations and shapes of unit volume of eight cells.
#[inline(always)]
pub(super) fn load<V: F32x8>(states: &[ShapeState; LANES]) -> (Turn<V>, Matrix<V>) {
    let at = |lane: usize| states.get(lane).copied().unwrap_or(ShapeState::REST);
    let turn = V::transposed(&chunk(|lane| at(lane).turn)).map(Lane);
    let unit = rows(|row, lane| at(lane).unit.get(row).copied().unwrap_or([0.0; 4]));
    (turn, lanes(unit))
}

/// Puts what a pass found into the states of eight cells.
#[inline(always)]
pub(super) fn store<V: F32x8>(step: Step<V>, states: &mut [ShapeState; LANES]) {
    let zero = V::splat(0.0);
    let put = |lanes: [V; 4]| {
        let mut chunk = [Cell::ZERO; LANES];
        V::put_transposed(lanes, &mut chunk);
        chunk
    };
    let row = |[a, b, c]: [Lane<V>; 3]| put([a.0, b.0, c.0, zero]);
    let (turn, pull) = (put(step.turn.map(|x| x.0)), put(step.pull.map(|x| x.0)));
    let (unit, stress) = (step.unit.map(row), step.stress.map(row));
    let of = |chunk: &Chunk, lane: usize| chunk.get(lane).map_or([0.0; 4], |cell| cell.0);
    for (lane, state) in states.iter_mut().enumerate() {
        *state = ShapeState {
            turn: of(&turn, lane),
            unit: [of(&unit[0], lane), of(&unit[1], lane), of(&unit[2], lane)],
            stress: [of(&stress[0], lane), of(&stress[1], lane), of(&stress[2], lane)],
            pull: of(&pull, lane),
        };
    }
}

/// The stresses of eight cells, by rows.
#[inline(always)]
pub(super) fn stresses<V: F32x8>(
    ids: &[u16; LANES],
    state: &impl Fn(usize) -> ShapeState,
) -> [[V; 3]; 3] {
    let id = |lane: usize| ids.get(lane).copied().map_or(0, usize::from);
    rows(|row, lane| state(id(lane)).stress.get(row).copied().unwrap_or([0.0; 4]))
}
