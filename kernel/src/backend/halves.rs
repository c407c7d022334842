//! NEON on aarch64 and `simd128` on WebAssembly: eight lanes in two registers.

use fearless_simd::{f32x4, f32x8, prelude::*};

#[cfg(target_arch = "aarch64")]
pub(super) use fearless_simd::aarch64::Neon as Unit;
#[cfg(target_arch = "wasm32")]
pub(super) use fearless_simd::wasm32::WasmSimd128 as Unit;

/// Returns true: the unit is part of the target.
pub(super) fn is_offered() -> bool {
    true
}

/// Calls a function: half as many operations on half as many lanes each need no function of their own.
#[inline(always)]
pub(super) fn apart<R>(_unit: Unit, work: impl FnOnce() -> R) -> R {
    work()
}

/// Transposes the low halves of four rows, and the high ones; it is its own inverse.
#[inline(always)]
pub(super) fn transposed(_unit: Unit, [a, b, c, d]: [f32x8<Unit>; 4]) -> [f32x8<Unit>; 4] {
    let ((a, e), (b, f), (c, g), (d, h)) = (a.split(), b.split(), c.split(), d.split());
    let ([x, y, z, w], [i, j, k, l]) = (four([a, b, c, d]), four([e, f, g, h]));
    [x.combine(i), y.combine(j), z.combine(k), w.combine(l)]
}

#[inline(always)]
fn four([a, b, c, d]: [f32x4<Unit>; 4]) -> [f32x4<Unit>; 4] {
    let (xy_low, xy_high) = (a.zip_low(c), b.zip_low(d));
    let (zw_low, zw_high) = (a.zip_high(c), b.zip_high(d));
    [
        xy_low.zip_low(xy_high),
        xy_low.zip_high(xy_high),
        zw_low.zip_low(zw_high),
        zw_low.zip_high(zw_high),
    ]
}
