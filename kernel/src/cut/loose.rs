//! Pieces of a cut body that hang on nothing, and what the image says becomes of them, see [`Loose`].
//!
//! Tetrahedra that share a cell are of one piece, so one that hangs on a single cell or an edge is part of what it
//! hangs on. A piece hangs if it has a fixed cell, or one that a tool holds; in a body without any the largest one
//! does, of two the one with the lowest cell. Its cells then have mobility 0 and no weight in the coarse level, so a
//! piece stays where it was. Without it the motions that the others can make are fewer, so all bounds hold, and the
//! energy is what it was. A dropped piece besides has no triangles and no lips. This is done at once after the splits
//! of a tick, and where the tool takes hold of other cells.
//!
//! Cost: in a tick with splits a look at each tetrahedron and at each cell, some 60 instructions for a tetrahedron. A
//! body whose image says nothing of loose pieces pays nothing.

use super::body::CutBody;
use super::joined::{join, standing};
use super::memory::LIPS;
use crate::model::image::NO_FUNCTION;
use crate::model::loose::Loose;

impl CutBody<'_, '_> {
    /// Returns true if the image says what becomes of loose pieces.
    pub(crate) fn seeks_pieces(&self) -> bool {
        self.cut.loose != Loose::Leave
    }

    /// Returns true for a cell of a piece that hangs on nothing.
    #[inline(always)]
    pub fn is_loose(&self, cell: usize) -> bool {
        self.arrays.loose.get(cell) == Some(&1)
    }

    /// Returns true for a cell of a piece that is dropped.
    #[inline(always)]
    pub fn is_dropped(&self, cell: usize) -> bool {
        self.cut.loose == Loose::Drop && self.is_loose(cell)
    }

    /// Returns true for a tetrahedron of such a piece.
    pub fn drops(&self, tetrahedron: usize) -> bool {
        let corners = self.arrays.corners.get(tetrahedron);
        corners.is_some_and(|[first, ..]| self.is_dropped(usize::from(*first)))
    }

    /// Finds the pieces that hang on nothing.
    pub(crate) fn find_loose(&mut self, is_held: &impl Fn(usize) -> bool) {
        if !self.seeks_pieces() {
            return;
        }
        // Join the cells of each tetrahedron: the lowest one stands for all.
        for (cell, root) in self.arrays.roots.iter_mut().enumerate() {
            *root = cell as u16;
        }
        for [first, others @ ..] in &*self.arrays.corners {
            for other in others {
                join(self.arrays.roots, *first, *other);
            }
        }
        // Count the cells of each.
        let cells = self.bodily + self.used();
        self.arrays.sizes.fill(0);
        for cell in 0..cells {
            let root = standing(self.arrays.roots, cell as u16);
            if let (Some(slot), Some(size)) =
                (self.arrays.roots.get_mut(cell), self.arrays.sizes.get_mut(usize::from(root)))
            {
                *slot = root;
                *size = size.saturating_add(1);
            }
        }
        // Those that hang count 0: of a body that nothing holds the largest.
        let largest =
            self.arrays.sizes.iter().enumerate().fold((0, 0), |most, (cell, &size)| {
                if size > most.1 { (cell, size) } else { most }
            });
        let mut is_any = false;
        for cell in 0..cells {
            let is_fixed = self.model.mobility.get(self.origin(cell)) == Some(&0.0);
            if is_fixed || is_held(cell) {
                let root = self.arrays.roots.get(cell).copied().map_or(0, usize::from);
                self.hang(root);
                is_any = true;
            }
        }
        if !is_any {
            self.hang(largest.0);
        }
        // Note the others.
        for (root, slot) in self.arrays.roots.iter().zip(&mut *self.arrays.loose).take(cells) {
            let size = self.arrays.sizes.get(usize::from(*root));
            *slot = size.is_some_and(|&size| size > 0).into();
        }
    }

    fn hang(&mut self, root: usize) {
        if let Some(size) = self.arrays.sizes.get_mut(root) {
            *size = 0;
        }
    }

    /// Takes the triangles and lips of dropped pieces out, after those of the body were listed.
    pub(super) fn drop_sides(&mut self) {
        if self.cut.loose != Loose::Drop {
            return;
        }
        for triangle in 0..self.model.triangles.len() {
            let corners = self.arrays.triangles.get(triangle).copied().unwrap_or_default();
            let [first, ..] = corners;
            if !self.is_dropped(first.into()) {
                self.name_triangle(triangle);
            } else if let Some(slot) = self.arrays.triangles.get_mut(triangle) {
                // Tools do not touch a triangle of one cell.
                *slot = [first; 3];
            }
        }
        for place in 0..LIPS * self.used() {
            let cells = self.arrays.lip_cells.get(place).copied().unwrap_or_default();
            let is_dropped = cells.iter().any(|&cell| self.is_dropped(cell.into()));
            if let Some(numbers) = self.arrays.lip_numbers.get_mut(place).filter(|_| is_dropped) {
                *numbers = [0.0; 5];
            }
        }
    }

    /// Holds the cells of loose pieces where they are, after the bounds of all cells were set.
    pub(super) fn freeze(&mut self) {
        if !self.seeks_pieces() {
            return;
        }
        for cell in 0..self.bodily + self.used() {
            let is_loose = self.is_loose(cell);
            let numbers = [&mut *self.arrays.mobility, &mut *self.arrays.factors];
            for slot in numbers.into_iter().filter_map(|array| array.get_mut(cell)) {
                *slot = if is_loose { 0.0 } else { *slot };
            }
            self.weigh(cell, is_loose);
        }
    }

    /// Sets the weights of a cell in the coarse level: none, or those of the image.
    fn weigh(&mut self, cell: usize, is_loose: bool) {
        let Some(basis) = self.model.coarse_basis else { return };
        let entries = [self.arrays.entry.get(cell), basis.entry.get(self.origin(cell))];
        let [Some(&here), Some(&whole)] = entries else { return };
        if here == NO_FUNCTION || whole == NO_FUNCTION {
            return;
        }
        let (here, whole) = (usize::from(here), usize::from(whole));
        let image = basis.weights.get(whole / 2).map_or(&[][..], |pair| pair.as_flattened());
        let Some(pair) = self.arrays.weights.get_mut(here / 2) else { return };
        // The weights of both cells of a pair alternate.
        let lane = |entry: usize| (entry % 2..).step_by(2);
        let slots = pair.as_flattened_mut().iter_mut().skip(here % 2).step_by(2);
        for (slot, at) in slots.zip(lane(whole)) {
            *slot = if is_loose { 0.0 } else { image.get(at).copied().unwrap_or(0.0) };
        }
    }
}
