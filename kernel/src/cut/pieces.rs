//! The tetrahedra at a cell, joined where they share a closed face.

use super::body::CutBody;

/// Most tetrahedra at a cell; a cell with more stays whole. Meshes have up to some sixty.
pub(super) const STAR_MAX: usize = 192;

/// The tetrahedra at a cell by pieces, which are numbered by their lowest tetrahedron.
pub(super) struct Pieces {
    tetrahedra: [u32; STAR_MAX],
    /// Piece of each tetrahedron.
    labels: [u8; STAR_MAX],
    len: usize,
    /// Number of pieces.
    pub count: usize,
}

impl Pieces {
    /// The tetrahedra with their pieces, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let tetrahedra = self.tetrahedra.iter().zip(&self.labels).take(self.len);
        tetrahedra.map(|(&tetrahedron, &label)| (tetrahedron as usize, label.into()))
    }

    /// Returns true if two of the tetrahedra are in one piece.
    fn are_one(&self, one: usize, other: usize) -> bool {
        self.labels.get(one) == self.labels.get(other)
    }

    /// Joins two pieces: the tetrahedra of the later one go to the earlier one.
    fn join(&mut self, one: usize, other: usize) {
        let label = |at: usize| self.labels.get(at).copied().unwrap_or(0);
        let (one, other) = (label(one), label(other));
        let (low, high) = if one < other { (one, other) } else { (other, one) };
        self.labels.iter_mut().filter(|label| **label == high).for_each(|label| *label = low);
    }

    /// Numbers the pieces from 0.
    fn number(&mut self) {
        let mut next = 0;
        for at in 0..self.len as u8 {
            if self.labels.get(usize::from(at)) == Some(&at) {
                for label in self.labels.iter_mut().filter(|label| **label == at) {
                    *label = next;
                }
                next += 1;
            }
        }
        self.count = next.into();
    }
}

impl CutBody<'_, '_> {
    /// The pieces at a cell; `None` with too many tetrahedra.
    pub(super) fn pieces(&self, cell: usize) -> Option<Pieces> {
        let mut labels = [u8::MAX; STAR_MAX];
        let (mut tetrahedra, mut len) = ([0; STAR_MAX], 0);
        for index in 0..self.star(cell).len() {
            if let Some(tetrahedron) = self.tetrahedron_at(cell, index) {
                *tetrahedra.get_mut(len)? = tetrahedron as u32;
                *labels.get_mut(len)? = len as u8;
                len += 1;
            }
        }
        let mut pieces = Pieces { tetrahedra, labels, len, count: 0 };
        for one in 0..len {
            for other in one + 1..len {
                if !pieces.are_one(one, other)
                    && self.are_joined(tetrahedra.get(one)?, tetrahedra.get(other)?)
                {
                    pieces.join(one, other);
                }
            }
        }
        pieces.number();
        Some(pieces)
    }

    /// Returns true if two tetrahedra share a face, and it is closed.
    fn are_joined(&self, one: &u32, other: &u32) -> bool {
        let corners = |of: &u32| self.cut.corners.get(*of as usize);
        let Some((here, there)) = corners(one).zip(corners(other)) else { return false };
        let mut alone = here.iter().enumerate().filter(|(_, id)| !there.contains(id));
        let (Some((corner, _)), None) = (alone.next(), alone.next()) else { return false };
        !self.is_open(*one as usize, corner)
    }
}
