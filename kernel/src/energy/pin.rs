//! Pins: half the squared distance of a cell to an anchor. A term used only in this crate's tests, which
//! shows how to add one: its two files, and the list in `model::others`.
//!
//! The anchor is the pin's point plus two displacements, the term's state. It slips: before a pass it follows
//! a cell that is farther away than the slip length, which lowers the energy. And it relaxes: at the start of
//! a tick by a share of the cell's distance from the unrelaxed anchor. That is a linear part of residual and
//! energy, and its change of the energy is booked.

use core::ops::Range;

use super::held::{Contact, Touched};
use super::number::TermNumber;
use super::state::{CellState, SliceMemory, StatesOf, number, put};
use super::term::Term;
use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::model::COORDINATE_MAX;
use crate::model::pin::{Pin, Pins};
use crate::number::cell::{Cell, add, dot, from_single, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

/// Slip of an anchor, and its relaxation in this tick [mean link lengths].
pub(crate) type Displaced = [[f32; 3]; 2];

impl CellState for Displaced {
    const REST: Self = [[0.0; 3]; 2];
    const LASTING: usize = 6;

    fn load(lane: usize, memory: SliceMemory<'_>) -> Self {
        let number = |row| number(memory.lasting, row, lane);
        [[number(0), number(1), number(2)], [number(3), number(4), number(5)]]
    }

    fn store(self, lane: usize, memory: SliceMemory<'_>) {
        put(memory.lasting, lane, self.into_iter().flatten());
    }

    fn is_valid(self) -> bool {
        // An anchor is at most twice the range of a coordinate from its point.
        self.as_flattened().iter().all(|x| x.abs() <= 2.0 * COORDINATE_MAX)
    }
}

impl Pin {
    /// Position of the anchor.
    pub fn anchor(&self, [slipped, given]: Displaced) -> [f32; 3] {
        add(add(self.point, slipped), given)
    }

    /// The state for a pass with the cell at `here`.
    fn slipped(&self, state: Displaced, here: [f32; 3]) -> Displaced {
        let ([slipped, given], way) = (state, sub(here, self.anchor(state)));
        let distance = sqrt(dot(way, way));
        if distance <= self.slip_length {
            return state;
        }
        let share = (distance - self.slip_length) / distance;
        let next = [add(slipped, scale(share, way)).map(|x| x + 0.0), given];
        // Rounding must not raise the energy.
        if self.energy(next, here) < self.energy(state, here) { next } else { state }
    }

    /// w d^2 / 4 with the cell at `here`, in double precision.
    fn energy(&self, state: Displaced, here: [f32; 3]) -> f64 {
        let way = sub(self.anchor(state), here).map(f64::from);
        f64::from(self.weight) * (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]) / 4.0
    }
}

/// The residual w (a - y) / 2 of a cell at y with the anchor a, and w d^2. In fixed point, w times twice K
/// must stay below the largest number.
#[inline(always)]
fn pin_force<N: TermNumber>(pin: &Pin, state: Displaced, here: [N; 3]) -> ([N; 3], N::Product) {
    let way = sub(from_single(pin.anchor(state)), here);
    let wd = scale(N::from_single(pin.weight), way);
    (scale(N::from_single(0.5), wd), N::inner(wd, way))
}

/// Adds the pin to a cell's residual: a pin's energy counts twice, like that of a link's two ends.
#[inline(always)]
fn with_pin<N: TermNumber>(residual: Cell<N>, ([x, y, z], wd2): ([N; 3], N::Product)) -> Cell<N> {
    let mark = N::mark(wd2);
    residual.plus(Cell([x, y, z, N::ZERO])).plus(Cell([N::ZERO, N::ZERO, N::ZERO, mark.plus(mark)]))
}

impl Term for Pins<'_> {
    type State = Displaced;

    fn corrects(self) -> bool {
        self.iter().next().is_some()
    }

    fn begin_tick(
        self,
        cell: usize,
        state: Displaced,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> (Displaced, f64) {
        let Some(pin) = self.at(cell) else { return (state, 0.0) };
        let ([slipped, _], here) = (state, at(cell));
        let way = sub(here, add(pin.point, slipped));
        // -0.0 becomes +0.0.
        let next = [slipped, scale(pin.give, way).map(|x| x + 0.0)];
        (next, pin.energy(next, here) - pin.energy(state, here))
    }

    fn update(
        self,
        cells: Range<usize>,
        at: &impl Fn(usize) -> [f32; 3],
        from: SliceMemory<'_>,
        to: SliceMemory<'_>,
    ) {
        for (lane, cell) in cells.enumerate() {
            let state = Displaced::load(lane, from);
            let next = self.at(cell).map_or(state, |pin| pin.slipped(state, at(cell)));
            next.store(lane, to);
        }
    }

    #[inline(always)]
    fn accumulate<N: TermNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        output: &impl Fn([N; 3]) -> [N; 3],
        states: StatesOf<'_, Displaced>,
    ) {
        for pin in self.iter().filter(|pin| awake.contains(pin.cell / LANES)) {
            if let (Some(v), Some(r)) = (v.get(pin.cell), residual.get_mut(pin.cell)) {
                let force = pin_force(&pin, states.at(pin.cell), output(v.xyz()));
                if force.0 != [N::ZERO; 3] {
                    *r = with_pin(*r, force);
                    N::count(tally, force.1);
                }
            }
        }
    }

    /// Lane by lane, since few slices have a pin.
    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        slice: usize,
        at: &[Cell],
        sum: &mut [V; 4],
        states: StatesOf<'_, Displaced>,
    ) {
        for cell in slice * LANES..at.len().min((slice + 1) * LANES) {
            if let (Some(pin), Some(v)) = (self.at(cell), at.get(cell)) {
                let mut lanes = [[0.0; LANES]; 4];
                for (sum, lanes) in sum.iter().zip(&mut lanes) {
                    sum.store(lanes);
                }
                let lane = cell % LANES;
                let force = pin_force(&pin, states.at(cell), v.xyz());
                if force.0 != [0.0; 3] {
                    let Cell(with) = with_pin(Cell(lanes.map(|lanes| lanes[lane])), force);
                    for ((sum, lanes), value) in sum.iter_mut().zip(&mut lanes).zip(with) {
                        lanes[lane] = value;
                        *sum = V::load(lanes);
                    }
                }
            }
        }
    }

    fn cell<N: TermNumber>(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_, Displaced>,
        add: &mut impl FnMut([f32; 3]),
    ) {
        if let Some(pin) = self.at(cell) {
            add(pin_force(&pin, states.at(cell), single(at(cell))).0);
        }
    }

    fn touched<N: TermNumber>(
        self,
        held: &[Contact<N>],
        output: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_, Displaced>,
        sums: &mut Touched,
    ) {
        for pin in held.iter().filter_map(|contact| self.at(contact.cell())) {
            let (state, here) = (states.at(pin.cell), single(output(pin.cell)));
            let (residual, wd2) = pin_force(&pin, state, here);
            let (wd, anchor) = (2.0 * sqrt(dot(residual, residual)), pin.anchor(state));
            sums.wd2 = sums.wd2.plus(wd2.into());
            sums.scale += wd2 + wd * sqrt(dot(anchor, anchor));
        }
    }

    fn add_move(self, cell: usize, squared: f32, sum: f32) -> f32 {
        self.at(cell).map_or(sum, |pin| sum + pin.weight * squared)
    }
}
