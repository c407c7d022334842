//! The elasticity K of the rest shape: the second derivative of the energy, for all three axes.
//!
//! A displacement u changes cell k's shape by G, the sum of `u_j` `a_kj'` over `V_k`. The stress is
//! then mu (G + G') + lambda tr G - 2 beta mu G. K is the sum over the cells of the stress times each
//! `a_kj`, and of the links' spread.

use chaincell_kernel::image::COARSE_FACTOR_MAX;
use nalgebra::{DMatrix, Matrix3, Vector3};

use super::{BETA, Shapes};

/// The local part of a cell's direction, in mean diagonal elements of K: a longer direction would
/// take its neighbours' part too.
pub(super) const OWN_PART: f64 = 0.7;

impl Shapes {
    /// Calls `visit(k, map)` for each cell with its gradient as a map of cells.
    pub(super) fn each_gradient(&self, mut visit: impl FnMut(usize, &[(usize, [f64; 3])])) {
        for k in 0..self.mu.len() {
            let mut map = vec![(k, self.shape.own(k))];
            map.extend(self.shape.of(k).iter().map(|half| (half.to as usize, half.area_m2)));
            visit(k, &map);
        }
    }

    /// Returns the block of K between two displacements with the shares `a` and `b` in cell k's gradient.
    fn block(&self, k: usize, a: Vector3<f64>, b: Vector3<f64>) -> Matrix3<f64> {
        let even = self.mu[k] * (1.0 - 2.0 * BETA) * a.dot(&b);
        let turned = self.mu[k] * b * a.transpose() + self.lambda[k] * a * b.transpose();
        (Matrix3::from_diagonal_element(even) + turned) / self.shape.volume_m3(k)
    }

    /// Returns P' K P, x of all coarse functions first, then y and z; `row` returns the weights of a cell.
    pub fn elasticity(
        &self,
        coarse_functions: usize,
        row: impl Fn(u16) -> Vec<(usize, f64)>,
    ) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(3 * coarse_functions, 3 * coarse_functions);
        let mut add = |a: usize, b: usize, block: Matrix3<f64>| {
            for (r, c) in (0..3).flat_map(|r| (0..3).map(move |c| (r, c))) {
                matrix[(r * coarse_functions + a, c * coarse_functions + b)] += block[(r, c)];
            }
        };
        self.each_gradient(|k, map| {
            // A cell's gradient in terms of the coarse functions.
            let mut shares: Vec<(usize, Vector3<f64>)> = Vec::new();
            for &(cell, area) in map {
                let area = Vector3::from(area);
                shares
                    .extend(row(cell as u16).into_iter().map(|(function, w)| (function, w * area)));
            }
            shares.sort_unstable_by_key(|&(function, _)| function);
            let shares: Vec<(usize, Vector3<f64>)> = shares
                .chunk_by(|a, b| a.0 == b.0)
                .map(|same| (same[0].0, same.iter().map(|(_, share)| share).sum()))
                .collect();
            for &(one, a) in &shares {
                for &(other, b) in &shares {
                    add(one, other, self.block(k, a, b));
                }
            }
        });
        for k in 0..self.mu.len() {
            // The spread of each link.
            for half in self.shape.of(k).iter().filter(|half| half.to as usize > k) {
                let mut difference = row(k as u16);
                difference
                    .extend(row(half.to as u16).into_iter().map(|(function, w)| (function, -w)));
                let stiffness = 2.0 * BETA * half.weight_m;
                for &(one, a) in &difference {
                    for &(other, b) in &difference {
                        add(one, other, Matrix3::from_diagonal_element(stiffness * a * b));
                    }
                }
            }
        }
        matrix
    }

    /// Returns the local part of each cell's direction over r / W, at least 1 and at most what an image takes.
    pub fn factors(&self) -> Vec<f32> {
        let mut trace = vec![0.0; self.mu.len()];
        self.each_gradient(|k, map| {
            for &(cell, area) in map {
                let area = Vector3::from(area);
                trace[cell] += self.block(k, area, area).trace();
            }
            for half in self.shape.of(k) {
                trace[k] += 3.0 * 2.0 * BETA * half.weight_m;
            }
        });
        let factor = |(trace, bound): (f64, &f32)| 3.0 * OWN_PART * f64::from(*bound) / trace;
        let factors = trace.into_iter().zip(&self.weights).map(factor);
        let most = |factor: f64| (factor as f32).min(COARSE_FACTOR_MAX);
        factors.map(|factor| if factor > 1.0 { most(factor) } else { 1.0 }).collect()
    }
}
