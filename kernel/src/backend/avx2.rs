//! AVX2: eight lanes in one register.

#![allow(unsafe_code)]

use core::arch::x86_64::*;
use core::cell::Cell as Shared;

use super::f32x8::{Chunk, F32x8};
use super::{VectorUnit, Work};
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// Returns true if processor and operating system offer AVX2.
pub(super) fn is_offered() -> bool {
    const OSXSAVE_AND_AVX: u32 = 1 << 27 | 1 << 28;
    const AVX2: u32 = 1 << 5;
    const YMM_SAVED: u64 = 0b110;
    if __cpuid(0).eax < 7 || __cpuid(1).ecx & OSXSAVE_AND_AVX != OSXSAVE_AND_AVX {
        return false;
    }
    // SAFETY: OSXSAVE says that the instruction exists.
    let saved = unsafe { _xgetbv(0) };
    saved & YMM_SAVED == YMM_SAVED && __cpuid_count(7, 0).ebx & AVX2 != 0
}

/// Does the work, compiled for AVX2.
#[inline]
pub(super) fn run<W: Work>(_proof: VectorUnit, work: W) -> W::Output {
    // SAFETY: the proof is that AVX2 is there.
    unsafe { compiled(work) }
}

#[target_feature(enable = "avx2")]
fn compiled<W: Work>(work: W) -> W::Output {
    work.run::<Avx2>()
}

/// A register of eight lanes. Values exist only inside [`run`], where AVX2 is available: this makes every
/// block below sound.
#[derive(Clone, Copy)]
pub(super) struct Avx2(__m256);

/// Loads one half of a register from a cell.
#[inline(always)]
fn half(cell: &Cell) -> __m128 {
    // SAFETY: a cell is four aligned floats.
    unsafe { _mm_load_ps(cell.0.as_ptr()) }
}

#[inline(always)]
fn joined(low: &Cell, high: &Cell) -> __m256 {
    // SAFETY: see `Avx2`.
    unsafe { _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(half(low)), half(high)) }
}

#[inline(always)]
fn put_half(lanes: __m128, cell: &mut Cell) {
    // SAFETY: a cell is four aligned floats.
    unsafe { _mm_store_ps(cell.0.as_mut_ptr(), lanes) };
}

/// Adds one half of a register to a cell.
#[inline(always)]
fn add_half(more: __m128, cell: &Shared<Cell>) {
    let place = cell.as_ptr().cast::<f32>();
    // SAFETY: a cell is four aligned floats, and a `Shared` lends no reference to them.
    unsafe { _mm_store_ps(place, _mm_add_ps(_mm_load_ps(place), more)) };
}

// There are no closures around vector operations here and below: they cannot be marked for inlining, and a
// closure that is not inlined is compiled without AVX2.
#[inline(always)]
fn put_joined(lanes: __m256, low: &mut Cell, high: &mut Cell) {
    // SAFETY: see `Avx2`.
    let halves = unsafe { (_mm256_castps256_ps128(lanes), _mm256_extractf128_ps::<1>(lanes)) };
    put_half(halves.0, low);
    put_half(halves.1, high);
}

/// Returns the two cells of a pair.
#[inline(always)]
fn two(chunk: &Chunk, pair: usize) -> &[Cell; 2] {
    match (pair, chunk) {
        (0, [two @ .., _, _, _, _, _, _]) => two,
        (1, [_, _, two @ .., _, _, _, _]) => two,
        (2, [_, _, _, _, two @ .., _, _]) => two,
        (_, [_, _, _, _, _, _, two @ ..]) => two,
    }
}

/// As `two`, for writing.
#[inline(always)]
fn two_mut(chunk: &mut Chunk, pair: usize) -> &mut [Cell; 2] {
    match (pair, chunk) {
        (0, [two @ .., _, _, _, _, _, _]) => two,
        (1, [_, _, two @ .., _, _, _, _]) => two,
        (2, [_, _, _, _, two @ .., _, _]) => two,
        (_, [_, _, _, _, _, _, two @ ..]) => two,
    }
}

