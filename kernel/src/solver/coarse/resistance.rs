//! The coarse level of links under tools: the resistance of the contacts is taken into account.
//!
//! A tool on the surface adds a resistance to the cells of the triangles in reach: a diagonal D in the bound's
//! Laplacian. P' D P is at most the diagonal S of its row sums, and by the Woodbury formula the step that
//! lowers the bound of the energy most is
//!
//! ```text
//! c = (A + R + S)^-1 g = B g - B_H (B_HH + S_H^-1)^-1 (B g)_H
//! ```
//!
//! H is the set of basis functions with a weight at such a cell. c' (A + R + S) c = g . c holds, hence the
//! certificate of [`track`](crate::Track). `B_HH` + S_H^-1 is positive definite as B is; its Cholesky factor
//! is computed when the contacts change. With more than [`RESISTED_MAX`] basis functions in H, or if rounding
//! makes a pivot too small, there is no coarse level until they change again.
//!
//! Cost: k^3 / 6 multiplications when the contacts change, k = |H|; 3 k (n + k) per sweep, n basis functions.

use super::vector;
use crate::backend::f32x8::F32x8;
use crate::model::coarse_basis::CoarseBasis;
use crate::number::sqrt::sqrt;
use crate::number::two_float::{Eight, LANES};

/// Largest number of basis functions that contacts may resist.
pub(crate) const RESISTED_MAX: usize = 64;
/// Smallest pivot, relative to the diagonal element.
const PIVOT_MIN: f32 = 1.0e-5;
/// Blocks of a row of the factor.
const fn row_blocks(functions: usize) -> usize {
    let row = (if functions < RESISTED_MAX { functions } else { RESISTED_MAX }).div_ceil(LANES);
    // A model has at least one basis function; this lets the compiler know.
    if row == 0 { 1 } else { row }
}

/// Memory that the coarse level needs for `functions` basis functions and tools \[blocks of eight `f32`\].
///
/// With K = min(`functions`, 64) rounded up to a multiple of 8: six vectors over the basis
/// functions, K numbers of basis functions, K sums for each axis, K^2 elements of the factor.
///
/// ```
/// assert_eq!(chaincell_kernel::tool_room(27), 6 * 4 + 4 * (4 + 8 * 4));
/// ```
#[must_use]
pub const fn tool_room(functions: usize) -> usize {
    let row = row_blocks(functions);
    6 * functions.div_ceil(LANES) + row * (4 + LANES * row)
}

/// The data after the vectors in the coarse memory.
struct Resisted<'a> {
    /// Indices of the basis functions, ascending.
    functions: &'a mut [f32],
    /// Three sums each.
    sums: &'a mut [[f32; 3]],
    /// Rows of the upper factor U, `B_HH` = U' U, with the inverse of each diagonal element.
    factor: &'a mut [Eight],
    row: usize,
}

impl<'a> Resisted<'a> {
    fn cut(basis: &CoarseBasis<'_>, behind: &'a mut [Eight]) -> Option<Self> {
        let row = row_blocks(basis.count);
        let (numbers, rest) = behind.split_at_mut_checked(row)?;
        let (sums, rest) = rest.split_at_mut_checked(3 * row)?;
        let factor = rest.get_mut(..LANES * row * row)?;
        let (sums, _) = sums.as_flattened_mut().as_chunks_mut();
        Some(Self { functions: numbers.as_flattened_mut(), sums, factor, row })
    }

    /// Row i of the factor.
    fn row_of(&self, i: usize) -> &[f32] {
        vector(self.factor, self.row, i).as_flattened()
    }

