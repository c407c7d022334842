//! The coarse level of nodal shapes: the elasticity of the rest shape between basis functions.
//!
//! The bound L of nodal shapes is several times as stiff as the shapes: it ignores rotations, and treats
//! every change of shape as a change of volume. Steps that it certifies are short. The direction of the next
//! pass needs no certificate, since the guard judges the pass:
//!
//! ```text
//! z = m r + P R B R' P' r,   B = (P' K P + room)^-1
//! ```
//!
//! K is the second derivative of the energy at rest, for all three axes together; R rotates each basis
//! function by the rotation of one cell under it, so that a rotated body is handled in its own frame
//! (corotated; Mueller, Gross 2004). m is 2.1 over the trace of K at the cell, several times 1 / W. The
//! published point is that of an accepted pass plus only r / W, which is certified ([`track`](crate::Track)).
//!
//! A cell that the tool holds has no residual and does not follow its basis functions. If that cuts off more
//! than the basis functions move, B is corrected ([`elastic_held`](super::elastic_held)).
//!
//! Memory with n basis functions: 36 n^2 bytes of the image for B; in RAM 36 bytes per basis function
//! ([`elastic_room`]). Cost of a sweep: 9 n^2 multiplications besides restriction and prolongation, and 6 n
//! per correction.

use super::sides;
use super::solve::add_along;
use super::touched::CoarseTouch;
use crate::backend::f32x8::F32x8;
use crate::backend::team::Team;
use crate::backend::{VectorUnit, Work, run};
use crate::energy::surface::IS_BUILT;
use crate::model::coarse_basis::CoarseBasis;
use crate::model::parts::PARTS;
use crate::model::sides as two_sided;
use crate::number::two_float::{Eight, LANES, Lanes, TwoFloat};

/// Memory that the coarse level of nodal shapes needs for `functions` basis functions \[blocks of eight
/// `f32`\]; for a body that can be cut and [`side_room`] more.
#[must_use]
pub const fn elastic_room(functions: usize) -> usize {
    9 * functions.div_ceil(LANES)
}

/// Memory that the coarse level needs on top of [`elastic_room`] for a body that can be cut \[blocks of eight
/// `f32`\]: for functions on one side of a cut.
///
/// ```
/// use chaincell_kernel::{Tissue, Track, elastic_room, side_room, term_states};
///
/// /// A body of 48 functions that can be cut.
/// type Body = Tissue<512, Track<{ elastic_room(48) + side_room(48) }>, 9, { term_states(512) }>;
/// assert_eq!(32 * side_room(48), 1_152); // [bytes]
/// assert_eq!(side_room(23), 0); // so few functions are enough beside a cut too
/// ```
#[must_use]
pub const fn side_room(functions: usize) -> usize {
    9 * two_sided::most(functions) / LANES
}

/// c = B g for the g in the coarse memory, which is kept there as the last one.
pub(crate) struct ElasticSolve<'a, 'm> {
    pub basis: CoarseBasis<'m>,
    pub room: &'a mut [Eight],
    /// Number of corrections for held cells in the coarse memory.
    pub corrections: usize,
    /// Effect of tools on B.
    pub touch: Option<&'a CoarseTouch>,
}

/// Blocks of c that are summed side by side.
const SIDE_BY_SIDE: usize = 6;

impl ElasticSolve<'_, '_> {
    /// Returns g . c and (last g) . c; the team computes the blocks of B g in this number of parts.
    pub fn solve(self, unit: Option<VectorUnit>, team: Team<'_>, parts: usize) -> [TwoFloat; 2] {
        let blocks = self.basis.row_blocks();
        let Some((g, rest)) = self.room.split_at_mut_checked(blocks) else {
            return [TwoFloat::ZERO; 2];
        };
        let Some(c) = rest.get_mut(..blocks) else { return [TwoFloat::ZERO; 2] };
        let (inverse, g) = (self.basis.inverse, &*g);
        if unit.is_none() || parts == 1 {
            run(unit, Product { inverse, g, c, first: 0 });
        } else {
            let share = blocks.div_ceil(SIDE_BY_SIDE).div_ceil(parts) * SIDE_BY_SIDE;
            let mut shares = c.chunks_mut(share.max(1)).enumerate();
            let product = |()| {
                let (part, c) = shares.next()?;
                Some(Product { inverse, g, c, first: part * share })
            };
            team.run(unit, [(); PARTS].map(product));
        }
        run(unit, self)
    }
}

