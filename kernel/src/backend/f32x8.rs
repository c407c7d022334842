//! Eight lanes of `f32`: the operations that the loops over slices are written in.
//!
//! Every operation is exactly rounded or exact, so all implementations give the same bits; none fuses or
//! approximates. [`Lanes8`] is the definition, in plain Rust; the others are checked against it operation by
//! operation. Only the bits of the NaN of an invalid operation are undefined: they differ between processors,
//! and no such NaN is stored.

#![allow(unsafe_code)]

use core::cell::Cell as Shared;
use core::hint::select_unpredictable;

use super::Work;
use crate::number::cell::Cell;
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

/// Eight consecutive cells.
pub type Chunk = [Cell; LANES];

/// Eight times four numbers.
#[inline(always)]
pub(crate) fn chunk(of: impl Fn(usize) -> [f32; 4]) -> Chunk {
    [
        Cell(of(0)),
        Cell(of(1)),
        Cell(of(2)),
        Cell(of(3)),
        Cell(of(4)),
        Cell(of(5)),
        Cell(of(6)),
        Cell(of(7)),
    ]
}

/// Eight lanes of `f32`.
pub trait F32x8: Copy {
    /// One truth value per lane.
    type Mask: Copy;

    /// Runs work in a function of its own, so that its loops have all registers of the processor.
    #[inline(always)]
    fn apart<W: Work>(work: W) -> W::Output {
        work.run::<Self>()
    }

    /// The same value in every lane.
    fn splat(value: f32) -> Self;
    /// Lane k from element k.
    fn load(values: &[f32; LANES]) -> Self;
    /// Lane k to element k.
    fn store(self, values: &mut [f32; LANES]);
    /// `self + other`.
    fn plus(self, other: Self) -> Self;
    /// `self - other`.
    fn minus(self, other: Self) -> Self;
    /// `self * other`.
    fn times(self, other: Self) -> Self;
    /// `self / other`.
    fn over(self, other: Self) -> Self;
    /// Square root.
    fn root(self) -> Self;
    /// |self|.
    #[cfg_attr(not(any(test, feature = "relax")), expect(dead_code, reason = "no body remembers"))]
    fn magnitude(self) -> Self;
    /// |self| with the sign of `other`.
    #[cfg_attr(not(any(test, feature = "relax")), expect(dead_code, reason = "no body remembers"))]
    fn signed_as(self, other: Self) -> Self;
    /// The larger of `self` and |other|, `self` where they do not compare.
    fn larger_magnitude(self, other: Self) -> Self;
    /// True in lanes where `self > other`.
    fn above(self, other: Self) -> Self::Mask;
    /// True in lanes where `self < other`.
    fn below(self, other: Self) -> Self::Mask;
    /// True in lanes where `self == other`.
    #[cfg_attr(not(any(test, feature = "relax")), expect(dead_code, reason = "no body remembers"))]
    fn equals(self, other: Self) -> Self::Mask;
    /// True in lanes where `a` or `b` holds.
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Returns true if the mask holds in any lane.
    fn any(mask: Self::Mask) -> bool;
    /// The lane where the mask holds, +0.0 elsewhere.
    fn keep(self, mask: Self::Mask) -> Self;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// x, y and z of eight cells.
    ///
    /// # Safety
    /// Every id is an index of `cells`.
    unsafe fn gather(cells: &[Cell], ids: &[u16; LANES]) -> [Self; 3];
    /// x, y, z and the fourth lane of eight consecutive cells.
    fn transposed(chunk: &Chunk) -> [Self; 4];
    /// The inverse of [`Self::transposed`].
    fn put_transposed(lanes: [Self; 4], chunk: &mut Chunk);
    /// Adds the lanes of x, y, z and the fourth lane to eight cells, one after the other: a cell may occur
    /// more than once.
    #[inline(always)]
    #[cfg_attr(not(any(test, feature = "nodal")), expect(dead_code, reason = "no term scatters"))]
    fn add_to(lanes: [Self; 4], cells: [&Shared<Cell>; LANES]) {
        let mut chunk = [Cell::ZERO; LANES];
        Self::put_transposed(lanes, &mut chunk);
        for (cell, more) in cells.into_iter().zip(chunk) {
            cell.set(cell.get().plus(more));
        }
    }
    /// Cells 2 `pair` and 2 `pair` + 1 of eight, one after the other; `pair` from 0 to 3, here and
    /// below.
    fn pair(chunk: &Chunk, pair: usize) -> Self;
    /// The inverse of [`Self::pair`].
    fn put_pair(self, chunk: &mut Chunk, pair: usize);
    /// Value 2 `pair` in the first four lanes, value 2 `pair` + 1 in the others.
    fn spread(values: &[f32; LANES], pair: usize) -> Self;
    /// Values 2 `pair` and 2 `pair` + 1 in turn, four times.
    fn in_turn(values: &[f32; LANES], pair: usize) -> Self;
    /// Lanes 0 to 3 in the even lanes, lanes 4 to 7 in the odd ones.
    fn woven(self) -> Self;
    /// The inverse of [`Self::woven`].
    fn unwoven(self) -> Self;
    /// Two cells, one after the other.
    ///
    /// # Safety
    /// Both ids are indices of `cells`.
    unsafe fn couple(cells: &[Cell], ids: [u16; 2]) -> Self;
    /// The inverse of [`Self::couple`], the second cell first.
    ///
    /// # Safety
    /// As for [`Self::couple`].
    unsafe fn uncouple(self, cells: &mut [Cell], ids: [u16; 2]);
    /// Two values, each in four lanes.
    ///
    /// # Safety
    /// Both ids are indices of `values`.
    unsafe fn couple_values(values: &[f32], ids: [u16; 2]) -> Self;
    /// +0.0 in lanes 3 and 7.
    fn positions(self) -> Self;
    /// The same cell twice.
    fn twice(cell: Cell) -> Self;
    /// Lanes 0 to 3 plus lanes 4 to 7.
    fn folded(self) -> Cell;
}

