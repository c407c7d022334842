//! One pass over slices: eight cells side by side.

use core::ops::Range;

use super::held::Contact;
use super::links::sliced::SlicedLinks;
use super::residual::Terms;
use super::state::States;
use super::term::Term;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{Chunks, ChunksMut};
use crate::backend::{Work, run};
use crate::model::Model;
use crate::model::parts::{self, PARTS};
use crate::number::cell::Cell;
use crate::number::two_float::{LANES, Lanes, TwoFloat};

/// Sums that a pass computes in addition to the residuals, eight cells at a time.
pub(crate) trait Reduce {
    /// Adds the terms of a slice: its cells' positions, and their residuals with contact cells driven.
    fn slice<V: F32x8>(&mut self, slice: usize, at: [V; 3], residual: [V; 4]);
}

/// Only the energy.
#[derive(Default)]
pub(crate) struct Energy(Lanes);

impl Reduce for Energy {
    #[inline(always)]
    fn slice<V: F32x8>(&mut self, _slice: usize, _at: [V; 3], [_, _, _, wd2]: [V; 4]) {
        self.0.add(wd2);
    }
}

impl Energy {
    /// E in internal units.
    pub fn total(&self) -> TwoFloat {
        self.0.total().times_power_of_two(0.125)
    }
}

/// Contact cells, ascending, visited slice by slice.
#[derive(Clone, Copy)]
pub(crate) struct Contacts<'a> {
    contacts: &'a [Contact],
    /// The contacts before this one are in earlier slices.
    next: usize,
}

impl<'a> Contacts<'a> {
    pub fn new(contacts: &'a [Contact]) -> Self {
        Self { contacts, next: 0 }
    }

    /// Flags of the contact cells in a slice; `None` if there are none. Call it for ascending slices.
    #[inline(always)]
    pub fn of_slice(&mut self, slice: usize) -> Option<[bool; LANES]> {
        let (first, mut chosen, mut any) = (slice * LANES, [false; LANES], false);
        while let Some(contact) = self.contacts.get(self.next) {
            if contact.cell() >= first + LANES {
                break;
            }
            if let Some(lane) = chosen.get_mut(contact.cell().wrapping_sub(first)) {
                *lane = true;
                any = true;
            }
            self.next += 1;
        }
        any.then_some(chosen)
    }
}

/// The pass over slices. Returns false if unit or model do not support it. The states must be within K.
pub(crate) fn residual(
    terms: Terms<'_, '_>,
    awake: &SliceSet,
    at: &[Cell],
    residual: &mut [Cell],
    contacts: &[Contact],
    reduce: &mut impl Reduce,
) -> bool {
    let (Some(_), Some(links)) = (terms.vectors, SlicedLinks::of(terms.links(), at)) else {
        return false;
    };
    if terms.states.any() {
        run(terms.vectors, Update { terms, awake, at });
    }
    let (model, current, contacts) = (terms.model, terms.current, Contacts::new(contacts));
    let (slices, states) = (0..model.slice_count(), || terms.states);
    let pulls = terms.pulls(at);
    #[rustfmt::skip]
    let pass = SlicedResidual { model, current, links, awake, slices, at, residual, contacts, states, reduce, pulls };
    run(terms.vectors, pass);
    true
}

/// The same part by part, each with its own sums, for a body of several parts. If terms keep states, the
/// calling thread does all the work.
pub(crate) fn residual_in_parts(
    terms: Terms<'_, '_>,
    awake: &SliceSet,
    at: &[Cell],
    residual: &mut [Cell],
    contacts: &[Contact],
    sums: &mut [impl Reduce + Send; PARTS],
) -> bool {
    let (Some(_), Some(links)) = (terms.vectors, SlicedLinks::of(terms.links(), at)) else {
        return false;
    };
    let (model, current, contacts) = (terms.model, terms.current, Contacts::new(contacts));
    if !terms.states.any() {
        // The tools' contribution goes through the residuals: threads share no other memory.
        terms.pull_into(awake, at, residual);
    }
    // Terms with states: the calling thread runs the parts in turn.
    let mut each = parts::split_mut(residual).into_iter().zip(sums).enumerate();
    if terms.states.any() {
        run(terms.vectors, Update { terms, awake, at });
        let states = || terms.states;
        let pulls = terms.pulls(at);
        for (part, (residual, reduce)) in each {
            let slices = parts::slices(model.cells(), part);
            #[rustfmt::skip]
            let pass = SlicedResidual { model, current, links, awake, slices, at, residual, contacts, states, reduce, pulls };
            run(terms.vectors, pass);
        }
        return true;
    }
    // Otherwise the team runs the parts.
    let pulled = terms.touch.get().map(|touching| touching.slices);
    let states = || States::NONE;
    let pulls = |slice, own: &Chunk| pulled?.contains(slice).then_some(*own);
    let passes = [(); PARTS].map(|()| {
        let (part, (residual, reduce)) = each.next()?;
        let slices = parts::slices(model.cells(), part);
        #[rustfmt::skip]
        let pass = SlicedResidual { model, current, links, awake, slices, at, residual, contacts, states, reduce, pulls };
        Some(pass)
    });
    terms.team.run(terms.vectors, passes);
    true
}

