//! One pass over slices: eight cells side by side.

use super::held::Contact;
use super::links::sliced::SlicedLinks;
use super::residual::Terms;
use super::term::Term;
use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{Chunks, ChunksMut};
use crate::backend::{Work, run};
use crate::number::cell::Cell;
use crate::number::two_float::{LANES, Lanes, TwoFloat};

/// What a pass sums over the cells beside their residuals, eight cells at a time.
pub(crate) trait Reduce {
    /// Adds the terms of a slice: where its cells are, and their residuals with contact cells
    /// driven.
    fn slice<V: F32x8>(&mut self, slice: usize, at: [V; 3], residual: [V; 4]);
}

/// The energy alone.
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

/// Contact cells, ascending, met slice by slice.
pub(crate) struct Contacts<'a> {
    contacts: &'a [Contact],
    /// Those before this one lie in earlier slices.
    next: usize,
}

impl<'a> Contacts<'a> {
    pub fn new(contacts: &'a [Contact]) -> Self {
        Self { contacts, next: 0 }
    }

    /// Which cells of a slice are contacts, where some are. Slices are to be asked for ascending.
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

/// The pass over slices, where unit and model allow it; whether they do. The states must lie
/// within K.
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
    terms.update(awake, at);
    let contacts = Contacts::new(contacts);
    run(terms.vectors, SlicedResidual { terms, links, awake, at, residual, contacts, reduce });
    true
}

/// A pass over the awake slices, and what it sums on the way.
pub(crate) struct SlicedResidual<'a, 'm, R> {
    pub terms: Terms<'a, 'm>,
    pub links: SlicedLinks<'a, 'm>,
    pub awake: &'a SliceSet,
    pub at: &'a [Cell],
    pub residual: &'a mut [Cell],
    pub contacts: Contacts<'a>,
    pub reduce: &'a mut R,
}

impl<R: Reduce> Work for SlicedResidual<'_, '_, R> {
    type Output = ();

    #[inline(always)]
    fn run<V: F32x8>(self) {
        let Self { terms, links, awake, at, residual, mut contacts, reduce } = self;
        let (cells, mut residual) = (Chunks::repeated(at), ChunksMut::new(residual));
        let (varied, even) = (links.differ(), links.even());
        for slice in awake.iter(terms.model.slice_count()) {
            let [x, y, z, _] = V::transposed(cells.at(slice));
            let here = [x, y, z];
            let mut sum = if varied {
                links.residual::<V, true>(slice, here, even)
            } else {
                links.residual::<V, false>(slice, here, even)
            };
            terms.model.others.slice(slice, at, &mut sum, &|cell| terms.states.at(cell));
            if let Some(contacts) = contacts.of_slice(slice) {
                drive(&mut sum, terms.current, contacts);
            }
            reduce.slice(slice, here, sum);
            V::put_transposed(sum, residual.at(slice));
        }
        residual.finish();
    }
}

/// Takes the residuals of contact cells out of a slice, or adds the current to them; lane by lane,
/// since few slices have any.
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
