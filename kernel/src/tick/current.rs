//! The tool's part of a tick under the current drive, see [`current`](crate::energy::current).

use super::order::Tick;
use super::sample::Flags;
use crate::energy::current::{Load, admitted, rounded_up};
use crate::number::cell::{from_single, single};
use crate::solver::Dynamics;

impl<D: Dynamics> Tick<'_, '_, D> {
    /// The current I at each contact cell, if the tool drives by current [mean link lengths].
    pub(super) fn current(&self) -> Option<[f32; 3]> {
        self.head.level.is_driven().then_some(self.head.applied)
    }

    /// Moves the current towards the value that the tool asks for, as far as the energy bound allows.
    pub(super) fn let_in(&mut self, wished: [f32; 3]) {
        let model = self.network.model();
        let from = self.head.applied;
        // Rounded to the number type of the cells: work and residual must mean the same current.
        let wished = single(from_single::<D::Number>(wished));
        // Cut the current at the energy bound.
        let energy = self.head.level.energy();
        let energy = f64::from(energy.hi) + f64::from(energy.lo);
        let to = admitted(model, [from, wished], energy, self.state, self.contacts);
        let to = single(from_single::<D::Number>(to));
        if to != wished {
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        // Book the change of the load's work.
        if to != from {
            let [old, new] = [from, to].map(|current| self.work(current));
            self.head.applied = to;
            self.head.level.shift(rounded_up(old - new));
            self.head.level.note_work(rounded_up(new));
            self.head.dynamics.pushed();
        }
        if to != [0.0; 3] {
            self.wake_contacts();
        }
    }

    /// Stops the current at once; the cells continue from where they are.
    pub(super) fn cut_off(&mut self) {
        self.head.level.end_work();
        self.head.dynamics.pushed();
        self.wake_contacts();
    }

    /// Books the current's work, after the sweeps.
    pub(super) fn book(&mut self) {
        if let Some(current) = self.current() {
            let work = self.work(current);
            self.head.level.note_work(rounded_up(work));
        }
    }

    /// Work of a current since the tool engaged.
    fn work(&self, current: [f32; 3]) -> f64 {
        let load = Load { current: Some(current), cells: self.contacts };
        load.work(&self.terms().published(self.state))
    }

    fn wake_contacts(&mut self) {
        for contact in &*self.contacts {
            self.head.awake.wake_around(self.network.model(), contact.cell());
        }
    }
}