impl F32x8 for Avx2 {
    type Mask = __m256;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_set1_ps(value) })
    }

    #[inline(always)]
    fn load(values: &[f32; LANES]) -> Self {
        // SAFETY: see `Avx2`; eight floats are there to be read.
        Self(unsafe { _mm256_loadu_ps(values.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        // SAFETY: see `Avx2`; `values` has eight floats.
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self.0) };
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn root(self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn larger_magnitude(self, other: Self) -> Self {
        // SAFETY: see `Avx2`; the maximum takes its second operand where they do not compare.
        Self(unsafe {
            let magnitude = _mm256_andnot_ps(_mm256_set1_ps(-0.0), other.0);
            _mm256_max_ps(magnitude, self.0)
        })
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        // SAFETY: see `Avx2`.
        unsafe { _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        // SAFETY: see `Avx2`.
        unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        // SAFETY: see `Avx2`.
        unsafe { _mm256_or_ps(a, b) }
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        // SAFETY: see `Avx2`.
        unsafe { _mm256_movemask_ps(mask) != 0 }
    }

    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_and_ps(self.0, mask) })
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_blendv_ps(no.0, yes.0, mask) })
    }

    #[inline(always)]
    unsafe fn gather(cells: &[Cell], ids: &[u16; LANES]) -> [Self; 3] {
        let [a, b, c, d, e, f, g, h] = *ids;
        // SAFETY: the caller's promise, and see `Avx2`.
        unsafe {
            let at = |id: u16| cells.get_unchecked(usize::from(id));
            let (ae, bf) = (joined(at(a), at(e)), joined(at(b), at(f)));
            let (cg, dh) = (joined(at(c), at(g)), joined(at(d), at(h)));
            let (xy_low, xy_high) = (_mm256_unpacklo_ps(ae, cg), _mm256_unpacklo_ps(bf, dh));
            let (z_low, z_high) = (_mm256_unpackhi_ps(ae, cg), _mm256_unpackhi_ps(bf, dh));
            [
                Self(_mm256_unpacklo_ps(xy_low, xy_high)),
                Self(_mm256_unpackhi_ps(xy_low, xy_high)),
                Self(_mm256_unpacklo_ps(z_low, z_high)),
            ]
        }
    }

    #[inline(always)]
    fn transposed(chunk: &Chunk) -> [Self; 4] {
        let [a, b, c, d, e, f, g, h] = chunk;
        let (ae, bf, cg, dh) = (joined(a, e), joined(b, f), joined(c, g), joined(d, h));
        // SAFETY: see `Avx2`.
        unsafe {
            let (xy_low, xy_high) = (_mm256_unpacklo_ps(ae, cg), _mm256_unpacklo_ps(bf, dh));
            let (zw_low, zw_high) = (_mm256_unpackhi_ps(ae, cg), _mm256_unpackhi_ps(bf, dh));
            [
                Self(_mm256_unpacklo_ps(xy_low, xy_high)),
                Self(_mm256_unpackhi_ps(xy_low, xy_high)),
                Self(_mm256_unpacklo_ps(zw_low, zw_high)),
                Self(_mm256_unpackhi_ps(zw_low, zw_high)),
            ]
        }
    }

    #[inline(always)]
    fn put_transposed([x, y, z, w]: [Self; 4], chunk: &mut Chunk) {
        let [a, b, c, d, e, f, g, h] = chunk;
        // SAFETY: see `Avx2`.
        unsafe {
            let (xz_low, xz_high) = (_mm256_unpacklo_ps(x.0, z.0), _mm256_unpackhi_ps(x.0, z.0));
            let (yw_low, yw_high) = (_mm256_unpacklo_ps(y.0, w.0), _mm256_unpackhi_ps(y.0, w.0));
            put_joined(_mm256_unpacklo_ps(xz_low, yw_low), a, e);
            put_joined(_mm256_unpackhi_ps(xz_low, yw_low), b, f);
            put_joined(_mm256_unpacklo_ps(xz_high, yw_high), c, g);
            put_joined(_mm256_unpackhi_ps(xz_high, yw_high), d, h);
        }
    }

    #[inline(always)]
    fn add_to([x, y, z, w]: [Self; 4], cells: [&Shared<Cell>; LANES]) {
        let [a, b, c, d, e, f, g, h] = cells;
        // SAFETY: see `Avx2`.
        unsafe {
            let (xz_low, xz_high) = (_mm256_unpacklo_ps(x.0, z.0), _mm256_unpackhi_ps(x.0, z.0));
            let (yw_low, yw_high) = (_mm256_unpacklo_ps(y.0, w.0), _mm256_unpackhi_ps(y.0, w.0));
            let ae = _mm256_unpacklo_ps(xz_low, yw_low);
            let bf = _mm256_unpackhi_ps(xz_low, yw_low);
            let cg = _mm256_unpacklo_ps(xz_high, yw_high);
            let dh = _mm256_unpackhi_ps(xz_high, yw_high);
            for (more, cell) in [(ae, a), (bf, b), (cg, c), (dh, d)] {
                add_half(_mm256_castps256_ps128(more), cell);
            }
            for (more, cell) in [(ae, e), (bf, f), (cg, g), (dh, h)] {
                add_half(_mm256_extractf128_ps::<1>(more), cell);
            }
        }
    }

    #[inline(always)]
    fn pair(chunk: &Chunk, pair: usize) -> Self {
        // SAFETY: see `Avx2`; two cells are eight floats.
        Self(unsafe { _mm256_loadu_ps(two(chunk, pair).as_ptr().cast()) })
    }

    #[inline(always)]
    fn put_pair(self, chunk: &mut Chunk, pair: usize) {
        // SAFETY: see `Avx2`; two cells are eight floats.
        unsafe { _mm256_storeu_ps(two_mut(chunk, pair).as_mut_ptr().cast(), self.0) };
    }

    #[inline(always)]
    fn spread(values: &[f32; LANES], pair: usize) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe {
            let all = _mm256_loadu_ps(values.as_ptr());
            let first = 2 * pair as i32;
            let second = first + 1;
            let order =
                _mm256_setr_epi32(first, first, first, first, second, second, second, second);
            _mm256_permutevar8x32_ps(all, order)
        })
    }

    #[inline(always)]
    fn in_turn(values: &[f32; LANES], pair: usize) -> Self {
        let (pairs, _) = values.as_chunks::<2>();
        let [a, b] = pairs.get(pair).copied().unwrap_or([0.0; 2]);
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_setr_ps(a, b, a, b, a, b, a, b) })
    }

    #[inline(always)]
    fn woven(self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe {
            let (low, high) = (_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let (first, second) = (_mm_unpacklo_ps(low, high), _mm_unpackhi_ps(low, high));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second)
        })
    }

    #[inline(always)]
    fn unwoven(self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe {
            let order = _mm256_setr_epi32(0, 2, 4, 6, 1, 3, 5, 7);
            _mm256_permutevar8x32_ps(self.0, order)
        })
    }

    #[inline(always)]
    unsafe fn couple(cells: &[Cell], [first, second]: [u16; 2]) -> Self {
        // SAFETY: the caller's promise.
        let (first, second) = unsafe {
            (cells.get_unchecked(usize::from(first)), cells.get_unchecked(usize::from(second)))
        };
        Self(joined(first, second))
    }

    #[inline(always)]
    unsafe fn uncouple(self, cells: &mut [Cell], [first, second]: [u16; 2]) {
        // SAFETY: the caller's promise, and see `Avx2`.
        unsafe {
            let high = _mm256_extractf128_ps::<1>(self.0);
            put_half(high, cells.get_unchecked_mut(usize::from(second)));
            let low = _mm256_castps256_ps128(self.0);
            put_half(low, cells.get_unchecked_mut(usize::from(first)));
        }
    }

    #[inline(always)]
    unsafe fn couple_values(values: &[f32], [first, second]: [u16; 2]) -> Self {
        // SAFETY: the caller's promise, and see `Avx2`.
        Self(unsafe {
            let first = _mm_broadcast_ss(values.get_unchecked(usize::from(first)));
            let second = _mm_broadcast_ss(values.get_unchecked(usize::from(second)));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(first), second)
        })
    }

    #[inline(always)]
    fn positions(self) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_blend_ps::<0b1000_1000>(self.0, _mm256_setzero_ps()) })
    }

    #[inline(always)]
    fn twice(cell: Cell) -> Self {
        // SAFETY: see `Avx2`.
        Self(unsafe { _mm256_broadcast_ps(&half(&cell)) })
    }

    #[inline(always)]
    fn folded(self) -> Cell {
        let mut cell = Cell::ZERO;
        // SAFETY: see `Avx2`.
        let sum = unsafe {
            _mm_add_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0))
        };
        put_half(sum, &mut cell);
        cell
    }
}
