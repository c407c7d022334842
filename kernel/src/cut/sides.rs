//! Two-sided basis functions beside a cut, made anew while the body runs.
//!
//! A hat function of the coarse level moves both sides of a cut together. On one of the sides a second function with
//! its values there lets them part:
//!
//! 1. The split cells are labelled with their sides, see `labels`; one of two sides that lie on each other keeps the
//!    hats of the image alone, and so does a piece that hangs on nothing.
//! 2. A side reaches [`RINGS`] links into the body, a ring in a tick.
//! 3. A hat under which a side has some weight gets a function there, a few hats in a tick.
//! 4. Each function and axis e gives a column of Y, see [`Sides`]. With K the elasticity of the body as it is, P all
//!    functions so far, g = P' K e and B + Y Y' the inverse so far, which is 0 at e:
//!
//! ```text
//! u = (B + Y Y') g      s = e' K e - g . u      next column (e - u) / sqrt(s)
//! ```
//!
//! A column counts as soon as it is there. The guard judges the passes, so no proof depends on them: K without
//! rotations, and a B that stems from the whole body, make them no worse than longer sweeps. Where a further
//! function adds next to nothing, s is small and it has no column.
//!
//! This begins anew once cells have split, [`PAUSE`] ticks after the last time, and takes some 130 ticks with the most
//! functions that there is room for.
//!
//! Cost: in a tick at most one product with B and the elasticity of the cells around one function; in the mean 1.4
//! million instructions with AVX2 for a body of 5,783 cells.

use super::body::CutBody;
use super::labels::{LAST, NEW, SIDE, SIDES};
use super::memory::LIPS;
use super::renewal::{
    AT_REST, CELLS, COLUMNS, COPIES, FUNCTIONS, KEEPING, Lists, NEXT, PAUSE, RINGS, SHARING,
    SOLVING, SPREADING, STEP,
};
use crate::backend::f32x8::F32x8;
use crate::backend::{VectorUnit, Work, run};
use crate::model::coarse_basis::CoarseBasis;
use crate::model::range;
use crate::model::sides::{NO_SIDE, Sides};
use crate::number::cell::{add, scale};
use crate::number::sqrt::sqrt;
use crate::number::two_float::{Eight, LANES};
use crate::solver::coarse::elastic::Product;
use crate::solver::coarse::sides;

/// Hats looked at in a tick.
const HATS: u32 = 8;
/// Least sum of squared weights of a function on a side, and of its hat on all others.
const SUPPORT: f32 = 0.3;
/// Share of e' K e that is added to it, for the rounding of B.
const MARGIN: f32 = 0.01;
/// Share of the stiffness between sides that lie on each other with which it counts in K: they press, or they part.
/// Without it one tick in some two hundred is off by a third of the force where they slide, with all of it no cut
/// opens.
const PRESSING: f32 = 0.03;
/// Least share of e' K e that a further column must add.
const ADDS: f32 = 0.05;
impl CutBody<'_, '_> {
    /// The next step of the renewal of the two-sided functions.
    pub fn renew_sides(&mut self, vectors: Option<VectorUnit>) {
        let Some(&[step, next, copies, functions, ..]) = self.arrays.renewal.first() else {
            return;
        };
        let used = self.used() as u32;
        match step {
            AT_REST if next > 0 => self.set_renewal(NEXT, next - 1),
            AT_REST if used != copies => {
                self.set_renewal(COPIES, used);
                let keeping = self.find_sides();
                self.set_renewal(KEEPING, keeping);
                self.go_on(SPREADING);
            }
            SPREADING if next < RINGS => {
                self.spread();
                self.set_renewal(NEXT, next + 1);
            }
            SPREADING => {
                self.set_renewal(KEEPING, self.renewal(KEEPING) as u32 | !self.hanging());
                self.clear_sides();
                self.go_on(SHARING);
            }
            SHARING => {
                let hats = self.model.coarse_basis.map_or(0, |basis| basis.count as u32);
                let end = hats.min(next + HATS);
                (next..end).for_each(|hat| self.share(hat as u16));
                self.set_renewal(NEXT, end);
                if end == hats {
                    self.go_on(SOLVING);
                }
            }
            SOLVING if next < 3 * functions => {
                self.solve(next as usize, vectors);
                self.set_renewal(NEXT, next + 1);
            }
            SOLVING => {
                self.go_on(AT_REST);
                self.set_renewal(NEXT, PAUSE);
            }
            _ => {}
        }
    }

