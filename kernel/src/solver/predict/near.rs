//! Balances the cells under the tools before the pass of a tick in which tools moved.
//!
//! A pass publishes its own point; what it finds out moves the point of the next one. So a tool that moves
//! loads the few cells under it a tick before they can give way, and with one sweep a tick the hand feels
//! that. The extrapolation ([`momentum`](super::momentum)) foresees what repeats, but not a new contact or a
//! tool that turns back. Here the cells of the slices in contact give way before the pass, by
//!
//! ```text
//! d_k = a_k z + b d_k-1,    p += d_k
//! ```
//!
//! with z the local part of a direction at p, and fixed a and b. The rest of the body stays where it is. The
//! stress of its neighbours changes with these cells, so their states are updated too. No proof depends on the
//! result, since the guard judges the pass at the new point like any other.
//!
//! Cost: [`PASSES`] passes over those slices, at most two thirds of a pass over the body. A tool that is
//! larger for its body pays nothing and gains nothing: a second sweep does more there for the same time.
//! Threads share the states in these passes: each part of a large body has as many of those slices.

use super::{ARRAYS, TRACK};
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{cells_of, clear};
use crate::energy::residual::Terms;
use crate::energy::sliced;
use crate::energy::surface::Touching;
use crate::model::Model;
use crate::number::cell::{Cell, add, peak, scale};
use crate::number::two_float::LANES;
use crate::solver::awake::{Awake, insert_around};
use crate::solver::loops::Loops;
use crate::solver::loops::scalar::track::factor;
use crate::solver::scheme::Body;

/// Passes over the slices under tools: after fewer, what they moved is on its way.
const PASSES: usize = 4;
/// a in the first pass and in later ones, and b, on nodal shapes.
const FIRST: f32 = 0.3;
const LATER: f32 = 0.5;
const ONWARD: f32 = 0.5;
/// a on links over that on nodal shapes: r / W is a shorter step than a local part.
const OF_LINKS: f32 = 2.0;

/// Moves the points of the next pass and of the last one at the cells under the tools. The last field is
/// memory for d. Returns true if some coordinate is beyond K.
#[inline(never)]
pub(super) fn balance(body: &mut Body<'_, '_>, own: &mut [Cell]) -> bool {
    let Some(&touching) = body.terms.touch.get() else { return false };
    let (model, cells) = (body.terms.model, body.state.len());
    if own.len() != ARRAYS * cells {
        return false;
    }
    let Some((points, fields)) = own.split_at_mut_checked(TRACK * cells) else { return false };
    let Some((at, before)) = points.split_at_mut_checked(cells) else { return false };
    let Some((_, ways)) = fields.split_at_mut_checked(2 * cells) else { return false };
    // Choose the slices, in the body's own sets, since all slices are awake. Too many are not worth their
    // passes.
    let slices = model.slice_count();
    let Awake { set: core, spread: around, .. } = &mut *body.awake;
    in_contact(&Touching { pins: &[], ..touching }, slices, at, core);
    with_neighbours(model, core, around);
    let count = around.iter(slices).count();
    if count == 0 || 3 * PASSES * count > 2 * slices {
        body.awake.wake_all(model);
        return false;
    }
    clear(ways, core.iter(slices));
    // Move the cells; the terms' states of the last pass come back afterwards.
    body.terms.states.save(around, slices);
    sliced::displace(body.terms, at);
    let (mobility, factors) = (body.terms.mobility(), body.terms.factors());
    let unit = if model.is_nodal() { 1.0 } else { OF_LINKS };
    let mut highest = 0.0;
    let states = body.terms.states.divided(around.iter(slices), count);
    let terms = Terms { states, ..body.terms };
    for pass in 0..PASSES {
        f32::residual(terms, around, core, at, body.residual);
        let (a, b) = if pass == 0 { (unit * FIRST, 0.0) } else { (unit * LATER, ONWARD) };
        let residual = &*body.residual;
        let mut step = Step { at, before, ways, residual, mobility, factors, a, b };
        for cell in core.iter(slices).flat_map(|slice| cells_of(slice, cells)) {
            let here = step.go(cell);
            highest = if here > highest { here } else { highest };
        }
    }
    body.terms.states.restore(around, slices);
    body.awake.wake_all(model);
    highest > model.saturation()
}

/// Sets `set` to the slices with a cell that a tool pushes or pulls.
fn in_contact(touching: &Touching<'_>, slices: usize, at: &[Cell], set: &mut SliceSet) {
    touching.pull(&|cell: usize| at.get(cell).map_or([0.0; 3], |at| at.xyz()));
    *set = SliceSet::EMPTY;
    for slice in touching.slices.iter(slices) {
        if touching.of_slice(slice).is_some_and(|pulls| pulls != [Cell::ZERO; LANES]) {
            set.insert(slice);
        }
    }
}

/// Sets `set` to these slices, and those with a neighbour of one of their cells.
fn with_neighbours(model: &Model<'_>, core: &SliceSet, set: &mut SliceSet) {
    *set = *core;
    let slices = core.iter(model.slice_count());
    for cell in slices.flat_map(|slice| cells_of(slice, model.cells())) {
        insert_around(set, model, cell);
    }
}

/// The arrays of a pass, and its factors a and b.
struct Step<'a> {
    at: &'a mut [Cell],
    before: &'a mut [Cell],
    ways: &'a mut [Cell],
    residual: &'a [Cell],
    mobility: &'a [f32],
    factors: &'a [f32],
    a: f32,
    b: f32,
}

impl Step<'_> {
    /// Moves a cell. Returns its largest coordinate.
    fn go(&mut self, cell: usize) -> f32 {
        let (Some(at), Some(before), Some(way), Some(r), Some(&mobility)) = (
            self.at.get_mut(cell),
            self.before.get_mut(cell),
            self.ways.get_mut(cell),
            self.residual.get(cell),
            self.mobility.get(cell),
        ) else {
            return 0.0;
        };
        let z = scale(factor(self.factors, cell) * mobility, r.xyz());
        let d = add(scale(self.a, z), scale(self.b, way.xyz()));
        *way = Cell::at(d);
        *at = Cell::at(add(at.xyz(), d));
        *before = Cell::at(add(before.xyz(), d));
        peak(at.xyz())
    }
}
