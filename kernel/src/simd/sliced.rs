//! The link pass over slices: eight cells side by side, one neighbour of each at a time.
//!
//! Every lane does what `link::pull` does, in its order. A cell's terms are added in ascending
//! order of its neighbours, as the scalar pass adds them, and the pull that a cell feels from
//! below is exactly the opposite of what the scalar pass computes at the other end.

#![allow(unsafe_code)]

use super::octet::Octet;
use super::{Work, run};
use crate::awake::SliceSet;
use crate::cell::Cell;
use crate::contact::Contact;
use crate::link::{Band, COINCIDENT, Pull, RIM};
use crate::model::{Slices, range};
use crate::pass::Links;
use crate::slice::{eight, put_lanes};
use crate::two_float::{LANES, Lanes, TwoFloat};

/// What a pass sums over the cells beside their residuals, eight cells at a time.
pub(crate) trait Reduce {
    /// Adds the terms of a slice: where its cells are, and their residuals with contact cells driven.
    fn slice<V: Octet>(&mut self, slice: usize, at: [V; 3], residual: [V; 4]);
}

/// The energy alone.
#[derive(Default)]
pub(crate) struct Energy(Lanes);

impl Reduce for Energy {
    #[inline(always)]
    fn slice<V: Octet>(&mut self, _slice: usize, _at: [V; 3], [_, _, _, wd2]: [V; 4]) {
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
pub(crate) fn pass(
    links: Links<'_, '_>,
    awake: &SliceSet,
    at: &[Cell],
    residual: &mut [Cell],
    contacts: &[Contact],
    reduce: &mut impl Reduce,
) -> bool {
    let (Some(_), Some(slices)) = (links.vectors, links.model.slices) else { return false };
    let contacts = Contacts::new(contacts);
    run(links.vectors, SlicedPass { links, slices, awake, at, residual, contacts, reduce });
    true
}

/// A pass over the awake slices, and what it sums on the way.
pub(crate) struct SlicedPass<'a, 'm, R> {
    pub links: Links<'a, 'm>,
    pub slices: Slices<'m>,
    pub awake: &'a SliceSet,
    pub at: &'a [Cell],
    pub residual: &'a mut [Cell],
    pub contacts: Contacts<'a>,
    pub reduce: &'a mut R,
}

/// Bands and weights of eight links.
struct Law<V> {
    low: V,
    high: V,
    low_squared: V,
    high_squared: V,
    weight: Option<V>,
}

impl<V: Octet> Law<V> {
    /// One band for all, weight 1.
    #[inline(always)]
    fn uniform(band: Band) -> Self {
        Self {
            low: V::splat(band.low),
            high: V::splat(band.high),
            low_squared: V::splat(band.low_squared),
            high_squared: V::splat(band.high_squared),
            weight: None,
        }
    }

    /// The arithmetic of [`Band::new`].
    #[inline(always)]
    fn varied(alpha: V, weight: V) -> Self {
        let one = V::splat(1.0);
        let (low, high) = (one.minus(alpha), one.plus(alpha));
        Self {
            low,
            high,
            low_squared: low.times(low).times(V::splat(1.0 - RIM)),
            high_squared: high.times(high).times(V::splat(1.0 + RIM)),
            weight: Some(weight),
        }
    }
}

impl<R: Reduce> Work for SlicedPass<'_, '_, R> {
    type Output = ();

    #[inline(always)]
    fn run<V: Octet>(mut self) {
        let cells = self.links.model.cells();
        if self.at.len() != cells || self.residual.len() != cells {
            return;
        }
        let varied =
            self.slices.weights.is_some() || !self.links.closed && self.slices.alphas.is_some();
        for slice in self.awake.iter(self.links.model.slice_count()) {
            if varied {
                self.slice::<V, true>(slice);
            } else {
                self.slice::<V, false>(slice);
            }
        }
    }
}

impl<R: Reduce> SlicedPass<'_, '_, R> {
    #[inline(always)]
    fn slice<V: Octet, const VARIED: bool>(&mut self, slice: usize) {
        let mut buffer = [Cell::ZERO; LANES];
        let [x, y, z, _] = V::transposed(eight(self.at, slice, &mut buffer));
        let here = [x, y, z];
        let mut sum = [V::splat(0.0); 4];
        let mut void = V::splat(0.0).below(V::splat(0.0));
        let mut law = Law::uniform(Band::new(self.links.alpha(0)));
        for group in range(self.slices.rows, slice) {
            // SAFETY: the last row start is the number of groups; a model's slices name only its
            // cells, and `at` holds as many.
            let (there, l0) = unsafe {
                let ids = self.slices.neighbours.get_unchecked(group);
                (V::gather(self.at, ids), V::load(self.slices.lengths.get_unchecked(group)))
            };
            if VARIED {
                law = self.law(group);
            }
            add_links(&law, here, there, l0, &mut void, &mut sum);
        }
        if V::any(void) {
            sum = [V::splat(0.0); 4];
            for (sum, lanes) in sum.iter_mut().zip(&self.one_by_one(slice)) {
                *sum = V::load(lanes);
            }
        }
        if let Some(contacts) = self.contacts.of_slice(slice) {
            drive(&mut sum, self.links.current, contacts);
        }
        self.reduce.slice(slice, here, sum);
        put_lanes(self.residual, slice, sum);
    }

    /// Bands and weights of a group whose links differ.
    #[inline(always)]
    fn law<V: Octet>(&self, group: usize) -> Law<V> {
        let alpha = if self.links.closed {
            V::splat(0.0)
        } else {
            of_group(self.slices.alphas, group, self.links.model.alpha())
        };
        Law::varied(alpha, of_group(self.slices.weights, group, 1.0))
    }

    /// The sums of a slice with coincident cells, link after link.
    #[cold]
    #[inline(never)]
    fn one_by_one(&self, slice: usize) -> [[f32; LANES]; 4] {
        let mut lanes = [[0.0_f32; LANES]; 4];
        for lane in 0..LANES {
            let cell = slice * LANES + lane;
            for (link, other) in self.links.model.neighbours(cell) {
                let pull: Option<Pull> = self.links.pull_on(self.at, link, cell, other);
                let Some(Pull { force: [x, y, z], wd2 }) = pull else {
                    continue;
                };
                for (lanes, term) in lanes.iter_mut().zip([x, y, z, wd2]) {
                    if let Some(sum) = lanes.get_mut(lane) {
                        *sum += term;
                    }
                }
            }
        }
        lanes
    }
}

/// Takes the residuals of contact cells out of a slice, or adds the current to them; lane by lane,
/// since few slices have any.
#[inline(always)]
fn drive<V: Octet>(sum: &mut [V; 4], current: Option<[f32; 3]>, contacts: [bool; LANES]) {
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

/// The values of a group, or one for all where they are not stored.
#[inline(always)]
fn of_group<V: Octet>(values: Option<&[[f32; LANES]]>, group: usize, otherwise: f32) -> V {
    match values.and_then(|values| values.get(group)) {
        Some(values) => V::load(values),
        None => V::splat(otherwise),
    }
}

/// Adds the pulls of eight links to the sums. `void` becomes true in the lane of a link without a
/// direction of its own.
#[inline(always)]
fn add_links<V: Octet>(
    law: &Law<V>,
    here: [V; 3],
    there: [V; 3],
    l0: V,
    void: &mut V::Mask,
    sum: &mut [V; 4],
) {
    let dx = there[0].minus(here[0]);
    let dy = there[1].minus(here[1]);
    let dz = there[2].minus(here[2]);
    let u2 = dx.times(dx).plus(dy.times(dy)).plus(dz.times(dz));
    let l02 = l0.times(l0);
    let above = u2.above(l02.times(law.high_squared));
    let taut = V::either(above, u2.below(l02.times(law.low_squared)));
    if !V::any(taut) {
        return;
    }
    *void = V::either(*void, u2.below(l02.times(V::splat(COINCIDENT))));
    let u = u2.root();
    let d = u.minus(l0.times(V::select(above, law.high, law.low)));
    let wd = match law.weight {
        Some(weight) => weight.times(d),
        None => d,
    };
    let factor = wd.over(u.plus(u)).keep(taut);
    let [x, y, z, wd2] = sum;
    *x = x.plus(factor.times(dx));
    *y = y.plus(factor.times(dy));
    *z = z.plus(factor.times(dz));
    *wd2 = wd2.plus(wd.times(d).keep(taut));
}
