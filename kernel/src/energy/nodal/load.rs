//! The load of a cell, by which a body tears, and the stretches of a shape.

use super::jacobi::Eigen;
use super::matrix::{each, inner, minus, three};
use super::nearest::rotation;
use crate::backend::lane::Lane;
use crate::energy::state::StatesOf;
use crate::model::nodal::Nodal;
use crate::number::sqrt::sqrt;

impl Nodal<'_> {
    /// The shape F of a cell at these positions, with its offset.
    pub(crate) fn shifted_at(self, cell: usize, at: &impl Fn(usize) -> [f32; 3]) -> [[f32; 3]; 3] {
        let f = three(self.shape_at(cell, at), |row| three(row, Lane));
        let kept = self.kept(cell, [0.0; 3]);
        each(super::law::shifted(f, &self.own(cell).keeping(&kept)), |x| x.0)
    }

    /// Energy of a cell's shape for each volume, mu |F - R|^2 + (3 lambda / 2) |F - Q|^2, for its present R and Q, in
    /// the unit of the moduli. The spread of the tetrahedra and the band of stretches take no part.
    pub(crate) fn energy_density(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
    ) -> f32 {
        let (f, kept, state) =
            (self.shifted_at(cell, at), self.kept(cell, [0.0; 3]), states.shape(cell));
        let f = three(f, |row| three(row, Lane));
        let own = self.own(cell).keeping(&kept);
        let strain = minus(f, rotation(state.turn.map(Lane)));
        let swollen = minus(f, three(state.unit, |row| three(row, Lane)));
        let twice =
            Lane(2.0) * own.mu * inner(strain, strain) + own.lambda_3 * inner(swollen, swollen);
        0.5 * twice.0
    }
}

/// An upper bound of the largest principal stretch of a shape: the root of the largest row sum of F'F.
pub(crate) fn stretch_bound(f: [[f32; 3]; 3]) -> f32 {
    let [[xx, yy, zz], beside] = squared(f);
    let [xy, xz, yz] = beside.map(f32::abs);
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    sqrt(larger(larger(xx + xy + xz, yy + xy + yz), zz + xz + yz))
}

/// The largest principal stretch of a shape, and the line in the rest shape that is stretched so: the eigenvector of
/// F'F with the largest eigenvalue, of length 1.
pub(crate) fn largest_stretch(f: [[f32; 3]; 3]) -> (f32, [f32; 3]) {
    let [diagonal, beside] = squared(f);
    let (squares, lines) = f32::eigen(diagonal.map(Lane), beside.map(Lane));
    let [first, second, third] = squares.map(|square| square.0);
    let [a, b, c] = lines.map(|line| line.map(|x| x.0));
    let (square, line) = if second > first { (second, b) } else { (first, a) };
    let (square, line) = if third > square { (third, c) } else { (square, line) };
    (sqrt(if square > 0.0 { square } else { 0.0 }), line)
}

/// F'F: its diagonal, then xy, xz and yz.
fn squared([a, b, c]: [[f32; 3]; 3]) -> [[f32; 3]; 2] {
    let of = |i: usize, j: usize| {
        let element =
            |row: [f32; 3]| row.get(i).copied().unwrap_or(0.0) * row.get(j).copied().unwrap_or(0.0);
        element(a) + element(b) + element(c)
    };
    [[of(0, 0), of(1, 1), of(2, 2)], [of(0, 1), of(0, 2), of(1, 2)]]
}