    fn set_renewal(&mut self, index: usize, word: u32) {
        let words = self.arrays.renewal.first_mut();
        if let Some(slot) = words.and_then(|words| words.get_mut(index)) {
            *slot = word;
        }
    }

    fn renewal(&self, index: usize) -> usize {
        let words = self.arrays.renewal.first();
        words.and_then(|words| words.get(index)).map_or(0, |&word| word as usize)
    }

    fn go_on(&mut self, step: u32) {
        self.set_renewal(STEP, step);
        self.set_renewal(NEXT, 0);
    }

    /// Takes all two-sided functions out.
    fn clear_sides(&mut self) {
        for index in [FUNCTIONS, COLUMNS, CELLS] {
            self.set_renewal(index, 0);
        }
        self.arrays.side_rows.fill([NO_SIDE; LANES]);
        self.arrays.labels.iter_mut().for_each(|label| *label &= SIDE);
    }

    /// Calls `visit(cell, corner, weight)` for the cells under a hat.
    fn each_under(&self, hat: u16, mut visit: impl FnMut(usize, usize, f32)) {
        let Some(basis) = self.basis() else { return };
        for (at_box, corners) in basis.corners.iter().enumerate() {
            let Some(corner) = corners.iter().position(|&function| function == hat) else {
                continue;
            };
            let pairs = range(basis.rows, at_box);
            let cells = basis.cells.get(pairs.clone()).unwrap_or(&[]).as_flattened();
            for (at, &cell) in cells.iter().enumerate() {
                let weight = basis.weight(2 * pairs.start + at, corner);
                if weight > 0.0 {
                    visit(cell.into(), corner, weight);
                }
            }
        }
    }

    /// Gives a hat its functions on the sides under it.
    fn share(&mut self, hat: u16) {
        // Sum the squared weights of each side.
        let (mut sums, mut all) = ([0.0; SIDES + 1], 0.0);
        self.each_under(hat, |cell, _, weight| {
            let side = self.arrays.labels.get(cell).map_or(0, |&label| usize::from(label));
            if let Some(sum) = sums.get_mut(side) {
                *sum += weight * weight;
            }
            all += weight * weight;
        });
        let keeping = self.renewal(KEEPING);
        for (side, sum) in sums.into_iter().enumerate().skip(1) {
            let keeps = keeping >> (side - 1) & 1 != 0;
            if !keeps && sum >= SUPPORT && all - sum >= SUPPORT {
                self.add_side(hat, side as u8);
            }
        }
    }

    /// Adds the function of a hat on a side, if there is room for one.
    fn add_side(&mut self, hat: u16, side: u8) {
        let function = self.renewal(FUNCTIONS);
        if function >= self.arrays.turns.len() {
            return;
        }
        // Name it at the cells under the hat, and list those that are not.
        let rows = core::mem::take(&mut self.arrays.side_rows);
        let cells = core::mem::take(&mut self.arrays.side_cells);
        let (mut listed, mut highest, mut turn) = (self.renewal(CELLS), 0.0, 0);
        self.each_under(hat, |cell, corner, weight| {
            let Some(row) = rows.get_mut(cell).filter(|_| self.label(cell) == side) else { return };
            if *row == [NO_SIDE; LANES]
                && let Some(slot) = cells.get_mut(listed)
            {
                *slot = cell as u16;
                listed += 1;
            }
            if let Some(slot) = row.get_mut(corner) {
                *slot = function as u8;
            }
            // The cell with the largest weight gives the rotation.
            if weight > highest {
                (highest, turn) = (weight, cell as u16);
            }
        });
        (self.arrays.side_rows, self.arrays.side_cells) = (rows, cells);
        if let Some(slot) = self.arrays.turns.get_mut(function) {
            *slot = turn;
        }
        self.set_renewal(CELLS, listed as u32);
        self.set_renewal(FUNCTIONS, function as u32 + 1);
    }

