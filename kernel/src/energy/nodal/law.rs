//! Stress and energy of a shape.
//!
//! A cell that a cut made keeps an offset C for a while (`cut::offset`): R, Q, stress and band then follow F + C,
//! the spread follows F. A cell of a body that relaxes has a memory ([`memory`](super::memory)).

use super::band::{least_short, short};
use super::jacobi::Eigen;
use super::matrix::{Matrix, both, each, inner, minus, three, times};
use super::nearest::{Turn, of_unit_volume, rotation};
use super::state::Step;
use super::strain::{distance, spread, step_turn, strain};
use super::sums::{Gathered, Own};
use crate::backend::lane::{Lane, Real};
use crate::model::image::nodal::BETA;

/// `F_i` - I.
#[inline(always)]
pub(super) fn slope<V: Real>(sums: &Gathered<V>, own: &Own<'_, V>) -> Matrix<V> {
    let share = Lane::of(1.0) / own.volume;
    each(sums.slope, |x| x * share)
}

/// A matrix plus the unit matrix.
#[inline(always)]
pub(super) fn and_unit<V: Real>([[a, b, c], [d, e, f], [g, h, i]]: Matrix<V>) -> Matrix<V> {
    let one = Lane::of(1.0);
    [[a + one, b, c], [d, e + one, f], [g, h, i + one]]
}

/// `F_i`.
#[inline(always)]
pub(super) fn shape<V: Real>(sums: &Gathered<V>, own: &Own<'_, V>) -> Matrix<V> {
    and_unit(slope(sums, own))
}

/// `F_i` plus the cell's offset, if it has one.
#[inline(always)]
pub(super) fn shifted<V: Real>(f: Matrix<V>, own: &Own<'_, V>) -> Matrix<V> {
    match own.offset {
        None => f,
        Some(offset) => both(f, *offset, |f, offset| f + offset),
    }
}

/// One step of R and Q, and the resulting stress and energy.
#[inline(always)]
pub(super) fn step<V: Eigen>(
    stretch_min: f32,
    sums: &Gathered<V>,
    own: &Own<'_, V>,
    turn: Turn<V>,
    unit: Matrix<V>,
) -> Step<V> {
    let f = shifted(shape(sums, own), own);
    let turn = step_turn(stretch_min, f, own, turn);
    let (unit, squared) = of_unit_volume(f, unit);
    respond(stretch_min, sums, own, turn, unit, squared)
}

/// Stress, force and energy; `squared` is the squared distance of F and Q.
#[inline(always)]
pub(super) fn respond<V: Eigen>(
    stretch_min: f32,
    sums: &Gathered<V>,
    own: &Own<'_, V>,
    turn: Turn<V>,
    unit: Matrix<V>,
    squared: Lane<V>,
) -> Step<V> {
    // Stress and energy density.
    let slope = slope(sums, own);
    let f = shifted(and_unit(slope), own);
    let rotation = rotation(turn);
    let strain = strain(f, rotation, own);
    let two_mu = Lane::of(2.0) * own.mu;
    let of_spread = Lane::of(2.0 * BETA) * own.mu;
    let (swollen, volume) = (each(minus(f, unit), |x| own.lambda_3 * x), own.lambda_3 * squared);
    let pressed = both(strain, swollen, |strain, swollen| two_mu * strain + swollen);
    let mut stress = both(pressed, slope, |pressed, slope| pressed - of_spread * slope);
    let strained = inner(strain, strain);
    let mut shape = two_mu * strained + volume - of_spread * inner(slope, slope);
    if let Some(memory) = own.memory {
        shape = shape + memory.constant;
    }
    // Add the band of stretches.
    if stretch_min > 0.0
        && V::any(distance(f, rotation, own, strained).above(least_short(stretch_min)))
        && let Some((off, squared)) = short(f, rotation, stretch_min)
    {
        stress = both(stress, off, |stress, off| stress + own.band * off);
        shape = shape + own.band * squared;
    }
    let ([x, y, z], halves) = spread(sums.pull, sums.spread, own);
    let [a, b, c] = times(stress, own.area);
    // Four times twice the energy of the cell and of its halves of the links.
    let energy = Lane::of(4.0) * (own.volume * shape) + Lane::of(2.0) * halves;
    let mut pull = [x - a, y - b, z - c, energy];
    if let Some(memory) = own.memory {
        pull = memory.push(pull);
    }
    // -0.0 becomes +0.0.
    let [x, y, z, energy] = pull;
    let [x, y, z] = three([x, y, z], |x| x + Lane::of(0.0));
    Step { turn, unit, stress, pull: [x, y, z, energy] }
}
