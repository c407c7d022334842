//! What a tick answers.

use super::order::Tick;
use super::sample::{Flags, TickOutput};
use crate::number::cell::{dot, scale};
use crate::number::sqrt::sqrt;
use crate::solver::Dynamics;
use crate::terms::held;

impl<D: Dynamics> Tick<'_, '_, D> {
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
    pub(super) fn output(mut self) -> TickOutput {
        let model = self.network.model();
        let mut force_n = [0.0; 3];
        if self.head.engaged {
            let force = held::force(self.terms(), self.state, self.contacts);
            force_n = self.within_limit(scale(model.force_unit_n(), force));
        }
        self.head.force_n = force_n;
        self.answer(force_n)
    }

    /// The force of the last tick, while the tool still holds on, with the energy of the state now.
    pub(super) fn late_output(mut self) -> TickOutput {
        self.flags.insert(Flags::LATE);
        if self.head.closed {
            self.flags.insert(Flags::BAND_CLOSED);
        }
        if !self.head.engaged {
            self.head.force_n = [0.0; 3];
        }
        // The limit may have changed since.
        let force_n = self.within_limit(self.head.force_n);
        self.answer(force_n)
    }

    fn within_limit(&mut self, force_n: [f32; 3]) -> [f32; 3] {
        let most_n = self.network.settings().max_force_n;
        let magnitude = sqrt(dot(force_n, force_n));
        if magnitude > most_n {
            self.flags.insert(Flags::FORCE_CLAMPED);
            return scale(most_n / magnitude, force_n);
        }
        force_n
    }

    fn answer(&self, force_n: [f32; 3]) -> TickOutput {
        let model = self.network.model();
        TickOutput {
            force_n: force_n.into(),
            energy_j: self.head.level.published() * model.energy_unit_j(),
            work_j: self.work.hi * model.energy_unit_j(),
            stiffness_n_per_m: self.stiffness(),
            contacts: if self.head.engaged { self.contacts.len() as u32 } else { 0 },
            sweeps: self.sweeps,
            flags: self.flags,
        }
    }
}
