//! The arrays of a body that is cut, with its image.

use super::memory::{Arrays, COUNTS, CutRoom, OPENED, USED, WAITING, image_groups};
use super::renewal::{Lists, Renewal};
use crate::model::cuttable::Cuttable;
use crate::model::lips::Lips;
use crate::model::nodal::Nodal;
use crate::model::opened::Opened;
use crate::model::sides::NO_SIDE;
use crate::model::stiffening::Stiffening;
use crate::model::{Model, others};
use crate::number::two_float::LANES;
use crate::number::words::Double;

/// A body that is cut.
pub(crate) struct CutBody<'a, 'm> {
    pub arrays: Arrays<'a>,
    pub model: &'a Model<'m>,
    pub cut: Cuttable<'m>,
    /// Number of cells before the spare ones.
    pub bodily: usize,
}

impl<'a, 'm> CutBody<'a, 'm> {
    /// `None` for a body that is not cut, and without memory for it.
    pub fn of(memory: &'a mut CutRoom<'_>, model: &'a Model<'m>) -> Option<Self> {
        let (arrays, cut) = (memory.arrays(model)?, model.cuttable());
        Some(Self { arrays, model, cut, bodily: model.cells() - cut.spare_cells })
    }

    /// The body as its image has it: whole.
    pub fn reset(&mut self) {
        *self.arrays.counts = [0; COUNTS];
        copy(self.arrays.corners, self.cut.corners);
        self.arrays.faces.fill(0);
        self.arrays.marks.fill(0);
        self.arrays.origins.fill(0);
        copy(self.arrays.rows, image_groups(self.model).rows);
        self.arrays.is_offset.fill(0);
        self.arrays.offsets.fill([[0.0; LANES]; 9]);
        self.arrays.normals.fill([0.0; 3]);
        self.arrays.tear.fill(0);
        self.arrays.renewal.fill(Renewal::default());
        self.arrays.loose.fill(0);
        self.arrays.work.fill(Double::default());
        self.arrays.labels.fill(0);
        self.arrays.side_rows.fill([NO_SIDE; LANES]);
        self.derive_whole();
    }

    /// Sets the numbers of the whole body; the groups of half-links stay where they are in the image.
    pub fn derive_whole(&mut self) {
        let (model, shapes) = (self.model, others::shapes(&self.model.others));
        copy(self.arrays.cells, shapes.cells);
        copy(self.arrays.slots, shapes.slots);
        copy(self.arrays.ids, image_groups(model).ids);
        copy(self.arrays.rest, model.rest);
        copy(self.arrays.mobility, model.mobility);
        if let Some(basis) = model.coarse_basis {
            copy(self.arrays.factors, basis.elastic().map_or(&[][..], |level| level.factors));
            copy(self.arrays.entry, basis.entry);
            copy(self.arrays.box_rows, basis.rows);
            copy(self.arrays.pairs, basis.cells);
            copy(self.arrays.weights, basis.weights);
        }
        copy(self.arrays.triangles, model.triangles);
        *self.arrays.listed = [0; 2];
        self.arrays.lip_numbers.fill([0.0; 5]);
        self.arrays.lip_rows.fill(0);
        self.derive_bands();
        if self.is_of_links() {
            self.derive_links();
        }
        self.derive_strengths();
    }

    /// Returns true for a body of links, not of shapes.
    pub fn is_of_links(&self) -> bool {
        !self.model.is_nodal()
    }

    /// Number of spare cells in use.
    pub fn used(&self) -> usize {
        self.arrays.counts.get(USED).map_or(0, |&used| used as usize)
    }

    /// The cell of the image that a cell is, or was copied from.
    pub fn origin(&self, cell: usize) -> usize {
        let copied = cell.checked_sub(self.bodily).and_then(|spare| self.arrays.origins.get(spare));
        copied.map_or(cell, |&origin| origin.into())
    }

