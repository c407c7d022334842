//! The links of a body of links by their ends, for passes that go over link by link.
//!
//! They follow from the half-links: a link is one whose other end is the larger cell. The list is made anew after the
//! splits of a tick.
//!
//! Cost: a look at each half-link twice.

use super::body::CutBody;
use super::memory::LinkArrays;
use crate::model::{Model, Slices, range};
use crate::number::two_float::LANES;

impl CutBody<'_, '_> {
    /// Lists the links by their lower ends, then by their upper ones.
    pub(super) fn list_links(&mut self) {
        if !self.is_of_links() {
            return;
        }
        let (cells, ids, rows) = (self.model.cells(), &*self.arrays.ids, &*self.arrays.rows);
        let links = &mut self.arrays.links;
        links.back_rows.fill(0);
        // The upper ends, and how many links each cell has as one.
        let mut count = 0_usize;
        for cell in 0..cells {
            if let Some(start) = links.rows.get_mut(cell) {
                *start = count as u32;
            }
            for group in range(rows, cell / LANES) {
                let end = ids.get(group).and_then(|ids| ids.get(cell % LANES)).copied();
                let Some(end) = end.filter(|&end| usize::from(end) > cell) else { continue };
                if links.put(count, group, cell % LANES, end) {
                    count += 1;
                }
            }
        }
        if let Some(end) = links.rows.get_mut(cells) {
            *end = count as u32;
        }
        links.list_back(cells);
    }
}

impl LinkArrays<'_> {
    /// Number of links.
    fn count(&self) -> usize {
        self.rows.last().map_or(0, |&end| end as usize)
    }

    /// Sets the numbers of a link to those of the half-link at its lower end. Returns false without a place for it.
    fn put(&mut self, link: usize, group: usize, lane: usize, end: u16) -> bool {
        let (Some(slot), Some(length), Some(weight), Some(back)) = (
            self.upper.get_mut(link),
            self.link_lengths.get_mut(link),
            self.link_weights.get_mut(link),
            self.back_rows.get_mut(usize::from(end) + 1),
        ) else {
            return false;
        };
        let of = |groups: &[[f32; LANES]]| {
            groups.get(group).and_then(|lanes| lanes.get(lane)).copied().unwrap_or(0.0)
        };
        (*slot, *length, *weight) = (end, of(self.lengths), of(self.weights));
        if let Some(alpha) = self.link_alphas.get_mut(link) {
            *alpha = of(self.alphas);
        }
        *back += 1;
        true
    }

    /// Lists the links at their upper ends, whose numbers are in the rows behind them.
    fn list_back(&mut self, cells: usize) {
        let mut sum = 0;
        for row in self.back_rows.iter_mut() {
            sum += *row;
            *row = sum;
        }
        // Each start goes up to the next one while its links are put.
        for cell in 0..cells {
            for link in range(self.rows, cell) {
                let end = self.upper.get(link).copied().map_or(cells, usize::from);
                let Some(place) = self.back_rows.get_mut(end) else { continue };
                if let (Some(lower), Some(back)) =
                    (self.lower.get_mut(*place as usize), self.back_link.get_mut(*place as usize))
                {
                    (*lower, *back) = (cell as u16, link as u32);
                }
                *place += 1;
            }
        }
        for cell in (1..=cells).rev() {
            super::memory::inherit(self.back_rows, cell - 1, cell);
        }
        if let Some(first) = self.back_rows.first_mut() {
            *first = 0;
        }
    }
}

impl<'a> LinkArrays<'a> {
    /// The model with these links, whose half-links have these groups and other ends.
    pub fn relinked(self, model: Model<'a>, rows: &'a [u32], ids: &'a [[u16; LANES]]) -> Model<'a> {
        let (count, varies) = (self.count(), model.alpha_varies());
        let slices = Slices {
            rows,
            neighbours: ids,
            lengths: self.lengths,
            alphas: varies.then_some(self.alphas),
            weights: Some(self.weights),
        };
        let alphas = self.link_alphas.get(..count).unwrap_or(&[]);
        Model {
            rows: self.rows,
            upper: self.upper.get(..count).unwrap_or(&[]),
            rest_length: self.link_lengths.get(..count).unwrap_or(&[]),
            back_rows: self.back_rows,
            lower: self.lower.get(..count).unwrap_or(&[]),
            back_link: self.back_link.get(..count).unwrap_or(&[]),
            slices: Some(slices),
            link_weights: Some(self.link_weights.get(..count).unwrap_or(&[])),
            link_alphas: varies.then_some(alphas),
            ..model
        }
    }
}
