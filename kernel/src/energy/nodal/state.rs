//! State of a cell: its rotation and its shape of unit volume.

use core::cell::Cell as Shared;

use super::matrix::Matrix;
use super::nearest::Turn;
use crate::backend::f32x8::F32x8;
use crate::backend::lane::Lane;
use crate::energy::state::{Row, SliceMemory, StatesOf, put};
use crate::model::nodal::Nodal;
use crate::model::terms::Keeps;
use crate::number::two_float::LANES;

/// State of a cell's shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ShapeState {
    /// R as a unit quaternion, the real part first.
    pub turn: [f32; 4],
    /// Q by rows.
    pub unit: [[f32; 3]; 3],
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

/// Rows of R and Q.
const LASTING: usize = <Nodal<'static> as Keeps>::LASTING;

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
    };

    /// The state of a lane, 0 beyond the eighth.
    #[inline(always)]
    pub fn load(lane: usize, memory: SliceMemory<'_>) -> Self {
        let Some(rows) = memory.lasting.first_chunk::<LASTING>() else { return Self::REST };
        let rows =
            rows.each_ref().map(|row| row.as_array_of_cells().get(lane).map_or(0.0, Shared::get));
        let [p, q, r, s, a, b, c, d, e, f, g, h, i] = rows;
        Self { turn: [p, q, r, s], unit: [[a, b, c], [d, e, f], [g, h, i]] }
    }

    /// Stores the state of a lane.
    #[inline(always)]
    pub fn store(self, lane: usize, memory: SliceMemory<'_>) {
        let Some(rows) = memory.lasting.first_chunk::<LASTING>() else { return };
        let ([p, q, r, s], [[a, b, c], [d, e, f], [g, h, i]]) = (self.turn, self.unit);
        put(rows, lane, [p, q, r, s, a, b, c, d, e, f, g, h, i]);
    }
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

/// Stores rotations and shapes of unit volume of the first `cells` cells of a slice; the padding stays at rest.
#[inline(always)]
pub(super) fn store<V: F32x8>(step: &Step<V>, memory: SliceMemory<'_>, cells: usize) {
    let Some(rows) = memory.lasting.first_chunk::<LASTING>() else { return };
    let [p, q, r, s] = step.turn;
    let [[a, b, c], [d, e, f], [g, h, i]] = step.unit;
    for (row, lanes) in rows.iter().zip([p, q, r, s, a, b, c, d, e, f, g, h, i]) {
        store_row(lanes, row);
    }
    for lane in cells..LANES {
        ShapeState::REST.store(lane, memory);
    }
}
