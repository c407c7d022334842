//! The split of a cell.
//!
//! The cell, its copies and the neighbours that see more than one of them get their numbers anew from their
//! tetrahedra. Every other neighbour sees one of them alone, at the same place and with the same numbers as the cell
//! before: its half-link takes the new name.

use core::ops::Range;

use super::body::CutBody;
use super::memory::{REFUSED, USED, inherit};
use super::offset::{at_most, of_shapes};
use super::pieces::Pieces;
use crate::energy::state::States;
use crate::model::image::nodal;
use crate::number::two_float::{LANES, TwoFloat};

/// Most cells whose numbers a split changes; a cell with more stays whole.
const RING_MAX: usize = 320;

/// The cells at the tetrahedra of a cell, each once.
struct Ring {
    cells: [u16; RING_MAX],
    len: usize,
}

impl Ring {
    const NONE: Self = Self { cells: [0; RING_MAX], len: 0 };

    fn has(&self, cell: u16) -> bool {
        self.cells.iter().take(self.len).any(|&other| other == cell)
    }

    /// The same cells and these.
    fn with(mut self, mut more: Range<usize>) -> Option<Self> {
        more.try_for_each(|cell| self.add(cell as u16).map(|_| ()))?;
        Some(self)
    }

    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.cells.iter().take(self.len).map(|&cell| cell.into())
    }

    /// Adds a cell that is not there yet. Returns its place; `None` without one.
    fn add(&mut self, cell: u16) -> Option<usize> {
        let known = self.cells.iter().take(self.len).position(|&other| other == cell);
        if known.is_none() {
            *self.cells.get_mut(self.len)? = cell;
            self.len += 1;
        }
        Some(known.unwrap_or(self.len - 1))
    }
}

/// Outcome of a look at a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Look {
    /// Its tetrahedra hang together.
    Whole,
    /// It was split; the change of the energy is at most this much, in internal units, if it rose.
    Split(f64),
    /// There are no spare cells, or no half-links, for its copies.
    Refused,
}

