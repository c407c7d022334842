//! Sums over the half-links of a cell, or of eight cells side by side.

#![allow(unsafe_code)]

use core::mem::MaybeUninit;

#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
use super::half_links_vfp;
use super::matrix::{Matrix, each, times};
use super::memory::Memory;
use super::sums::{Gathered, Kept, Own, rows};
use crate::backend::f32x8::{Chunk, F32x8, chunk};
use crate::backend::lane::Lane;
use crate::energy::state::Quad;
use crate::model::image::nodal;
use crate::model::nodal::{
    CellNumbers, MemoryNumbers, Nodal, OffsetNumbers, Relaxing, SliceMemoryOf, SlotNumbers,
};
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
pub(super) fn own<'k, V: F32x8>(numbers: &CellNumbers) -> Own<'k, V> {
    Own::of(|row| load(numbers, row))
}

/// The memory of the cells of a slice; their displacements are `here`.
#[inline(always)]
pub(super) fn memory_at<V: F32x8>(
    numbers: &MemoryNumbers,
    part: f32,
    proof: Relaxing,
    here: &[Quad; LANES],
) -> Memory<V> {
    Memory::of(|row| load(numbers, row), displacements(here.each_ref()), part, proof)
}

impl Kept {
    /// Offset and memory of a cell whose displacement is `here`.
    #[inline(always)]
    pub fn of_cell(shapes: Nodal<'_>, cell: usize, here: [Lane<f32>; 3]) -> Self {
        let (slice, lane) = (cell / LANES, cell % LANES);
        Self::of_lane(lane, shapes.offset_of(slice), shapes.memory_of(slice), here)
    }

    /// The same of a lane of a slice with these numbers.
    #[inline(always)]
    pub fn of_lane(
        lane: usize,
        offset: Option<&OffsetNumbers>,
        memory: SliceMemoryOf<'_>,
        here: [Lane<f32>; 3],
    ) -> Self {
        let offset = offset.map(|numbers| {
            let row = |row| Lane(number(numbers, row, lane));
            [rows(row, 0), rows(row, 3), rows(row, 6)]
        });
        let memory = memory.map(|(numbers, part, proof)| {
            Memory::of(|row| Lane(number(numbers, row, lane)), here, part, proof)
        });
        Self { offset, memory }
    }
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

/// Most groups of half-links of a slice that is stepped eight cells at a time.
const GROUPS: usize = 48;

/// Memory for the byte offsets of the other ends of a slice's half-links in an array of [`Quad`]s: they are
/// computed eight at a time, before the loops that use them, and once for both.
pub(super) struct Offsets([MaybeUninit<[u32; LANES]>; GROUPS]);

impl Offsets {
    pub const NONE: Self = Self([MaybeUninit::uninit(); GROUPS]);

