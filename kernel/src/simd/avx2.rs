//! AVX2: eight cells side by side, one neighbour of each at a time.
//!
//! Every lane does what `link::pull` does, in its order; no fused multiply-add, no approximate
//! instructions. A cell's terms are added in ascending order of its neighbours, as the scalar pass
//! adds them, and the pull that a cell feels from below is exactly the opposite of what the scalar
//! pass computes at the other end.

#![allow(unsafe_code)]

use core::arch::x86_64::*;

use super::VectorUnit;
use crate::cell::Cell;
use crate::link::{Band, COINCIDENT, Pull};
use crate::model::{Model, Slices, range};
use crate::two_float::LANES;

/// Whether processor and operating system offer AVX2.
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

/// See [`VectorUnit::pass`].
pub(super) fn pass(
    _proof: VectorUnit,
    model: &Model<'_>,
    slices: &Slices<'_>,
    band: Band,
    at: &[Cell],
    residual: &mut [Cell],
    pull: impl Fn(usize, usize, f32) -> Option<Pull>,
) {
    let cells = model.cells();
    if at.len() < cells || residual.len() < cells {
        return;
    }
    for slice in 0..slices.rows.len().saturating_sub(1) {
        // SAFETY: the proof is that AVX2 is there; the slices of a model name only its cells, and
        // both arrays hold as many.
        unsafe { one_slice(slices, slice, cells, band, at, residual, &pull) };
    }
}

/// Coordinates of eight cells.
struct Eight {
    x: __m256,
    y: __m256,
    z: __m256,
}

/// # Safety
/// AVX2 is there; every id in `ids` is an index of `at`.
#[inline]
#[target_feature(enable = "avx2")]
unsafe fn gather(at: &[Cell], ids: &[u16; LANES]) -> Eight {
    // SAFETY: the caller's promise; a cell is four aligned floats.
    let load = |low: u16, high: u16| unsafe {
        let low = _mm_load_ps(at.get_unchecked(usize::from(low)).0.as_ptr());
        let high = _mm_load_ps(at.get_unchecked(usize::from(high)).0.as_ptr());
        _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
    };
    let [a, b, c, d, e, f, g, h] = *ids;
    let (ae, bf, cg, dh) = (load(a, e), load(b, f), load(c, g), load(d, h));
    let (xy_low, xy_high) = (_mm256_unpacklo_ps(ae, cg), _mm256_unpacklo_ps(bf, dh));
    let (z_low, z_high) = (_mm256_unpackhi_ps(ae, cg), _mm256_unpackhi_ps(bf, dh));
    Eight {
        x: _mm256_unpacklo_ps(xy_low, xy_high),
        y: _mm256_unpackhi_ps(xy_low, xy_high),
        z: _mm256_unpacklo_ps(z_low, z_high),
    }
}

/// # Safety
/// AVX2 is there; `slices` are those of a model of `cells` cells, `at` and `residual` as long.
#[target_feature(enable = "avx2")]
unsafe fn one_slice(
    slices: &Slices<'_>,
    slice: usize,
    cells: usize,
    band: Band,
    at: &[Cell],
    residual: &mut [Cell],
    pull: &impl Fn(usize, usize, f32) -> Option<Pull>,
) {
    let first = slice * LANES;
    let own: [u16; LANES] = core::array::from_fn(|lane| (first + lane).min(cells - 1) as u16);
    // SAFETY: every own id is below `cells`.
    let here = unsafe { gather(at, &own) };
    let mut sum = [_mm256_setzero_ps(); 4];
    for group in range(slices.rows, slice) {
        // SAFETY: the last row start is the number of groups.
        let (ids, lengths) = unsafe {
            (slices.neighbours.get_unchecked(group), slices.lengths.get_unchecked(group))
        };
        // SAFETY: a model's slices name only its cells.
        let there = unsafe { gather(at, ids) };
        // SAFETY: the section is eight floats a group.
        let l0 = unsafe { _mm256_loadu_ps(lengths.as_ptr()) };
        let taut = links(band, &here, &there, l0, &mut sum);
        if let Taut::SomeCoincident = taut {
            by_lane(&own, ids, lengths, &mut sum, pull);
        }
    }
    store(residual, first, cells, sum);
}

/// What a group of links was.
enum Taut {
    /// Nothing, or added.
    Done,
    /// Not added: some link has no direction of its own.
    SomeCoincident,
}

