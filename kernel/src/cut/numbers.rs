//! Volumes and half-links of a cell from its tetrahedra.
//!
//! ```text
//! V_i  = sum of V_t / 4      a_ij = sum of V_t / 4 g_j      a_ii = - sum of a_ij
//! s_ij = -2 beta sum of mu V_t g_i . g_j,   mu the mean of the corners'
//! ```
//!
//! over the tetrahedra t at cell i, ascending. A cell's half-links follow the order in which its tetrahedra
//! name their other ends.

use core::ops::Range;

use super::body::CutBody;
use super::hats::{dot, gradients};
use super::links::LinkNumbers;
use super::memory::inherit;
use crate::model::image::nodal;
use crate::model::range;
use crate::number::two_float::LANES;

impl CutBody<'_, '_> {
    /// Sets volume and half-links of a cell. A half-link without a place in the cell's groups is left out.
    pub fn renumber(&mut self, cell: usize) {
        if self.is_of_links() {
            return self.relink(cell);
        }
        // Clear the cell's numbers and places.
        self.set_number(cell, nodal::VOLUME, 0.0);
        let (lane, groups) = (cell % LANES, range(self.arrays.rows, cell / LANES));
        for group in groups.clone() {
            self.put(group, lane, cell as u16, [0.0; nodal::SLOT_ROWS]);
        }
        // Add the tetrahedra.
        for index in 0..self.star(cell).len() {
            if let Some(tetrahedron) = self.tetrahedron_at(cell, index) {
                self.add(cell, tetrahedron);
            }
        }
        // A cell without tetrahedra exerts no force.
        if self.number(cell, nodal::VOLUME) <= 0.0 {
            self.set_number(cell, nodal::VOLUME, 1.0);
        }
        // The sum of all areas is 0, to the last place.
        let mut own = [0.0_f32; 3];
        for group in groups {
            for (axis, own) in own.iter_mut().enumerate() {
                *own -= self.slot_number(group, lane, nodal::AREA + axis);
            }
        }
        for (axis, own) in own.into_iter().enumerate() {
            self.set_number(cell, nodal::OWN + axis, own + 0.0);
        }
        self.renumber_bands(cell);
    }

    /// Adds a tetrahedron to the numbers of one of its cells.
    fn add(&mut self, cell: usize, tetrahedron: usize) {
        let (Some(&corners), Some(&bodily)) =
            (self.arrays.corners.get(tetrahedron), self.cut.corners.get(tetrahedron))
        else {
            return;
        };
        let (volume, slopes) = gradients(bodily.map(|id| self.rest_position(id)));
        let mu = corners.map(|id| f64::from(self.number(id.into(), nodal::MU)));
        let mu = 0.25 * (mu[0] + mu[1] + mu[2] + mu[3]);
        let here = corners.iter().zip(slopes).find(|(id, _)| usize::from(**id) == cell);
        let Some((_, own)) = here else { return };
        let sum = self.number(cell, nodal::VOLUME) + (0.25 * volume) as f32;
        self.set_number(cell, nodal::VOLUME, sum);
        for (&other, slope) in corners.iter().zip(slopes) {
            if usize::from(other) != cell {
                let [x, y, z] = slope.map(|x| (0.25 * volume * x) as f32);
                let spread = -2.0 * f64::from(nodal::BETA) * mu * volume * dot(own, slope);
                self.add_slot(cell, other, [x, y, z, spread as f32]);
            }
        }
    }

    /// Adds numbers to a cell's half-link, which takes the next place if it is new.
    fn add_slot(&mut self, cell: usize, other: u16, more: [f32; nodal::SLOT_ROWS]) {
        let lane = cell % LANES;
        let place = range(self.arrays.rows, cell / LANES).find(|&group| {
            let id = self.arrays.ids.get(group).and_then(|ids| ids.get(lane)).copied();
            id.is_some_and(|id| id == other || usize::from(id) == cell)
        });
        let Some(group) = place else { return };
        let mut numbers = more;
        for (row, sum) in numbers.iter_mut().enumerate() {
            *sum = self.slot_number(group, lane, row) + *sum + 0.0;
        }
        self.put(group, lane, other, numbers);
    }

    /// Names the other end of a cell's half-link anew; `to` is the last copy that the cell sees.
    pub fn rename_end(&mut self, cell: usize, from: u16, to: u16) {
        if self.is_of_links() {
            return self.relink_end(cell, from, to);
        }
        let lane = cell % LANES;
        for group in range(self.arrays.rows, cell / LANES) {
            let id = self.arrays.ids.get_mut(group).and_then(|ids| ids.get_mut(lane));
            if let Some(id) = id.filter(|id| **id == from) {
                *id = to;
            }
        }
    }

    fn slot_number(&self, group: usize, lane: usize, row: usize) -> f32 {
        let lanes = self.arrays.slots.get(group).and_then(|rows| rows.get(row));
        lanes.and_then(|lanes| lanes.get(lane)).copied().unwrap_or(0.0)
    }

    /// Sets a place of a cell's half-links.
    fn put(&mut self, group: usize, lane: usize, other: u16, numbers: [f32; nodal::SLOT_ROWS]) {
        if let Some(slot) = self.arrays.ids.get_mut(group).and_then(|ids| ids.get_mut(lane)) {
            *slot = other;
        }
        let rows = self.arrays.slots.get_mut(group).into_iter().flatten();
        for (lanes, number) in rows.zip(numbers) {
            if let Some(slot) = lanes.get_mut(lane) {
                *slot = number;
            }
        }
    }

    /// Gives a slice as many groups as `needed`; those after it move. Returns false if there is no place.
    pub fn grow(&mut self, slice: usize, needed: usize) -> bool {
        let groups = range(self.arrays.rows, slice);
        let more = needed.saturating_sub(groups.len());
        let (end, used) = (groups.end, self.arrays.rows.last().map_or(0, |&row| row as usize));
        if more == 0 {
            return true;
        }
        if used + more > self.arrays.ids.len() {
            return false;
        }
        // Move the groups after it, and clear the new ones.
        for from in (end..used).rev() {
            self.move_group(from, from + more);
        }
        self.clear_groups(slice, end..end + more);
        self.arrays.rows.iter_mut().skip(slice + 1).for_each(|row| *row += more as u32);
        true
    }

    /// Clears groups of a slice: their other ends are the lanes' own cells.
    pub fn clear_groups(&mut self, slice: usize, groups: Range<usize>) {
        let last = self.arrays.rest.len().saturating_sub(1);
        for group in groups {
            for lane in 0..LANES {
                let cell = (slice * LANES + lane).min(last);
                self.put(group, lane, cell as u16, [0.0; nodal::SLOT_ROWS]);
                self.put_link(group, lane, cell as u16, LinkNumbers::PADDING);
                self.arrays.bands.put(group, lane, 0.0, 0.0);
            }
        }
    }

    pub fn move_group(&mut self, from: usize, to: usize) {
        inherit(self.arrays.slots, from, to);
        inherit(self.arrays.ids, from, to);
        self.arrays.links.move_group(from, to);
        self.arrays.bands.move_group(from, to);
    }
}