    /// Computes the factor of the first `count` basis functions, with the first of their sums on the
    /// diagonal. Returns false if that is not possible.
    fn factorise(&mut self, of: &CoarseBasis<'_>, count: usize) -> bool {
        // Lets the compiler know here too that a row is neither empty nor too long.
        let row = self.row.clamp(1, RESISTED_MAX / LANES);
        // Fill the rows with the inverse's elements, and add the diagonal.
        self.factor.fill([0.0; LANES]);
        let numbers = self.functions.get(..count).unwrap_or(&[]);
        for (line, &i) in self.factor.as_flattened_mut().chunks_exact_mut(row * LANES).zip(numbers)
        {
            for (slot, &j) in line.iter_mut().zip(numbers) {
                *slot = of.inverse_at(i as usize, j as usize);
            }
        }
        let diagonal = self.factor.as_flattened_mut().iter_mut().step_by(row * LANES + 1);
        for (slot, [give, ..]) in diagonal.zip(&*self.sums).take(count) {
            *slot += give;
        }
        // Factorise row by row.
        for pivot in 0..count {
            let Some((above, below)) = self.factor.split_at_mut_checked((pivot + 1) * row) else {
                return false;
            };
            let Some(own) = above.get_mut(pivot * row..) else { return false };
            let own = own.as_flattened_mut();
            let number = numbers.get(pivot).map_or(0, |&function| function as usize);
            let left = own.get(pivot).copied().unwrap_or(0.0);
            if left.is_nan() || left <= PIVOT_MIN * of.inverse_at(number, number) {
                return false;
            }
            let inverse = 1.0 / sqrt(left);
            for slot in own.iter_mut().skip(pivot + 1) {
                *slot *= inverse;
            }
            if let Some(slot) = own.get_mut(pivot) {
                *slot = inverse;
            }
            let lines = below.as_flattened_mut().chunks_exact_mut(row * LANES);
            for (i, line) in (pivot + 1..count).zip(lines) {
                let share = own.get(i).copied().unwrap_or(0.0);
                for (slot, u) in line.iter_mut().zip(&*own).skip(i) {
                    *slot -= share * u;
                }
            }
        }
        true
    }

    /// Solves `B_HH` y = sums, in place.
    fn solve(&mut self, count: usize) {
        for at in 0..count {
            let row = vector(self.factor, self.row, at).as_flattened();
            let inverse = row.get(at).copied().unwrap_or(0.0);
            let Some((own, later)) = self.sums.get_mut(at..).and_then(<[_]>::split_first_mut)
            else {
                return;
            };
            *own = own.map(|x| x * inverse);
            for (sum, &u) in later.iter_mut().zip(row.iter().skip(at + 1)) {
                *sum = [sum[0] - u * own[0], sum[1] - u * own[1], sum[2] - u * own[2]];
            }
        }
        for at in (0..count).rev() {
            let row = self.row_of(at);
            let inverse = row.get(at).copied().unwrap_or(0.0);
            let known = self.sums.iter().zip(row).take(count).skip(at + 1);
            let own = self.sums.get(at).copied().unwrap_or([0.0; 3]);
            let own = known
                .fold(own, |own, (y, u)| [own[0] - u * y[0], own[1] - u * y[1], own[2] - u * y[2]]);
            if let Some(slot) = self.sums.get_mut(at) {
                *slot = own.map(|x| x * inverse);
            }
        }
    }
}

/// Finds the basis functions at these cells, each cell with its resistance, and factorises their part of the
/// inverse. Returns their number; `None` if they are too many or the factor does not exist.
pub(crate) fn resist(
    basis: &CoarseBasis<'_>,
    room: &mut [Eight],
    cells: impl Iterator<Item = (usize, f32)>,
) -> Option<u16> {
    let blocks = basis.blocks();
    let (vectors, behind) = room.split_at_mut_checked(6 * blocks)?;
    let marks = vectors.get_mut(..blocks)?.as_flattened_mut();
    marks.fill(0.0);
    for (cell, resists) in cells {
        for (function, weight) in basis.row_of(cell) {
            if let Some(mark) = marks.get_mut(function)
                && weight > 0.0
            {
                *mark += weight * resists;
            }
        }
    }
    // Index the marked basis functions.
    let mut taken = Resisted::cut(basis, behind)?;
    let mut count = 0;
    let marked = marks.iter().enumerate().filter(|&(_, &mark)| mark > 0.0);
    for (function, mark) in marked {
        *taken.functions.get_mut(count)? = function as f32;
        *taken.sums.get_mut(count)? = [1.0 / mark, 0.0, 0.0];
        count += 1;
    }
    taken.factorise(basis, count).then_some(count as u16)
}