/// The definition of every operation, lane by lane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lanes8(pub [f32; LANES]);

impl Lanes8 {
    #[inline(always)]
    fn each(self, other: Self, operation: impl Fn(f32, f32) -> f32) -> Self {
        let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (self.0, other.0);
        Self([
            operation(a, i),
            operation(b, j),
            operation(c, k),
            operation(d, l),
            operation(e, m),
            operation(f, n),
            operation(g, o),
            operation(h, p),
        ])
    }

    #[inline(always)]
    fn compare(self, other: Self, holds: impl Fn(f32, f32) -> bool) -> [bool; LANES] {
        let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (self.0, other.0);
        [
            holds(a, i),
            holds(b, j),
            holds(c, k),
            holds(d, l),
            holds(e, m),
            holds(f, n),
            holds(g, o),
            holds(h, p),
        ]
    }
}

/// Two cells of a chunk, [0, 0, 0, 0] beyond it.
#[inline(always)]
fn two(chunk: &Chunk, pair: usize) -> [Cell; 2] {
    let at = |index: usize| chunk.get(index).copied().unwrap_or(Cell::ZERO);
    [at(2 * pair), at(2 * pair + 1)]
}

impl F32x8 for Lanes8 {
    type Mask = [bool; LANES];

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn load(values: &[f32; LANES]) -> Self {
        Self(*values)
    }

    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        *values = self.0;
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self.each(other, |a, b| a * b)
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self.each(other, |a, b| a / b)
    }

    #[inline(always)]
    fn root(self) -> Self {
        Self(self.0.map(sqrt))
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        self.each(self, |a, _| a.abs())
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        self.each(other, f32::copysign)
    }

    #[inline(always)]
    fn larger_magnitude(self, other: Self) -> Self {
        self.each(other, |a, b| {
            let b = f32::from_bits(b.to_bits() & 0x7fff_ffff);
            if b > a { b } else { a }
        })
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        self.compare(other, |a, b| a > b)
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        self.compare(other, |a, b| a < b)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> Self::Mask {
        self.compare(other, |a, b| a == b)
    }

    #[inline(always)]
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (a, b);
        [a | i, b | j, c | k, d | l, e | m, f | n, g | o, h | p]
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.iter().any(|&lane| lane)
    }

    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::splat(0.0))
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (yes.0, no.0);
        let [q, r, s, t, u, v, w, x] = mask;
        Self([
            select_unpredictable(q, a, i),
            select_unpredictable(r, b, j),
            select_unpredictable(s, c, k),
            select_unpredictable(t, d, l),
            select_unpredictable(u, e, m),
            select_unpredictable(v, f, n),
            select_unpredictable(w, g, o),
            select_unpredictable(x, h, p),
        ])
    }

    #[inline(always)]
    unsafe fn gather(cells: &[Cell], ids: &[u16; LANES]) -> [Self; 3] {
        let chunk = ids.map(|id| cells.get(usize::from(id)).copied().unwrap_or(Cell::ZERO));
        let [x, y, z, _] = Self::transposed(&chunk);
        [x, y, z]
    }

    #[inline(always)]
    fn transposed(chunk: &Chunk) -> [Self; 4] {
        let lanes = |lane: fn(Cell) -> f32| Self(chunk.map(lane));
        [lanes(|c| c.0[0]), lanes(|c| c.0[1]), lanes(|c| c.0[2]), lanes(|c| c.0[3])]
    }

    #[inline(always)]
    fn put_transposed([x, y, z, w]: [Self; 4], chunk: &mut Chunk) {
        for ((((cell, x), y), z), w) in chunk.iter_mut().zip(x.0).zip(y.0).zip(z.0).zip(w.0) {
            *cell = Cell([x, y, z, w]);
        }
    }

    #[inline(always)]
    fn pair(chunk: &Chunk, pair: usize) -> Self {
        let [Cell([a, b, c, d]), Cell([e, f, g, h])] = two(chunk, pair);
        Self([a, b, c, d, e, f, g, h])
    }

    #[inline(always)]
    fn put_pair(self, chunk: &mut Chunk, pair: usize) {
        let [a, b, c, d, e, f, g, h] = self.0;
        for (cell, lanes) in chunk.iter_mut().skip(2 * pair).zip([[a, b, c, d], [e, f, g, h]]) {
            *cell = Cell(lanes);
        }
    }

    #[inline(always)]
    fn spread(values: &[f32; LANES], pair: usize) -> Self {
        let at = |index: usize| values.get(index).copied().unwrap_or(0.0);
        let (a, b) = (at(2 * pair), at(2 * pair + 1));
        Self([a, a, a, a, b, b, b, b])
    }

    #[inline(always)]
    fn in_turn(values: &[f32; LANES], pair: usize) -> Self {
        let at = |index: usize| values.get(index).copied().unwrap_or(0.0);
        let (a, b) = (at(2 * pair), at(2 * pair + 1));
        Self([a, b, a, b, a, b, a, b])
    }

    #[inline(always)]
    fn woven(self) -> Self {
        let [a, b, c, d, e, f, g, h] = self.0;
        Self([a, e, b, f, c, g, d, h])
    }

    #[inline(always)]
    fn unwoven(self) -> Self {
        let [a, b, c, d, e, f, g, h] = self.0;
        Self([a, c, e, g, b, d, f, h])
    }

    #[inline(always)]
    unsafe fn couple(cells: &[Cell], ids: [u16; 2]) -> Self {
        let at = |id: u16| cells.get(usize::from(id)).copied().unwrap_or(Cell::ZERO);
        let [Cell([a, b, c, d]), Cell([e, f, g, h])] = ids.map(at);
        Self([a, b, c, d, e, f, g, h])
    }

    #[inline(always)]
    unsafe fn uncouple(self, cells: &mut [Cell], [first, second]: [u16; 2]) {
        let [a, b, c, d, e, f, g, h] = self.0;
        for (id, lanes) in [(second, [e, f, g, h]), (first, [a, b, c, d])] {
            if let Some(cell) = cells.get_mut(usize::from(id)) {
                *cell = Cell(lanes);
            }
        }
    }

    #[inline(always)]
    unsafe fn couple_values(values: &[f32], ids: [u16; 2]) -> Self {
        let [a, b] = ids.map(|id| values.get(usize::from(id)).copied().unwrap_or(0.0));
        Self([a, a, a, a, b, b, b, b])
    }

    #[inline(always)]
    fn positions(self) -> Self {
        let [a, b, c, _, e, f, g, _] = self.0;
        Self([a, b, c, 0.0, e, f, g, 0.0])
    }

    #[inline(always)]
    fn twice(cell: Cell) -> Self {
        let [a, b, c, d] = cell.0;
        Self([a, b, c, d, a, b, c, d])
    }

    #[inline(always)]
    fn folded(self) -> Cell {
        let [a, b, c, d, e, f, g, h] = self.0;
        Cell([a + e, b + f, c + g, d + h])
    }
}
