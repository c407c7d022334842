//! The strain of a cell that may remember: F - R A, and the step of R.

use super::band::{least_short, short};
use super::jacobi::Eigen;
use super::matrix::{Matrix, inner, minus, pairs};
use super::nearest::{Turn, rotation, turned};
use super::sums::Own;
use crate::backend::lane::{Lane, Real};

/// F - R A.
#[inline(always)]
pub(super) fn strain<V: Real>(f: Matrix<V>, rotation: Matrix<V>, own: &Own<'_, V>) -> Matrix<V> {
    match own.memory {
        None => minus(f, rotation),
        Some(memory) => minus(f, memory.stretched(rotation)),
    }
}

/// The squared distance of F and R, from F - R A with its square.
#[inline(always)]
pub(super) fn distance<V: Real>(
    f: Matrix<V>,
    rotation: Matrix<V>,
    own: &Own<'_, V>,
    strained: Lane<V>,
) -> Lane<V> {
    if own.memory.is_none() {
        return strained;
    }
    apart(f, rotation)
}

/// A step of R that does not raise the energy of the shape: towards F A. Where the band of stretches acts, R stays if
/// shape and band together would rise.
#[inline(always)]
pub(super) fn step_turn<V: Eigen>(
    stretch_min: f32,
    f: Matrix<V>,
    own: &Own<'_, V>,
    turn: Turn<V>,
) -> Turn<V> {
    let Some(memory) = own.memory else { return turned(f, turn) };
    let next = turned(memory.stretched(f), turn);
    if stretch_min <= 0.0 {
        return next;
    }
    let (old, new) = (rotation(turn), rotation(next));
    // Lanes whose shape may be out of the band: 1 there, else 0.
    let (zero, one) = (Lane::of(0.0), Lane::of(1.0));
    let farthest = larger(apart(f, old), apart(f, new));
    let is_far = farthest.above(least_short(stretch_min));
    if !V::any(is_far) {
        return next;
    }
    let is_far = Lane::select(is_far, one, zero);
    // In a loop: without optimisation each copy of the band's code would take a third of a megabyte of stack.
    let mut energies = [zero; 2];
    for (slot, rotation) in energies.iter_mut().zip([old, new]) {
        *slot = energy(stretch_min, f, own, rotation);
    }
    let [before, after] = energies;
    let is_higher = Lane::select(after.above(before), is_far, zero).above(zero);
    let ([a, b, c, d], [e, f, g, h]) = (turn, next);
    [
        Lane::select(is_higher, a, e),
        Lane::select(is_higher, b, f),
        Lane::select(is_higher, c, g),
        Lane::select(is_higher, d, h),
    ]
}

/// The squared distance of two matrices.
#[inline(always)]
fn apart<V: Real>(f: Matrix<V>, rotation: Matrix<V>) -> Lane<V> {
    let from = minus(f, rotation);
    inner(from, from)
}

#[inline(always)]
fn larger<V: Real>(a: Lane<V>, b: Lane<V>) -> Lane<V> {
    Lane::select(a.above(b), a, b)
}

/// Twice the energy density of shape and band.
#[inline(always)]
fn energy<V: Eigen>(
    stretch_min: f32,
    f: Matrix<V>,
    own: &Own<'_, V>,
    rotation: Matrix<V>,
) -> Lane<V> {
    let strain = strain(f, rotation, own);
    let shape = Lane::of(2.0) * own.mu * inner(strain, strain);
    match short(f, rotation, stretch_min) {
        None => shape,
        Some((_, squared)) => shape + own.band * squared,
    }
}

/// The part of the spread's sums that acts.
#[inline(always)]
pub(super) fn spread<V: Real>(
    pull: [Lane<V>; 3],
    energy: Lane<V>,
    own: &Own<'_, V>,
) -> ([Lane<V>; 3], Lane<V>) {
    match own.memory {
        None => (pull, energy),
        Some(memory) => {
            (pairs(pull, [memory.part; 3], |pull, part| pull * part), energy * memory.part)
        }
    }
}
