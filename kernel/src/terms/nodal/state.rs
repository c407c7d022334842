//! State of a cell: its rotation, its shape of unit volume, and the results of the last pass.

use super::law::Step;
use super::matrix::{Matrix, each};
use super::nearest::Turn;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::lane::Lane;
use crate::number::cell::Cell;
use crate::number::kept::kept;
use crate::number::two_float::LANES;
use crate::terms::state::CellState;

kept! {
    /// State of a cell's shape. Rotation and shape of unit volume persist from pass to pass; stress and pull
    /// follow from them and the positions of the last pass, and share a cache line: neighbours read the stress.
    #[derive(Debug, Clone, Copy, PartialEq)]
    #[repr(C, align(64))]
    pub(crate) struct ShapeState {
        /// R as a unit quaternion, the real part first.
        pub turn: [f32; 4],
        /// Q by rows; the fourth column is 0.
        pub unit: [[f32; 4]; 3],
        /// P by rows; the fourth column is 0.
        pub stress: [[f32; 4]; 3],
        /// Force of the spread and of the cell's stress, and eight times the energy.
        pub pull: [f32; 4],
    }
}

impl CellState for ShapeState {
    const REST: Self = Self {
        turn: [1.0, 0.0, 0.0, 0.0],
        unit: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        ..Self::ZERO
    };
    const ZERO: Self =
        Self { turn: [0.0; 4], unit: [[0.0; 4]; 3], stress: [[0.0; 4]; 3], pull: [0.0; 4] };
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
    [
        Cell(of(0)),
        Cell(of(1)),
        Cell(of(2)),
        Cell(of(3)),
        Cell(of(4)),
        Cell(of(5)),
        Cell(of(6)),
        Cell(of(7)),
    ]
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

/// Rotations and shapes of unit volume of eight cells.
#[inline(always)]
pub(super) fn load<V: F32x8>(states: &[ShapeState; LANES]) -> (Turn<V>, Matrix<V>) {
    let at = |lane: usize| states.get(lane).copied().unwrap_or(ShapeState::REST);
    let [p, q, r, s] = V::transposed(&chunk(|lane| at(lane).turn));
    let unit = rows(|row, lane| at(lane).unit.get(row).copied().unwrap_or([0.0; 4]));
    ([Lane(p), Lane(q), Lane(r), Lane(s)], each(unit, Lane))
}

/// Eight cells of four numbers each.
#[inline(always)]
fn cells<V: F32x8>([a, b, c, d]: [Lane<V>; 4]) -> Chunk {
    let mut chunk = [Cell::ZERO; LANES];
    V::put_transposed([a.0, b.0, c.0, d.0], &mut chunk);
    chunk
}

/// Rows of a matrix for eight cells.
#[inline(always)]
fn row<V: F32x8>([a, b, c]: [Lane<V>; 3]) -> Chunk {
    cells([a, b, c, Lane::of(0.0)])
}

/// Writes the results of a pass into the states of eight cells.
#[inline(always)]
pub(super) fn store<V: F32x8>(step: Step<V>, states: &mut [ShapeState; LANES]) {
    let (turn, pull) = (cells(step.turn), cells(step.pull));
    let ([a, b, c], [d, e, f]) = (step.unit, step.stress);
    let ([a, b, c], [d, e, f]) = ([row(a), row(b), row(c)], [row(d), row(e), row(f)]);
    let of = |chunk: &Chunk, lane: usize| chunk.get(lane).map_or([0.0; 4], |cell| cell.0);
    for (lane, state) in states.iter_mut().enumerate() {
        *state = ShapeState {
            turn: of(&turn, lane),
            unit: [of(&a, lane), of(&b, lane), of(&c, lane)],
            stress: [of(&d, lane), of(&e, lane), of(&f, lane)],
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
