//! Contact by shape: a sphere, the paper's virtual haptic probe (its Fig. 6).
//!
//! While engaged the sphere's centre follows the tool, starting at the tool's position. In each tick the
//! contacts are
//!
//! - the surface cells inside the sphere, and
//! - the contacts of the last tick that the links hold against it: those on the sphere which their links do
//!   not pull away from the centre, and those beyond it which they pull towards it strongly enough to bring
//!   them there.
//!
//! They are moved onto the sphere radially but within K, a cell at the centre along its normal at rest, and
//! held there during the sweeps. Fixed cells and cells without links are not moved. Beyond the capacity the
//! lowest ids are kept.
//!
//! A contact sticks where it touches: there is no sliding along the sphere. A cell that leaves the
//! contact drops its tangential force within a tick.
//!
//! **No chatter.** A distance is known only up to its rounding, [`GRAIN`]: a cell that near to the sphere is
//! on it, neither inside nor beyond, and is not moved. So a tool at rest moves no cell, and a released cell
//! becomes a contact again only when it really enters.
//!
//! **No drag.** A contact at a distance b beyond the sphere is brought back to it only if b <= 2 f / W, with
//! f its links' pull towards the centre and W their weight: then the moves of all contacts together change
//! the energy by at most the sum of `W_i` `b_i`^2 / 2 - `f_i` `b_i` <= 0. So a tool that leaves, however
//! fast, draws no cell along.
//!
//! **Energy.** The moves `D_i` of a tick raise sqrt(E) by at most half the root of the sum of w |`D_i` -
//! `D_j`|^2 over the links. If that may exceed the model's largest energy, and the energy does rise, all
//! moves are shortened by the same factor.
//!
//! **Engaged in contact or inside the body** the sphere starts as [`begin`](crate::tick::begin) describes:
//! these rules hold for the sphere at its present size.
//!
//! **Late ticks.** Without a sweep no contact is released and none is brought back: contacts inside the
//! sphere are pushed out, those beyond it stay. Other cells are searched for after the centre has moved an
//! eighth of the radius since the last search, so a tool that plunges in takes the surface along.
//!
//! Cost per tick while engaged: one look at each surface cell; the links of the contacts, at most six times;
//! at most contacts^2 / 2 slots moved when cells enter. A late tick without a search costs the links of the
//! contacts, at most four times.

use super::held::Contact;
use super::links::number::LinkNumber;
use super::residual::Terms;
use super::term::Term;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{Cell, add, dot, output, peak, scale, single, sub};
use crate::number::sqrt::sqrt;

/// Rounding of a distance, relative to the size of its coordinates.
const GRAIN: f32 = 4.0 * f32::EPSILON;

/// The sphere in a tick [mean link lengths].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sphere {
    pub centre: [f32; 3],
    pub radius: f32,
    /// Cells this near to the sphere's surface are on it.
    pub grain: f32,
    /// True in a late tick: cells beyond the sphere stay where they are.
    pub only_pushes: bool,
}

impl Sphere {
    pub(crate) fn new(centre: [f32; 3], radius: f32) -> Self {
        Self { centre, radius, grain: GRAIN * (peak(centre) + radius), only_pushes: false }
    }

    /// The distance of a point from the centre.
    pub(crate) fn distance(&self, at: [f32; 3]) -> f32 {
        let way = sub(at, self.centre);
        sqrt(dot(way, way))
    }

    /// The vector from the centre, and its length less the radius.
    fn beyond(&self, at: [f32; 3]) -> ([f32; 3], f32) {
        (sub(at, self.centre), self.distance(at) - self.radius)
    }

    pub(crate) fn is_inside(&self, at: [f32; 3]) -> bool {
        self.beyond(at).1 < -self.grain
    }

    /// Returns true if a contact at `at`, which its links pull by `force`, stays one; `mobility` = 1 / W.
    pub(crate) fn keeps(&self, at: [f32; 3], force: [f32; 3], mobility: f32) -> bool {
        let (way, beyond) = self.beyond(at);
        let outward = dot(force, way);
        if beyond > self.grain {
            return beyond * (beyond + self.radius) <= -2.0 * mobility * outward;
        }
        beyond < -self.grain || outward <= 0.0
    }

