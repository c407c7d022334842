//! The two-sided functions of a body that is cut, in the coarse level of nodal shapes.
//!
//! Their vectors g, c and the last g follow the three of the level in the coarse memory. A kernel without cuts has
//! none of this.
//!
//! Cost with m functions, of n in the level: 18 m (n + m) multiplications a sweep, and 48 for each cell under them.

use super::solve::{along, inner, total};
use super::turns::turn_each;
use crate::backend::f32x8::F32x8;
use crate::energy::residual::Terms;
use crate::model::coarse_basis::CoarseBasis;
use crate::number::cell::{Cell, add, scale};
use crate::number::two_float::{Eight, LANES};

/// The vectors over the two-sided functions: g, c and the last g, x of all functions first, then y and z.
fn vectors<'a>(basis: &CoarseBasis<'_>, room: &'a mut [Eight]) -> Option<[&'a mut [Eight]; 3]> {
    let (first, blocks) = (3 * basis.row_blocks(), basis.side_blocks());
    let all = room.get_mut(first..first + 3 * blocks)?;
    let (g, rest) = all.split_at_mut_checked(blocks)?;
    let (c, last) = rest.split_at_mut_checked(blocks)?;
    Some([g, c, last])
}

/// P' r over the two-sided functions, into the coarse memory.
pub(super) fn restrict(basis: &CoarseBasis<'_>, residual: &[Cell], room: &mut [Eight]) {
    let (Some(sides), Some([g, ..])) = (basis.sides(), vectors(basis, room)) else { return };
    let (first, stride) = (basis.stride(), sides.blocks * LANES);
    g.fill([0.0; LANES]);
    let flat = g.as_flattened_mut();
    for &cell in sides.cells {
        let r = residual.get(usize::from(cell)).map_or([0.0; 3], |r| r.xyz());
        for (function, weight) in basis.sides_of(cell.into()) {
            for (axis, term) in scale(weight, r).into_iter().enumerate() {
                if let Some(slot) = flat.get_mut(axis * stride + function - first) {
                    *slot += term;
                }
            }
        }
    }
}

/// Rotates g by the rotations of the functions' cells back to the rest shape, or c forward.
pub(crate) fn turn(terms: Terms<'_, '_>, basis: &CoarseBasis<'_>, room: &mut [Eight], back: bool) {
    let (Some(sides), Some([g, c, _])) = (basis.sides(), vectors(basis, room)) else { return };
    turn_each(terms, sides.turns, sides.blocks * LANES, if back { g } else { c }, back);
}

/// c += Y Y' g, over the basis functions of the image and then over the two-sided ones; there c is Y Y' g.
#[inline(always)]
pub(crate) fn add_to<V: F32x8>(
    basis: &CoarseBasis<'_>,
    g: &[Eight],
    of_sides: &[Eight],
    c: &mut [Eight],
    to_sides: &mut [Eight],
) {
    to_sides.fill([0.0; LANES]);
    let blocks = basis.row_blocks();
    for column in basis.columns() {
        let Some((own, of)) = column.split_at_checked(blocks) else { return };
        let sum = total(inner::<V>(inner::<V>(V::splat(0.0), own, g), of, of_sides));
        along::<V>(own, sum, c);
        along::<V>(of, sum, to_sides);
    }
}

/// The part of the coarse direction of a cell that comes from its two-sided functions.
#[inline(always)]
pub(super) fn at_cell(basis: &CoarseBasis<'_>, room: &[Eight], cell: usize) -> [f32; 3] {
    let Some(sides) = basis.sides() else { return [0.0; 3] };
    let (first, blocks) = (3 * basis.row_blocks() + basis.side_blocks(), basis.side_blocks());
    let c = room.get(first..first + blocks).unwrap_or(&[]).as_flattened();
    let (own, stride) = (basis.stride(), sides.blocks * LANES);
    basis.sides_of(cell).fold([0.0; 3], |way, (function, weight)| {
        let at = |axis: usize| c.get(axis * stride + function - own).copied().unwrap_or(0.0);
        add(way, scale(weight, [0, 1, 2].map(at)))
    })
}

/// Index of a function's value on an axis in a vector over all functions, the two-sided ones last.
#[inline(always)]
pub(crate) fn place(basis: &CoarseBasis<'_>, function: usize, axis: usize) -> usize {
    let stride = basis.stride();
    match function.checked_sub(stride) {
        None => axis * stride + function,
        Some(side) => 3 * stride + axis * basis.side_blocks() / 3 * LANES + side,
    }
}
