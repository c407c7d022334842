//! The bound L of the curvature: 2 mu ((1 - beta) Ln + beta Lc) + (3 lambda + b) Ln, b = 8 mu with a
//! band.
//!
//! Ln is the Laplacian of the nodal gradients, sum of `n_k` / `V_k` times the squares of
//! sum over j of `a_kj` `u_j`, and Lc that of the tetrahedra's, the cotangent weights.

use super::shape::element;
use super::{BETA, Shapes};
use crate::mesh::geometry::dot;

/// A linear map of a few cells whose square is a part of L.
#[cfg(test)]
pub(super) type Map = Vec<(usize, f64)>;

/// Margin for the rounding of a bound to single precision.
const UP: f64 = 1.0 + 1e-6;

impl Shapes {
    /// Returns the weight of the squares of cell k's gradient.
    fn nodal(&self, k: usize) -> f64 {
        let modulus = 2.0 * (1.0 - BETA) * self.mu[k] + 3.0 * self.lambda[k] + self.band(k);
        modulus / self.shape.volume_m3(k)
    }

    /// Calls `visit(map, weight)` for the parts of L: the sum of the weights times the squares of
    /// the maps.
    #[cfg(test)]
    pub(super) fn each_map(&self, mut visit: impl FnMut(&Map, f64)) {
        self.each_gradient(|k, map| {
            for axis in 0..3 {
                let map = map.iter().map(|&(cell, area)| (cell, area[axis])).collect();
                visit(&map, self.nodal(k));
            }
            for half in self.shape.of(k).iter().filter(|half| half.to as usize > k) {
                let map = vec![(k, 1.0), (half.to as usize, -1.0)];
                visit(&map, 2.0 * BETA * half.weight_m);
            }
        });
    }

    /// Returns a bound of L by the tetrahedra alone, rounded up: at each cell the sum over its tetrahedra of
    /// (2 mu + 3 lambda + b) V times the sum of the magnitudes of the products of its gradient with all four.
    /// Moduli are means of the corners'. It holds however the tetrahedra are joined: the square of a mean of
    /// gradients is at most the mean of their squares, and G' G at most the diagonal of those sums.
    pub(super) fn tetrahedron_sums(&self, rest: &[[f64; 3]], tetrahedra: &[[u32; 4]]) -> Vec<f32> {
        let modulus = |i: usize| 2.0 * self.mu[i] + 3.0 * self.lambda[i] + self.band(i);
        let mut sums = vec![0.0; self.mu.len()];
        for &nodes in tetrahedra {
            let cells = nodes.map(|node| node as usize);
            let Some((volume, gradients)) = element(rest, nodes) else { continue };
            let weight = volume * cells.iter().map(|&i| modulus(i)).sum::<f64>() / 4.0;
            for (cell, one) in cells.into_iter().zip(gradients) {
                sums[cell] += weight * gradients.iter().map(|g| dot(one, *g).abs()).sum::<f64>();
            }
        }
        sums.into_iter().map(|sum| (sum * UP) as f32).collect()
    }

    /// Returns the sums of the magnitudes of the rows of L, rounded up.
    pub(super) fn row_sums(&self) -> Vec<f32> {
        let (mut row, mut touched) = (vec![0.0; self.mu.len()], Vec::new());
        (0..self.mu.len())
            .map(|i| {
                self.each_of_row(i, |j, value| {
                    if row[j] == 0.0 {
                        touched.push(j);
                    }
                    row[j] += value;
                });
                let mut sum = 0.0;
                for j in touched.drain(..) {
                    sum += f64::abs(std::mem::take(&mut row[j]));
                }
                (sum * UP) as f32
            })
            .collect()
    }

    /// Calls `visit(j, value)` for the summands of the elements of row i of L.
    fn each_of_row(&self, i: usize, mut visit: impl FnMut(usize, f64)) {
        let mut through = |k: usize, of_i: [f64; 3]| {
            let weight = self.nodal(k);
            visit(k, weight * dot(of_i, self.shape.own(k)));
            for half in self.shape.of(k) {
                visit(half.to as usize, weight * dot(of_i, half.area_m2));
            }
        };
        through(i, self.shape.own(i));
        for half in self.shape.of(i) {
            through(half.to as usize, self.shape.back(i, half));
        }
        for half in self.shape.of(i) {
            visit(i, 2.0 * BETA * half.weight_m);
            visit(half.to as usize, -2.0 * BETA * half.weight_m);
        }
    }
}
