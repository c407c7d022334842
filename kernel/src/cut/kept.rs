//! Parts of a cut body that a snapshot contains: its state. The numbers follow from it and from the image.

use super::body::CutBody;
use super::memory::{CREDIT, CutRoom, OPENED, TURN, USED, WAITING, image_groups};
use super::renewal::{in_use, is_fit};
use super::tear::TURNS;
use crate::model::Model;
use crate::model::nodal::OffsetNumbers;
use crate::model::sides::NO_SIDE;
use crate::number::kept::Pass;
use crate::number::words::number;

/// Largest square of a normal's length.
const NORMAL_MAX: f32 = 1.001;

/// Passes over the state of a body that can be cut; `model` is such a one.
pub(crate) fn keep(memory: &mut CutRoom<'_>, model: &Model<'_>, pass: &mut Pass<'_>) {
    let room = memory.state(model).map_or(0, <[u32]>::len);
    let needed = pass.word(room as u32) as usize;
    let is_whole = needed == 0;
    if needed != room && !is_whole {
        return if room == 0 { pass.lacks(needed, room) } else { pass.refuse() };
    }
    let Some(mut body) = CutBody::of(memory, model) else { return };
    if is_whole {
        if pass.is_reading() {
            body.reset();
        }
        return;
    }
    body.keep(pass);
}

impl CutBody<'_, '_> {
    /// Passes over the arrays of the state; every word is checked before any is read.
    fn keep(&mut self, pass: &mut Pass<'_>) {
        let (bodily, spare) = (self.bodily, self.cut.spare_cells);
        // The counts, and the origins of the copies.
        let mut counts = *self.arrays.counts;
        for count in &mut counts {
            *count = pass.word(*count);
        }
        let used = counts.get(USED).map_or(0, |&used| used as usize);
        if used > spare {
            return pass.refuse();
        }
        pass.slice_if(self.arrays.origins, |_, &origin| usize::from(origin) < bodily);
        // The corners: of the image, or copies.
        let whole = self.cut.corners;
        pass.slice_if(self.arrays.corners, |tetrahedron, corners| {
            whole.get(tetrahedron).is_some_and(|whole| {
                let mut pairs = corners.iter().zip(whole);
                pairs.all(|(&id, &whole)| {
                    id == whole || (bodily..bodily + used).contains(&usize::from(id))
                })
            })
        });
        // Each face is open on both sides, and counted; so is each mark.
        let count = |index: usize| counts.get(index).copied().unwrap_or(0);
        let mut sides = 0;
        pass.slice_if(self.arrays.faces, |_, &faces| {
            sides += faces.count_ones();
            faces < 16
        });
        let mut waiting = 0;
        pass.slice_if(self.arrays.marks, |_, &mark| {
            waiting += u32::from(mark);
            mark < 2
        });
        if sides != count(OPENED).saturating_mul(2) || waiting != count(WAITING) {
            pass.refuse();
        }
        // The groups of each slice: never fewer than in the image.
        let (image, most) = (image_groups(self.model).rows, self.arrays.ids.len());
        let mut last = 0;
        pass.slice_if(self.arrays.rows, |slice, &row| {
            let before = image.get(slice.saturating_sub(1)).copied().unwrap_or(0);
            let groups = image.get(slice).map_or(0, |&row| row - before);
            let has_groups = row.checked_sub(last).is_some_and(|of_slice| of_slice >= groups);
            let is_fit = row as usize <= most && has_groups && (slice > 0 || row == 0);
            last = row;
            is_fit
        });
        pass.slice_if(self.arrays.is_offset, |_, &is_offset| is_offset < 2);
        let is_finite = |rows: &OffsetNumbers| rows.as_flattened().iter().all(|x| x.is_finite());
        pass.slice_if(self.arrays.offsets, |_, rows| is_finite(rows));
        pass.slice_if(self.arrays.normals, |_, normal| {
            normal.iter().map(|x| x * x).sum::<f32>() <= NORMAL_MAX
        });
        pass.slice_if(self.arrays.tear, |place, &word| match place {
            TURN => word < TURNS,
            CREDIT => f32::from_bits(word).is_finite() && word != (-0.0_f32).to_bits(),
            _ => true,
        });
        self.keep_sides(pass);
        if pass.is_reading() {
            *self.arrays.counts = counts;
            self.derive();
        }
    }

