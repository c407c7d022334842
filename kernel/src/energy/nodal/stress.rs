//! Strain and stress of a shape, for reports.

use super::band::short;
use super::jacobi::Eigen;
use super::matrix::{Matrix, both, cofactors, dot, each, minus, three, times_transposed};
use super::nearest::{Turn, of_unit_volume, rotation};
use super::strain::{step_turn, strain};
use super::sums::Own;
use crate::backend::lane::Lane;
use crate::energy::stress::Stress;
use crate::model::nodal::Nodal;
use crate::number::sqrt::sqrt;

/// Steps from the states of the last pass to the rotation and to the shape of unit volume that are nearest.
const STEPS: usize = 16;
/// Least volume of a shape in volumes at rest that a stress is divided by.
const VOLUME_MIN: f32 = 0.05;

impl Nodal<'_> {
    /// Strain and stress at a cell, for positions of all cells \[mean link lengths\] and a rotation near that of
    /// the shape; `unit_pa` is the unit of the moduli. The spread of the tetrahedra about the mean
    /// gradient takes no part, nor do bands of stiffening.
    pub(super) fn stressed(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        turn: [f32; 4],
        unit_pa: f32,
    ) -> Stress {
        let (f, own) =
            (three(self.shape_at(cell, at), |row| three(row, Lane)), self.own(cell, [0.0; 3]));
        // P = 2 mu (F - R A) + 3 lambda (F - Q) + b S- R.
        let (turn, unit) = nearest(f, &own, turn.map(Lane));
        let (mu, lambda_3) = (Lane(2.0) * own.mu, own.lambda_3);
        let of = |strain, swollen| mu * strain + lambda_3 * swollen;
        let mut first = both(strain(f, turn, &own), minus(f, unit), of);
        if self.stretch_min > 0.0
            && let Some((off, _)) = short(f, turn, self.stretch_min)
        {
            first = both(first, off, |stress, off| stress + own.band * off);
        }
        // P F' / det F; rounding alone makes it asymmetric.
        let ([row, ..], [of_row, ..]) = (f, cofactors(f));
        let volume = dot(row, of_row).0;
        let share = Lane(unit_pa / if volume > VOLUME_MIN { volume } else { VOLUME_MIN });
        let cauchy = each(times_transposed(first, f), |x| x * share);
        let [[a, b, c], [d, e, g], [h, i, j]] = each(cauchy, |x: Lane<f32>| x.0);
        let [p, q, r] = [0.5 * (b + d), 0.5 * (c + h), 0.5 * (g + i)];
        Stress {
            gradient: each(f, |x| x.0),
            stretches: stretches(f),
            cauchy_pa: [[a, p, q], [p, e, r], [q, r, j]],
        }
    }
}

/// The nearest rotation to a shape, and the nearest shape of unit volume.
fn nearest(f: Matrix<f32>, own: &Own<f32>, mut turn: Turn<f32>) -> (Matrix<f32>, Matrix<f32>) {
    for _ in 0..STEPS {
        turn = step_turn(0.0, f, own, turn);
    }
    let turn = rotation(turn);
    let mut unit = turn;
    for _ in 0..STEPS {
        unit = of_unit_volume(f, unit).0;
    }
    (turn, unit)
}

/// Square roots of the eigenvalues of F F', the largest first.
fn stretches(f: Matrix<f32>) -> [f32; 3] {
    let [[xx, xy, xz], [_, yy, yz], [.., zz]] = times_transposed(f, f);
    let (squares, _) = f32::eigen([xx, yy, zz], [xy, xz, yz]);
    let mut stretches = squares.map(|square| sqrt(if square.0 > 0.0 { square.0 } else { 0.0 }));
    stretches.sort_unstable_by(|a, b| b.total_cmp(a));
    stretches
}
