//! The memory of the cells of a body that relaxes, in a tick.
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
//! that is at most that of the elastic body with mu, so all bounds hold. The step of R follows F A in place of F, see
//! `strain`.
//!
//! [`follow`]: super::follow
//!
//! Source: J. C. Simo, Comput. Methods Appl. Mech. Eng. 60 (1987) 153, for a strain that is linear within a tick.

use super::matrix::Matrix;
use crate::backend::lane::{Lane, Real};
use crate::model::nodal::Relaxing;

/// The memory of a cell.
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
    pub fn stretched(&self, of: Matrix<V>) -> Matrix<V> {
        let [first, second, third] = of;
        [self.row(first), self.row(second), self.row(third)]
    }

    /// A row times A.
    #[inline(always)]
    fn row(&self, of: [Lane<V>; 3]) -> [Lane<V>; 3] {
        let [a, b, c] = of;
        let [xx, yy, zz, xy, xz, yz] = self.stretch;
        [
            a + (a * xx + b * xy + c * xz),
            b + (a * xy + b * yy + c * yz),
            c + (a * xz + b * yz + c * zz),
        ]
    }

    /// Adds B and its energy to the force on a cell and to eight times the energy.
    #[inline(always)]
    pub fn push(&self, pull: [Lane<V>; 4]) -> [Lane<V>; 4] {
        let [x, y, z, energy] = pull;
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
