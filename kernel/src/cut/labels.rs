//! The sides of a cut, as labels of the cells.
//!
//! The split cells of faces that share one lie on one side. Sides that lie on each other are told apart: one of them
//! keeps the hats of the image alone. A side grows into the body link by link, as far as no other one has come.

use super::body::CutBody;
use super::joined::{join, standing};
use crate::model::range;
use crate::number::two_float::LANES;

/// Most sides: a bit each in a word.
pub(super) const SIDES: usize = 32;

/// A cell of the last ring, and one of the next, in the labels; the rest is the side from 1 on.
pub(super) const LAST: u8 = 0x40;
pub(super) const NEW: u8 = 0x80;
/// The side in a label.
pub(super) const SIDE: u8 = 0x3F;

impl CutBody<'_, '_> {
    /// Labels the split cells with the side of the cut on which they lie. Returns the sides that keep the hats of the
    /// image alone, a bit each.
    pub(super) fn find_sides(&mut self) -> u32 {
        // Mark the split cells, each as a side of its own.
        self.arrays.labels.fill(0);
        for copy in self.bodily..self.bodily + self.used() {
            for cell in [copy, self.origin(copy)] {
                self.set_label(cell, LAST);
            }
        }
        // A cell on both sides of an opened face lies at the front of the cut.
        for tetrahedron in 0..self.arrays.faces.len() {
            for corner in self.open_corners(tetrahedron) {
                let Some((other, _)) = self.across(tetrahedron, corner) else { continue };
                let there = self.arrays.corners.get(other).copied().unwrap_or_default();
                for cell in self.side(tetrahedron, corner) {
                    if there.contains(&cell) {
                        self.set_label(cell.into(), 0);
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
            self.set_label(cell, if stands < cell || is_new { side | LAST } else { LAST });
        }
        self.tell_apart()
    }

    pub(super) fn label(&self, cell: usize) -> u8 {
        self.arrays.labels.get(cell).copied().unwrap_or(0)
    }

    fn set_label(&mut self, cell: usize, label: u8) {
        if let Some(slot) = self.arrays.labels.get_mut(cell) {
            *slot = label;
        }
    }

    /// Chooses the sides that keep the hats of the image: those that lie on none before them that keeps them.
    fn tell_apart(&self) -> u32 {
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
        keeping
    }

    /// Gives the neighbours of the last ring the lowest side of those that they have there.
    pub(super) fn spread(&mut self) {
        for cell in 0..self.arrays.labels.len() {
            let label = self.label(cell);
            let side = label & SIDE;
            if label & LAST == 0 || side == 0 {
                continue;
            }
            for other in ends(self.arrays.rows, self.arrays.ids, cell) {
                if let Some(label) = self.arrays.labels.get_mut(other)
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

    /// The sides that hang on something, a bit each. A piece that hangs on nothing has motions without energy, so a
    /// step of a function of its own could be of any length.
    pub(super) fn hanging(&self) -> u32 {
        let mut hanging = 0_u32;
        for cell in 0..self.bodily + self.used() {
            let side = self.label(cell) & SIDE;
            let is_held = self.model.mobility.get(self.origin(cell)) == Some(&0.0);
            let mut ends = ends(self.arrays.rows, self.arrays.ids, cell);
            if side > 0 && (is_held || ends.any(|end| self.label(end) & SIDE != side)) {
                hanging |= 1 << (side - 1);
            }
        }
        hanging
    }

    /// Marks a cell and its neighbours.
    pub(super) fn mark_around(&mut self, cell: usize, mark: u8) {
        let others = ends(self.arrays.rows, self.arrays.ids, cell);
        for cell in others.chain(core::iter::once(cell)) {
            if let Some(label) = self.arrays.labels.get_mut(cell) {
                *label |= mark;
            }
        }
    }

    pub(super) fn mark_cell(&mut self, cell: usize, mark: u8) {
        self.set_label(cell, self.label(cell) | mark);
    }
}

/// The other ends of a cell's half-links, the cell itself where a place is free.
fn ends(rows: &[u32], ids: &[[u16; LANES]], cell: usize) -> impl Iterator<Item = usize> {
    range(rows, cell / LANES)
        .filter_map(move |group| ids.get(group)?.get(cell % LANES).copied().map(usize::from))
}