    /// The same for the two-sided functions, which do not follow from state and image.
    fn keep_sides(&mut self, pass: &mut Pass<'_>) {
        let basis = self.model.coarse_basis;
        let column = basis.map_or(0, |basis| basis.row_blocks() + basis.side_blocks());
        pass.slice_if(self.arrays.loose, |_, &flag| flag <= 1);
        pass.slice_if(self.arrays.work, |_, &work| number(work).is_finite());
        let cells = self.arrays.labels.len();
        for renewal in &mut *self.arrays.renewal {
            let mut words = *renewal;
            for word in &mut words {
                *word = pass.word(*word);
            }
            let [functions, columns, listed] = in_use(words);
            if !is_fit(words, self.arrays.turns.len(), cells) {
                return pass.refuse();
            }
            // Every list up to its end; `is_fit` has compared the counts with their room.
            let is_cell = |_, &cell: &u16| usize::from(cell) < cells;
            let turns = self.arrays.turns.get_mut(..functions).unwrap_or_default();
            pass.slice_if(turns, is_cell);
            pass.slice_if(self.arrays.labels, |_, _| true);
            pass.slice_if(self.arrays.side_rows, |_, row| {
                row.iter().all(|&side| side == NO_SIDE || usize::from(side) < functions)
            });
            let listed = self.arrays.side_cells.get_mut(..listed).unwrap_or_default();
            pass.slice_if(listed, is_cell);
            let columns = self.arrays.columns.get_mut(..columns * column).unwrap_or_default();
            pass.slice_if(columns, |_, block| block.iter().all(|x| x.is_finite()));
            if pass.is_reading() {
                *renewal = words;
            }
        }
    }

    /// Sets all numbers from the state.
    pub fn derive(&mut self) {
        // The whole body, with the groups where they are now.
        let rows = image_groups(self.model).rows;
        self.derive_whole();
        for slice in (0..rows.len().saturating_sub(1)).rev() {
            self.spread_groups(slice, rows);
        }
        // The copies, then every cell whose tetrahedra have changed.
        for spare in 0..self.used() {
            let copy = self.bodily + spare;
            self.inherit(self.origin(copy), copy);
        }
        for cell in 0..self.bodily + self.used() {
            // The order of a cell's links follows the names of their ends.
            let is_named = |body: &Self| body.ends(cell).any(|(whole, now)| whole != now);
            if self.is_torn(cell) || (self.is_of_links() && is_named(self)) {
                self.renumber(cell);
            } else {
                self.name_ends(cell);
            }
        }
        for triangle in 0..self.arrays.triangles.len() {
            self.name_triangle(triangle);
        }
        self.list_read();
    }

    /// Moves the groups of a slice from their places in the image to the present ones; the last slice first.
    fn spread_groups(&mut self, slice: usize, image: &[u32]) {
        let row = |rows: &[u32], at: usize| rows.get(at).map_or(0, |&row| row as usize);
        let (from, to) = (row(image, slice), row(self.arrays.rows, slice));
        let (count, end) = (row(image, slice + 1) - from, row(self.arrays.rows, slice + 1));
        for group in (0..count).rev() {
            self.move_group(from + group, to + group);
        }
        self.clear_groups(slice, to + count..end);
    }

    /// Returns true if a split has renumbered the cell: it is split, or sees two copies of a cell.
    fn is_torn(&self, cell: usize) -> bool {
        let is_split = self.arrays.origins.iter().take(self.used());
        let origin = self.origin(cell);
        if is_split.clone().any(|&split| usize::from(split) == origin) {
            return true;
        }
        let mut renamed = self.ends(cell).filter(|(whole, now)| whole != now);
        renamed.any(|(whole, now)| self.ends(cell).any(|(other, id)| other == whole && id != now))
    }

    /// The corners of the tetrahedra at a cell, in the image and as they are now.
    fn ends(&self, cell: usize) -> impl Iterator<Item = (u16, u16)> {
        let corners = self.star(cell).iter().filter_map(|&tetrahedron| {
            let tetrahedron = tetrahedron as usize;
            Some((self.cut.corners.get(tetrahedron)?, self.arrays.corners.get(tetrahedron)?))
        });
        corners.flat_map(|(whole, now)| whole.iter().copied().zip(now.iter().copied()))
    }

    /// Names the other ends of a cell's half-links as its tetrahedra name them.
    fn name_ends(&mut self, cell: usize) {
        for index in 0..self.star(cell).len() {
            let Some(tetrahedron) = self.tetrahedron_at(cell, index) else { continue };
            let whole = self.cut.corners.get(tetrahedron).copied().unwrap_or_default();
            let now = self.arrays.corners.get(tetrahedron).copied().unwrap_or_default();
            for (whole, now) in whole.into_iter().zip(now).filter(|(whole, now)| whole != now) {
                self.rename_end(cell, whole, now);
            }
        }
    }
}
