//! Stress and energy of a shape.

use super::gather::{Gathered, Own};
use super::matrix::{Matrix, both, each, inner, minus, three, times};
use super::nearest::{Turn, of_unit_volume, rotation, turned};
use crate::backend::lane::{Lane, Real};
use crate::model::image::nodal::BETA;

/// What a pass finds of a cell.
#[derive(Clone, Copy)]
pub(super) struct Step<V> {
    pub turn: Turn<V>,
    pub unit: Matrix<V>,
    /// P.
    pub stress: Matrix<V>,
    /// Force of the spread and of the own stress, and eight times the energy.
    pub pull: [Lane<V>; 4],
}

/// `F_i` - I.
#[inline(always)]
fn slope<V: Real>(sums: &Gathered<V>, own: &Own<V>) -> Matrix<V> {
    let share = Lane::of(1.0) / own.volume;
    each(sums.slope, |x| x * share)
}

/// A matrix and the unit matrix.
#[inline(always)]
fn and_unit<V: Real>([[a, b, c], [d, e, f], [g, h, i]]: Matrix<V>) -> Matrix<V> {
    let one = Lane::of(1.0);
    [[a + one, b, c], [d, e + one, f], [g, h, i + one]]
}

/// One step of R and Q, and what they make of the shape.
#[inline(always)]
pub(super) fn step<V: Real>(
    sums: &Gathered<V>,
    own: &Own<V>,
    turn: Turn<V>,
    unit: Matrix<V>,
) -> Step<V> {
    let f = and_unit(slope(sums, own));
    let turn = turned(f, turn);
    let (unit, squared) = of_unit_volume(f, unit);
    respond(sums, own, turn, unit, squared)
}

/// The same with R and Q as they are.
#[inline(always)]
pub(super) fn stay<V: Real>(
    sums: &Gathered<V>,
    own: &Own<V>,
    turn: Turn<V>,
    unit: Matrix<V>,
) -> Step<V> {
    let off = minus(and_unit(slope(sums, own)), unit);
    respond(sums, own, turn, unit, inner(off, off))
}

/// `squared` is the squared distance of F and Q.
#[inline(always)]
fn respond<V: Real>(
    sums: &Gathered<V>,
    own: &Own<V>,
    turn: Turn<V>,
    unit: Matrix<V>,
    squared: Lane<V>,
) -> Step<V> {
    let slope = slope(sums, own);
    let f = and_unit(slope);
    let (strain, swollen) = (minus(f, rotation(turn)), minus(f, unit));
    let two_mu = Lane::of(2.0) * own.mu;
    let spread = Lane::of(2.0 * BETA) * own.mu;
    let pressed = both(strain, swollen, |strain, swollen| two_mu * strain + own.lambda_3 * swollen);
    let stress = both(pressed, slope, |pressed, slope| pressed - spread * slope);
    let [x, y, z] = sums.pull;
    let [a, b, c] = times(stress, own.area);
    // Four times twice the energy of the cell and of the halves of its links.
    let shape =
        two_mu * inner(strain, strain) + own.lambda_3 * squared - spread * inner(slope, slope);
    let energy = Lane::of(4.0) * (own.volume * shape) + Lane::of(2.0) * sums.spread;
    // -0.0 becomes +0.0.
    let [x, y, z] = three([x - a, y - b, z - c], |x| x + Lane::of(0.0));
    Step { turn, unit, stress, pull: [x, y, z, energy] }
}