    /// New position of a cell; `None` if it stays, as a cell on the sphere does.
    pub(crate) fn place(
        &self,
        at: [f32; 3],
        normal: impl FnOnce() -> [f32; 3],
    ) -> Option<[f32; 3]> {
        let (way, beyond) = self.beyond(at);
        if beyond.abs() <= self.grain || self.only_pushes && beyond > 0.0 {
            return None;
        }
        let distance = sqrt(dot(way, way));
        let out = if distance > self.grain {
            scale(self.radius / distance, way)
        } else {
            scale(self.radius, normal())
        };
        Some(add(self.centre, out))
    }
}

/// Outward normal of a surface cell at rest.
pub(crate) fn normal(model: &Model<'_>, cell: usize) -> [f32; 3] {
    let at = u16::try_from(cell).ok().and_then(|cell| model.surface.binary_search(&cell).ok());
    at.and_then(|at| model.normals.get(at)).copied().unwrap_or([0.0, 0.0, 1.0])
}

/// The residual of a cell, in single precision.
pub(crate) fn residual<N: LinkNumber>(
    terms: Terms<'_, '_>,
    v: &[Cell<N>],
    cell: usize,
) -> [f32; 3] {
    let links = terms.links();
    let forces = links.model.neighbours(cell).filter_map(|(link, other)| {
        let on = links.force_on(v, link, cell, other)?;
        Some(on.force)
    });
    let mut sum = forces.fold([0.0; 3], add);
    let (at, state) = (|cell| links.published(v, cell), |cell| terms.states.at(cell));
    terms.model.others.cell(cell, &at, &state, &mut |of| sum = add(sum, of));
    sum
}

/// The contacts, ascending, in slots; the first `count` are taken.
pub(crate) struct Contacts<'a, N> {
    pub slots: &'a mut [Contact<N>],
    pub count: usize,
    /// True if a cell was released or added.
    pub changed: bool,
    /// True if some cell found no slot.
    pub full: bool,
}

impl<N: Number> Contacts<'_, N> {
    /// Releases the contacts for which `keeps` is false.
    pub(crate) fn retain(&mut self, keeps: impl Fn(usize) -> bool) {
        let before = self.count;
        self.count = 0;
        for at in 0..before {
            let Some(&contact) = self.slots.get(at) else { break };
            if keeps(contact.cell())
                && let Some(slot) = self.slots.get_mut(self.count)
            {
                *slot = contact;
                self.count += 1;
            }
        }
        self.changed |= self.count < before;
    }

    /// Adds a cell; beyond the capacity the highest id is dropped.
    pub(crate) fn insert(&mut self, id: u16) {
        let taken = self.slots.get(..self.count).unwrap_or(&[]);
        let Err(at) = taken.binary_search_by_key(&usize::from(id), Contact::cell) else { return };
        self.full |= self.count == self.slots.len();
        if at == self.slots.len() {
            return;
        }
        self.count = (self.count + 1).min(self.slots.len());
        self.changed = true;
        let mut carried = Contact::new(id);
        for slot in self.slots.iter_mut().take(self.count).skip(at) {
            core::mem::swap(slot, &mut carried);
        }
    }
}

