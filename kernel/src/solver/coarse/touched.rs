//! An elastic coarse level under a sphere that meets the surface.
//!
//! The level's B knows of the body alone. What the sphere adds to its matrix is, with the samples of
//! each triangle taken as one of stiffness `k_t`, corner weights `w_t` and normal `n_t`,
//!
//! ```text
//! C = U S U',   S_ab = sum over t of k_t p_a p_b (n_t . n_a) (n_t . n_b),   p_a = w_t' P_a
//! ```
//!
//! U has a column for each basis function under the sphere: its mean normal `n_a`, turned to the rest
//! shape. With S = L L' the Woodbury formula gives
//!
//! ```text
//! (B^-1 + C)^-1 = B - B U L (1 + L' U' B U L)^-1 L' U' B
//! ```
//!
//! Without it a direction would press the surface into the sphere as if nothing were there, and the
//! guard would discard the pass. It is a direction as ever: the guard judges the pass, and no proof
//! rests on it. Beyond [`FUNCTIONS`] basis functions the others are taken as untouched.
//!
//! Cost with m functions: m^3 a tick and m^2 / 2 elements of B; 3 m rows of B a sweep.

use super::elastic::turned;
use crate::backend::f32x8::F32x8;
use crate::model::coarse_basis::CoarseBasis;
use crate::number::cell::{add, dot, scale};
use crate::number::sqrt::sqrt;
use crate::number::two_float::Eight;
use crate::terms::residual::Terms;
use crate::terms::surface::{Ball, NearTriangle, Press};

/// Most basis functions under a sphere.
const FUNCTIONS: usize = 48;
/// Basis functions at the corners of a triangle.
const OF_TRIANGLE: usize = 24;
/// Pivots of S below this share of the largest are taken as 0.
const LEAST: f32 = 1.0e-5;

type Square = [[f32; FUNCTIONS]; FUNCTIONS];

/// What a sphere makes of an elastic coarse level in a tick: memory for it.
#[derive(Debug, Clone, Copy)]
pub struct CoarseTouch {
    count: usize,
    functions: [u16; FUNCTIONS],
    /// Mean normals, in the rest shape's frame once prepared.
    normals: [[f32; 3]; FUNCTIONS],
    /// L.
    lower: Square,
    /// The Cholesky factor of 1 + L' V L, V = U' B U.
    factor: Square,
}

/// An element of a square; 0 beyond it.
fn at(square: &Square, row: usize, column: usize) -> f32 {
    square.get(row).and_then(|row| row.get(column)).copied().unwrap_or(0.0)
}

fn put(square: &mut Square, row: usize, column: usize, value: f32) {
    if let Some(slot) = square.get_mut(row).and_then(|row| row.get_mut(column)) {
        *slot = value;
    }
}

/// Replaces the lower triangle of a symmetric matrix by its Cholesky factor; a column whose pivot is
/// lost in rounding becomes 0.
fn cholesky(matrix: &mut Square, count: usize) {
    let mut most = 0.0;
    for i in 0..count {
        let own = at(matrix, i, i);
        most = if own > most { own } else { most };
    }
    for column in 0..count {
        for row in column..count {
            let mut sum = at(matrix, row, column);
            for k in 0..column {
                sum -= at(matrix, row, k) * at(matrix, column, k);
            }
            put(matrix, row, column, sum);
        }
        let pivot = at(matrix, column, column);
        let root = if pivot > LEAST * most { 1.0 / sqrt(pivot) } else { 0.0 };
        for row in column..count {
            let value = at(matrix, row, column);
            put(matrix, row, column, value * root);
        }
    }
}

/// A triangle under the sphere: its samples as one.
struct OneSample {
    stiffness: f32,
    normal: [f32; 3],
    /// Basis functions with what they move it by.
    functions: [(u16, f32); OF_TRIANGLE],
    count: usize,
}

