//! Contact of a spherical tool in a tick, see [`probe`](crate::terms::probe).

use super::begin;
use super::order::Tick;
use super::sample::{Flags, ToolSample};
use super::surface::places;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{Cell, add, from_single, output, scale, single, sub};
use crate::solver::Dynamics;
use crate::terms::held;
use crate::terms::inside::is_inside;
use crate::terms::probe::{Contacts, Sphere, normal, residual, spread};

/// Largest coordinate of a centre [mean link lengths], so that its square stays finite.
const CENTRE_MAX: f32 = 2.0e6;
/// In late ticks the sphere searches for cells after it has moved this share of its radius.
const LOOK: f32 = 0.125;
/// Least distance of an engaging sphere's centre from the body, as a share of its radius: cells at the height
/// of the centre, which stick to the sphere, would draw it in.
const OUT: f32 = 0.125;
/// Returns true if a probe may move the cell.
fn is_free(model: &Model<'_>, cell: usize) -> bool {
    model.mobility.get(cell).is_some_and(|&mobility| mobility > 0.0)
}

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Moves the sphere with the tool and pushes cells out.
    pub(super) fn touch(&mut self, sample: &ToolSample, radius: f32) {
        // Move the sphere within the step limit.
        let model = self.network.model();
        let from = self.head.applied;
        self.head.applied = self.step_towards(sample);
        let [x, y, z] = sub(self.head.applied, from);
        self.head.unseen += x.abs() + y.abs() + z.abs();
        let unit = model.unit_m();
        let start = sub(self.head.tool_origin_m, model.centre_m())
            .map(|way| (way / unit).clamp(-CENTRE_MAX, CENTRE_MAX));
        // Set its radius, update its contacts and push them out.
        let whole = Sphere::new(add(start, self.head.applied), radius);
        self.head.share = self.share(&whole);
        let sphere = Sphere::new(whole.centre, self.head.share * radius);
        let sphere = Sphere { only_pushes: self.is_late, ..sphere };
        let touched = self.head.chosen > 0;
        let changed = self.renew(&sphere);
        if !touched && self.head.chosen > 0 {
            self.head.touched_at = self.head.applied;
            self.head.deepest = -1.0;
        }
        let moved = self.push_out(&sphere);
        // Adapt the coarse level to the new contacts.
        if changed {
            let cells = self.contacts.iter().map(|contact| (contact.cell(), f32::INFINITY));
            self.head.deflated = D::deflate(model, self.room, cells);
        }
        if changed || moved {
            self.head.dynamics.pushed();
        }
    }

    /// The share of its radius that the sphere has in this tick, see [`begin`]. It grows only in ticks with
    /// sweeps.
    fn share(&self, whole: &Sphere) -> f32 {
        let share = self.head.share;
        if share >= 1.0 || self.is_late && share >= begin::WAITS {
            return share;
        }
        let (model, at) = (self.network.model(), places(self.network.model(), self.state));
        let is_inside = |margin| is_inside(model, &at, (whole.centre, margin));
        // A growing sphere grows on, unless the tissue has closed over it.
        if share > begin::WAITS {
            return if is_inside(0.0) { begin::WAITS } else { begin::grown(share) };
        }
        // A new or waiting sphere starts if the nearest free cell and the body permit.
        let nearest = model.surface.iter().fold(whole.radius, |nearest, &cell| {
            let cell = usize::from(cell);
            let distance = whole.distance(at(cell));
            if is_free(model, cell) && distance < nearest { distance } else { nearest }
        });
        let nearest = nearest / whole.radius;
        let has_waited = share >= begin::WAITS;
        let waits = (has_waited && !begin::is_clear(nearest)) || is_inside(OUT * whole.radius);
        // A cell at the centre does not prevent growth: it leaves along its normal.
        if waits { begin::WAITS } else { begin::begins(nearest) }
    }

    /// Finds the contacts of this tick and returns true if they have changed. A late tick releases none and
    /// rarely searches for more.
    fn renew(&mut self, sphere: &Sphere) -> bool {
        let (terms, state) = (self.terms(), &*self.state);
        let model = terms.model;
        let k = D::Number::from_single(model.saturation());
        let at = |cell: usize| state.get(cell).map(|v| single(output(v.xyz(), k)));
        let mut contacts = Contacts {
            slots: core::mem::take(&mut self.contacts),
            count: self.head.chosen,
            changed: false,
            full: false,
        };
        // Drop the contacts that the tissue no longer pushes against the sphere.
        if !self.is_late {
            contacts.retain(|cell| {
                let mobility = model.mobility.get(cell).copied().unwrap_or(0.0);
                let keeps = |at| sphere.keeps(at, residual(terms, state, cell), mobility);
                sphere.radius > 0.0 && at(cell).is_some_and(keeps)
            });
        }
        // Search for cells inside the sphere.
        let is_looking = !self.is_late || self.head.unseen >= LOOK * sphere.radius;
        let surface = if is_looking { model.surface } else { &[] };
        if is_looking {
            self.head.unseen = 0.0;
        }
        for &id in surface {
            let cell = usize::from(id);
            if is_free(model, cell) && at(cell).is_some_and(|at| sphere.is_inside(at)) {
                contacts.insert(id);
            }
        }
        let Contacts { slots, count, changed, full } = contacts;
        if full {
            self.flags.insert(Flags::CONTACT_CAPACITY);
        }
        self.head.chosen = count;
        self.contacts = slots.get_mut(..count).unwrap_or(&mut []);
        changed
    }

    /// Moves the contacts onto the sphere, as far as the model's largest energy allows. Returns true if one
    /// moved.
    fn push_out(&mut self, sphere: &Sphere) -> bool {
        let model = self.network.model();
        let k = D::Number::from_single(model.saturation());
        // Start from the published positions.
        for contact in &mut *self.contacts {
            if let Some(v) = self.state.get(contact.cell()) {
                contact.origin = output(v.xyz(), k);
            }
        }
        let before = held::touched(self.terms(), self.state, self.contacts);
        // Move fully, and shorten a move that may exceed the energy bound.
        let mut moved = self.put(sphere, 1.0);
        if moved {
            let mut change = self.change(before);
            let spread = spread(model, self.state, self.contacts);
            let level = self.head.level.at_most(model.energy_max());
            let share = held::move_max(model.energy_max(), level, spread);
            if share < 1.0 && change.bound().hi > 0.0 {
                self.put(sphere, share);
                change = self.change(before);
                self.flags.insert(Flags::MOTION_CLAMPED);
                // With a share of 0 all are back at their origins.
                moved = share > 0.0;
            }
            if moved {
                self.load(change);
            }
        }
        // Note the final positions as origins.
        for contact in &mut *self.contacts {
            if let Some(v) = self.state.get(contact.cell()) {
                contact.origin = output(v.xyz(), k);
            }
        }
        moved
    }

    /// Moves the contacts by a share of the displacement from their origins to the sphere, in every copy of
    /// the state. Returns true if one moved.
    fn put(&mut self, sphere: &Sphere, share: f32) -> bool {
        let model = self.network.model();
        let k = model.saturation();
        let mut moved = false;
        for contact in &*self.contacts {
            let cell = contact.cell();
            let from = single(contact.origin);
            let place = sphere.place(from, || normal(model, cell)).filter(|_| share > 0.0);
            let position = place.map_or(contact.origin, |to| {
                let to = output(to, k);
                let to = if share < 1.0 { add(from, scale(share, sub(to, from))) } else { to };
                // -0.0 becomes +0.0.
                from_single(to.map(|x| x + 0.0))
            });
            let Some(v) = self.state.get_mut(cell) else { continue };
            if v.xyz() != position {
                *v = Cell::at(position);
                moved = true;
                self.head.awake.wake_around(model, cell);
            }
            self.head.dynamics.place(self.own, cell, Cell::at(position), k);
        }
        moved
    }
}