    /// The tetrahedra at a cell in the image.
    pub fn star(&self, cell: usize) -> &'m [u32] {
        self.cut.star(self.origin(cell))
    }

    /// A tetrahedron of a cell's star, if the cell is still one of its corners.
    pub fn tetrahedron_at(&self, cell: usize, index: usize) -> Option<usize> {
        let tetrahedron = *self.star(cell).get(index)? as usize;
        let corners = self.arrays.corners.get(tetrahedron)?;
        corners.iter().any(|&id| usize::from(id) == cell).then_some(tetrahedron)
    }

    /// Rest position of a cell of the image.
    pub fn rest_position(&self, cell: u16) -> [f32; 3] {
        self.model.rest_position(cell.into())
    }

    /// A number of a cell.
    pub fn number(&self, cell: usize, row: usize) -> f32 {
        let lanes = self.arrays.cells.get(cell / LANES).and_then(|slice| slice.get(row));
        lanes.and_then(|lanes| lanes.get(cell % LANES)).copied().unwrap_or(0.0)
    }

    pub fn set_number(&mut self, cell: usize, row: usize, number: f32) {
        let lanes = self.arrays.cells.get_mut(cell / LANES).and_then(|slice| slice.get_mut(row));
        if let Some(slot) = lanes.and_then(|lanes| lanes.get_mut(cell % LANES)) {
            *slot = number;
        }
    }

    /// The tetrahedron on the other side of a face, with the corner opposite to it there; `None` at an outer
    /// face, and beyond the body.
    pub(super) fn across(&self, tetrahedron: usize, corner: usize) -> Option<(usize, usize)> {
        let corners = self.cut.corners.get(tetrahedron)?;
        let mut of_face = corners.iter().enumerate().filter(|(at, _)| *at != corner);
        let (_, &first) = of_face.next()?;
        self.cut.star(first.into()).iter().map(|&other| other as usize).find_map(|other| {
            let there = self.cut.corners.get(other).filter(|_| other != tetrahedron)?;
            let is_shared = of_face.clone().all(|(_, id)| there.contains(id));
            let opposite = there.iter().position(|id| {
                corners.iter().enumerate().all(|(at, corner_id)| at == corner || corner_id != id)
            });
            opposite.filter(|_| is_shared).map(|opposite| (other, opposite))
        })
    }

    /// Corners of a tetrahedron whose opposite faces are open.
    pub(super) fn open_corners(&self, tetrahedron: usize) -> impl Iterator<Item = usize> + use<> {
        let faces = self.arrays.faces.get(tetrahedron).copied().unwrap_or(0);
        (0..4).filter(move |corner| faces >> corner & 1 != 0)
    }

    /// Returns true if the face opposite to a corner of a tetrahedron is open.
    pub(super) fn is_open(&self, tetrahedron: usize, corner: usize) -> bool {
        self.open_corners(tetrahedron).any(|open| open == corner)
    }

    /// Opens a face on both sides and marks its cells. Returns true if it was closed, `None` beyond the body.
    pub fn open_face(&mut self, tetrahedron: usize, corner: usize) -> Option<bool> {
        let is_there = tetrahedron < self.cut.corners.len() && corner < 4;
        is_there.then_some(())?;
        let Some(other) = self.across(tetrahedron, corner) else { return Some(false) };
        if self.is_open(tetrahedron, corner) {
            return Some(false);
        }
        for (tetrahedron, corner) in [(tetrahedron, corner), other] {
            if let Some(faces) = self.arrays.faces.get_mut(tetrahedron) {
                *faces |= 1 << corner;
            }
            let corners = self.arrays.corners.get(tetrahedron).copied().unwrap_or_default();
            for (at, id) in corners.into_iter().enumerate() {
                if at != corner {
                    self.mark(id.into(), 1);
                }
            }
        }
        self.count(OPENED, 1);
        Some(true)
    }

    /// Sets or clears a cell's mark.
    pub fn mark(&mut self, cell: usize, mark: u8) {
        let Some(slot) = self.arrays.marks.get_mut(cell) else { return };
        let before = core::mem::replace(slot, mark);
        if let Some(waiting) = self.arrays.counts.get_mut(WAITING) {
            *waiting = (*waiting + u32::from(mark)).saturating_sub(before.into());
        }
    }

    /// Adds to a count.
    pub fn count(&mut self, index: usize, more: u32) {
        if let Some(count) = self.arrays.counts.get_mut(index) {
            *count = count.saturating_add(more);
        }
    }

    /// The nodal shapes as they are now.
    pub fn shapes(&self) -> Nodal<'_>
    where
        'm: 'a,
    {
        let Arrays { cells, slots, rows, ids, rest, offsets, is_offset, .. } = &self.arrays;
        Nodal {
            cells,
            slots,
            rows,
            ids,
            rest,
            offsets,
            is_offset,
            ..others::shapes(&self.model.others)
        }
    }

    /// The triangles of the surface as it is now.
    pub fn into_triangles(self) -> Option<&'a [[u16; 3]]> {
        let [count, _] = self.arrays.listed.map(|listed| listed as usize);
        let triangles: &'a [[u16; 3]] = self.arrays.triangles;
        triangles.get(..self.model.triangles.len() + count)
    }

    /// The model as it is now.
    pub fn into_model(self) -> Model<'a>
    where
        'm: 'a,
    {
        let is_relinked = self.is_of_links() && self.used() > 0;
        let (model, arrays): (Model<'a>, _) = (*self.model, self.arrays);
        let Arrays { cells, slots, rows, ids, rest, offsets, is_offset, .. } = arrays;
        let (rows, ids): (&[u32], &[[u16; LANES]]) = (rows, ids);
        let (shapes, bands) = (others::shapes(&model.others), others::bands(&model.others));
        let shapes = if shapes.is_any() {
            Nodal { cells, slots, rows, ids, rest, offsets, is_offset, ..shapes }
        } else {
            shapes
        };
        let bands = if bands.is_any() {
            let (volumes, lengths) = (&*arrays.bands.volumes, &*arrays.bands.lengths);
            Stiffening { volumes, lengths, rows, ids, rest, ..bands }
        } else {
            bands
        };
        let coarse_basis = model.coarse_basis.map(|basis| {
            let (pairs, weights) = (&*arrays.pairs, &*arrays.weights);
            basis.with_cells(arrays.box_rows, pairs, weights, arrays.entry, arrays.factors)
        });
        let coarse_basis = coarse_basis.map(|basis| {
            let Some(&renewal) = arrays.renewal.first() else { return basis };
            let length = basis.row_blocks() + basis.side_blocks();
            let lists =
                Lists { turns: arrays.turns, cells: arrays.side_cells, rows: arrays.side_rows };
            basis.with_sides(lists.sides(renewal, arrays.columns, length))
        });
        let ends = arrays.lip_rows.last().map_or(0, |&row| row as usize);
        let lips = Lips {
            cells: arrays.lip_cells,
            numbers: arrays.lip_numbers,
            normals: arrays.normals,
            rows: arrays.lip_rows,
            ends: arrays.ends.get(..ends).unwrap_or(&[]),
        };
        let others = others::cut(model.others, shapes, bands, lips);
        let [count, _] = arrays.listed.map(|listed| listed as usize);
        let all = model.triangles.len() + count;
        let triangles = arrays.triangles.get(..all).unwrap_or(model.triangles);
        let opened = Opened {
            names: arrays.names.get(..count).unwrap_or(&[]),
            numbers: arrays.numbers.get(..count).unwrap_or(&[]),
        };
        let mobility = &*arrays.mobility;
        let model = if is_relinked { arrays.links.relinked(model, rows, ids) } else { model };
        Model { rest, mobility, triangles, opened, coarse_basis, others, ..model }
    }
}

/// Copies items into the first places of an array.
fn copy<T: Copy>(to: &mut [T], from: &[T]) {
    to.iter_mut().zip(from).for_each(|(slot, item)| *slot = *item);
}