impl OneSample {
    fn of(
        basis: &CoarseBasis<'_>,
        ball: &Ball,
        near: &NearTriangle,
        place: &impl Fn(usize) -> [f32; 3],
    ) -> Option<Self> {
        let press = Press::of(ball, near, near.corners.map(|cell| place(cell.into())));
        let force = sqrt(dot(press.force, press.force));
        if !(press.stiffness > 0.0 && force > 0.0) {
            return None;
        }
        let normal = scale(1.0 / force, press.force);
        let mut one = Self {
            stiffness: press.stiffness,
            normal,
            functions: [(0, 0.0); OF_TRIANGLE],
            count: 0,
        };
        for (&cell, share) in near.corners.iter().zip(press.shares) {
            for (function, weight) in basis.row_of(cell.into()) {
                one.add(function as u16, weight * share / press.stiffness);
            }
        }
        Some(one)
    }

    fn add(&mut self, function: u16, weight: f32) {
        let taken = self.functions.get_mut(..self.count).unwrap_or_default();
        if let Some((_, sum)) = taken.iter_mut().find(|(of, _)| *of == function) {
            *sum += weight;
        } else if let Some(slot) = self.functions.get_mut(self.count) {
            *slot = (function, weight);
            self.count += 1;
        }
    }

    fn functions(&self) -> &[(u16, f32)] {
        self.functions.get(..self.count).unwrap_or(&[])
    }
}

impl CoarseTouch {
    /// Nothing under the sphere.
    pub const NONE: Self = Self {
        count: 0,
        functions: [0; FUNCTIONS],
        normals: [[0.0; 3]; FUNCTIONS],
        lower: [[0.0; FUNCTIONS]; FUNCTIONS],
        factor: [[0.0; FUNCTIONS]; FUNCTIONS],
    };

    fn index_of(&self, function: u16) -> Option<usize> {
        let taken = self.functions.get(..self.count).unwrap_or(&[]);
        taken.iter().position(|&of| of == function)
    }

    /// Prepares for a sphere among these triangles, the cells being at `place`.
    pub(crate) fn prepare(
        &mut self,
        terms: Terms<'_, '_>,
        (ball, near): (&Ball, &[NearTriangle]),
        place: &impl Fn(usize) -> [f32; 3],
    ) {
        self.count = 0;
        let Some(basis) = terms.model.coarse_basis.filter(|basis| basis.elastic().is_some()) else {
            return;
        };
        let samples = || near.iter().filter_map(|near| OneSample::of(&basis, ball, near, place));
        samples().for_each(|sample| self.take_in(&sample));
        let count = self.count;
        for normal in self.normals.iter_mut().take(count) {
            let length = sqrt(dot(*normal, *normal));
            *normal = if length > 0.0 { scale(1.0 / length, *normal) } else { [0.0; 3] };
        }
        self.lower.iter_mut().take(count).for_each(|row| row.fill(0.0));
        samples().for_each(|sample| self.stiffen(&sample));
        cholesky(&mut self.lower, count);
        let functions = self.functions;
        for (normal, &function) in self.normals.iter_mut().zip(&functions).take(count) {
            *normal = turned(terms, &basis, function.into(), *normal, true);
        }
        self.find_factor(&basis);
    }

    /// The basis functions of a sample, with its normal.
    fn take_in(&mut self, sample: &OneSample) {
        for &(function, weight) in sample.functions() {
            let index = self.index_of(function).unwrap_or(self.count);
            let (Some(slot), Some(normal)) =
                (self.functions.get_mut(index), self.normals.get_mut(index))
            else {
                continue;
            };
            if index == self.count {
                (*slot, *normal) = (function, [0.0; 3]);
                self.count += 1;
            }
            *normal = add(*normal, scale(sample.stiffness * weight, sample.normal));
        }
    }