/// Reduces c = B g by the resistance of the first `count` indexed basis functions. Returns false if the
/// memory is too small for them.
#[inline(always)]
pub(crate) fn solve_resisted<V: F32x8>(
    basis: &CoarseBasis<'_>,
    behind: &mut [Eight],
    count: usize,
    c: &mut [Eight],
) -> bool {
    let blocks = basis.blocks();
    if count == 0 {
        return true;
    }
    let Some(mut taken) = Resisted::cut(basis, behind) else { return false };
    let numbers = |taken: &Resisted<'_>, at: usize| {
        taken.functions.get(at).map_or(0, |&function| function as usize)
    };
    let stride = blocks * LANES;
    let value = |c: &[Eight], axis: usize, function: usize| {
        c.as_flattened().get(axis * stride + function).copied().unwrap_or(0.0)
    };
    // Solve for the shares of these basis functions.
    for at in 0..count {
        let sum = [0, 1, 2].map(|axis| value(c, axis, numbers(&taken, at)));
        if let Some(slot) = taken.sums.get_mut(at) {
            *slot = sum;
        }
    }
    taken.solve(count);
    // Subtract their columns of the inverse.
    for at in 0..count {
        let sum = taken.sums.get(at).copied().unwrap_or([0.0; 3]);
        let row = vector(basis.inverse, blocks, numbers(&taken, at));
        for (axis, &share) in sum.iter().enumerate() {
            let share = V::splat(share);
            let c = c.get_mut(axis * blocks..(axis + 1) * blocks).unwrap_or(&mut []);
            for (b, c) in row.iter().zip(c) {
                V::load(c).minus(V::load(b).times(share)).store(c);
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::{VectorUnit, run};
    use crate::energy::tests::{ROUNDING_ROOM, matrix};
    use crate::model::Model;
    use crate::solver::coarse::tests::CUBE;
    use crate::solver::coarse::{Coarse, Solve};
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn the_best_direction_under_what_resists_cells() {
        let model = Model::from_bytes(CUBE).unwrap();
        let basis = model.coarse_basis.unwrap();
        let whole = matrix(&model, model.others.0.iter(), &basis, &[]);
        let free: Vec<u16> = (0..model.cells() as u16).filter(|&c| !model.is_fixed(c)).collect();
        let cells: Vec<_> =
            free[90..110].iter().map(|&c| (usize::from(c), 0.1 * f32::from(c))).collect();
        let mut resists = vec![0.0; basis.count];
        for (function, more) in
            cells.iter().flat_map(|&(cell, of)| basis.row_of(cell).map(move |(f, w)| (f, w * of)))
        {
            resists[function] += f64::from(more);
        }
        let blocks = basis.blocks();
        let mut room = vec![[0.0_f32; LANES]; tool_room(basis.count)];
        let count = resist(&basis, &mut room, cells.iter().copied()).unwrap();
        assert!(resists.iter().filter(|&&of| of > 0.0).count() == usize::from(count) && count > 4);
        for (function, g) in room[..blocks].as_flattened_mut()[..basis.count].iter_mut().enumerate()
        {
            *g = (7 * function) as f32 * 0.618_034 % 1.0 - 0.5;
        }
        let solve = Solve { basis, room: &mut room, coarse: Coarse::Resisted(count) };
        run(VectorUnit::find(), solve);
        let (g, c) = (room[..blocks].as_flattened(), room[3 * blocks..].as_flattened());
        for function in 0..basis.count {
            let sum = |with: &dyn Fn(usize) -> f64| (0..basis.count).map(with).sum::<f64>();
            let own = ROUNDING_ROOM * (basis.count as f64).sqrt() * whole[function][function];
            let all = sum(&|other| whole[function][other] * f64::from(c[other]));
            let all = all + (own + resists[function]) * f64::from(c[function]);
            assert!((all - f64::from(g[function])).abs() < 2e-3, "{function}: {all}");
        }
    }

    #[test]
    fn too_many_functions_or_a_bad_factor_leave_no_coarse_level() {
        let model = Model::from_bytes(CUBE).unwrap();
        let basis = model.coarse_basis.unwrap();
        let mut room = vec![[0.0_f32; LANES]; tool_room(basis.count)];
        let free = || (0..model.cells()).filter(|&cell| !model.is_fixed(cell as u16));
        let all = resist(&basis, &mut room, free().map(|cell| (cell, 1.0))).map(usize::from);
        assert_eq!(all, (basis.count <= RESISTED_MAX).then_some(basis.count));
        let short = room.len() - 1;
        assert_eq!(
            resist(&basis, &mut room[..short], free().take(1).map(|cell| (cell, 1.0))),
            None
        );
        // The same basis function twice has no factor.
        let mut taken = Resisted::cut(&basis, &mut room[6 * basis.blocks()..]).unwrap();
        (taken.functions[0], taken.functions[1]) = (3.0, 3.0);
        taken.sums[..2].fill([0.0; 3]);
        assert!(taken.factorise(&basis, 1) && !taken.factorise(&basis, 2));
    }

    #[test]
    fn the_room_is_what_the_page_says() {
        assert_eq!([1, 8, 9, 64, 400].map(tool_room), [18, 18, 52, 592, 844]);
    }
}
