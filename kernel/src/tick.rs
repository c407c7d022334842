//! One tick, in the order that the contract fixes: sample, contact, sweeps, outputs.

mod current;

use crate::cell::{Cell, add, dot, from_single, output, scale, sub};
use crate::contact::{self, Contact, Touched};
use crate::dynamics::{Body, Dynamics};
use crate::hats::{Coarse, Eight};
use crate::number::Number;
use crate::pass::Links;
use crate::sample::{Flags, TickOutput, ToolSample};
use crate::settings::{Drive, Network, Unloading};
use crate::sqrt::sqrt;
use crate::tissue::{Head, TissueMut};
use crate::two_float::TwoFloat;

/// Bad samples in a row that the last good one stands in for.
pub const HELD_TICKS_MAX: u32 = 10;
/// How far the tool comes back from its deepest point before the bands close [mean link lengths].
const RETREAT: f32 = 0.1;
/// Bound of a coordinate of the wished displacement, so that its square stays finite.
const DISPLACEMENT_MAX: f32 = 1.0e6;

impl<D: Dynamics> TissueMut<'_, D> {
    /// One tick of the network: infallible, with [`Settings::sweeps`](crate::Settings::sweeps)
    /// link passes whatever the input, none in the safe state.
    ///
    /// The safe state (force 0, cells as they are) answers a sample that stays bad for more than
    /// [`HELD_TICKS_MAX`] ticks, and a network other than that of the last reset. The arithmetic
    /// of the calling thread must be that which the reset found: IEEE 754 to nearest.
    pub fn tick(&mut self, network: &Network<'_>, sample: &ToolSample) -> TickOutput {
        let mut flags = Flags::default();
        let cells = network.model().cells();
        if self.head.model != Some(network.model().checksum()) {
            return self.safe(network, flags);
        }
        let Some(sample) = self.head.accept(sample, &mut flags) else {
            return self.safe(network, flags);
        };
        let (Some(state), Some(residual), Some(own)) = (
            self.state.get_mut(..cells),
            self.residual.get_mut(..D::RESIDUALS * cells),
            self.own.get_mut(..D::ARRAYS * cells),
        ) else {
            return self.safe(network, flags);
        };
        let chosen = self.contacts.len().min(self.head.chosen);
        // A probe finds its cells by itself.
        let slots = if self.head.probe.is_some() { self.contacts.len() } else { chosen };
        let contacts = self.contacts.get_mut(..slots).unwrap_or(&mut []);
        let room = &mut *self.room;
        let mut tick = Tick {
            network,
            head: self.head,
            state,
            residual,
            own,
            room,
            contacts,
            work: TwoFloat::ZERO,
            flags,
        };
        tick.hold_or_release(&sample);
        match tick.head.probe {
            _ if !tick.head.engaged => {}
            Some(radius) => tick.touch(&sample, radius),
            None => tick.pull(&sample),
        }
        tick.unload();
        tick.sweep();
        tick.book();
        tick.settle();
        tick.output()
    }

    fn safe(&self, network: &Network<'_>, mut flags: Flags) -> TickOutput {
        flags.insert(Flags::SAFE_STATE);
        if self.head.closed {
            flags.insert(Flags::BAND_CLOSED);
        }
        TickOutput {
            energy_j: self.head.level.published() * network.model().energy_unit_j(),
            contacts: if self.head.engaged { self.head.chosen as u32 } else { 0 },
            flags,
            ..TickOutput::NONE
        }
    }
}

impl<D> Head<D> {
    /// The sample to act on; `None` where bad samples have gone on for too long.
    fn accept(&mut self, sample: &ToolSample, flags: &mut Flags) -> Option<ToolSample> {
        if sample.is_good() {
            self.last_good = *sample;
            self.bad_ticks = 0;
            return Some(*sample);
        }
        flags.insert(Flags::BAD_SAMPLE);
        self.bad_ticks = self.bad_ticks.saturating_add(1);
        if self.bad_ticks == HELD_TICKS_MAX + 1 {
            log::warn!("tool samples stay bad: safe state");
        }
        (self.bad_ticks <= HELD_TICKS_MAX).then_some(self.last_good)
    }
}

