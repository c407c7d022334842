//! A copy in the boxes of the coarse level: it takes a pair of its own, with the weights of the cell from which
//! it was copied.

use super::body::CutBody;
use crate::model::image::NO_FUNCTION;
use crate::number::two_float::Eight;

/// The weights of one cell of a pair as those of the first cell, the second one without weights.
fn alone(pair: [Eight; 2], is_second: bool) -> [Eight; 2] {
    pair.map(|[a, b, c, d, e, f, g, h]| {
        let [a, c, e, g] = if is_second { [b, d, f, h] } else { [a, c, e, g] };
        [a, 0.0, c, 0.0, e, 0.0, g, 0.0]
    })
}

impl CutBody<'_, '_> {
    /// Returns true if the boxes have places for `more` pairs.
    pub fn has_places(&self, more: usize) -> bool {
        let used = self.pairs_used() + more;
        self.arrays.entry.is_empty()
            || (used <= self.arrays.pairs.len() && 2 * used < usize::from(NO_FUNCTION))
    }

    fn pairs_used(&self) -> usize {
        self.arrays.box_rows.last().map_or(0, |&row| row as usize)
    }

    /// Gives a copy the weights of its original, at the end of the same box.
    pub fn join_box(&mut self, original: usize, copy: usize) {
        let entry = self.arrays.entry.get(original).copied();
        let Some(entry) = entry.filter(|&entry| entry != NO_FUNCTION) else { return };
        // Find the box, and move the pairs after it.
        let (pair, used) = (usize::from(entry / 2), self.pairs_used());
        let next = self.arrays.box_rows.partition_point(|&row| row as usize <= pair);
        let end = self.arrays.box_rows.get(next).map_or(used, |&row| row as usize);
        let weights = self.arrays.weights.get(pair).copied().unwrap_or_default();
        for from in (end..used).rev() {
            self.move_pair(from);
        }
        self.arrays.box_rows.iter_mut().skip(next).for_each(|row| *row += 1);
        for entry in &mut *self.arrays.entry {
            if *entry != NO_FUNCTION && usize::from(*entry) >= 2 * end {
                *entry += 2;
            }
        }
        // Put the copy in the free place.
        if let (Some(cells), Some(slot), Some(place)) = (
            self.arrays.pairs.get_mut(end),
            self.arrays.weights.get_mut(end),
            self.arrays.entry.get_mut(copy),
        ) {
            *cells = [copy as u16; 2];
            *slot = alone(weights, entry % 2 == 1);
            *place = 2 * end as u16;
        }
    }

    /// Moves a pair to the next place.
    fn move_pair(&mut self, from: usize) {
        let (pairs, weights) = (&mut *self.arrays.pairs, &mut *self.arrays.weights);
        if let (Some(cells), Some(of)) = (pairs.get(from).copied(), weights.get(from).copied())
            && let (Some(pair), Some(slot)) = (pairs.get_mut(from + 1), weights.get_mut(from + 1))
        {
            (*pair, *slot) = (cells, of);
        }
    }
}