/// Sum of w |`D_i` - `D_j`|^2 over the links of the contacts, each link once, and of w |`D_i`|^2 over the
/// other terms; D are the displacements of the contacts from their origins.
pub(crate) fn spread<N: Number>(model: &Model<'_>, v: &[Cell<N>], held: &[Contact<N>]) -> f32 {
    let k = N::from_single(model.saturation());
    let way = |contact: &Contact<N>| {
        let here = v.get(contact.cell()).map(|v| output(v.xyz(), k));
        here.map_or([0.0; 3], |here| single(sub(here, contact.origin)))
    };
    let mut sum = 0.0;
    for contact in held {
        let own = way(contact);
        for (link, other) in model.neighbours(contact.cell()) {
            let at = held.binary_search_by_key(&other, Contact::cell).ok();
            let theirs = at.and_then(|at| held.get(at)).map(way);
            if theirs.is_none() || other > contact.cell() {
                let apart = sub(own, theirs.unwrap_or([0.0; 3]));
                sum += model.link_weight(link) * dot(apart, apart);
            }
        }
        sum = model.others.add_move(contact.cell(), dot(own, own), sum);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    const BALL: [f32; 3] = [10.0, -4.0, 0.0];

    fn sphere() -> Sphere {
        Sphere::new(BALL, 2.0)
    }

    #[test]
    fn a_cell_goes_out_along_its_radius_or_its_normal() {
        let up = || [0.0, 0.0, 1.0];
        assert_eq!(sphere().place([10.0, -3.5, 0.0], up), Some([10.0, -2.0, 0.0]));
        assert_eq!(sphere().place([10.0, -9.0, 0.0], up), Some([10.0, -6.0, 0.0]));
        for centre in [BALL, [10.0, -4.0, 1e-7]] {
            assert_eq!(sphere().place(centre, up), Some([10.0, -4.0, 2.0]));
        }
        for near in [2.0, 2.000_001, 1.999_999] {
            assert_eq!(sphere().place([10.0, -4.0, near], up), None);
        }
    }

    #[test]
    fn a_sphere_that_only_pushes_brings_no_cell_back() {
        let sphere = Sphere { only_pushes: true, ..sphere() };
        let up = || [0.0, 0.0, 1.0];
        assert_eq!(sphere.place([10.0, -3.5, 0.0], up), Some([10.0, -2.0, 0.0]));
        assert_eq!(sphere.place([10.0, -9.0, 0.0], up), None);
    }

    // REQ-FOR-06
    #[test]
    fn a_contact_stays_while_it_is_pressed_on() {
        let (inwards, outwards) = ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
        let keeps = |z: f32, force| sphere().keeps([10.0, -4.0, z], force, 0.3);
        assert!(keeps(1.0, outwards) && keeps(2.0, inwards) && keeps(2.5, inwards));
        assert!(!keeps(2.0, outwards) && !keeps(2.5, outwards));
        // It may be drawn by twice 0.3 of the force.
        assert!(keeps(2.59, inwards) && !keeps(2.61, inwards));
        // No force: a contact on the sphere stays, one that would have to be dragged does not.
        assert!(keeps(2.0, [0.0; 3]) && !keeps(2.5, [0.0; 3]));
        // On the sphere within rounding is not inside.
        assert!(!keeps(1.999_999, outwards) && !sphere().is_inside([10.0, -4.0, 1.999_999]));
    }

    // REQ-CON-04
    #[test]
    fn the_lowest_ids_get_the_slots() {
        let mut slots = vec![Contact::<f32>::NONE; 3];
        let mut contacts = Contacts { slots: &mut slots, count: 0, changed: false, full: false };
        for (id, expected, full) in [
            (20_u16, &[20][..], false),
            (10, &[10, 20], false),
            (10, &[10, 20], false),
            (30, &[10, 20, 30], false),
            (40, &[10, 20, 30], true),
            (15, &[10, 15, 20], true),
        ] {
            contacts.changed = false;
            let before: Vec<usize> = contacts.slots.iter().map(Contact::cell).collect();
            contacts.insert(id);
            let after: Vec<usize> = contacts.slots.iter().map(Contact::cell).collect();
            assert_eq!(after[..contacts.count], *expected);
            assert_eq!((contacts.full, contacts.changed), (full, after != before));
        }
        contacts.changed = false;
        contacts.retain(|_| true);
        assert!(!contacts.changed);
        contacts.retain(|cell| cell != 15);
        assert!(contacts.changed && contacts.count == 2);
        assert_eq!(contacts.slots[..2].iter().map(Contact::cell).collect::<Vec<_>>(), [10, 20]);
    }
}
