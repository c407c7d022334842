//! NEON: eight lanes in two registers.

#![allow(unsafe_code)]

use core::arch::aarch64::*;

use super::f32x8::{Chunk, F32x8};
use super::{VectorUnit, Work};
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// Runs the work; NEON is part of every aarch64 target with floating point.
#[inline]
pub(super) fn run<W: Work>(_proof: VectorUnit, work: W) -> W::Output {
    work.run::<Neon>()
}

/// Lanes 0 to 3 and 4 to 7. NEON is part of the target: this makes every block below sound.
#[derive(Clone, Copy)]
pub(super) struct Neon(float32x4_t, float32x4_t);

/// All bits of a lane are set where the mask holds.
#[derive(Clone, Copy)]
pub(super) struct Mask(uint32x4_t, uint32x4_t);

#[inline(always)]
fn half(cell: &Cell) -> float32x4_t {
    // SAFETY: see `Neon`; a cell is four floats.
    unsafe { vld1q_f32(cell.0.as_ptr()) }
}

#[inline(always)]
fn put_half(lanes: float32x4_t, cell: &mut Cell) {
    // SAFETY: see `Neon`; a cell is four floats.
    unsafe { vst1q_f32(cell.0.as_mut_ptr(), lanes) };
}

/// Transposes four rows to four columns; it is its own inverse.
#[inline(always)]
fn transposed([a, b, c, d]: [float32x4_t; 4]) -> [float32x4_t; 4] {
    // SAFETY: see `Neon`.
    unsafe {
        let (ab_even, ab_odd) = (vtrn1q_f32(a, b), vtrn2q_f32(a, b));
        let (cd_even, cd_odd) = (vtrn1q_f32(c, d), vtrn2q_f32(c, d));
        let low = |a, c| vcombine_f32(vget_low_f32(a), vget_low_f32(c));
        let high = |a, c| vcombine_f32(vget_high_f32(a), vget_high_f32(c));
        [low(ab_even, cd_even), low(ab_odd, cd_odd), high(ab_even, cd_even), high(ab_odd, cd_odd)]
    }
}

