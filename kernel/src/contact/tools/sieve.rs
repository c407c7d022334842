//! A search of spheres over eight triangles at a time.

#![allow(unsafe_code)]

use super::candidates::Search;
use crate::backend::f32x8::F32x8;
use crate::backend::slices::Chunks;
use crate::backend::{VectorUnit, Work};
use crate::number::Number;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// States in `f32` and the unit that looks at eight triangles at a time.
#[derive(Clone, Copy)]
pub(crate) struct EightWide<'a> {
    pub unit: VectorUnit,
    pub state: &'a [Cell],
    pub saturation: f32,
}

impl<'a> EightWide<'a> {
    /// `None` without a unit, for other numbers, and for fewer states than `cells`, those that triangles name.
    #[inline(always)]
    pub fn of<N: Number>(
        unit: Option<VectorUnit>,
        state: &'a [Cell<N>],
        cells: usize,
        saturation: f32,
    ) -> Option<Self> {
        let state = N::singles(state).filter(|state| state.len() >= cells)?;
        Some(Self { unit: unit?, state, saturation })
    }
}

impl Search<'_> {
    /// Compares eight triangles with each sphere, as [`Whole::within`]: above 0 in lanes that may be in reach.
    #[inline(always)]
    fn may_reach<V: F32x8>(&mut self, middle: [V; 3], size: V) -> V {
        let (mut may_reach, two) = (V::splat(0.0), V::splat(2.0));
        for (tool, nearest) in self.tools.iter().zip(&mut self.nearest) {
            if !tool.is_in {
                continue;
            }
            let stride = self.reach * tool.proxy.radius_min();
            for solid in tool.proxy.parts() {
                let [x, y, z] = solid.centre;
                let squares = squared(middle, [V::splat(x), V::splat(y), V::splat(z)]);
                let far = solid.whole + stride;
                let beyond = squares.above(two.times(V::splat(far * far).plus(size)));
                may_reach = V::select(beyond, may_reach, two);
                if V::any(squares.below(V::splat(*nearest))) {
                    let mut lanes = [0.0; LANES];
                    squares.store(&mut lanes);
                    for squared in lanes {
                        *nearest = if squared < *nearest { squared } else { *nearest };
                    }
                }
            }
        }
        may_reach
    }
}

/// A search of spheres over eight triangles at a time: those that may be in reach are looked at one by one.
pub(super) struct Sieve<'a, 'b, A> {
    pub seek: &'a mut Search<'b>,
    pub state: &'a [Cell],
    pub saturation: f32,
    pub at: &'a A,
}

impl<A: Fn(usize) -> [f32; 3]> Work for Sieve<'_, '_, A> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Self { seek, state, saturation, at } = self;
        let (mut widest, zero, third) = (V::splat(0.0), V::splat(0.0), V::splat(1.0 / 3.0));
        let triangles = seek.surface.triangles;
        let (slices, padding) = (triangles.len().div_ceil(LANES), triangles.last().copied());
        let chunks = Chunks::new(triangles, padding.unwrap_or_default());
        for slice in 0..slices {
            let chunk = chunks.at(slice);
            let [
                [a, i, q],
                [b, j, r],
                [c, k, s],
                [d, l, t],
                [e, m, u],
                [f, n, v],
                [g, o, w],
                [h, p, x],
            ] = *chunk;
            // SAFETY: a model's triangles name only its cells, and `EightWide` has as many states.
            let [a, b, c] = unsafe {
                [
                    outputs::<V>(state, [a, b, c, d, e, f, g, h], saturation),
                    outputs::<V>(state, [i, j, k, l, m, n, o, p], saturation),
                    outputs::<V>(state, [q, r, s, t, u, v, w, x], saturation),
                ]
            };
            // Middle and size, as `Whole::of`.
            let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (a, b, c);
            let middle = [
                third.times(ax.plus(bx).plus(cx)),
                third.times(ay.plus(by).plus(cy)),
                third.times(az.plus(bz).plus(cz)),
            ];
            let sizes = [squared(a, middle), squared(b, middle), squared(c, middle)];
            let size = larger(larger(larger(zero, sizes[0]), sizes[1]), sizes[2]);
            widest = larger(widest, size);
            // Look at those that may be in reach one by one.
            let may_reach = seek.may_reach(middle, size);
            if V::any(may_reach.above(zero)) {
                let mut lanes = [0.0; LANES];
                may_reach.store(&mut lanes);
                for (lane, (&corners, may)) in chunk.iter().zip(lanes).enumerate() {
                    let index = slice * LANES + lane;
                    if may > 0.0 && index < triangles.len() {
                        seek.look(index, corners, at);
                    }
                }
            }
        }
        let mut lanes = [0.0; LANES];
        widest.store(&mut lanes);
        for size in lanes {
            seek.widest = if size > seek.widest { size } else { seek.widest };
        }
    }
}

/// Outputs of eight cells.
///
/// # Safety
/// The cells are indices of `state`.
#[inline(always)]
unsafe fn outputs<V: F32x8>(state: &[Cell], cells: [u16; LANES], saturation: f32) -> [V; 3] {
    let (low, high) = (V::splat(-saturation), V::splat(saturation));
    // SAFETY: the caller's promise.
    let [x, y, z] = unsafe { V::gather(state, &cells) };
    [clamped(x, low, high), clamped(y, low, high), clamped(z, low, high)]
}

#[inline(always)]
fn clamped<V: F32x8>(x: V, low: V, high: V) -> V {
    let x = V::select(x.below(low), low, x);
    V::select(x.above(high), high, x)
}

/// Squared distance.
#[inline(always)]
fn squared<V: F32x8>([x, y, z]: [V; 3], [a, b, c]: [V; 3]) -> V {
    let (x, y, z) = (x.minus(a), y.minus(b), z.minus(c));
    x.times(x).plus(y.times(y)).plus(z.times(z))
}

#[inline(always)]
fn larger<V: F32x8>(most: V, x: V) -> V {
    V::select(x.above(most), x, most)
}
