//! Contact in a tick in which the tool holds chosen cells.

use super::choices::Drive;
use super::order::Tick;
use super::sample::{Flags, ToolSample};
use crate::energy::contact::Touched;
use crate::energy::held;
use crate::energy::surface::IS_BUILT;
use crate::number::Number;
use crate::number::cell::{Cell, add, from_single, output, sub};
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;

/// Bound of a coordinate of the tool's displacement, so that its square stays finite.
const DISPLACEMENT_MAX: f32 = 1.0e6;

/// Change of E by a motion of the tool.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    exact: TwoFloat,
    rounding: f32,
}

impl Change {
    /// Change rounded up: the level stays an upper bound if two large energies almost cancel.
    pub fn bound(&self) -> TwoFloat {
        self.exact.plus(self.rounding.into())
    }
}

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Handles the edges of `engaged`: the tool engages or releases.
    pub(super) fn hold_or_release(&mut self, sample: &ToolSample) {
        let engaged = sample.engaged == 1;
        // A tool that engages starts its displacement anew.
        if engaged && !self.head.engaged {
            self.head.tool_origin_m = sample.position_m.into();
            self.head.applied = [0.0; 3];
            // Any depth is deeper: engaging reopens the bands.
            self.head.deepest = -1.0;
        }
        // Tools leave the surface; held cells note their origins.
        if IS_BUILT && self.head.has_tools {
            if engaged != self.head.engaged {
                if !engaged {
                    self.leave_surface();
                }
                self.head.resisted = Some(0);
            }
        } else if engaged && !self.head.engaged {
            let model = self.network.model();
            let k = D::Number::from_single(model.saturation());
            for contact in &mut *self.contacts {
                if let Some(v) = self.state.get(contact.cell()) {
                    contact.origin = output(v.xyz(), k);
                }
            }
            match self.network.settings().drive {
                Drive::Position => {
                    self.head.outer_weight = held::outer_weight(model, self.contacts);
                    self.place();
                }
                Drive::Current => self.head.level.begin_work(),
            }
        }
        // A released current stops.
        if !engaged && self.current().is_some() {
            self.cut_off();
        }
        if engaged != self.head.engaged {
            self.head.released = !engaged;
        }
        self.head.engaged = engaged;
    }

    /// Displacement of the tool after this tick: towards the sample, within the step limit.
    pub fn step_towards(&mut self, sample: &ToolSample) -> [f32; 3] {
        let (model, settings) = (self.network.model(), self.network.settings());
        let wished = sub(sample.position_m.into(), self.head.tool_origin_m)
            .map(|way| (way / model.unit_m()).clamp(-DISPLACEMENT_MAX, DISPLACEMENT_MAX));
        let step = settings.max_tool_step_m / model.unit_m();
        let (to, clamped) = held::approach(self.head.applied, wished, step);
        if clamped {
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        to
    }

    /// Moves the held cells, or the current, towards the tool, as far as the limits allow.
    pub(super) fn follow(&mut self, sample: &ToolSample) {
        let from = self.head.applied;
        let to = self.step_towards(sample);
        if self.current().is_some() {
            return self.let_in(to);
        }
        if to == from {
            return;
        }
        // Try the whole move.
        let room = held::move_max(
            self.network.model().energy_max(),
            self.head.level.leading(),
            self.head.outer_weight,
        );
        let (_, beyond) = held::approach(from, to, room);
        let before = held::touched(self.terms(), self.state, self.contacts);
        let mut change = self.displace(to, before);
        // A move that lowers the energy is not shortened: the tool can always come back.
        if beyond && change.bound().hi > 0.0 {
            change = self.shorten([from, to], room, before);
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        if self.head.applied != from {
            self.load(change);
            self.head.dynamics.follow(sub(self.head.applied, from));
        }
    }

    /// Moves the held cells as far as the energy bound allows: by `room`, or farther if the tissue pulls them
    /// that way and this lowers the energy.
    fn shorten(&mut self, [from, to]: [[f32; 3]; 2], room: f32, before: Touched) -> Change {
        self.displace(from, before);
        let force = held::force(self.terms(), self.state, self.contacts);
        let drawn = held::fall_max(force, sub(to, from), self.head.outer_weight);
        if drawn > room {
            let change = self.displace(held::approach(from, to, drawn).0, before);
            if change.bound().hi <= 0.0 {
                return change;
            }
        }
        self.displace(held::approach(from, to, room).0, before)
    }

    /// Books the work of the tool.
    pub fn load(&mut self, change: Change) {
        self.head.level.shift(change.bound());
        self.work = change.exact;
    }

    /// Moves the held cells to a displacement and returns the change of the energy.
    fn displace(&mut self, to: [f32; 3], before: Touched) -> Change {
        self.head.applied = to;
        self.place();
        self.head.dynamics.pushed();
        self.change(before)
    }

    /// Energy of the contacts' links above `before`.
    pub fn change(&self, before: Touched) -> Change {
        let after = held::touched(self.terms(), self.state, self.contacts);
        let rounding = f32::EPSILON * (before.scale + after.scale);
        Change { exact: after.wd2.minus(before.wd2).times_power_of_two(0.25), rounding }
    }

    /// Sets the held cells to the tool's displacement, in every copy of the state.
    fn place(&mut self) {
        let k = self.network.model().saturation();
        let applied = from_single(self.head.applied);
        for contact in &*self.contacts {
            let position = Cell::at(add(contact.origin, applied));
            if let Some(v) = self.state.get_mut(contact.cell()) {
                *v = position;
            }
            self.head.dynamics.place(self.own, contact.cell(), position, k);
            self.head.awake.wake_around(self.network.model(), contact.cell());
        }
    }
}
