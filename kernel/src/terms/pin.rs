//! Pins: half the squared distance of a cell to a point. A term of this crate's tests alone, which
//! shows what adding one takes: its two files, and the list in `model::terms`.

use super::held::{Contact, Touched};
use super::number::TermNumber;
use super::term::{CellTerm, Term};
use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::model::pin::{Pin, Pins};
use crate::number::cell::{Cell, dot, from_single, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

/// The residual w (p - y) / 2 of a cell at y, and w d^2. In fixed point, w times twice K is to stay
/// below the largest number.
#[inline(always)]
fn pull<N: TermNumber>(pin: &Pin, here: [N; 3]) -> ([N; 3], N::Product) {
    let way = sub(from_single(pin.point), here);
    let wd = scale(N::from_single(pin.weight), way);
    (scale(N::from_single(0.5), wd), N::inner(wd, way))
}

/// The residual of a cell with its pin's: at a pin the energy counts as at both ends of a link.
#[inline(always)]
fn pulled<N: TermNumber>(residual: Cell<N>, ([x, y, z], wd2): ([N; 3], N::Product)) -> Cell<N> {
    let mark = N::mark(wd2);
    residual.plus(Cell([x, y, z, N::ZERO])).plus(Cell([N::ZERO, N::ZERO, N::ZERO, mark.plus(mark)]))
}

impl Term for Pins<'_> {
    #[inline(always)]
    fn accumulate<N: TermNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        output: &impl Fn([N; 3]) -> [N; 3],
    ) {
        for pin in self.iter().filter(|pin| awake.contains(pin.cell / LANES)) {
            if let (Some(v), Some(r)) = (v.get(pin.cell), residual.get_mut(pin.cell)) {
                let pull = pull(&pin, output(v.xyz()));
                if pull.0 != [N::ZERO; 3] {
                    *r = pulled(*r, pull);
                    N::count(tally, pull.1);
                }
            }
        }
    }

    /// Lane by lane, since few slices have a pin.
    #[inline(always)]
    fn slice<V: F32x8>(self, slice: usize, at: &[Cell], sum: &mut [V; 4]) {
        for cell in slice * LANES..at.len().min((slice + 1) * LANES) {
            if let (Some(pin), Some(v)) = (self.at(cell), at.get(cell)) {
                let mut lanes = [[0.0; LANES]; 4];
                for (sum, lanes) in sum.iter().zip(&mut lanes) {
                    sum.store(lanes);
                }
                let lane = cell % LANES;
                let pull = pull(&pin, v.xyz());
                if pull.0 != [0.0; 3] {
                    let Cell(with) = pulled(Cell(lanes.map(|lanes| lanes[lane])), pull);
                    for ((sum, lanes), value) in sum.iter_mut().zip(&mut lanes).zip(with) {
                        lanes[lane] = value;
                        *sum = V::load(lanes);
                    }
                }
            }
        }
    }

    fn cell<N: TermNumber>(self, cell: usize, here: [N; 3], add: &mut impl FnMut(CellTerm)) {
        if let Some(pin) = self.at(cell) {
            let (residual, wd2) = pull(&pin, single(here));
            let length = residual.iter().fold(0.0, |sum, x| sum + 2.0 * x.abs());
            add(CellTerm { residual, wd2: 2.0 * wd2, length });
        }
    }

    fn touched<N: TermNumber>(
        self,
        held: &[Contact<N>],
        output: &impl Fn(usize) -> [N; 3],
        sums: &mut Touched,
    ) {
        for pin in held.iter().filter_map(|contact| self.at(contact.cell())) {
            let (residual, wd2) = pull(&pin, single(output(pin.cell)));
            let wd = 2.0 * sqrt(dot(residual, residual));
            sums.wd2 = sums.wd2.plus(wd2.into());
            sums.scale += wd2 + wd * sqrt(dot(pin.point, pin.point));
        }
    }

    fn add_move(self, cell: usize, squared: f32, sum: f32) -> f32 {
        self.at(cell).map_or(sum, |pin| sum + pin.weight * squared)
    }
}
