//! An elastic coarse level under tools on the surface.
//!
//! The level's B covers only the body. The tools add a matrix. With the samples of each triangle taken as one
//! of corner weights `w_t` and stiffness K_t, which is `k_t` n n' in contact and has a part perpendicular to
//! the normal n if friction or a grip holds the samples, it is
//!
//! ```text
//! C = U S U',   S_ab = sum over t of p_a p_b d_a' K_t d_b,   p_a = w_t' P_a
//! ```
//!
//! U has a column for each basis function under a tool and each direction d_a in which it is pushed, rotated
//! to the rest shape: one, its mean normal, if all samples slide, else three. With S = L L' the Woodbury
//! formula gives
//!
//! ```text
//! (B^-1 + C)^-1 = B - B U L (1 + L' U' B U L)^-1 L' U' B
//! ```
//!
//! Without it a direction would press the surface into the tool as if there were no contact, and the guard
//! would discard the pass. The guard judges the pass as usual, and no proof depends on this direction. Beyond
//! [`COLUMNS`] columns the other basis functions are treated as free.
//!
//! Cost with m columns: m^3 per tick and m^2 / 2 elements of B; 3 m rows of B per sweep.

use super::sides::place;
use super::solve::along;
use super::square::{COLUMNS, Square, add_scaled, at, cholesky, put};
use super::turns::turned_with;
use super::under::{Mean, OF_SAMPLE, OneSample, Under};
use crate::backend::f32x8::F32x8;
use crate::energy::residual::Terms;
use crate::energy::surface::{NearTriangle, PINS_ARE_BUILT, PinSample};
use crate::model::coarse_basis::CoarseBasis;
use crate::number::cell::{add, dot, scale};
use crate::number::kept::{Kept, Pass};
use crate::number::sqrt::sqrt;
use crate::number::two_float::Eight;

/// Memory for the changes that tools make to an elastic coarse level in a tick.
#[derive(Debug, Clone, Copy)]
pub struct CoarseTouch {
    count: usize,
    /// The basis function of each column.
    functions: [u16; COLUMNS],
    /// The direction of each column; in the rest shape's frame after `prepare`.
    ways: [[f32; 3]; COLUMNS],
    /// L.
    lower: Square,
    /// The Cholesky factor of 1 + L' V L, V = U' B U.
    factor: Square,
}

impl CoarseTouch {
    /// One pass of a snapshot over the used columns.
    pub(crate) fn keep(&mut self, pass: &mut Pass<'_>) {
        let mut count = self.count;
        count.keep(pass);
        pass.slice(&mut self.functions, count);
        pass.slice(&mut self.ways, count);
        let rows = self.lower.iter_mut().chain(&mut self.factor);
        for (place, row) in rows.enumerate() {
            // Only the lower triangles of both are stored.
            let row_at = place % COLUMNS;
            pass.slice(row, if row_at < count { row_at + 1 } else { 0 });
        }
        if pass.is_reading() {
            self.count = count;
        }
    }
}

impl CoarseTouch {
    /// No contact.
    pub const NONE: Self = Self {
        count: 0,
        functions: [0; COLUMNS],
        ways: [[0.0; 3]; COLUMNS],
        lower: [[0.0; COLUMNS]; COLUMNS],
        factor: [[0.0; COLUMNS]; COLUMNS],
    };

