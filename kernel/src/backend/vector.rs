//! Eight lanes on the vector unit of the target, by `fearless_simd`.
//!
//! Only operations of that crate are used that are exact or exactly rounded on every target: no fused
//! product and sum, and neither `max` nor `min`, whose results for zeros and NaNs differ between units.

#![allow(unsafe_code)]

use core::cell::Cell as Shared;

use fearless_simd::{Simd, f32x4, f32x8, i32x8, mask32x8, prelude::*, u64x4};

#[cfg(target_arch = "x86_64")]
use super::avx2 as target;
use super::f32x8::{Chunk, F32x8};
#[cfg(not(target_arch = "x86_64"))]
use super::halves as target;
use super::{VectorUnit, Work};
use crate::number::cell::Cell;
use crate::number::two_float::LANES;
use target::{Unit, transposed};

/// The content of a [`VectorUnit`], which [`find`] alone makes.
pub(super) type Proof = ();

/// Asks the processor for the unit.
pub(super) fn find() -> Option<Proof> {
    target::is_offered().then_some(())
}

/// Runs the work, compiled for the unit.
#[inline]
pub(super) fn run<W: Work>(_proof: VectorUnit, work: W) -> W::Output {
    unit().vectorize(
        #[inline(always)]
        || work.run::<Vector>(),
    )
}

/// Eight lanes. Values exist only inside [`run`], where the unit is there.
#[derive(Clone, Copy)]
pub(super) struct Vector(f32x8<Unit>);

/// The token of the unit, called only inside [`run`].
#[inline(always)]
#[cfg_attr(target_arch = "wasm32", allow(unused_unsafe))]
fn unit() -> Unit {
    // SAFETY: `run` was given the proof that the unit is there.
    unsafe { Unit::assume_supported() }
}

#[inline(always)]
fn half(cell: &Cell) -> f32x4<Unit> {
    f32x4::simd_from(unit(), cell.0)
}

#[inline(always)]
fn add_half(cell: &Shared<Cell>, more: f32x4<Unit>) {
    cell.set(Cell((half(&cell.get()) + more).into()));
}

#[inline(always)]
fn joined(low: &Cell, high: &Cell) -> Vector {
    Vector(half(low).combine(half(high)))
}

// There are no closures around vector operations here and below: they cannot be marked for inlining, and a
// closure that is not inlined is compiled without the unit.
#[inline(always)]
fn put_joined(lanes: Vector, low: &mut Cell, high: &mut Cell) {
    let halves = lanes.0.split();
    low.0 = halves.0.into();
    high.0 = halves.1.into();
}

/// One value in the first four lanes, the other in the rest.
#[inline(always)]
fn two_values(low: f32, high: f32) -> Vector {
    Vector(f32x4::splat(unit(), low).combine(f32x4::splat(unit(), high)))
}

/// Returns two values of eight.
#[inline(always)]
fn two_of(values: &[f32; LANES], pair: usize) -> [f32; 2] {
    let (pairs, _) = values.as_chunks();
    pairs.get(pair).copied().unwrap_or([0.0; 2])
}

impl F32x8 for Vector {
    type Mask = mask32x8<Unit>;