/// Blocks of c = B g from the block `first` on.
pub(crate) struct Product<'a> {
    pub inverse: &'a [Eight],
    pub g: &'a [Eight],
    pub c: &'a mut [Eight],
    pub first: usize,
}

impl Work for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Self { inverse, g, c, mut first } = self;
        let (many, few) = c.as_chunks_mut::<SIDE_BY_SIDE>();
        for c in many {
            columns::<V, SIDE_BY_SIDE>(inverse, first, g, c);
            first += SIDE_BY_SIDE;
        }
        for c in few {
            columns::<V, 1>(inverse, first, g, core::array::from_mut(c));
            first += 1;
        }
    }
}

/// Corrects c = B g for held cells and tools. Returns g . c and (last g) . c.
impl Work for ElasticSolve<'_, '_> {
    type Output = [TwoFloat; 2];

    #[inline(always)]
    fn run<V: F32x8>(self) -> [TwoFloat; 2] {
        let blocks = self.basis.row_blocks();
        let Some((g, rest)) = self.room.split_at_mut_checked(blocks) else {
            return [TwoFloat::ZERO; 2];
        };
        let Some((c, rest)) = rest.split_at_mut_checked(blocks) else {
            return [TwoFloat::ZERO; 2];
        };
        let Some((last, rest)) = rest.split_at_mut_checked(blocks) else {
            return [TwoFloat::ZERO; 2];
        };
        let side_blocks = self.basis.side_blocks();
        let Some((of_sides, corrections)) = rest.split_at_mut_checked(3 * side_blocks) else {
            return [TwoFloat::ZERO; 2];
        };
        // Apply the corrections, the two-sided functions and the tools.
        for along in corrections.chunks_exact(blocks).take(self.corrections) {
            add_along::<V>(along, -1.0, g, c);
        }
        let used = if self.basis.sides().is_some() { side_blocks } else { 0 };
        let Some((g_sides, rest)) = of_sides.split_at_mut_checked(used) else {
            return [TwoFloat::ZERO; 2];
        };
        let Some((c_sides, last_sides)) = rest.split_at_mut_checked(used) else {
            return [TwoFloat::ZERO; 2];
        };
        sides::add_to::<V>(&self.basis, g, g_sides, c, c_sides);
        if IS_BUILT && let Some(touch) = self.touch {
            touch.correct::<V>(&self.basis, c, c_sides);
        }
        // Sum the products, and keep g as the last one.
        let (mut product, mut mixed) = (Lanes::ZERO, Lanes::ZERO);
        let (g, c, last) = (g.iter().chain(&*g_sides), c.iter().chain(&*c_sides), last.iter_mut());
        for ((g, c), last) in g.zip(c).zip(last.chain(last_sides)) {
            let c = V::load(c);
            product.add(V::load(g).times(c));
            mixed.add(V::load(last).times(c));
            *last = *g;
        }
        [product.total(), mixed.total()]
    }
}

/// N blocks of c = B g from the block `first` on, summed over the rows in ascending order.
#[inline(always)]
fn columns<V: F32x8, const N: usize>(
    inverse: &[Eight],
    first: usize,
    g: &[Eight],
    c: &mut [Eight; N],
) {
    let mut sums = [V::splat(0.0); N];
    // A vector has at least one block; `max` makes this known to the compiler.
    for (row, &g) in inverse.chunks_exact(g.len().max(1)).zip(g.as_flattened()) {
        let here = row.get(first..).and_then(|row| row.first_chunk::<N>());
        let Some(here) = here else { continue };
        let g = V::splat(g);
        for (sum, b) in sums.iter_mut().zip(here) {
            *sum = sum.plus(V::load(b).times(g));
        }
    }
    for (sum, slot) in sums.into_iter().zip(c) {
        sum.store(slot);
    }
}