impl CutBody<'_, '_> {
    /// Looks at a cell, and splits it if its tetrahedra fall apart. The copies' states follow here; the caller
    /// copies the arrays from `cell` to the cells from `first` on, those before this call in use.
    pub fn look(
        &mut self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> Look {
        let Some(pieces) = self.pieces(cell) else { return self.refuse() };
        if pieces.count < 2 {
            return Look::Whole;
        }
        let Some(torn) = self.torn(cell, &pieces) else { return self.refuse() };
        if self.is_of_links() {
            // The shares of a link store what it did, but for their rounding, a unit in the last place at most: of the
            // energy with closed bands, which is the larger.
            let stored = self.wd2_of_links(cell, Some(0.0), at);
            let Some(_) = self.part(cell, &pieces, torn, states) else { return self.refuse() };
            return Look::Split(at_most(TwoFloat::ZERO, stored + stored));
        }
        // Note energy and shape before. The shares of a link's bands store what it did, but for their rounding.
        let (shapes, banded) = (of_shapes(states), self.bands().stored_at_most(cell, at));
        let before = self.shapes().stored(torn.iter(), at, shapes);
        let (whole, offset) = (self.shapes().shape_at(cell, at), self.offset(cell));
        let first = self.bodily + self.used();
        let Some(all) = self.part(cell, &pieces, torn, states) else { return self.refuse() };
        // The pieces' offsets, and the energy after.
        let place = |other: usize| at(if other < first { other } else { cell });
        for piece in core::iter::once(cell).chain(first..self.bodily + self.used()) {
            let part = self.shapes().shape_at(piece, &place);
            let mut shift = offset;
            for ((shift, whole), part) in shift.iter_mut().zip(whole).zip(part) {
                for ((shift, whole), part) in shift.iter_mut().zip(whole).zip(part) {
                    *shift += whole - part;
                }
            }
            self.set_offset(piece, shift);
        }
        let after = self.shapes().stored(all.iter(), &place, shapes);
        Look::Split(at_most(after.wd2.minus(before.wd2), before.scale + after.scale + 2.0 * banded))
    }

    /// Gives each piece of a cell but the first one a copy, and the numbers that follow to all cells. Returns the cells
    /// with other numbers than before; `None` without places.
    fn part(
        &mut self,
        cell: usize,
        pieces: &Pieces,
        torn: Ring,
        states: States<'_>,
    ) -> Option<Ring> {
        // Rename the corners, and make place for the half-links.
        let (first, copies) = (self.bodily + self.used(), pieces.count - 1);
        if copies > self.cut.spare_cells - self.used() || !self.has_places(copies) {
            return None;
        }
        self.rename(cell, first, pieces);
        let all = torn.with(first..first + copies).filter(|all| self.make_places(all));
        let Some(all) = all else {
            self.unname(cell, first, pieces);
            return None;
        };
        // Let the copies inherit; renumber the torn cells, and rename half-links of the others.
        for copy in first..first + copies {
            self.inherit(cell, copy);
            states.inherit(cell, copy);
        }
        all.iter().for_each(|cell| self.renumber(cell));
        self.rename_ends(cell, first, pieces, &all);
        Some(all)
    }

    fn refuse(&mut self) -> Look {
        self.count(REFUSED, 1);
        Look::Refused
    }

    /// The cells whose numbers a split changes: the cell, and those at tetrahedra of more than one piece.
    fn torn(&self, cell: usize, pieces: &Pieces) -> Option<Ring> {
        let (mut torn, mut seen) = (Ring::NONE, Ring::NONE);
        let mut piece_of = [0; RING_MAX];
        torn.add(cell as u16)?;
        for (tetrahedron, piece) in pieces.iter() {
            for &id in self.arrays.corners.get(tetrahedron)? {
                let place = seen.add(id)?;
                let known = piece_of.get_mut(place)?;
                if *known == 0 {
                    *known = piece + 1;
                } else if *known != piece + 1 {
                    torn.add(id)?;
                }
            }
        }
        Some(torn)
    }

    /// Names the copies in the half-links of the cells that see one of them in place of the cell.
    fn rename_ends(&mut self, cell: usize, first: usize, pieces: &Pieces, torn: &Ring) {
        for (tetrahedron, piece) in pieces.iter().filter(|(_, piece)| *piece > 0) {
            let corners = self.arrays.corners.get(tetrahedron).copied().unwrap_or_default();
            for id in corners.into_iter().filter(|&id| !torn.has(id)) {
                self.rename_end(id.into(), cell as u16, (first + piece - 1) as u16);
            }
        }
    }

    /// Gives the tetrahedra of all pieces but the first one their copy in place of the cell.
    fn rename(&mut self, cell: usize, first: usize, pieces: &Pieces) {
        let origin = self.origin(cell) as u16;
        for spare in first - self.bodily..first - self.bodily + pieces.count - 1 {
            if let Some(slot) = self.arrays.origins.get_mut(spare) {
                *slot = origin;
            }
        }
        self.count(USED, pieces.count as u32 - 1);
        for (tetrahedron, piece) in pieces.iter().filter(|(_, piece)| *piece > 0) {
            self.replace(tetrahedron, cell, first + piece - 1);
        }
        self.rename_triangles(cell);
    }

    /// Takes a renaming back.
    fn unname(&mut self, cell: usize, first: usize, pieces: &Pieces) {
        for (tetrahedron, piece) in pieces.iter().filter(|(_, piece)| *piece > 0) {
            self.replace(tetrahedron, first + piece - 1, cell);
        }
        (first..first + pieces.count - 1).for_each(|copy| self.rename_triangles(copy));
        self.arrays.origins.iter_mut().skip(first - self.bodily).for_each(|origin| *origin = 0);
        if let Some(used) = self.arrays.counts.get_mut(USED) {
            *used = (first - self.bodily) as u32;
        }
    }

    fn replace(&mut self, tetrahedron: usize, from: usize, to: usize) {
        for id in self.arrays.corners.get_mut(tetrahedron).into_iter().flatten() {
            if usize::from(*id) == from {
                *id = to as u16;
            }
        }
    }

    /// Names the corners of the triangles at a cell anew.
    fn rename_triangles(&mut self, cell: usize) {
        for triangle in 0..self.arrays.triangles.len() {
            let corners = self.arrays.triangles.get(triangle);
            if corners.is_some_and(|corners| corners.contains(&(cell as u16))) {
                self.name_triangle(triangle);
            }
        }
    }

    /// Names the corners of a triangle of the surface after its tetrahedron, the lowest with these corners.
    pub(super) fn name_triangle(&mut self, triangle: usize) {
        let Some(whole) = self.model.triangles.get(triangle) else { return };
        let [first, ..] = *whole;
        let tetrahedra =
            self.cut.star(first.into()).iter().map(|&tetrahedron| tetrahedron as usize);
        let sides = tetrahedra.filter_map(|tetrahedron| {
            Some((self.cut.corners.get(tetrahedron)?, self.arrays.corners.get(tetrahedron)?))
        });
        let mut owners = sides.filter(|(corners, _)| whole.iter().all(|id| corners.contains(id)));
        let Some((corners, names)) = owners.next() else { return };
        let name = |id: &u16| corners.iter().zip(names).find(|(corner, _)| *corner == id);
        if let Some(slot) = self.arrays.triangles.get_mut(triangle) {
            for (slot, id) in slot.iter_mut().zip(whole) {
                *slot = name(id).map_or(*slot, |(_, &name)| name);
            }
        }
    }

    /// Makes place for the half-links of these cells. Returns false if there is none.
    fn make_places(&mut self, ring: &Ring) -> bool {
        ring.iter().all(|cell| {
            let needed = self.links(cell);
            needed.is_some_and(|needed| self.grow(cell / LANES, needed))
        })
    }

    /// Number of half-links of a cell.
    fn links(&self, cell: usize) -> Option<usize> {
        let mut others = Ring::NONE;
        for index in 0..self.star(cell).len() {
            if let Some(tetrahedron) = self.tetrahedron_at(cell, index) {
                let mut corners = self.arrays.corners.get(tetrahedron)?.iter();
                corners.try_for_each(|&id| others.add(id).map(|_| ()))?;
            }
        }
        Some(others.len.saturating_sub(1))
    }

    /// Gives a copy the numbers that it inherits.
    pub(super) fn inherit(&mut self, cell: usize, copy: usize) {
        for row in [nodal::MU, nodal::LAMBDA_3, nodal::BAND, nodal::BOUND] {
            self.set_number(copy, row, self.number(cell, row));
        }
        inherit(self.arrays.mobility, cell, copy);
        inherit(self.arrays.factors, cell, copy);
        inherit(self.arrays.rest, cell, copy);
        self.join_box(cell, copy);
    }
}