impl F32x8 for Neon {
    type Mask = Mask;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vdupq_n_f32(value), vdupq_n_f32(value)) }
    }

    #[inline(always)]
    fn load(values: &[f32; LANES]) -> Self {
        let [low @ .., _, _, _, _] = values;
        let [_, _, _, _, high @ ..] = values;
        // SAFETY: see `Neon`; each half has four floats.
        unsafe { Self(vld1q_f32(low.as_ptr()), vld1q_f32(high.as_ptr())) }
    }

    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        let (low, high) = values.split_at_mut(4);
        // SAFETY: see `Neon`; each half has four floats.
        unsafe {
            vst1q_f32(low.as_mut_ptr(), self.0);
            vst1q_f32(high.as_mut_ptr(), self.1);
        }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vaddq_f32(self.0, other.0), vaddq_f32(self.1, other.1)) }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vsubq_f32(self.0, other.0), vsubq_f32(self.1, other.1)) }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vmulq_f32(self.0, other.0), vmulq_f32(self.1, other.1)) }
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vdivq_f32(self.0, other.0), vdivq_f32(self.1, other.1)) }
    }

    #[inline(always)]
    fn root(self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vsqrtq_f32(self.0), vsqrtq_f32(self.1)) }
    }

    #[inline(always)]
    fn larger_magnitude(self, other: Self) -> Self {
        // SAFETY: see `Neon`.
        let magnitude = unsafe { Self(vabsq_f32(other.0), vabsq_f32(other.1)) };
        Self::select(magnitude.above(self), magnitude, self)
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        // SAFETY: see `Neon`.
        unsafe { Mask(vcgtq_f32(self.0, other.0), vcgtq_f32(self.1, other.1)) }
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        other.above(self)
    }

    #[inline(always)]
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        // SAFETY: see `Neon`.
        unsafe { Mask(vorrq_u32(a.0, b.0), vorrq_u32(a.1, b.1)) }
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        // SAFETY: see `Neon`.
        unsafe { vmaxvq_u32(vorrq_u32(mask.0, mask.1)) != 0 }
    }

    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::splat(0.0))
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vbslq_f32(mask.0, yes.0, no.0), vbslq_f32(mask.1, yes.1, no.1)) }
    }

    #[inline(always)]
    unsafe fn gather(cells: &[Cell], ids: &[u16; LANES]) -> [Self; 3] {
        // SAFETY: the caller's promise.
        let rows = ids.map(|id| half(unsafe { cells.get_unchecked(usize::from(id)) }));
        let [a, b, c, d, e, f, g, h] = rows;
        let ([x, y, z, _], [i, j, k, _]) = (transposed([a, b, c, d]), transposed([e, f, g, h]));
        [Self(x, i), Self(y, j), Self(z, k)]
    }

    #[inline(always)]
    fn transposed(chunk: &Chunk) -> [Self; 4] {
        let [a, b, c, d, e, f, g, h] = chunk;
        let [x, y, z, w] = transposed([half(a), half(b), half(c), half(d)]);
        let [i, j, k, l] = transposed([half(e), half(f), half(g), half(h)]);
        [Self(x, i), Self(y, j), Self(z, k), Self(w, l)]
    }

    #[inline(always)]
    fn put_transposed([x, y, z, w]: [Self; 4], chunk: &mut Chunk) {
        let low = transposed([x.0, y.0, z.0, w.0]);
        let high = transposed([x.1, y.1, z.1, w.1]);
        for (lanes, cell) in low.into_iter().chain(high).zip(chunk) {
            put_half(lanes, cell);
        }
    }

    #[inline(always)]
    fn pair(chunk: &Chunk, pair: usize) -> Self {
        let [a, b, c, d, e, f, g, h] = chunk;
        let (low, high) = match pair {
            0 => (a, b),
            1 => (c, d),
            2 => (e, f),
            _ => (g, h),
        };
        Self(half(low), half(high))
    }

    #[inline(always)]
    fn put_pair(self, chunk: &mut Chunk, pair: usize) {
        for (lanes, cell) in [self.0, self.1].into_iter().zip(chunk.iter_mut().skip(2 * pair)) {
            put_half(lanes, cell);
        }
    }

    #[inline(always)]
    fn spread(values: &[f32; LANES], pair: usize) -> Self {
        let at = |index: usize| values.get(index).copied().unwrap_or(0.0);
        // SAFETY: see `Neon`.
        unsafe { Self(vdupq_n_f32(at(2 * pair)), vdupq_n_f32(at(2 * pair + 1))) }
    }

    #[inline(always)]
    fn in_turn(values: &[f32; LANES], pair: usize) -> Self {
        let (pairs, _) = values.as_chunks::<2>();
        let both = pairs.get(pair).copied().unwrap_or([0.0; 2]);
        // SAFETY: see `Neon`; two floats are there to be read.
        let four = unsafe {
            let two = vld1_f32(both.as_ptr());
            vcombine_f32(two, two)
        };
        Self(four, four)
    }

    #[inline(always)]
    fn woven(self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vzip1q_f32(self.0, self.1), vzip2q_f32(self.0, self.1)) }
    }

    #[inline(always)]
    fn unwoven(self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vuzp1q_f32(self.0, self.1), vuzp2q_f32(self.0, self.1)) }
    }

    #[inline(always)]
    unsafe fn couple(cells: &[Cell], [first, second]: [u16; 2]) -> Self {
        // SAFETY: the caller's promise.
        let (first, second) = unsafe {
            (cells.get_unchecked(usize::from(first)), cells.get_unchecked(usize::from(second)))
        };
        Self(half(first), half(second))
    }

    #[inline(always)]
    unsafe fn uncouple(self, cells: &mut [Cell], [first, second]: [u16; 2]) {
        // SAFETY: the caller's promise.
        unsafe {
            put_half(self.1, cells.get_unchecked_mut(usize::from(second)));
            put_half(self.0, cells.get_unchecked_mut(usize::from(first)));
        }
    }

    #[inline(always)]
    unsafe fn couple_values(values: &[f32], [first, second]: [u16; 2]) -> Self {
        // SAFETY: the caller's promise, and see `Neon`.
        unsafe {
            Self(
                vdupq_n_f32(*values.get_unchecked(usize::from(first))),
                vdupq_n_f32(*values.get_unchecked(usize::from(second))),
            )
        }
    }

    #[inline(always)]
    fn positions(self) -> Self {
        // SAFETY: see `Neon`.
        unsafe { Self(vsetq_lane_f32::<3>(0.0, self.0), vsetq_lane_f32::<3>(0.0, self.1)) }
    }

    #[inline(always)]
    fn twice(cell: Cell) -> Self {
        Self(half(&cell), half(&cell))
    }

    #[inline(always)]
    fn folded(self) -> Cell {
        let mut cell = Cell::ZERO;
        // SAFETY: see `Neon`.
        put_half(unsafe { vaddq_f32(self.0, self.1) }, &mut cell);
        cell
    }
}