    /// The part of a sample in S.
    fn stiffen(&mut self, sample: &OneSample) {
        let mut shares = [(0, 0.0); OF_TRIANGLE];
        let mut count = 0;
        for &(function, weight) in sample.functions() {
            let Some(index) = self.index_of(function) else { continue };
            let normal = self.normals.get(index).copied().unwrap_or([0.0; 3]);
            if let Some(slot) = shares.get_mut(count) {
                *slot = (index, weight * dot(sample.normal, normal));
                count += 1;
            }
        }
        let shares = shares.get(..count).unwrap_or(&[]);
        for &(a, one) in shares {
            for &(b, other) in shares.iter().filter(|&&(b, _)| b <= a) {
                let sum = at(&self.lower, a, b) + sample.stiffness * one * other;
                put(&mut self.lower, a, b, sum);
            }
        }
    }

    /// The factor of 1 + L' V L.
    fn find_factor(&mut self, basis: &CoarseBasis<'_>) {
        let (count, stride) = (self.count, basis.stride());
        let of = |index: usize| {
            let function = self.functions.get(index).copied().unwrap_or(0);
            (usize::from(function), self.normals.get(index).copied().unwrap_or([0.0; 3]))
        };
        // V, then V L in its place, row by row.
        let mut product = [[0.0; FUNCTIONS]; FUNCTIONS];
        for a in 0..count {
            let (one, normal) = of(a);
            for b in 0..=a {
                let (other, across) = of(b);
                let mut sum = 0.0;
                for (row, n) in normal.into_iter().enumerate() {
                    for (column, m) in across.into_iter().enumerate() {
                        sum +=
                            n * m * basis.inverse_at(row * stride + one, column * stride + other);
                    }
                }
                put(&mut product, a, b, sum);
                put(&mut product, b, a, sum);
            }
        }
        for row in product.iter_mut().take(count) {
            let v = *row;
            for (column, slot) in row.iter_mut().enumerate().take(count) {
                let below = v.iter().enumerate().take(count).skip(column);
                *slot = below.fold(0.0, |sum, (k, v)| sum + v * at(&self.lower, k, column));
            }
        }
        for a in 0..count {
            for b in 0..=a {
                let mut sum = if a == b { 1.0 } else { 0.0 };
                for k in a..count {
                    sum += at(&self.lower, k, a) * at(&product, k, b);
                }
                put(&mut self.factor, a, b, sum);
            }
        }
        cholesky(&mut self.factor, count);
    }

    /// y of B U y, for t = U' B g.
    fn solve(&self, t: [f32; FUNCTIONS]) -> [f32; FUNCTIONS] {
        let (count, mut b, mut y) = (self.count, [0.0; FUNCTIONS], [0.0; FUNCTIONS]);
        let get = |of: &[f32; FUNCTIONS], at: usize| of.get(at).copied().unwrap_or(0.0);
        for row in 0..count {
            // L' t, then forward through the factor.
            let mut sum = 0.0;
            for k in row..count {
                sum += at(&self.lower, k, row) * get(&t, k);
            }
            for k in 0..row {
                sum -= at(&self.factor, row, k) * get(&b, k);
            }
            if let Some(slot) = b.get_mut(row) {
                *slot = sum / at(&self.factor, row, row);
            }
        }
        for row in (0..count).rev() {
            let mut sum = get(&b, row);
            for k in row + 1..count {
                sum -= at(&self.factor, k, row) * get(&b, k);
            }
            if let Some(slot) = b.get_mut(row) {
                *slot = sum / at(&self.factor, row, row);
            }
        }
        for (row, slot) in y.iter_mut().enumerate().take(count) {
            for k in 0..=row {
                *slot += at(&self.lower, row, k) * get(&b, k);
            }
        }
        y
    }

