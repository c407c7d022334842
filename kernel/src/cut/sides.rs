//! Two-sided basis functions beside a cut, made anew while the body runs.
//!
//! A hat function of the coarse level moves both sides of a cut together. On one of the sides a second function with
//! its values there lets them part:
//!
//! 1. The split cells of faces that share one lie on one side of a cut. Sides that lie on each other are told apart:
//!    one of them keeps the hats of the image alone.
//! 2. A side reaches [`RINGS`] links into the body, a ring in a tick.
//!    A piece that hangs on nothing has no functions.
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
//! This begins anew once cells have split, at most every [`PAUSE`] ticks, and ends within about 150 ticks, with the most functions that there is room for.
//!
//! Cost: in a tick at most one product with B and the elasticity of the cells around one function; in the mean 1.4
//! million instructions with AVX2 for a body of 5,783 cells.

use super::body::CutBody;
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
/// Without it one tick in some two hundred is off by a third of the force where they slide, with all of it no cut opens.
const PRESSING: f32 = 0.03;
/// Least share of e' K e that a further column must add.
const ADDS: f32 = 0.05;
/// Most sides: a bit each in a word.
const SIDES: usize = 32;

/// A cell of the last ring, and one of the next, in the labels; the rest is the side from 1 on.
const LAST: u8 = 0x40;
const NEW: u8 = 0x80;
/// The side in a label.
const SIDE: u8 = 0x3F;

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
                self.find_sides();
                self.go_on(SPREADING);
            }
            SPREADING if next < RINGS => {
                self.spread();
                self.set_renewal(NEXT, next + 1);
            }
            SPREADING => {
                self.leave_loose();
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

    /// Labels the split cells with the side of the cut on which they lie.
    fn find_sides(&mut self) {
        // Mark the split cells, each as a side of its own.
        self.arrays.labels.fill(0);
        for copy in self.bodily..self.bodily + self.used() {
            for cell in [copy, self.origin(copy)] {
                if let Some(label) = self.arrays.labels.get_mut(cell) {
                    *label = LAST;
                }
            }
        }
        // A cell on both sides of an opened face lies at the front of the cut.
        for tetrahedron in 0..self.arrays.faces.len() {
            for corner in self.open_corners(tetrahedron) {
                let Some((other, _)) = self.across(tetrahedron, corner) else { continue };
                let there = self.arrays.corners.get(other).copied().unwrap_or_default();
                for cell in self.side(tetrahedron, corner) {
                    if there.contains(&cell)
                        && let Some(label) = self.arrays.labels.get_mut(usize::from(cell))
                    {
                        *label = 0;
                    }
                }
            }
        }
        for (cell, parent) in self.arrays.parents.iter_mut().enumerate() {
            *parent = cell as u16;
        }
        // Join those of each opened face: the lowest cell of a side stands for it.
        for tetrahedron in 0..self.arrays.faces.len() {
            for corner in self.open_corners(tetrahedron) {
                let mut first = None;
                for cell in self.side(tetrahedron, corner) {
                    if self.label(cell.into()) == LAST {
                        join(self.arrays.parents, *first.get_or_insert(cell), cell);
                    }
                }
            }
        }
        // Number the sides.
        let mut sides = 0;
        for cell in 0..self.arrays.labels.len() {
            if self.label(cell) != LAST {
                continue;
            }
            let stands = usize::from(standing(self.arrays.parents, cell as u16));
            let side = if stands < cell { self.label(stands) & SIDE } else { sides + 1 };
            let is_new = stands == cell && usize::from(sides) < SIDES;
            sides += u8::from(is_new);
            if let Some(label) = self.arrays.labels.get_mut(cell) {
                *label = if stands < cell || is_new { side | LAST } else { LAST };
            }
        }
        self.tell_apart();
    }

    fn label(&self, cell: usize) -> u8 {
        self.arrays.labels.get(cell).copied().unwrap_or(0)
    }

    /// Chooses the sides that keep the hats of the image: those that lie on none before them that keeps them.
    fn tell_apart(&mut self) {
        let mut meets = [0_u32; SIDES];
        let side = |body: &Self, cell| usize::from(body.label(cell) & SIDE).checked_sub(1);
        for copy in self.bodily..self.bodily + self.used() {
            let (Some(here), Some(there)) = (side(self, copy), side(self, self.origin(copy)))
            else {
                continue;
            };
            for (one, other) in [(here, there), (there, here)] {
                if let Some(meets) = meets.get_mut(one) {
                    *meets |= 1 << other;
                }
            }
        }
        let mut keeping = 0;
        for (side, meets) in meets.into_iter().enumerate() {
            keeping |= if meets & keeping == 0 { 1 << side } else { 0 };
        }
        self.set_renewal(KEEPING, keeping);
    }

    /// Gives the neighbours of the last ring the lowest side of those that they have there.
    fn spread(&mut self) {
        for cell in 0..self.arrays.labels.len() {
            let label = self.label(cell);
            let side = label & SIDE;
            if label & LAST == 0 || side == 0 {
                continue;
            }
            for group in range(self.arrays.rows, cell / LANES) {
                let other = self.arrays.ids.get(group).and_then(|ids| ids.get(cell % LANES));
                let label = other.and_then(|&other| self.arrays.labels.get_mut(usize::from(other)));
                if let Some(label) = label
                    && (*label == 0 || (*label & NEW != 0 && *label & SIDE > side))
                {
                    *label = side | NEW;
                }
            }
        }
        for label in &mut *self.arrays.labels {
            *label = *label & SIDE | (*label & NEW) >> 1;
        }
    }

    /// Leaves the hats of the image alone on pieces that hang on nothing: they have motions without energy, so a step
    /// could be of any length.
    fn leave_loose(&mut self) {
        let mut hanging = 0_u32;
        for cell in 0..self.bodily + self.used() {
            let side = self.label(cell) & SIDE;
            let is_held = self.model.mobility.get(self.origin(cell)) == Some(&0.0);
            let mut ends = range(self.arrays.rows, cell / LANES)
                .filter_map(|group| self.arrays.ids.get(group)?.get(cell % LANES));
            if side > 0 && (is_held || ends.any(|&end| self.label(end.into()) & SIDE != side)) {
                hanging |= 1 << (side - 1);
            }
        }
        self.set_renewal(KEEPING, self.renewal(KEEPING) as u32 | !hanging);
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
        self.arrays.lengths.fill(0.0);
        for index in 0..self.renewal(CELLS) {
            let cell = self.arrays.side_cells.get(index).map_or(0, |&cell| usize::from(cell));
            let row = self.arrays.side_rows.get(cell).copied().unwrap_or([NO_SIDE; LANES]);
            let Some(corner) = row.iter().position(|&side| side == function) else { continue };
            let entry = self.arrays.entry.get(cell).map_or(0, |&entry| usize::from(entry));
            let weight = self.basis().map_or(0.0, |basis| basis.weight(entry, corner));
            if let Some(slot) = self.arrays.lengths.get_mut(cell) {
                *slot = weight;
            }
            self.mark_around(cell, LAST);
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

    /// Marks a cell and its neighbours.
    fn mark_around(&mut self, cell: usize, mark: u8) {
        for group in range(self.arrays.rows, cell / LANES) {
            let other = self.arrays.ids.get(group).and_then(|ids| ids.get(cell % LANES));
            let label = other.and_then(|&other| self.arrays.labels.get_mut(usize::from(other)));
            if let Some(label) = label {
                *label |= mark;
            }
        }
        self.mark_cell(cell, mark);
    }

    fn mark_cell(&mut self, cell: usize, mark: u8) {
        if let Some(label) = self.arrays.labels.get_mut(cell) {
            *label |= mark;
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

/// The lowest cell of a side.
fn standing(parents: &[u16], mut cell: u16) -> u16 {
    while let Some(&parent) = parents.get(usize::from(cell)).filter(|&&parent| parent != cell) {
        cell = parent;
    }
    cell
}

/// Joins the sides of two cells.
fn join(parents: &mut [u16], one: u16, other: u16) {
    let (one, other) = (standing(parents, one), standing(parents, other));
    let (low, high) = if one < other { (one, other) } else { (other, one) };
    if let Some(parent) = parents.get_mut(usize::from(high)) {
        *parent = low;
    }
}