/// What a move of the tool did to E.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Change {
    exact: TwoFloat,
    rounding: f32,
}

impl Change {
    /// Rounded up: the level stays an upper bound where two large energies almost cancel.
    pub fn bound(&self) -> TwoFloat {
        self.exact.plus(self.rounding.into())
    }
}

/// A tick under way: the arrays cut to the model's size.
pub(crate) struct Tick<'a, 'm, D: Dynamics> {
    pub network: &'a Network<'m>,
    pub head: &'a mut Head<D>,
    pub state: &'a mut [Cell<D::Number>],
    residual: &'a mut [Cell<D::Number>],
    pub own: &'a mut [Cell<D::Number>],
    pub room: &'a mut [Eight],
    pub contacts: &'a mut [Contact<D::Number>],
    /// What the tool's motion did to E.
    pub work: TwoFloat,
    pub flags: Flags,
}

impl<'a, 'm, D: Dynamics> Tick<'a, 'm, D> {
    pub fn links(&self) -> Links<'a, 'm> {
        let (model, current) = (self.network.model(), self.current());
        Links { model, closed: self.head.closed, vectors: self.head.vectors, current }
    }

    /// The edges of `engaged`: the tool takes hold of its cells, or lets go of them.
    fn hold_or_release(&mut self, sample: &ToolSample) {
        let engaged = sample.engaged == 1;
        if engaged && !self.head.engaged {
            self.head.tool_origin_m = sample.position_m.into();
            self.head.applied = [0.0; 3];
            self.head.touched_at = [0.0; 3];
            // Any depth is deeper: taking hold reopens the bands.
            self.head.deepest = -1.0;
        }
        if self.head.probe.is_some() {
            if engaged != self.head.engaged {
                self.head.taken = Some(0);
                self.head.chosen = 0;
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
                    self.head.outer_weight = contact::outer_weight(model, self.contacts);
                    self.place();
                }
                Drive::Current => self.head.level.begin_work(),
            }
        }
        if !engaged && self.current().is_some() {
            self.cut_off();
        }
        if engaged != self.head.engaged {
            self.head.released = !engaged;
        }
        self.head.engaged = engaged;
    }

    /// The tool's displacement after this tick: towards the sample, by the step limit at most.
    pub fn step_towards(&mut self, sample: &ToolSample) -> [f32; 3] {
        let (model, settings) = (self.network.model(), self.network.settings());
        let wished = sub(sample.position_m.into(), self.head.tool_origin_m)
            .map(|way| (way / model.unit_m()).clamp(-DISPLACEMENT_MAX, DISPLACEMENT_MAX));
        let step = settings.max_tool_step_m / model.unit_m();
        let (to, clamped) = contact::approach(self.head.applied, wished, step);
        if clamped {
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        to
    }

    /// Moves the held cells, or the current, towards the tool, as far as the limits allow.
    fn pull(&mut self, sample: &ToolSample) {
        let from = self.head.applied;
        let to = self.step_towards(sample);
        if self.current().is_some() {
            return self.let_in(to);
        }
        if to == from {
            return;
        }
        let room = contact::move_max(
            self.network.model().energy_max(),
            self.head.level.leading(),
            self.head.outer_weight,
        );
        let (within, beyond) = contact::approach(from, to, room);
        let before = contact::touched(self.links(), self.state, self.contacts);
        let mut change = self.displace(to, before);
        // A move that lowers the energy is not shortened: the tool can always come back.
        if beyond && change.bound().hi > 0.0 {
            change = self.displace(within, before);
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        if self.head.applied != from {
            self.load(change);
        }
    }

    /// Books what the tool has done.
    pub fn load(&mut self, change: Change) {
        self.head.level.shift(change.bound());
        self.work = change.exact;
    }

    /// Puts the held cells at a displacement and returns what that does to the energy.
    fn displace(&mut self, to: [f32; 3], before: Touched) -> Change {
        self.head.applied = to;
        self.place();
        self.head.dynamics.pushed();
        self.change(before)
    }

    /// What the links of the contacts store more than `before`.
    pub fn change(&self, before: Touched) -> Change {
        let after = contact::touched(self.links(), self.state, self.contacts);
        let rounding = f32::EPSILON * (before.scale + after.scale);
        Change { exact: after.wd2.minus(before.wd2).times_power_of_two(0.25), rounding }
    }

    /// Puts the held cells where the tool has them, in every copy of the state.
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

    /// Closes or reopens the bands.
    fn unload(&mut self) {
        let way = sub(self.head.applied, self.head.touched_at);
        let depth = sqrt(dot(way, way));
        let released = self.head.released;
        let closed = match self.network.settings().unloading {
            Unloading::Off => false,
            Unloading::Release => released,
            Unloading::Retreat if released => true,
            Unloading::Retreat if depth > self.head.deepest => false,
            Unloading::Retreat => self.head.closed || depth < self.head.deepest - RETREAT,
        };
        if depth > self.head.deepest {
            self.head.deepest = depth;
        }
        if closed != self.head.closed {
            self.head.closed = closed;
            self.head.level.forget();
            self.head.dynamics.interrupt();
            self.head.awake.wake_all(self.network.model());
        }
        if closed {
            self.flags.insert(Flags::BAND_CLOSED);
        }
    }

    /// The bounded number of link passes.
    fn sweep(&mut self) {
        let current = self.current();
        let contacts: &[Contact<D::Number>] = if self.head.engaged { self.contacts } else { &[] };
        let held = if current.is_none() { contacts } else { &[] };
        // The origins of a probe's contacts are where it has put them.
        let (applied, coarse) = match self.head.probe {
            Some(_) => ([0.0; 3], self.head.taken.map(Coarse::Without)),
            None => (self.head.applied, Some(Coarse::Corrected(held.len()))),
        };
        let mut body = Body {
            links: Links {
                model: self.network.model(),
                closed: self.head.closed,
                vectors: self.head.vectors,
                current,
            },
            settings: self.network.settings(),
            contacts,
            held,
            applied,
            coarse,
            state: self.state,
            residual: self.residual,
            own: self.own,
            room: self.room,
            awake: &mut self.head.awake,
            level: &mut self.head.level,
        };
        self.head.dynamics.begin(self.network.model(), self.network.settings());
        for _ in 0..self.network.settings().sweeps {
            if self.head.dynamics.sweep(&mut body) {
                self.flags.insert(Flags::ROLLED_BACK);
            }
        }
    }

    /// Puts parts of the body to sleep: behind the sweeps, before anything else can move a cell.
    fn settle(&mut self) {
        let (state, own, residual) = (&*self.state, &*self.own, &*self.residual);
        self.head.awake.settle(self.network.model(), residual, |cell| {
            D::has_moved(state, own, residual, cell)
        });
    }

    /// Upper bound of the stiffness at the tool \[N/m\]: E curves by at most half the weight of the
    /// links that a move of the tool stretches.
    fn stiffness(&self) -> f32 {
        if !self.head.engaged || self.current().is_some() {
            return 0.0;
        }
        let model = self.network.model();
        let weight = match self.head.probe {
            None => self.head.outer_weight,
            Some(_) => self.contacts.iter().fold(0.0, |weight, contact| {
                weight + model.mobility.get(contact.cell()).map_or(0.0, |&m| 1.0 / m)
            }),
        };
        model.stiffness_n_per_m() * weight
    }

    /// Force and energy of the state after the last update.
    fn output(mut self) -> TickOutput {
        let (model, settings) = (self.network.model(), self.network.settings());
        let mut force_n = [0.0; 3];
        if self.head.engaged {
            let force = contact::force(self.links(), self.state, self.contacts);
            force_n = scale(model.force_unit_n(), force);
            let magnitude = sqrt(dot(force_n, force_n));
            if magnitude > settings.max_force_n {
                force_n = scale(settings.max_force_n / magnitude, force_n);
                self.flags.insert(Flags::FORCE_CLAMPED);
            }
        }
        TickOutput {
            force_n: force_n.into(),
            energy_j: self.head.level.published() * model.energy_unit_j(),
            work_j: self.work.hi * model.energy_unit_j(),
            stiffness_n_per_m: self.stiffness(),
            contacts: if self.head.engaged { self.contacts.len() as u32 } else { 0 },
            flags: self.flags,
        }
    }
}