    /// Takes c = B g to what the sphere leaves of it.
    #[inline(always)]
    pub(crate) fn correct<V: F32x8>(&self, basis: &CoarseBasis<'_>, c: &mut [Eight]) {
        let (stride, blocks) = (basis.stride(), basis.row_blocks());
        let mut t = [0.0; FUNCTIONS];
        let flat = c.as_flattened();
        let each = self.functions.iter().zip(&self.normals).take(self.count);
        for (slot, (&function, normal)) in t.iter_mut().zip(each.clone()) {
            for (axis, n) in normal.iter().enumerate() {
                let value = flat.get(axis * stride + usize::from(function));
                *slot += n * value.copied().unwrap_or(0.0);
            }
        }
        let y = self.solve(t);
        for (y, (&function, normal)) in y.iter().zip(each) {
            for (axis, n) in normal.iter().enumerate() {
                let (row, factor) = (axis * stride + usize::from(function), V::splat(y * n));
                let row = basis.inverse.get(row * blocks..(row + 1) * blocks).unwrap_or(&[]);
                for (slot, b) in c.iter_mut().zip(row) {
                    V::load(slot).minus(V::load(b).times(factor)).store(slot);
                }
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::needless_range_loop)]
mod tests {
    use super::*;

    /// A symmetric positive matrix.
    fn matrix(count: usize) -> Square {
        let mut matrix = [[0.0; FUNCTIONS]; FUNCTIONS];
        for (a, row) in matrix.iter_mut().enumerate().take(count) {
            for (b, slot) in row.iter_mut().enumerate().take(count) {
                *slot = 1.0 / (1.0 + a.abs_diff(b) as f32) + if a == b { 2.0 } else { 0.0 };
            }
        }
        matrix
    }

    #[test]
    fn a_cholesky_factor_times_itself_is_the_matrix() {
        for count in [1, 2, 7, FUNCTIONS] {
            let (whole, mut factor) = (matrix(count), matrix(count));
            cholesky(&mut factor, count);
            for a in 0..count {
                for b in 0..=a {
                    let sum: f32 = (0..=b).map(|k| factor[a][k] * factor[b][k]).sum();
                    assert!((sum - whole[a][b]).abs() < 1e-5, "{count} {a} {b}");
                }
            }
        }
        // Of rank one: what is left is nothing.
        let mut same = [[0.0; FUNCTIONS]; FUNCTIONS];
        same.iter_mut().take(3).for_each(|row| row[..3].fill(4.0));
        cholesky(&mut same, 3);
        assert_eq!([same[0][0], same[2][0], same[1][1], same[2][2]], [2.0, 2.0, 0.0, 0.0]);
    }

    #[test]
    fn the_solution_is_that_of_the_woodbury_formula() {
        // y = L (1 + L' V L)^-1 L' t, so that (1 + S V) y = S t.
        let (count, v) = (5, matrix(5));
        let mut touch = CoarseTouch { count, ..CoarseTouch::NONE };
        let mut s = matrix(count);
        s.iter_mut()
            .enumerate()
            .for_each(|(a, row)| row.iter_mut().for_each(|x| *x *= 0.3 + a as f32));
        for a in 0..count {
            for b in 0..a {
                s[b][a] = s[a][b];
            }
            s[a][a] += 9.0;
        }
        touch.lower = s;
        cholesky(&mut touch.lower, count);
        for a in 0..count {
            for b in 0..=a {
                let mut sum = if a == b { 1.0 } else { 0.0 };
                for k in a..count {
                    for l in b..count {
                        sum += touch.lower[k][a] * v[k][l] * touch.lower[l][b];
                    }
                }
                touch.factor[a][b] = sum;
            }
        }
        cholesky(&mut touch.factor, count);
        let mut t = [0.0; FUNCTIONS];
        t[..count].copy_from_slice(&[1.0, -2.0, 0.5, 3.0, 0.1]);
        let y = touch.solve(t);
        for a in 0..count {
            let sv: f32 =
                (0..count).map(|k| s[a][k] * (0..count).map(|l| v[k][l] * y[l]).sum::<f32>()).sum();
            let st: f32 = (0..count).map(|k| s[a][k] * t[k]).sum();
            assert!((y[a] + sv - st).abs() < 1e-3 * st.abs().max(1.0), "{a}: {} {st}", y[a] + sv);
        }
    }
}
