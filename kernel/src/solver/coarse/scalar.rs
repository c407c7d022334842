//! The loops between cells and basis functions, cell by cell: restriction and the coarse update.
//!
//! Basis functions are summed as over pairs of cells: the first cells of the pairs, then the second ones,
//! then both together. The eight basis functions of a box, or their sums, stay in registers.

use super::sides;
use crate::energy::residual::Terms;
use crate::model::coarse_basis::{CoarseBasis, weights};
use crate::model::image::NO_FUNCTION;
use crate::model::range;
use crate::number::cell::{Cell, add, scale, sub};
use crate::number::two_float::{Eight, LANES};
use crate::solver::loops::Points;
use crate::solver::loops::scalar::Range;
use crate::solver::loops::scalar::track::factor;

/// One value per corner of a box and axis.
type Corners = [[f32; 3]; LANES];

/// Sums of w r over the first or the second cells of a box's pairs.
#[inline(always)]
fn sums(cells: &[[u16; 2]], of: &[[Eight; 2]], second: bool, residual: &[Cell]) -> Corners {
    let mut sums = [[0.0; 3]; LANES];
    for (&[one, other], pair) in cells.iter().zip(of) {
        let cell = usize::from(if second { other } else { one });
        let Some(r) = residual.get(cell).map(|r| r.xyz()) else { continue };
        for (sum, weight) in sums.iter_mut().zip(weights(pair, second)) {
            *sum = add(*sum, scale(weight, r));
        }
    }
    sums
}

/// P' r of the masked residuals, into the first three vectors of the coarse memory.
pub(crate) fn restrict(basis: &CoarseBasis<'_>, residual: &[Cell], room: &mut [Eight]) {
    let stride = basis.stride();
    let Some(vectors) = room.get_mut(..3 * basis.blocks()) else { return };
    vectors.fill([0.0; LANES]);
    let flat = vectors.as_flattened_mut();
    for (at_box, corners) in basis.corners.iter().enumerate() {
        let pairs = range(basis.rows, at_box);
        let cells = basis.cells.get(pairs.clone()).unwrap_or(&[]);
        let weights = basis.weights.get(pairs).unwrap_or(&[]);
        let first = sums(cells, weights, false, residual);
        let second = sums(cells, weights, true, residual);
        for ((&function, a), b) in corners.iter().zip(first).zip(second) {
            if function == NO_FUNCTION {
                continue;
            }
            for (axis, term) in add(a, b).into_iter().enumerate() {
                if let Some(slot) = flat.get_mut(axis * stride + usize::from(function)) {
                    *slot += term;
                }
            }
        }
    }
    sides::restrict(basis, residual, room);
}

/// The coarse direction: a function for its values at the basis functions.
#[inline(always)]
pub(super) fn direction<'a>(
    basis: &CoarseBasis<'_>,
    room: &'a [Eight],
) -> impl Fn(usize) -> [f32; 3] + 'a {
    let stride = basis.stride();
    let c = room.get(3 * basis.blocks()..6 * basis.blocks()).unwrap_or(&[]).as_flattened();
    move |function| [0, 1, 2].map(|axis| c.get(axis * stride + function).copied().unwrap_or(0.0))
}

/// The coarse direction at the corners of a box.
#[inline(always)]
fn corners(basis: &CoarseBasis<'_>, room: &[Eight], at_box: usize) -> Corners {
    let value = direction(basis, room);
    match basis.corners.get(at_box) {
        Some(corners) => corners.map(|function| match function {
            NO_FUNCTION => [0.0; 3],
            function => value(usize::from(function)),
        }),
        None => [[0.0; 3]; LANES],
    }
}

/// The coarse direction at one cell.
pub(crate) fn at_cell(basis: &CoarseBasis<'_>, room: &[Eight], cell: usize) -> [f32; 3] {
    let value = direction(basis, room);
    let coarse_functions = basis.row_of(cell);
    let along = coarse_functions
        .fold([0.0; 3], |sum, (function, weight)| add(sum, scale(weight, value(function))));
    if basis.sides().is_some() { add(along, sides::at_cell(basis, room, cell)) } else { along }
}