/// Updates the terms' states of the cells in awake slices to their positions.
struct Update<'a, 'm> {
    terms: Terms<'a, 'm>,
    awake: &'a SliceSet,
    at: &'a [Cell],
}

impl Work for Update<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Terms { model, states, .. } = self.terms;
        let (cells, quads) = (Chunks::new(self.at, Cell::ZERO), states.all().quads());
        for slice in self.awake.iter(model.slice_count()) {
            model.others.displace(slice, cells.at(slice), quads);
        }
        for slice in self.awake.iter(model.slice_count()) {
            if let Some([from, to]) = states.step(slice) {
                model.others.update_slice::<V>(slice, self.at, from, to);
            }
        }
    }
}

/// A pass over the awake slices of a range, with its sums.
pub(crate) struct SlicedResidual<'a, 'm, R, S, P> {
    pub model: &'a Model<'m>,
    pub current: Option<[f32; 3]>,
    pub links: SlicedLinks<'a, 'm>,
    pub awake: &'a SliceSet,
    /// A part of the body.
    pub slices: Range<usize>,
    pub at: &'a [Cell],
    /// Residuals of the cells in these slices.
    pub residual: &'a mut [Cell],
    pub contacts: Contacts<'a>,
    /// Returns the terms' states of the cells. A function, since threads share no states.
    pub states: S,
    pub reduce: &'a mut R,
    /// The tools' contribution to the residuals of a slice, from the slice's residuals before the pass.
    pub pulls: P,
}

impl<'a, R: Reduce, S: Fn() -> States<'a>, P: Fn(usize, &Chunk) -> Option<Chunk>> Work
    for SlicedResidual<'a, '_, R, S, P>
{
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Self { links, at, mut contacts, reduce, pulls, .. } = self;
        let states = (self.states)().all();
        let (cells, mut residual) = (Chunks::repeated(at), ChunksMut::new(self.residual));
        let (varied, even) = (links.differ(), links.even());
        let first = self.slices.start;
        for slice in self.awake.iter_in(self.slices) {
            let [x, y, z, _] = V::transposed(cells.at(slice));
            let here = [x, y, z];
            // Links, other terms, tools and contacts, in this order.
            let mut sum = if self.model.is_nodal() {
                [V::splat(0.0); 4]
            } else if varied {
                links.residual::<V, true>(slice, here, even)
            } else {
                links.residual::<V, false>(slice, here, even)
            };
            self.model.others.slice(slice, at, &mut sum, states);
            if let Some(pulls) = pulls(slice, residual.at(slice - first)) {
                let [x, y, z, w] = V::transposed(&pulls);
                let [a, b, c, d] = sum;
                sum = [a.plus(x), b.plus(y), c.plus(z), d.plus(w)];
            }
            if let Some(contacts) = contacts.of_slice(slice) {
                drive(&mut sum, self.current, contacts);
            }
            reduce.slice(slice, here, sum);
            V::put_transposed(sum, residual.at(slice - first));
        }
        residual.finish();
    }
}

/// Clears the residuals of contact cells in a slice, or adds the current to them; lane by lane, since few
/// slices have any.
#[inline(always)]
fn drive<V: F32x8>(sum: &mut [V; 4], current: Option<[f32; 3]>, contacts: [bool; LANES]) {
    for (sum, current) in sum.iter_mut().zip(match current {
        Some(current) => current.map(Some),
        None => [None; 3],
    }) {
        let mut lanes = [0.0; LANES];
        sum.store(&mut lanes);
        for (lane, _) in lanes.iter_mut().zip(contacts).filter(|(_, contact)| *contact) {
            *lane = current.map_or(0.0, |current| *lane + current);
        }
        *sum = V::load(&lanes);
    }
}
