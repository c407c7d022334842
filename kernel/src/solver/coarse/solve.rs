//! The product with the inverse, with held cells kept fixed or under the resistance of tools.

use super::resistance::solve_resisted;
use super::vector;
use crate::backend::Work;
use crate::backend::f32x8::F32x8;
use crate::model::coarse_basis::CoarseBasis;
use crate::number::two_float::{Eight, LANES, Lanes, TwoFloat};

/// Effect of the tool on the coarse level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Coarse {
    /// By the corrections for this number of held cells, stored in the coarse memory.
    Corrected(usize),
    /// With this number of basis functions resisted by tools on a surface; their factor is in the coarse
    /// memory.
    Resisted(u16),
}

/// c = B g with the held cells fixed, or under the tools' resistance. Returns g . c.
pub(crate) struct Solve<'a, 'm> {
    pub basis: CoarseBasis<'m>,
    pub room: &'a mut [Eight],
    pub coarse: Coarse,
}

impl Work for Solve<'_, '_> {
    type Output = TwoFloat;

    #[inline(always)]
    fn run<V: F32x8>(self) -> TwoFloat {
        let blocks = self.basis.blocks();
        let Some((g, rest)) = self.room.split_at_mut_checked(3 * blocks) else {
            return TwoFloat::ZERO;
        };
        let Some((c, corrections)) = rest.split_at_mut_checked(3 * blocks) else {
            return TwoFloat::ZERO;
        };
        // c = B g.
        let mut first = 0;
        while first + 2 <= blocks {
            columns::<V, 2>(self.basis.inverse, blocks, first, g, c);
            first += 2;
        }
        if first < blocks {
            columns::<V, 1>(self.basis.inverse, blocks, first, g, c);
        }
        // Keep the held cells fixed, or take the tools' resistance into account.
        match self.coarse {
            Coarse::Corrected(held) => {
                let vectors = corrections.chunks_exact(blocks).take(2 * held);
                for (index, along) in vectors.enumerate() {
                    correct::<V>(along, blocks, if index % 2 == 0 { -1.0 } else { 1.0 }, g, c);
                }
            }
            Coarse::Resisted(count) => {
                if !solve_resisted::<V>(&self.basis, corrections, count.into(), c) {
                    return TwoFloat::ZERO;
                }
            }
        }
        // Sum g . c.
        let mut product = Lanes::ZERO;
        for block in 0..blocks {
            let mut term = V::splat(0.0);
            for axis in 0..3 {
                let at = axis * blocks + block;
                if let (Some(g), Some(c)) = (g.get(at), c.get(at)) {
                    term = term.plus(V::load(g).times(V::load(c)));
                }
            }
            product.add(term);
        }
        product.total()
    }
}

/// N blocks of eight `f32` of c = B g on all axes, summed over the basis functions in ascending
/// order.
#[inline(always)]
fn columns<V: F32x8, const N: usize>(
    inverse: &[Eight],
    blocks: usize,
    first: usize,
    g: &[Eight],
    c: &mut [Eight],
) {
    let mut sums = [[V::splat(0.0); 3]; N];
    let axis = |axis: usize| vector(g, blocks, axis).as_flattened();
    let g = axis(0).iter().zip(axis(1)).zip(axis(2));
    for (row, ((&x, &y), &z)) in inverse.chunks_exact(blocks).zip(g) {
        let here = row.get(first..).and_then(|row| row.first_chunk::<N>());
        let Some(here) = here else { continue };
        let (x, y, z) = (V::splat(x), V::splat(y), V::splat(z));
        for ([sum_x, sum_y, sum_z], b) in sums.iter_mut().zip(here) {
            let b = V::load(b);
            *sum_x = sum_x.plus(b.times(x));
            *sum_y = sum_y.plus(b.times(y));
            *sum_z = sum_z.plus(b.times(z));
        }
    }
    for (at, sums) in sums.into_iter().enumerate() {
        for (axis, sum) in sums.into_iter().enumerate() {
            if let Some(slot) = c.get_mut(axis * blocks + first + at) {
                sum.store(slot);
            }
        }
    }
}

/// c += sign v (v . g) on all axes.
#[inline(always)]
fn correct<V: F32x8>(along: &[Eight], blocks: usize, sign: f32, g: &[Eight], c: &mut [Eight]) {
    for axis in 0..3 {
        let c = c.get_mut(axis * blocks..(axis + 1) * blocks).unwrap_or(&mut []);
        add_along::<V>(along, sign, vector(g, blocks, axis), c);
    }
}

/// c += sign v (v . g).
#[inline(always)]
pub(super) fn add_along<V: F32x8>(v: &[Eight], sign: f32, g: &[Eight], c: &mut [Eight]) {
    along::<V>(v, sign * total(inner::<V>(V::splat(0.0), v, g)), c);
}

/// Adds the products of two vectors to sums, lane by lane.
#[inline(always)]
pub(super) fn inner<V: F32x8>(sums: V, a: &[Eight], b: &[Eight]) -> V {
    a.iter().zip(b).fold(sums, |sums, (a, b)| sums.plus(V::load(a).times(V::load(b))))
}

/// The sum of the lanes.
#[inline(always)]
pub(super) fn total<V: F32x8>(lanes: V) -> f32 {
    let mut sums = [0.0; LANES];
    lanes.store(&mut sums);
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// c += factor v.
#[inline(always)]
pub(super) fn along<V: F32x8>(v: &[Eight], factor: f32, c: &mut [Eight]) {
    let factor = V::splat(factor);
    for (v, c) in v.iter().zip(c) {
        V::load(c).plus(V::load(v).times(factor)).store(c);
    }
}