    /// The coarse basis of the body as it is, without two-sided functions.
    fn basis(&self) -> Option<CoarseBasis<'_>> {
        let arrays = &self.arrays;
        let (rows, pairs, entry) = (&*arrays.box_rows, &*arrays.pairs, &*arrays.entry);
        let basis = self.model.coarse_basis?;
        Some(basis.with_cells(rows, pairs, arrays.weights, entry, arrays.factors))
    }

    /// The two-sided functions, with these columns of Y.
    fn sides<'s>(&'s self, columns: &'s [Eight]) -> Sides<'s> {
        let arrays = &self.arrays;
        let lists = Lists { turns: arrays.turns, cells: arrays.side_cells, rows: arrays.side_rows };
        let renewal = arrays.renewal.first().copied().unwrap_or_default();
        Sides { columns, ..lists.sides(renewal, &[], 0) }
    }

    /// Solves for the column of a function and axis, if it adds something.
    fn solve(&mut self, index: usize, vectors: Option<VectorUnit>) {
        let pushes = core::mem::take(&mut self.arrays.pushes);
        let columns = core::mem::take(&mut self.arrays.columns);
        let is_added = self.try_column(index, vectors, pushes, columns);
        (self.arrays.pushes, self.arrays.columns) = (pushes, columns);
        if is_added == Some(true) {
            self.set_renewal(COLUMNS, self.renewal(COLUMNS) as u32 + 1);
        }
    }

    fn try_column(
        &mut self,
        index: usize,
        vectors: Option<VectorUnit>,
        pushes: &mut [[f32; 3]],
        columns: &mut [Eight],
    ) -> Option<bool> {
        let function = (index / 3) as u8;
        self.push(function, index % 3, pushes);
        // Divide the memory: earlier columns, the new one, and g in the last place.
        let basis = self.basis()?;
        let (own, length) = (basis.row_blocks(), basis.row_blocks() + basis.side_blocks());
        let (earlier, rest) = columns.split_at_mut_checked(self.renewal(COLUMNS) * length)?;
        let (column, rest) = rest.split_at_mut_checked(length)?;
        let g = rest.get_mut(rest.len().checked_sub(length)?..)?;
        // g = P' K e.
        let basis = basis.with_sides(self.sides(earlier));
        g.fill([0.0; LANES]);
        let at = |function: usize, axis: usize| sides::place(&basis, function, axis);
        for (cell, push) in pushes.iter().enumerate() {
            if self.label(cell) & NEW == 0 {
                continue;
            }
            for (function, weight) in basis.row_of(cell).chain(basis.sides_of(cell)) {
                for (axis, push) in push.iter().enumerate() {
                    if let Some(sum) = g.as_flattened_mut().get_mut(at(function, axis)) {
                        *sum += weight * push;
                    }
                }
            }
        }
        // u = (B + Y Y') g, into the place of the column.
        let here = at(basis.stride() + usize::from(function), index % 3);
        let stiffness = g.as_flattened().get(here).copied()?;
        let ((g, of_sides), (u, u_sides)) =
            (g.split_at_checked(own)?, column.split_at_mut_checked(own)?);
        run(vectors, Product { inverse: basis.inverse, g, c: u, first: 0 });
        run(vectors, Added { basis, g, of_sides, c: u, to_sides: u_sides });
        // (e - u) / sqrt(s), if it adds something.
        let along = |u: &[Eight], g: &[Eight]| {
            u.as_flattened().iter().zip(g.as_flattened()).fold(0.0, |sum, (u, g)| sum + u * g)
        };
        let rest = (1.0 + MARGIN) * stiffness - (along(u, g) + along(u_sides, of_sides));
        let adds = rest > ADDS * stiffness;
        if !adds {
            return Some(false);
        }
        let share = 1.0 / sqrt(rest);
        let values = column.as_flattened_mut();
        values.iter_mut().for_each(|x| *x = -share * *x + 0.0);
        if let Some(slot) = values.get_mut(here) {
            *slot = share;
        }
        Some(true)
    }

    /// K e for a function along an axis: `pushes` at the cells whose labels have [`NEW`], until the next call.
    fn push(&mut self, function: u8, axis: usize, pushes: &mut [[f32; 3]]) {
        // Its lengths. Mark the cells that it strains, then those that these push.
        self.arrays.labels.iter_mut().for_each(|label| *label &= SIDE);
        let lengths = core::mem::take(&mut self.arrays.lengths);
        lengths.fill(0.0);
        if let Some(basis) = self.basis().map(|basis| basis.with_sides(self.sides(&[]))) {
            let of = basis.stride() + usize::from(function);
            for &cell in basis.sides().map_or(&[][..], |sides| sides.cells) {
                let weight = basis.sides_of(cell.into()).find(|&(at, _)| at == of);
                if let (Some((_, weight)), Some(slot)) =
                    (weight, lengths.get_mut(usize::from(cell)))
                {
                    *slot = weight;
                }
            }
        }
        self.arrays.lengths = lengths;
        for cell in 0..self.arrays.labels.len() {
            if self.arrays.lengths.get(cell).is_some_and(|&length| length > 0.0) {
                self.mark_around(cell, LAST);
            }
        }
        for cell in 0..self.arrays.labels.len() {
            if self.label(cell) & LAST != 0 {
                self.mark_around(cell, NEW);
            }
        }
        // Mark both sides of its lips.
        for place in 0..LIPS * self.used() {
            let Some(lip) = self.lip(place) else { continue };
            if lip.cells.iter().any(|&cell| self.label(cell.into()) & LAST != 0) {
                lip.cells.iter().for_each(|&cell| self.mark_cell(cell.into(), NEW));
            }
        }
        // Add a share of what these exert, and what the strained cells do.
        pushes.fill([0.0; 3]);
        let (lengths, shapes) = (&*self.arrays.lengths, self.shapes());
        let length = |cell: usize| lengths.get(cell).copied().unwrap_or(0.0);
        for (place, lip) in self.lips() {
            let normal = self.arrays.normals.get(place).copied().unwrap_or_default();
            let [first, second] = lip.cells.map(|cell| length(cell.into()));
            let along = normal.get(axis).map_or(0.0, |n| n * (second - first));
            let push = scale(PRESSING * lip.weight * along, normal);
            for (cell, push) in lip.cells.into_iter().zip([scale(-1.0, push), push]) {
                if let Some(sum) = pushes.get_mut(usize::from(cell)) {
                    *sum = add(*sum, push);
                }
            }
        }
        for cell in (0..self.arrays.labels.len()).filter(|&cell| self.label(cell) & LAST != 0) {
            shapes.resist_along(cell, axis, &length, &mut |to, push| {
                if let Some(sum) = pushes.get_mut(to) {
                    *sum = add(*sum, push);
                }
            });
        }
    }
}

/// c += Y Y' g.
struct Added<'a> {
    basis: CoarseBasis<'a>,
    g: &'a [Eight],
    of_sides: &'a [Eight],
    c: &'a mut [Eight],
    to_sides: &'a mut [Eight],
}

impl Work for Added<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        sides::add_to::<V>(&self.basis, self.g, self.of_sides, self.c, self.to_sides);
    }
}