    /// Prepares for the contacts with these triangles; the cells are at `place`.
    pub(crate) fn prepare(
        &mut self,
        terms: Terms<'_, '_>,
        under: Under<'_>,
        place: &impl Fn(usize) -> [f32; 3],
    ) {
        self.count = 0;
        let Some(basis) = terms.model.coarse_basis.filter(|basis| basis.elastic().is_some()) else {
            return;
        };
        // Take the samples of each triangle as one.
        let mut holds = PINS_ARE_BUILT && !under.pins.is_empty();
        for (index, near) in under.near.iter().enumerate() {
            let mean = Mean::of(under, near, place).unwrap_or(Mean::NONE);
            holds |= mean.stiffness[1] > 0.0;
            if let Some(slot) = self.means_mut().get_mut(index) {
                *slot = mean.to_block();
            }
        }
        // Collect the columns of U and their directions.
        for (index, near) in under.near.iter().enumerate() {
            if let Some(sample) = self.sample(&basis, under, index, near, place) {
                self.take_in(&sample, holds);
            }
        }
        of_edges(&basis, under, place, |sample| self.take_in(sample, holds));
        of_pins(&basis, under, |sample| self.take_in(sample, holds));
        let count = self.count;
        if !holds {
            for way in self.ways.iter_mut().take(count) {
                let length = sqrt(dot(*way, *way));
                *way = if length > 0.0 { scale(1.0 / length, *way) } else { [0.0; 3] };
            }
        }
        // Factorise S, and rotate the directions to the rest shape.
        self.lower.iter_mut().take(count).for_each(|row| row.fill(0.0));
        for (index, near) in under.near.iter().enumerate() {
            if let Some(sample) = self.sample(&basis, under, index, near, place) {
                self.stiffen(&sample);
            }
        }
        of_edges(&basis, under, place, |sample| self.stiffen(sample));
        of_pins(&basis, under, |sample| self.stiffen(sample));
        cholesky(&mut self.lower, count);
        let functions = self.functions;
        for (way, &function) in self.ways.iter_mut().zip(&functions).take(count) {
            *way = turned_with(terms, &basis, function.into(), *way, true);
        }
        self.find_factor(&basis);
    }

    /// Memory for the means of the first triangles until the factor takes their place.
    fn means_mut(&mut self) -> &mut [Eight] {
        self.factor.as_flattened_mut().as_chunks_mut().0
    }

    /// The samples of a triangle taken as one: from the memory, or computed anew beyond it. `None` without
    /// contact.
    fn sample(
        &self,
        basis: &CoarseBasis<'_>,
        under: Under<'_>,
        index: usize,
        near: &NearTriangle,
        place: &impl Fn(usize) -> [f32; 3],
    ) -> Option<OneSample> {
        let means: &[Eight] = self.factor.as_flattened().as_chunks().0;
        let mean = match means.get(index) {
            Some(block) => Mean::of_block(*block),
            None => Mean::of(under, near, place)?,
        };
        (mean.stiffness[0] > 0.0).then(|| OneSample::of(basis, near, mean))
    }

    /// The range of a basis function's columns.
    fn columns_of(&self, function: u16) -> Option<core::ops::Range<usize>> {
        let taken = self.functions.get(..self.count).unwrap_or(&[]);
        let first = taken.iter().position(|&of| of == function)?;
        let more = taken.iter().skip(first).take_while(|&&of| of == function).count();
        Some(first..first + more)
    }

    /// Adds the basis functions of a sample: with its normal, or with all directions.
    fn take_in(&mut self, sample: &OneSample, holds: bool) {
        const AXES: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for &(function, weight) in sample.functions() {
            let known = self.columns_of(function);
            let more: &[[f32; 3]] = if holds { &AXES } else { &[[0.0; 3]] };
            if known.is_none() {
                let Some(end) = self.count.checked_add(more.len()).filter(|end| *end <= COLUMNS)
                else {
                    continue;
                };
                let slots = self.functions.iter_mut().zip(&mut self.ways);
                for ((of, way), axis) in slots.skip(self.count).zip(more) {
                    (*of, *way) = (function, *axis);
                }
                self.count = end;
            }
            if !holds && let Some(columns) = self.columns_of(function) {
                let push = scale(sample.mean.stiffness[0] * weight, sample.mean.normal);
                for way in self.ways.get_mut(columns).unwrap_or_default() {
                    *way = add(*way, push);
                }
            }
        }
    }

