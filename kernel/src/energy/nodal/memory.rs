//! What the cells of a body that relaxes remember in a tick.
//!
//! A Prony series: branch k has the share g of the instantaneous shear modulus mu and the time tau. With the shape in
//! the frame of R, z = sym(R' F) - I, the branch remembers Y, which follows z at the start of a tick ([`follow`]) and
//! is constant in it, and so does the spread of the tetrahedra with its own force. With c = b tau / dt, b the part
//! that fades in the tick, and p = 1 - sum g (1 - c) the part of mu that acts,
//!
//! ```text
//! A   = I + (sum g c Y) / p
//! E_i = V [ p mu |F - R A|^2 + mu k + (3 lambda / 2) |F - Q|^2 ],   k = sum of the weights times |Y - (A - I)|^2
//! spread: p times the elastic one + u . B + its energy at u = 0,   B = sum g c f
//! ```
//!
//! where f is the force of the spread that the branch remembers, in the direction of that on the cell, and the first of
//! the weights, 1 - sum g, belongs to Y = 0. Each branch is half a squared distance of a linear map, of a curvature
//! that is at most that of the elastic body with mu, so all bounds hold. The step of R follows F A in place of F.
//!
//! [`follow`]: super::follow
//!
//! Source: J. C. Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153, for a strain that is linear within a tick.

use super::band::{least_short, short};
use super::jacobi::Eigen;
use super::matrix::{Matrix, inner, minus, pairs};
use super::nearest::{Turn, rotation, turned};
use super::sums::Own;
use crate::backend::lane::{Lane, Real};
use crate::model::nodal::Relaxing;

/// What a cell remembers.
#[derive(Clone, Copy)]
pub(super) struct Memory<V> {
    /// A - I: xx, yy, zz, xy, xz, yz.
    stretch: [Lane<V>; 6],
    /// Twice the density of the energy that does not depend on R.
    pub constant: Lane<V>,
    /// B.
    push: [Lane<V>; 3],
    /// Displacement of the cell.
    displacement: [Lane<V>; 3],
    /// The part of mu that acts.
    pub part: Lane<V>,
    _proof: Relaxing,
}

impl<V: Real> Memory<V> {
    /// From its numbers, by row.
    #[inline(always)]
    pub fn of(
        row: impl Fn(usize) -> Lane<V>,
        displacement: [Lane<V>; 3],
        part: f32,
        proof: Relaxing,
    ) -> Self {
        Self {
            stretch: [row(0), row(1), row(2), row(3), row(4), row(5)],
            constant: row(6),
            push: [row(7), row(8), row(9)],
            displacement,
            part: Lane::of(part),
            _proof: proof,
        }
    }

    /// A matrix times A.
    #[inline(always)]
    fn stretched(&self, [first, second, third]: Matrix<V>) -> Matrix<V> {
        [self.row(first), self.row(second), self.row(third)]
    }

    /// A row times A.
    #[inline(always)]
    fn row(&self, [a, b, c]: [Lane<V>; 3]) -> [Lane<V>; 3] {
        let [xx, yy, zz, xy, xz, yz] = self.stretch;
        [
            a + (a * xx + b * xy + c * xz),
            b + (a * xy + b * yy + c * yz),
            c + (a * xz + b * yz + c * zz),
        ]
    }

    /// Adds B and its energy to the force on a cell and to eight times the energy.
    #[inline(always)]
    pub fn push(&self, [x, y, z, energy]: [Lane<V>; 4]) -> [Lane<V>; 4] {
        let ([a, b, c], [u, v, w]) = (self.push, self.displacement);
        let work = a * u + b * v + c * w;
        [x - a, y - b, z - c, energy + Lane::of(8.0) * work]
    }
}

impl Memory<f32> {
    /// Bound of the rounding error of eight times the energy of B, in units of the last place.
    pub fn scale(&self) -> f32 {
        let ([a, b, c], [u, v, w]) = (self.push, self.displacement);
        8.0 * ((a.0 * u.0).abs() + (b.0 * v.0).abs() + (c.0 * w.0).abs())
    }
}

/// F - R A.
#[inline(always)]
pub(super) fn strain<V: Real>(f: Matrix<V>, rotation: Matrix<V>, own: &Own<V>) -> Matrix<V> {
    match &own.memory {
        None => minus(f, rotation),
        Some(memory) => minus(f, memory.stretched(rotation)),
    }
}

/// The squared distance of F and R, from F - R A with its square.
#[inline(always)]
pub(super) fn distance<V: Real>(
    f: Matrix<V>,
    rotation: Matrix<V>,
    own: &Own<V>,
    strained: Lane<V>,
) -> Lane<V> {
    if own.memory.is_none() {
        return strained;
    }
    let from = minus(f, rotation);
    inner(from, from)
}

/// A step of R that does not raise the energy of the shape: towards F A. Where the band of stretches acts, R stays if
/// shape and band together would rise.
#[inline(always)]
pub(super) fn step_turn<V: Eigen>(
    stretch_min: f32,
    f: Matrix<V>,
    own: &Own<V>,
    turn: Turn<V>,
) -> Turn<V> {
    let Some(memory) = &own.memory else { return turned(f, turn) };
    let next = turned(memory.stretched(f), turn);
    if stretch_min <= 0.0 {
        return next;
    }
    let (old, new) = (rotation(turn), rotation(next));
    // Lanes whose shape may be out of the band.
    let is_far = larger(far(f, old, stretch_min), far(f, new, stretch_min));
    let zero = Lane::of(0.0);
    if !V::any(is_far.above(zero)) {
        return next;
    }
    let (before, after) = (energy(stretch_min, f, own, old), energy(stretch_min, f, own, new));
    let is_higher = Lane::select(after.above(before), is_far, zero).above(zero);
    let ([a, b, c, d], [e, f, g, h]) = (turn, next);
    [
        Lane::select(is_higher, a, e),
        Lane::select(is_higher, b, f),
        Lane::select(is_higher, c, g),
        Lane::select(is_higher, d, h),
    ]
}

/// 1 in lanes that are so far from a rotation that the band may act, else 0.
#[inline(always)]
fn far<V: Real>(f: Matrix<V>, rotation: Matrix<V>, stretch_min: f32) -> Lane<V> {
    let from = minus(f, rotation);
    Lane::select(inner(from, from).above(least_short(stretch_min)), Lane::of(1.0), Lane::of(0.0))
}

#[inline(always)]
fn larger<V: Real>(a: Lane<V>, b: Lane<V>) -> Lane<V> {
    Lane::select(a.above(b), a, b)
}

/// Twice the energy density of shape and band.
#[inline(always)]
fn energy<V: Eigen>(stretch_min: f32, f: Matrix<V>, own: &Own<V>, rotation: Matrix<V>) -> Lane<V> {
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
    own: &Own<V>,
) -> ([Lane<V>; 3], Lane<V>) {
    match &own.memory {
        None => (pull, energy),
        Some(memory) => {
            (pairs(pull, [memory.part; 3], |pull, part| pull * part), energy * memory.part)
        }
    }
}
