//! Pins: half the squared distance of a cell to an anchor. A term used only in this crate's tests, which
//! shows how to add one: its two files, and the list in `model::others`.
//!
//! The anchor is the pin's point plus two displacements, the term's state. It slips: before a pass it follows
//! a cell that is farther away than the slip length, which lowers the energy. And it relaxes: at the start of
//! a tick by a share of the cell's distance from the unrelaxed anchor. That is a linear part of residual and
//! energy, and its change of the energy is booked.

use core::ops::Range;

use super::held::{Contact, Touched};
use super::links::number::LinkNumber;
use super::state::{SliceMemory, StatesOf, number, put};
use super::term::{Here, Pass, Term, change_lane};
use crate::backend::f32x8::{Chunk, F32x8};
use crate::model::pin::{Pin, Pins};
use crate::number::cell::{Cell, add, dot, from_single, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

/// Slip of an anchor, and its relaxation in this tick [mean link lengths].
pub(crate) type Displaced = [[f32; 3]; 2];

/// The displacements of a lane.
pub(crate) fn load(lane: usize, memory: SliceMemory<'_>) -> Displaced {
    let number = |row| number(memory.lasting, row, lane);
    [[number(0), number(1), number(2)], [number(3), number(4), number(5)]]
}

pub(crate) fn store(state: Displaced, lane: usize, memory: SliceMemory<'_>) {
    put(memory.lasting, lane, state.into_iter().flatten());
}

/// The displacements of a cell.
pub(crate) fn displaced(states: StatesOf<'_>, cell: usize) -> Displaced {
    states.slice(cell / LANES).map_or_else(Displaced::default, |memory| load(cell % LANES, memory))
}

impl Pin {
    /// Position of the anchor.
    pub fn anchor(&self, [slipped, given]: Displaced) -> [f32; 3] {
        add(add(self.point, slipped), given)
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
fn pin_force<N: LinkNumber>(pin: &Pin, state: Displaced, here: [N; 3]) -> ([N; 3], N::Product) {
    let way = sub(from_single(pin.anchor(state)), here);
    let wd = scale(N::from_single(pin.weight), way);
    (scale(N::from_single(0.5), wd), N::inner(wd, way))
}

/// Adds the pin to a cell's residual: a pin's energy counts twice, like that of a link's two ends.
#[inline(always)]
fn with_pin<N: LinkNumber>(residual: Cell<N>, ([x, y, z], wd2): ([N; 3], N::Product)) -> Cell<N> {
    let mark = N::mark(wd2);
    residual.plus(Cell([x, y, z, N::ZERO])).plus(Cell([N::ZERO, N::ZERO, N::ZERO, mark.plus(mark)]))
}

/// The state of a cell for a pass with the cell at `here`.
fn slipped(pin: &Pin, state: Displaced, here: [f32; 3]) -> Displaced {
    let ([slipped, given], way) = (state, sub(here, pin.anchor(state)));
    let distance = sqrt(dot(way, way));
    if distance <= pin.slip_length {
        return state;
    }
    let share = (distance - pin.slip_length) / distance;
    let next = [add(slipped, scale(share, way)).map(|x| x + 0.0), given];
    // Rounding must not raise the energy.
    if pin.energy(next, here) < pin.energy(state, here) { next } else { state }
}

impl<N: LinkNumber> Term<N> for Pins<'_> {
    fn begin_tick(
        self,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
        changed: &mut impl FnMut(usize),
    ) -> f64 {
        let mut rise = 0.0;
        for pin in self.iter() {
            let (state, here) = (displaced(states, pin.cell), at(pin.cell));
            let way = sub(here, add(pin.point, state[0]));
            // -0.0 becomes +0.0.
            let next = [state[0], scale(pin.give, way).map(|x| x + 0.0)];
            if next != state
                && let Some(memory) = states.change(pin.cell / LANES)
            {
                store(next, pin.cell % LANES, memory);
                rise += pin.energy(next, here) - pin.energy(state, here);
                changed(pin.cell);
            }
        }
        rise
    }

    fn update(
        self,
        cells: Range<usize>,
        at: &impl Fn(usize) -> [f32; 3],
        from: SliceMemory<'_>,
        to: SliceMemory<'_>,
    ) {
        for (lane, cell) in cells.enumerate() {
            let state = load(lane, from);
            let next = self.at(cell).map_or(state, |pin| slipped(&pin, state, at(cell)));
            store(next, lane, to);
        }
    }

    #[inline(always)]
    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        states: StatesOf<'_>,
    ) {
        for pin in self.iter().filter(|pin| pass.awake.contains(pin.cell / LANES)) {
            let force = pin_force(&pin, displaced(states, pin.cell), pass.at(pin.cell));
            if force.0 != [N::ZERO; 3]
                && let Some(r) = residual.get_mut(pin.cell)
            {
                *r = with_pin(*r, force);
                N::count(tally, force.1);
            }
        }
    }

    /// Lane by lane, since few slices have a pin.
    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        states: StatesOf<'_>,
    ) {
        for lane in 0..LANES {
            let cell = here.slice * LANES + lane;
            if let (Some(pin), Some(v)) = (self.at(cell), here.at.get(cell)) {
                let force = pin_force(&pin, displaced(states, cell), v.xyz());
                if force.0 != [0.0; 3] {
                    change_lane(sum, lane, |r| with_pin(r, force));
                }
            }
        }
    }

    fn cell(
        self,
        cell: usize,
        _: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_>,
        sum: [f32; 3],
    ) -> [f32; 3] {
        let force = |pin| pin_force(&pin, displaced(states, cell), single(at(cell))).0;
        self.at(cell).map_or(sum, |pin| add(sum, force(pin)))
    }

    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        for pin in held.iter().filter_map(|contact| self.at(contact.cell())) {
            let (state, here) = (displaced(states, pin.cell), single(at(pin.cell)));
            let (residual, wd2) = pin_force(&pin, state, here);
            let (wd, anchor) = (2.0 * sqrt(dot(residual, residual)), pin.anchor(state));
            sums.wd2 = sums.wd2.plus(wd2.into());
            sums.scale += wd2 + wd * sqrt(dot(anchor, anchor));
        }
    }
}