    /// Adds the part of a sample to S.
    fn stiffen(&mut self, sample: &OneSample) {
        let mut shares = [(0, 0.0, [0.0; 3]); 3 * OF_SAMPLE];
        let mut count = 0;
        for &(function, weight) in sample.functions() {
            for column in self.columns_of(function).unwrap_or(0..0) {
                let way = self.ways.get(column).copied().unwrap_or([0.0; 3]);
                if let Some(slot) = shares.get_mut(count) {
                    *slot = (column, weight, way);
                    count += 1;
                }
            }
        }
        let shares = shares.get(..count).unwrap_or(&[]);
        for &(a, weight, way) in shares {
            let resisted = scale(weight, sample.resist(way));
            let row = self.lower.get_mut(a).map_or(&mut [][..], |row| row.as_mut_slice());
            for &(b, other, across) in shares.iter().filter(|&&(b, ..)| b <= a) {
                if let Some(sum) = row.get_mut(b) {
                    *sum += other * dot(across, resisted);
                }
            }
        }
    }

    /// Computes the factor of 1 + L' V L.
    fn find_factor(&mut self, basis: &CoarseBasis<'_>) {
        let (count, stride) = (self.count, basis.stride());
        let of = |index: usize| {
            let function = self.functions.get(index).copied().unwrap_or(0);
            (usize::from(function), self.ways.get(index).copied().unwrap_or([0.0; 3]))
        };
        // V, then V L in its place row by row, then the matrix in that place.
        for a in 0..count {
            let (one, normal) = of(a);
            let rows = [0, 1, 2].map(|row| basis.inverse_row(row * stride + one));
            for b in 0..=a {
                let (other, across) = of(b);
                let mut sum = 0.0;
                if one < stride && other < stride {
                    for (row, n) in rows.into_iter().zip(normal) {
                        for (column, m) in across.into_iter().enumerate() {
                            let element = row.get(column * stride + other);
                            sum += n * m * element.copied().unwrap_or(0.0);
                        }
                    }
                }
                put(&mut self.factor, a, b, sum);
                put(&mut self.factor, b, a, sum);
            }
        }
        self.add_sides(basis);
        for row in self.factor.iter_mut().take(count) {
            let mut sums = [0.0; COLUMNS];
            for (k, (v, lower)) in row.iter().zip(&self.lower).enumerate().take(count) {
                add_scaled(sums.iter_mut().zip(lower).take(k + 1), *v);
            }
            *row = sums;
        }
        for a in 0..count {
            let mut sums = [0.0; COLUMNS];
            if let Some(slot) = sums.get_mut(a) {
                *slot = 1.0;
            }
            for (lower, row) in self.lower.iter().zip(&self.factor).take(count).skip(a) {
                let factor = lower.get(a).copied().unwrap_or(0.0);
                add_scaled(sums.iter_mut().zip(row).take(a + 1), factor);
            }
            if let Some(row) = self.factor.get_mut(a) {
                *row = sums;
            }
        }
        cholesky(&mut self.factor, count);
    }

    /// Adds U' Y Y' U, of the two-sided functions, to V.
    fn add_sides(&mut self, basis: &CoarseBasis<'_>) {
        let (count, mut z) = (self.count, [0.0; COLUMNS]);
        for column in basis.columns() {
            self.along_ways(basis, column, &mut z);
            for (a, z_a) in z.into_iter().enumerate().take(count) {
                let row = self.factor.get_mut(a).map_or(&mut [][..], |row| row.as_mut_slice());
                add_scaled(row.iter_mut().zip(&z).take(count), z_a);
            }
        }
    }

    /// U' v, for a vector over all basis functions, the two-sided ones last.
    fn along_ways(&self, basis: &CoarseBasis<'_>, v: &[Eight], z: &mut [f32; COLUMNS]) {
        let flat = v.as_flattened();
        let each = self.functions.iter().zip(&self.ways).take(self.count);
        for (slot, (&function, way)) in z.iter_mut().zip(each) {
            *slot = 0.0;
            for (axis, n) in way.iter().enumerate() {
                let value = flat.get(place(basis, function.into(), axis));
                *slot += n * value.copied().unwrap_or(0.0);
            }
        }
    }

