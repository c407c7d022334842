//! Strain and stress of a shape, for reports.

use super::band::short;
use super::jacobi::Eigen;
use super::law::shifted;
use super::matrix::{Matrix, both, cofactors, dot, each, minus, three, times_transposed};
use super::nearest::{Turn, of_unit_volume, rotation};
use super::strain::{step_turn, strain};
use super::sums::Own;
use crate::backend::lane::Lane;
use crate::energy::stress::{Stress, bounded_volume};
use crate::model::image::nodal;
use crate::model::nodal::Nodal;
use crate::number::sqrt::sqrt;

/// Most steps from the states of the last pass to the rotation and to the shape of unit volume that are nearest.
const STEPS: usize = 16;

impl Nodal<'_> {
    /// Strain and stress at a cell, for positions of all cells \[mean link lengths\] and rotations near those of the
    /// shapes; `unit_pa` is the unit of the moduli. The spread of the tetrahedra about the mean gradient has a
    /// mean of 0 and takes no part. The stress of a cell that a cut has split follows its offset, as its forces do.
    ///
    /// The mean stress is that of the cell and of those linked to it, by volume: of shapes that hardly change their
    /// volume it alternates from cell to cell about that value.
    pub(super) fn stressed(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        turn_of: &impl Fn(usize) -> [f32; 4],
        unit_pa: f32,
        means_pa: &mut [f32],
    ) -> Stress {
        let alone = self.stressed_alone(cell, at, turn_of(cell), unit_pa);
        // The mean stress of the cell and of its neighbours.
        let mut volume = self.number(cell, nodal::VOLUME);
        let mut sum = volume * alone.mean_pa();
        for other in self.others(cell) {
            let share = self.number(other, nodal::VOLUME);
            volume += share;
            let known = means_pa.get(other).copied().filter(|mean| !mean.is_nan());
            let mean = known.unwrap_or_else(|| {
                self.stressed_alone(other, at, turn_of(other), unit_pa).mean_pa()
            });
            if let Some(slot) = means_pa.get_mut(other) {
                *slot = mean;
            }
            sum += share * mean;
        }
        let change = sum / volume - alone.mean_pa();
        let [[a, p, q], [_, e, r], [.., j]] = alone.cauchy_pa;
        let cauchy_pa = [[a + change, p, q], [p, e + change, r], [q, r, j + change]];
        Stress { cauchy_pa, ..alone }
    }

    /// The same with the cell's own mean stress.
    fn stressed_alone(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        turn: [f32; 4],
        unit_pa: f32,
    ) -> Stress {
        let f = three(self.shape_at(cell, at), |row| three(row, Lane));
        let kept = self.kept(cell, [0.0; 3]);
        let own = self.own(cell).keeping(&kept);
        let of_stress = shifted(f, &own);
        // P = 2 mu (F - R A) + 3 lambda (F - Q) + b S- R.
        let (turn, unit) = nearest(of_stress, &own, turn.map(Lane));
        let (mu, lambda_3) = (Lane(2.0) * own.mu, own.lambda_3);
        let of = |strain, swollen| mu * strain + lambda_3 * swollen;
        let mut first = both(strain(of_stress, turn, &own), minus(of_stress, unit), of);
        if self.stretch_min > 0.0
            && let Some((off, _)) = short(of_stress, turn, self.stretch_min)
        {
            first = both(first, off, |stress, off| stress + own.band * off);
        }
        // P F' / det F; rounding alone makes it asymmetric.
        let ([row, ..], [of_row, ..]) = (of_stress, cofactors(of_stress));
        let share = Lane(unit_pa / bounded_volume(dot(row, of_row).0));
        let cauchy = each(times_transposed(first, of_stress), |x| x * share);
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
fn nearest(f: Matrix<f32>, own: &Own<'_, f32>, mut turn: Turn<f32>) -> (Matrix<f32>, Matrix<f32>) {
    for _ in 0..STEPS {
        let next = step_turn(0.0, f, own, turn);
        let is_there = next.map(|x| x.0) == turn.map(|x| x.0);
        turn = next;
        if is_there {
            break;
        }
    }
    let turn = rotation(turn);
    let mut unit = turn;
    for _ in 0..STEPS {
        let next = of_unit_volume(f, unit).0;
        let is_there = each(next, |x| x.0) == each(unit, |x| x.0);
        unit = next;
        if is_there {
            break;
        }
    }
    (turn, unit)
}

/// Square roots of the eigenvalues of F F', the largest first.
fn stretches(f: Matrix<f32>) -> [f32; 3] {
    let [[xx, xy, xz], [_, yy, yz], [.., zz]] = times_transposed(f, f);
    let (squares, _) = f32::eigen([xx, yy, zz], [xy, xz, yz]);
    let [a, b, c] = squares.map(|square| sqrt(if square.0 > 0.0 { square.0 } else { 0.0 }));
    let falling = |a: f32, b: f32| if a < b { (b, a) } else { (a, b) };
    let (a, b) = falling(a, b);
    let (b, c) = falling(b, c);
    let (a, b) = falling(a, b);
    [a, b, c]
}
