//! Sums over the half-links of a cell, or of eight cells side by side.

#![allow(unsafe_code)]

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
use super::half_links_vfp;
use super::matrix::{Matrix, each, times};
use super::sums::{Gathered, Own, rows};
use crate::backend::f32x8::{Chunk, F32x8, chunk};
use crate::backend::lane::Lane;
use crate::energy::state::Quad;
use crate::model::image::nodal;
use crate::model::nodal::{CellNumbers, Nodal, OffsetNumbers, SlotNumbers};
use crate::model::range;
use crate::number::cell::{Cell, sub};
use crate::number::two_float::LANES;

/// A row of numbers of eight cells or half-links.
#[inline(always)]
fn load<V: F32x8>(rows: &[[f32; LANES]], row: usize) -> Lane<V> {
    Lane(rows.get(row).map_or(V::splat(0.0), V::load))
}

/// Numbers of eight cells.
#[inline(always)]
pub(super) fn own<V: F32x8>(numbers: &CellNumbers) -> Own<V> {
    Own::of(|row| load(numbers, row))
}

/// Offsets of eight cells.
#[inline(always)]
pub(super) fn offset<V: F32x8>(numbers: &OffsetNumbers) -> Matrix<V> {
    let row = |row| load(numbers, row);
    [rows(row, 0), rows(row, 3), rows(row, 6)]
}

/// Positions of eight cells.
#[inline(always)]
pub(crate) fn places<V: F32x8>(of: impl Fn(usize) -> [f32; 4]) -> [Lane<V>; 3] {
    let [x, y, z, _] = V::transposed(&chunk(of));
    [Lane(x), Lane(y), Lane(z)]
}

/// The half-links of a body, with an array that has an element for each cell.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    shapes: Nodal<'a>,
    array: &'a [Quad],
}

impl<'a> Ends<'a> {
    /// `None` if the array is too short.
    #[inline(always)]
    pub fn of(shapes: Nodal<'a>, array: &'a [Quad]) -> Option<Self> {
        (array.len() >= shapes.count).then_some(Self { shapes, array })
    }

    /// The elements of the cells of a slice.
    #[inline(always)]
    pub fn own(self, slice: usize) -> Option<&'a [Quad; LANES]> {
        self.array.as_chunks().0.get(slice)
    }

    /// Stores the displacements of the cells of a slice, which are at `here`.
    #[inline(always)]
    pub fn displace(self, slice: usize, here: &Chunk) {
        let Some(own) = self.own(slice) else { return };
        let mut last = [[0.0; 3]; LANES];
        let rest = self.shapes.rest.as_chunks().0.get(slice).unwrap_or_else(|| {
            let rest = self.shapes.rest.as_chunks::<LANES>().1;
            last.iter_mut().zip(rest).for_each(|(slot, rest)| *slot = *rest);
            &last
        });
        for ((slot, here), rest) in own.iter().zip(here).zip(rest) {
            slot.set(Cell::at(sub(here.xyz(), *rest)));
        }
    }

    /// The half-links of a slice by groups: their numbers, and the ids of their other ends; as many of both.
    #[inline(always)]
    fn rows(self, slice: usize) -> (&'a [SlotNumbers], &'a [[u16; LANES]]) {
        let groups = range(self.shapes.rows, slice);
        let rows = self.shapes.slots.get(groups.clone()).zip(self.shapes.ids.get(groups));
        rows.unwrap_or_default()
    }

    /// The element of another end.
    #[inline(always)]
    fn end(self, id: u16) -> &'a Quad {
        // SAFETY: a model's slices name only its cells, and there are as many elements.
        unsafe { self.array.get_unchecked(usize::from(id)) }
    }

    /// The groups of half-links of a slice: their numbers, and the elements of their other ends.
    #[inline(always)]
    fn groups(self, slice: usize) -> impl Iterator<Item = (&'a SlotNumbers, [&'a Quad; LANES])> {
        let (slots, ids) = self.rows(slice);
        slots.iter().zip(ids).map(move |(slots, &[a, b, c, d, e, f, g, h])| {
            let at = |id: u16| self.end(id);
            (slots, [at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h)])
        })
    }

    /// Takes the forces P `a_ij` of the cells of a slice from their neighbours, in the order of groups and
    /// lanes, and adds `pull` to the cells' own.
    #[inline(always)]
    pub fn push<V: F32x8>(self, slice: usize, stress: Matrix<V>, pull: [Lane<V>; 4]) {
        let zero = Lane::of(0.0);
        let opposite = each(stress, |x| zero - x);
        for (slots, cells) in self.groups(slice) {
            let [x, y, z] = times(opposite, rows(|row| load(slots, row), nodal::AREA));
            V::add_to([x.0, y.0, z.0, zero.0], cells);
        }
        let [x, y, z, energy] = pull;
        if let Some(own) = self.own(slice) {
            V::add_to([x.0, y.0, z.0, energy.0], own.each_ref());
        }
    }
}