/// Adds the pulls of eight links to the sums, unless one of them has no direction of its own.
#[inline]
#[target_feature(enable = "avx2")]
fn links(band: Band, here: &Eight, there: &Eight, l0: __m256, sum: &mut [__m256; 4]) -> Taut {
    let dx = _mm256_sub_ps(there.x, here.x);
    let dy = _mm256_sub_ps(there.y, here.y);
    let dz = _mm256_sub_ps(there.z, here.z);
    let xy = _mm256_add_ps(_mm256_mul_ps(dx, dx), _mm256_mul_ps(dy, dy));
    let u2 = _mm256_add_ps(xy, _mm256_mul_ps(dz, dz));
    let l02 = _mm256_mul_ps(l0, l0);
    let high2 = _mm256_mul_ps(l02, _mm256_set1_ps(band.high_squared));
    let low2 = _mm256_mul_ps(l02, _mm256_set1_ps(band.low_squared));
    let above = _mm256_cmp_ps::<_CMP_GT_OQ>(u2, high2);
    let taut = _mm256_or_ps(above, _mm256_cmp_ps::<_CMP_LT_OQ>(u2, low2));
    if _mm256_movemask_ps(taut) == 0 {
        return Taut::Done;
    }
    let rare = _mm256_mul_ps(l02, _mm256_set1_ps(COINCIDENT));
    if _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(u2, rare)) != 0 {
        return Taut::SomeCoincident;
    }
    let u = _mm256_sqrt_ps(u2);
    let side = _mm256_blendv_ps(_mm256_set1_ps(band.low), _mm256_set1_ps(band.high), above);
    let d = _mm256_sub_ps(u, _mm256_mul_ps(l0, side));
    let factor = _mm256_and_ps(_mm256_div_ps(d, _mm256_add_ps(u, u)), taut);
    let [x, y, z, wd2] = sum;
    *x = _mm256_add_ps(*x, _mm256_mul_ps(factor, dx));
    *y = _mm256_add_ps(*y, _mm256_mul_ps(factor, dy));
    *z = _mm256_add_ps(*z, _mm256_mul_ps(factor, dz));
    *wd2 = _mm256_add_ps(*wd2, _mm256_and_ps(_mm256_mul_ps(d, d), taut));
    Taut::Done
}

/// Adds the pulls of eight links one after the other.
#[cold]
#[target_feature(enable = "avx2")]
fn by_lane(
    own: &[u16; LANES],
    ids: &[u16; LANES],
    lengths: &[f32; LANES],
    sum: &mut [__m256; 4],
    pull: &impl Fn(usize, usize, f32) -> Option<Pull>,
) {
    let mut lanes = [[0.0_f32; LANES]; 4];
    for (lanes, sum) in lanes.iter_mut().zip(&*sum) {
        // SAFETY: eight floats have room for eight floats.
        unsafe { _mm256_storeu_ps(lanes.as_mut_ptr(), *sum) };
    }
    for (lane, ((&i, &j), &l0)) in own.iter().zip(ids).zip(lengths).enumerate() {
        // Padding has no length.
        let pulled = if l0 > 0.0 { pull(i.into(), j.into(), l0) } else { None };
        let Some(pulled) = pulled else { continue };
        let [x, y, z] = pulled.force;
        for (lanes, term) in lanes.iter_mut().zip([x, y, z, pulled.wd2]) {
            if let Some(lane) = lanes.get_mut(lane) {
                *lane += term;
            }
        }
    }
    for (lanes, sum) in lanes.iter().zip(sum) {
        // SAFETY: as above.
        *sum = unsafe { _mm256_loadu_ps(lanes.as_ptr()) };
    }
}

/// Writes the sums of a slice's cells, of which the last slice may have fewer than eight.
#[inline]
#[target_feature(enable = "avx2")]
fn store(residual: &mut [Cell], first: usize, cells: usize, sum: [__m256; 4]) {
    let [x, y, z, w] = sum;
    let (xz_low, xz_high) = (_mm256_unpacklo_ps(x, z), _mm256_unpackhi_ps(x, z));
    let (yw_low, yw_high) = (_mm256_unpacklo_ps(y, w), _mm256_unpackhi_ps(y, w));
    let pairs = [
        _mm256_unpacklo_ps(xz_low, yw_low),
        _mm256_unpackhi_ps(xz_low, yw_low),
        _mm256_unpacklo_ps(xz_high, yw_high),
        _mm256_unpackhi_ps(xz_high, yw_high),
    ];
    for (lane, pair) in pairs.into_iter().enumerate() {
        let low = _mm256_castps256_ps128(pair);
        let high = _mm256_extractf128_ps::<1>(pair);
        for (cell, lanes) in [(first + lane, low), (first + lane + 4, high)] {
            if cell < cells
                && let Some(cell) = residual.get_mut(cell)
            {
                // SAFETY: a cell is four aligned floats.
                unsafe { _mm_store_ps(cell.0.as_mut_ptr(), lanes) };
            }
        }
    }
}
