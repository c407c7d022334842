//! State of a cell: its rotation, its shape of unit volume, and the results of the last pass.

use core::cell::Cell as Shared;

use super::matrix::Matrix;
use super::nearest::Turn;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::lane::Lane;
use crate::energy::state::{Row, SliceMemory, StatesOf, TermState, number, put};
use crate::model::nodal::Nodal;
use crate::model::terms::Keeps;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// State of a cell's shape. Rotation and shape of unit volume persist from pass to pass; stress and pull
/// follow from them and the positions of the last pass. Neighbours read the stress from the cell's line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShapeState {
    /// R as a unit quaternion, the real part first.
    pub turn: [f32; 4],
    /// Q by rows.
    pub unit: [[f32; 3]; 3],
    /// P by rows; the fourth column is 0.
    pub stress: [[f32; 4]; 3],
    /// Force of the spread and of the cell's stress, and eight times the energy.
    pub pull: [f32; 4],
}

/// Result of a pass at a cell.
#[derive(Clone, Copy)]
pub(super) struct Step<V> {
    pub turn: Turn<V>,
    pub unit: Matrix<V>,
    /// P.
    pub stress: Matrix<V>,
    /// Force of the spread and of the cell's stress, and eight times the energy.
    pub pull: [Lane<V>; 4],
}

/// Rows of R and Q, and of the pull.
const LASTING: usize = <Nodal<'static> as Keeps>::LASTING;
const RESULTS: usize = <Nodal<'static> as Keeps>::RESULTS;

impl StatesOf<'_> {
    /// The shape of a cell.
    #[inline(always)]
    pub(super) fn shape(self, cell: usize) -> ShapeState {
        let slice = self.slice(cell / LANES);
        slice.map_or(ShapeState::REST, |memory| ShapeState::load(cell % LANES, memory))
    }
}

impl ShapeState {
    /// The state in the rest shape.
    const REST: Self = Self {
        turn: [1.0, 0.0, 0.0, 0.0],
        unit: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        stress: [[0.0; 4]; 3],
        pull: [0.0; 4],
    };

    /// The state of a lane.
    #[inline(always)]
    pub fn load(lane: usize, memory: SliceMemory<'_>) -> Self {
        let row = |row| number(memory.lasting, row, lane);
        let three = |first| [row(first), row(first + 1), row(first + 2)];
        Self {
            turn: [row(0), row(1), row(2), row(3)],
            unit: [three(4), three(7), three(10)],
            stress: memory.lines.get(lane).map_or([[0.0; 4]; 3], stress),
            pull: pull(memory.results, lane),
        }
    }

    /// Stores the state of a lane.
    #[inline(always)]
    pub fn store(self, lane: usize, memory: SliceMemory<'_>) {
        let ([p, q, r, s], [[a, b, c], [d, e, f], [g, h, i]]) = (self.turn, self.unit);
        put(memory.lasting, lane, [p, q, r, s, a, b, c, d, e, f, g, h, i]);
        put(memory.results, lane, self.pull);
        if let Some(line) = memory.lines.get(lane) {
            let [a, b, c] = self.stress;
            line.set(TermState([a, b, c, [0.0; 4]]));
        }
    }
}

/// The stress in a cell's line.
#[inline(always)]
pub(super) fn stress(line: &Shared<TermState>) -> [[f32; 4]; 3] {
    let TermState([a, b, c, _]) = line.get();
    [a, b, c]
}

/// The pull of a lane.
#[inline(always)]
pub(super) fn pull(results: &[Shared<Row>], lane: usize) -> [f32; 4] {
    let row = |row| number(results, row, lane);
    [row(0), row(1), row(2), row(3)]
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

#[inline(always)]
fn load_row<V: F32x8>(row: &Shared<Row>) -> Lane<V> {
    Lane(V::load(&row.get()))
}

#[inline(always)]
fn store_row<V: F32x8>(lanes: Lane<V>, row: &Shared<Row>) {
    let mut numbers = [0.0; LANES];
    lanes.0.store(&mut numbers);
    row.set(numbers);
}

/// Rotations and shapes of unit volume of the cells of a slice.
#[inline(always)]
pub(super) fn load<V: F32x8>(memory: SliceMemory<'_>) -> Option<(Turn<V>, Matrix<V>)> {
    let rows: &[Shared<Row>; LASTING] = memory.lasting.first_chunk()?;
    let [p, q, r, s, a, b, c, d, e, f, g, h, i] = rows;
    let turn = [load_row(p), load_row(q), load_row(r), load_row(s)];
    let unit = [
        [load_row(a), load_row(b), load_row(c)],
        [load_row(d), load_row(e), load_row(f)],
        [load_row(g), load_row(h), load_row(i)],
    ];
    Some((turn, unit))
}

/// The pulls of the cells of a slice.
#[inline(always)]
pub(super) fn load_pull<V: F32x8>(results: &[Shared<Row>]) -> Option<[V; 4]> {
    let [a, b, c, d]: &[Shared<Row>; RESULTS] = results.first_chunk()?;
    Some([load_row(a).0, load_row(b).0, load_row(c).0, load_row(d).0])
}

/// The rows of a matrix for eight cells.
#[inline(always)]
fn row<V: F32x8>([a, b, c]: [Lane<V>; 3]) -> Chunk {
    let mut chunk = [Cell::ZERO; LANES];
    V::put_transposed([a.0, b.0, c.0, V::splat(0.0)], &mut chunk);
    chunk
}

/// Stores the results of a pass over the first `cells` cells of a slice; the padding stays at rest.
#[inline(always)]
pub(super) fn store<V: F32x8>(step: &Step<V>, memory: SliceMemory<'_>, cells: usize) {
    let Some(rows) = memory.lasting.first_chunk::<LASTING>() else { return };
    let Some(results) = memory.results.first_chunk::<RESULTS>() else { return };
    // R, Q and the pull by rows.
    let ([p, q, r, s], [w, x, y, z]) = (step.turn, step.pull);
    let [[a, b, c], [d, e, f], [g, h, i]] = step.unit;
    for (row, lanes) in rows.iter().zip([p, q, r, s, a, b, c, d, e, f, g, h, i]) {
        store_row(lanes, row);
    }
    for (row, lanes) in results.iter().zip([w, x, y, z]) {
        store_row(lanes, row);
    }
    // The stress by cells.
    let [a, b, c] = step.stress;
    let (a, b, c) = (row(a), row(b), row(c));
    for (((line, a), b), c) in memory.lines.iter().zip(a).zip(b).zip(c) {
        line.set(TermState([a.0, b.0, c.0, [0.0; 4]]));
    }
    for lane in cells..LANES {
        ShapeState::REST.store(lane, memory);
    }
}