/// Forces of one cell after the other.
impl Ends<'_> {
    /// Takes the forces P `a_ij` of the cells of a slice from their neighbours, as [`Self::push`] does. The sum of
    /// forces is never -0.0, so neither sign nor number of the zeros matters that are taken from it.
    pub fn push_each(self, slice: usize, stresses: &[Matrix<f32>; LANES]) {
        let (slots, ids) = self.rows(slice);
        #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
        // SAFETY: a model's slices name only its cells, there are as many elements, and as many groups.
        unsafe {
            half_links_vfp::push(slots, ids, stresses, self.array);
        }
        #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
        for (slots, ids) in slots.iter().zip(ids) {
            for ((lane, stress), &id) in stresses.iter().enumerate().zip(ids) {
                let area = rows(|row| Lane(number(slots, row, lane)), nodal::AREA);
                let ([x, y, z], end) = (times(*stress, area), self.end(id));
                let Cell([a, b, c, d]) = end.get();
                end.set(Cell([a - x.0, b - y.0, c - z.0, d]));
            }
        }
    }
}

impl Gathered<f32> {
    /// The sums of one cell of a slice; the array is that of the displacements.
    #[inline(always)]
    pub fn of_lane(ends: Ends<'_>, slice: usize, lane: usize) -> Option<Self> {
        let here = ends.own(slice)?.get(lane)?;
        let (slots, ids) = ends.rows(slice);
        // SAFETY: a model's slices name only its cells, there are as many elements, as many groups, and the slice
        // has this lane.
        #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
        let sums = unsafe { half_links_vfp::sums(slots, ids, lane, here, ends.array) };
        #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
        let sums = {
            let (here, mut sums) = (here.get().xyz().map(Lane), Self::none());
            for (slots, ids) in slots.iter().zip(ids) {
                let there = ends.end(ids.get(lane).copied()?).get().xyz().map(Lane);
                sums.add(here, there, |row| Lane(number(slots, row, lane)));
            }
            sums
        };
        Some(sums)
    }
}

/// A number of one lane.
#[inline(always)]
pub(super) fn number(rows: &[[f32; LANES]], row: usize, lane: usize) -> f32 {
    rows.get(row).and_then(|lanes| lanes.get(lane)).copied().unwrap_or(0.0)
}

/// Displacements of eight cells.
#[inline(always)]
fn displacements<V: F32x8>([a, b, c, d, e, f, g, h]: [&Quad; LANES]) -> [Lane<V>; 3] {
    let cells = [a.get(), b.get(), c.get(), d.get(), e.get(), f.get(), g.get(), h.get()];
    let [x, y, z, _] = V::transposed(&cells);
    [Lane(x), Lane(y), Lane(z)]
}

impl<V: F32x8> Gathered<V> {
    /// The sums of the cells of a slice; the array is that of the displacements.
    #[inline(always)]
    pub fn of_slice(ends: Ends<'_>, slice: usize) -> Option<Self> {
        let here = displacements(ends.own(slice)?.each_ref());
        let mut sums = Self::none();
        for (slots, there) in ends.groups(slice) {
            sums.add(here, displacements(there), |row| load(slots, row));
        }
        Some(sums)
    }
}
