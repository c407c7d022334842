//! Rotation of an elastic level's vectors into the rest shape, by the rotations of the cells, and back.

use crate::energy::residual::Terms;
use crate::model::coarse_basis::{CoarseBasis, ElasticLevel};
use crate::number::turn::{Turn, turned};
use crate::number::two_float::Eight;

/// Rotates the vectors of the basis functions, with x, y and z in separate arrays, by the rotations of their
/// cells, or back.
pub(crate) fn turn(
    terms: Terms<'_, '_>,
    basis: &CoarseBasis<'_>,
    vectors: &mut [Eight],
    back: bool,
) {
    let Some(ElasticLevel { turns, .. }) = basis.elastic() else { return };
    turn_each(terms, turns, basis.stride(), vectors, back);
}

/// Rotates vectors, with `stride` numbers for each axis, by the rotations of these cells, or back.
#[inline(always)]
pub(super) fn turn_each(
    terms: Terms<'_, '_>,
    cells: &[u16],
    stride: usize,
    vectors: &mut [Eight],
    back: bool,
) {
    let Some((x, rest)) = vectors.as_flattened_mut().split_at_mut_checked(stride) else { return };
    let Some((y, z)) = rest.split_at_mut_checked(stride) else { return };
    for (((x, y), z), &cell) in x.iter_mut().zip(y).zip(z).zip(cells) {
        [*x, *y, *z] = turned_by(terms, cell, [*x, *y, *z], back);
    }
}

/// Rotates a vector of a basis function by the rotation of its cell, or back.
pub(crate) fn turned_with(
    terms: Terms<'_, '_>,
    basis: &CoarseBasis<'_>,
    function: usize,
    v: [f32; 3],
    back: bool,
) -> [f32; 3] {
    let turns = basis.elastic().map_or(&[][..], |level| level.turns);
    let side = function.checked_sub(basis.stride());
    let of_side = side.and_then(|side| basis.sides()?.turns.get(side));
    turns.get(function).or(of_side).map_or(v, |&cell| turned_by(terms, cell, v, back))
}

#[inline(always)]
fn turned_by(terms: Terms<'_, '_>, cell: u16, v: [f32; 3], back: bool) -> [f32; 3] {
    let Some(turn) = terms.turn(cell.into()).map(Turn::of_unit) else { return v };
    turned(if back { turn.back() } else { turn }, v)
}