    /// The offsets of these groups; `None` if there are too many.
    #[inline(always)]
    fn of(&mut self, ids: &[[u16; LANES]]) -> Option<&[[u32; LANES]]> {
        let slots = self.0.get_mut(..ids.len())?;
        for (slot, ids) in slots.iter_mut().zip(ids) {
            slot.write(ids.map(|id| u32::from(id) * size_of::<Quad>() as u32));
        }
        // SAFETY: each is written, since there are as many ids.
        Some(unsafe { slots.assume_init_ref() })
    }
}

/// The half-links of a slice by groups: their numbers, and the offsets of their other ends; as many of both.
#[derive(Clone, Copy)]
pub(super) struct Groups<'a> {
    slots: &'a [SlotNumbers],
    offsets: &'a [[u32; LANES]],
    /// The offsets are those of ids below this number.
    cells: usize,
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
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    fn end(self, id: u16) -> &'a Quad {
        // SAFETY: a model's slices name only its cells, and there are as many elements.
        unsafe { self.array.get_unchecked(usize::from(id)) }
    }

    /// The half-links of a slice; `None` if there are more than [`GROUPS`].
    #[inline(always)]
    pub fn groups<'o>(self, slice: usize, memory: &'o mut Offsets) -> Option<Groups<'o>>
    where
        'a: 'o,
    {
        let (slots, ids) = self.rows(slice);
        Some(Groups { slots, offsets: memory.of(ids)?, cells: self.shapes.count })
    }

    /// Groups of half-links: their numbers, and the elements of their other ends; none if an end has no element.
    #[inline(always)]
    fn each(self, groups: Groups<'_>) -> impl Iterator<Item = (&SlotNumbers, [&'a Quad; LANES])> {
        let first = self.array.as_ptr();
        let offsets = if groups.cells <= self.array.len() { groups.offsets } else { &[] };
        groups.slots.iter().zip(offsets).map(move |(slots, offsets)| {
            let [a, b, c, d, e, f, g, h] = *offsets;
            // SAFETY: the offsets are those of elements of the array, as checked above.
            let at = |offset: u32| unsafe { &*first.byte_add(offset as usize) };
            (slots, [at(a), at(b), at(c), at(d), at(e), at(f), at(g), at(h)])
        })
    }

    /// Takes the forces P `a_ij` of the cells of a slice from their neighbours, in the order of groups and
    /// lanes, and adds `pull` to the cells' own.
    #[inline(always)]
    pub fn push<V: F32x8>(
        self,
        slice: usize,
        stress: Matrix<V>,
        pull: [Lane<V>; 4],
        groups: Groups<'_>,
    ) {
        let zero = Lane::of(0.0);
        self.pull(slice, each(stress, |x| zero - x), pull, groups);
    }

    /// The same with T = -P: adds the forces T `a_ij` to the neighbours'.
    #[inline(always)]
    fn pull<V: F32x8>(
        self,
        slice: usize,
        tension: Matrix<V>,
        pull: [Lane<V>; 4],
        groups: Groups<'_>,
    ) {
        for (slots, cells) in self.each(groups) {
            let [x, y, z] = times(tension, rows(|row| load(slots, row), nodal::AREA));
            V::add_to([x.0, y.0, z.0, V::splat(0.0)], cells);
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
pub(super) fn displacements<V: F32x8>([a, b, c, d, e, f, g, h]: [&Quad; LANES]) -> [Lane<V>; 3] {
    let cells = [a.get(), b.get(), c.get(), d.get(), e.get(), f.get(), g.get(), h.get()];
    let [x, y, z, _] = V::transposed(&cells);
    [Lane(x), Lane(y), Lane(z)]
}

impl<V: F32x8> Gathered<V> {
    /// The sums of the cells of a slice; the array is that of the displacements.
    #[inline(always)]
    pub fn of_slice(ends: Ends<'_>, slice: usize, groups: Groups<'_>) -> Option<Self> {
        let here = displacements(ends.own(slice)?.each_ref());
        let mut sums = Self::none();
        for (slots, there) in ends.each(groups) {
            sums.add(here, displacements(there), |row| load(slots, row));
        }
        Some(sums)
    }
}

/// The same at the start of a tick, for a slice of any number of groups.
#[cfg(feature = "relax")]
impl<V: F32x8> Gathered<V> {
    /// The sums of the cells of a slice, lane by lane without groups.
    #[inline(always)]
    pub fn of_any_slice(ends: Ends<'_>, slice: usize, groups: Option<Groups<'_>>) -> Option<Self> {
        if let Some(groups) = groups {
            return Self::of_slice(ends, slice, groups);
        }
        let mut lanes = [Gathered::<f32>::none(); LANES];
        for (lane, sums) in lanes.iter_mut().enumerate() {
            *sums = Gathered::of_lane(ends, slice, lane)?;
        }
        let side_by_side = |of: &dyn Fn(&Gathered<f32>) -> Lane<f32>| {
            Lane(V::load(&lanes.each_ref().map(|sums| of(sums).0)))
        };
        let row = |row: usize| {
            let element = |column: usize| {
                let of = move |sums: &Gathered<f32>| {
                    let row = sums.slope.get(row).and_then(|row| row.get(column));
                    row.copied().unwrap_or(Lane(0.0))
                };
                side_by_side(&of)
            };
            [element(0), element(1), element(2)]
        };
        let pull = |axis: usize| {
            let of = move |sums: &Gathered<f32>| *sums.pull.get(axis).unwrap_or(&Lane(0.0));
            side_by_side(&of)
        };
        Some(Self {
            slope: [row(0), row(1), row(2)],
            pull: [pull(0), pull(1), pull(2)],
            spread: side_by_side(&|sums| sums.spread),
        })
    }
}

#[cfg(feature = "relax")]
impl Ends<'_> {
    /// Adds the forces T `a_ij` of a slice to its neighbours' as [`Self::pull`] does, lane by lane without groups.
    #[inline(always)]
    pub fn pull_any<V: F32x8>(
        self,
        slice: usize,
        tension: Matrix<V>,
        pull: [Lane<V>; 4],
        groups: Option<Groups<'_>>,
    ) {
        if let Some(groups) = groups {
            return self.pull(slice, tension, pull, groups);
        }
        let zero = [[Lane(0.0); 3]; 3];
        let mut stresses = [zero; LANES];
        for (row, lanes) in tension.into_iter().enumerate() {
            for (column, element) in lanes.into_iter().enumerate() {
                let mut numbers = [0.0; LANES];
                (Lane::of(0.0) - element).0.store(&mut numbers);
                for (stress, number) in stresses.iter_mut().zip(numbers) {
                    if let Some(slot) = stress.get_mut(row).and_then(|row| row.get_mut(column)) {
                        *slot = Lane(number);
                    }
                }
            }
        }
        self.push_each(slice, &stresses);
        let [x, y, z, energy] = pull;
        if let Some(own) = self.own(slice) {
            V::add_to([x.0, y.0, z.0, energy.0], own.each_ref());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_those_of_the_elements() {
        let ids = [[0, 1, 7, 65_535, 300, 2, 2, 40_000]; GROUPS + 1];
        let mut memory = Offsets::NONE;
        let offsets = memory.of(&ids[..GROUPS]).unwrap();
        assert_eq!(offsets, [ids[0].map(|id| 16 * u32::from(id)); GROUPS]);
        assert_eq!(memory.of(&[]), Some(&[][..]));
        assert!(memory.of(&ids).is_none());
    }
}