    #[inline(always)]
    fn apart<W: Work>(work: W) -> W::Output {
        target::apart(
            unit(),
            #[inline(always)]
            || work.run::<Self>(),
        )
    }

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(f32x8::splat(unit(), value))
    }

    #[inline(always)]
    fn load(values: &[f32; LANES]) -> Self {
        Self(f32x8::simd_from(unit(), *values))
    }

    #[inline(always)]
    fn store(self, values: &mut [f32; LANES]) {
        *values = self.0.into();
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }

    #[inline(always)]
    fn root(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn magnitude(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        Self(self.0.copysign(other.0))
    }

    #[inline(always)]
    fn larger_magnitude(self, other: Self) -> Self {
        let magnitude = Self(other.0.abs());
        Self::select(magnitude.above(self), magnitude, self)
    }

    #[inline(always)]
    fn above(self, other: Self) -> Self::Mask {
        self.0.simd_gt(other.0)
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        self.0.simd_lt(other.0)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> Self::Mask {
        self.0.simd_eq(other.0)
    }

    #[inline(always)]
    fn either(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        a | b
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.any_true()
    }

    #[inline(always)]
    fn keep(self, mask: Self::Mask) -> Self {
        Self::select(mask, self, Self::splat(0.0))
    }

    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Self(mask.select(yes.0, no.0))
    }

    #[inline(always)]
    unsafe fn gather(cells: &[Cell], ids: &[u16; LANES]) -> [Self; 3] {
        // SAFETY: the caller's promise.
        let [a, b, c, d, e, f, g, h] =
            ids.map(|id| unsafe { cells.get_unchecked(usize::from(id)) });
        let rows = [joined(a, e).0, joined(b, f).0, joined(c, g).0, joined(d, h).0];
        let [x, y, z, _] = transposed(unit(), rows);
        [Self(x), Self(y), Self(z)]
    }

    #[inline(always)]
    fn transposed([a, b, c, d, e, f, g, h]: &Chunk) -> [Self; 4] {
        let rows = [joined(a, e).0, joined(b, f).0, joined(c, g).0, joined(d, h).0];
        let [x, y, z, w] = transposed(unit(), rows);
        [Self(x), Self(y), Self(z), Self(w)]
    }

    #[inline(always)]
    fn put_transposed([x, y, z, w]: [Self; 4], [a, b, c, d, e, f, g, h]: &mut Chunk) {
        let [ae, bf, cg, dh] = transposed(unit(), [x.0, y.0, z.0, w.0]);
        put_joined(Self(ae), a, e);
        put_joined(Self(bf), b, f);
        put_joined(Self(cg), c, g);
        put_joined(Self(dh), d, h);
    }

    #[inline(always)]
    fn add_to([x, y, z, w]: [Self; 4], [a, b, c, d, e, f, g, h]: [&Shared<Cell>; LANES]) {
        let [ae, bf, cg, dh] = transposed(unit(), [x.0, y.0, z.0, w.0]);
        let (a_e, b_f, c_g, d_h) = (ae.split(), bf.split(), cg.split(), dh.split());
        add_half(a, a_e.0);
        add_half(b, b_f.0);
        add_half(c, c_g.0);
        add_half(d, d_h.0);
        add_half(e, a_e.1);
        add_half(f, b_f.1);
        add_half(g, c_g.1);
        add_half(h, d_h.1);
    }

    #[inline(always)]
    fn pair([a, b, c, d, e, f, g, h]: &Chunk, pair: usize) -> Self {
        match pair {
            0 => joined(a, b),
            1 => joined(c, d),
            2 => joined(e, f),
            _ => joined(g, h),
        }
    }

    #[inline(always)]
    fn put_pair(self, [a, b, c, d, e, f, g, h]: &mut Chunk, pair: usize) {
        match pair {
            0 => put_joined(self, a, b),
            1 => put_joined(self, c, d),
            2 => put_joined(self, e, f),
            _ => put_joined(self, g, h),
        }
    }

    #[inline(always)]
    fn spread(values: &[f32; LANES], pair: usize) -> Self {
        let [low, high] = two_of(values, pair);
        two_values(low, high)
    }

    #[inline(always)]
    fn in_turn(values: &[f32; LANES], pair: usize) -> Self {
        let both: u64 = bytemuck::cast(two_of(values, pair));
        Self(u64x4::splat(unit(), both).bitcast())
    }

    #[inline(always)]
    fn woven(self) -> Self {
        let (low, high) = self.0.split();
        Self(low.zip_low(high).combine(low.zip_high(high)))
    }

    #[inline(always)]
    fn unwoven(self) -> Self {
        let (low, high) = self.0.split();
        Self(low.unzip_low(high).combine(low.unzip_high(high)))
    }

    #[inline(always)]
    unsafe fn couple(cells: &[Cell], ids: [u16; 2]) -> Self {
        // SAFETY: the caller's promise.
        let [low, high] = ids.map(|id| unsafe { cells.get_unchecked(usize::from(id)) });
        joined(low, high)
    }

    #[inline(always)]
    unsafe fn uncouple(self, cells: &mut [Cell], [a, b]: [u16; 2]) {
        let (low, high) = self.0.split();
        // SAFETY: the caller's promise.
        unsafe {
            cells.get_unchecked_mut(usize::from(b)).0 = high.into();
            cells.get_unchecked_mut(usize::from(a)).0 = low.into();
        }
    }

    #[inline(always)]
    unsafe fn couple_values(values: &[f32], ids: [u16; 2]) -> Self {
        // SAFETY: the caller's promise.
        let [low, high] = ids.map(|id| unsafe { *values.get_unchecked(usize::from(id)) });
        two_values(low, high)
    }

    #[inline(always)]
    fn positions(self) -> Self {
        let xyz = i32x8::simd_from(unit(), [-1, -1, -1, 0, -1, -1, -1, 0]);
        Self((self.0.bitcast::<i32x8<Unit>>() & xyz).bitcast())
    }

    #[inline(always)]
    fn twice(cell: Cell) -> Self {
        Self(f32x8::block_splat(half(&cell)))
    }

    #[inline(always)]
    fn folded(self) -> Cell {
        let (low, high) = self.0.split();
        Cell((low + high).into())
    }
}