/// Updates all free cells with the coarse direction. Returns true if some coordinate is beyond K.
pub(crate) fn step(
    terms: Terms<'_, '_>,
    basis: &CoarseBasis<'_>,
    room: &[Eight],
    points: &mut Points<'_, f32>,
    factors: [f32; 2],
) -> bool {
    let linear = Range::new(terms.model.saturation());
    // Arrays of one length, so that a cell is looked up in all of them or in none.
    let mobility = terms.mobility();
    let cells = mobility.len();
    let (Some(published), Some(at), Some(before), Some(residual)) = (
        points.published.get_mut(..cells),
        points.at.get_mut(..cells),
        points.before.get_mut(..cells),
        points.residual.get(..cells),
    ) else {
        return false;
    };
    let local = basis.elastic().and_then(|_| terms.factors().get(..cells));
    let is_elastic = basis.elastic().is_some();
    let mut arrays = Arrays { published, at, before, residual, mobility, local, is_elastic };
    let mut beyond = false;
    for at_box in 0..basis.corners.len() {
        let corners = corners(basis, room, at_box);
        let pairs = range(basis.rows, at_box);
        let cells = basis.cells.get(pairs.clone()).unwrap_or(&[]);
        let of = basis.weights.get(pairs).unwrap_or(&[]);
        for (&[one, other], pair) in cells.iter().zip(of) {
            // A box with an odd number of cells lists its last one twice, once without weights.
            let coarse = along(&corners, weights(pair, true));
            beyond |= arrays.update(other, coarse, factors, &linear, other != one);
            let coarse = along(&corners, weights(pair, false));
            beyond |= arrays.update(one, coarse, factors, &linear, true);
        }
    }
    beyond | step_sides(basis, room, points, factors[0], terms.model.saturation())
}

/// Moves the extrapolated points of the cells under the two-sided functions by alpha times their direction. Returns
/// true if some coordinate is beyond K.
pub(super) fn step_sides(
    basis: &CoarseBasis<'_>,
    room: &[Eight],
    points: &mut Points<'_, f32>,
    alpha: f32,
    k: f32,
) -> bool {
    let (Some(sides), linear) = (basis.sides(), Range::new(k)) else { return false };
    let mut beyond = false;
    for &cell in sides.cells {
        let way = sides::at_cell(basis, room, cell.into());
        if let Some(at) = points.at.get_mut(usize::from(cell)) {
            let ahead = add(at.xyz(), scale(alpha, way));
            *at = Cell::at(ahead);
            beyond |= linear.is_left(ahead, ahead);
        }
    }
    beyond
}

/// Arrays of an update, with an element for each cell.
struct Arrays<'a> {
    published: &'a mut [Cell],
    at: &'a mut [Cell],
    before: &'a mut [Cell],
    residual: &'a [Cell],
    mobility: &'a [f32],
    /// The local part of the direction over r / W, if it is another one than 1.
    local: Option<&'a [f32]>,
    is_elastic: bool,
}

impl Arrays<'_> {
    /// Updates a cell if `is_stored`. Returns true if some coordinate of the new points is beyond K.
    #[inline(always)]
    fn update(
        &mut self,
        id: u16,
        coarse: [f32; 3],
        factors: [f32; 2],
        linear: &Range<f32>,
        is_stored: bool,
    ) -> bool {
        let ([alpha, beta], cell) = (factors, usize::from(id));
        let (Some(published), Some(at), Some(before), Some(r), Some(&mobility)) = (
            self.published.get_mut(cell),
            self.at.get_mut(cell),
            self.before.get_mut(cell),
            self.residual.get(cell),
            self.mobility.get(cell),
        ) else {
            return false;
        };
        let (y, last) = (at.xyz(), before.xyz());
        let sure = scale(mobility, r.xyz());
        let own = self.local.map_or(sure, |local| scale(factor(local, cell), sure));
        let z = add(own, coarse);
        let next = add(y, if self.is_elastic { sure } else { z });
        let ahead = add(add(y, scale(alpha, z)), scale(beta, sub(y, last)));
        if is_stored {
            *before = Cell::at(y);
            *published = Cell::at(next);
            *at = Cell::at(ahead);
        }
        linear.is_left(next, ahead)
    }
}

/// The coarse direction at a cell, summed over the corners in their order.
#[inline(always)]
fn along(corners: &Corners, weights: [f32; LANES]) -> [f32; 3] {
    let ([a, b, c, d, e, f, g, h], [p, q, r, s, t, u, v, w]) = (*corners, weights);
    let sum = add(add(scale(p, a), scale(q, b)), scale(r, c));
    let sum = add(add(sum, scale(s, d)), scale(t, e));
    add(add(add(sum, scale(u, f)), scale(v, g)), scale(w, h))
}