    /// Returns the y that corrects c by - B U y, for t = U' B g.
    fn solve(&self, t: [f32; COLUMNS]) -> [f32; COLUMNS] {
        let (count, mut b, mut y) = (self.count, [0.0; COLUMNS], [0.0; COLUMNS]);
        let get = |of: &[f32; COLUMNS], at: usize| of.get(at).copied().unwrap_or(0.0);
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
        // Back through the factor, then times L.
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

    /// Corrects c = B g for the tools, over the basis functions of the image and over the two-sided ones.
    #[inline(always)]
    pub(crate) fn correct<V: F32x8>(
        &self,
        basis: &CoarseBasis<'_>,
        c: &mut [Eight],
        of_sides: &mut [Eight],
    ) {
        let (stride, blocks) = (basis.stride(), basis.row_blocks());
        let mut t = [0.0; COLUMNS];
        let (first, rest) = (c.as_flattened(), of_sides.as_flattened());
        let each = self.functions.iter().zip(&self.ways).take(self.count);
        for (slot, (&function, normal)) in t.iter_mut().zip(each.clone()) {
            for (axis, n) in normal.iter().enumerate() {
                *slot += n * value(first, rest, place(basis, function.into(), axis));
            }
        }
        let y = self.solve(t);
        for (y, (&function, normal)) in y.iter().zip(each) {
            for (axis, n) in normal.iter().enumerate().filter(|_| usize::from(function) < stride) {
                let (row, factor) = (axis * stride + usize::from(function), V::splat(y * n));
                let row = basis.inverse.get(row * blocks..(row + 1) * blocks).unwrap_or(&[]);
                for (slot, b) in c.iter_mut().zip(row) {
                    V::load(slot).minus(V::load(b).times(factor)).store(slot);
                }
            }
        }
        // The part of the two-sided functions: Y Y' U y.
        let mut z = [0.0; COLUMNS];
        for column in basis.columns() {
            self.along_ways(basis, column, &mut z);
            let sum = z.iter().zip(&y).take(self.count).fold(0.0, |sum, (z, y)| sum + z * y);
            let Some((own, of)) = column.split_at_checked(blocks) else { return };
            along::<V>(own, -sum, c);
            along::<V>(of, -sum, of_sides);
        }
    }
}

/// A value of a vector in two parts.
fn value(first: &[f32], rest: &[f32], place: usize) -> f32 {
    let at = match place.checked_sub(first.len()) {
        None => first.get(place),
        Some(place) => rest.get(place),
    };
    at.copied().unwrap_or(0.0)
}

/// Calls `each` for the samples of the blades' edges that press.
fn of_edges(
    basis: &CoarseBasis<'_>,
    under: Under<'_>,
    place: &impl Fn(usize) -> [f32; 3],
    mut each: impl FnMut(&OneSample),
) {
    for edge in under.tools.edges() {
        let pressing = edge.fronts().filter(|sample| sample.press(edge.forward(), place).is_some());
        pressing.for_each(|sample| each(&OneSample::of_edge(basis, sample, edge.forward())));
    }
}

/// Calls `each` for the pinned samples, those of a triangle as one.
fn of_pins(basis: &CoarseBasis<'_>, under: Under<'_>, mut each: impl FnMut(&OneSample)) {
    let pins = if PINS_ARE_BUILT { under.pins } else { &[] };
    for pins in pins.chunk_by(PinSample::is_with) {
        each(&OneSample::of_pins(basis, pins));
    }
}

#[cfg(test)]
#[allow(clippy::needless_range_loop)]
mod tests {
    use super::super::square::tests::matrix;
    use super::*;

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
        let mut t = [0.0; COLUMNS];
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
