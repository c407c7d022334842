//! The tool's part of a tick under the current drive, see [`current`](crate::terms::current).

use super::order::Tick;
use super::sample::Flags;
use crate::number::cell::{from_single, single};
use crate::solver::Dynamics;
use crate::terms::current::{admitted, rounded_up, work};

impl<D: Dynamics> Tick<'_, '_, D> {
    /// I at each contact cell, while the tool drives by it [mean link lengths].
    pub(super) fn current(&self) -> Option<[f32; 3]> {
        self.head.level.is_driven().then_some(self.head.applied)
    }

    /// Moves the current to a value that the tool asks for, as far as the energy bound allows.
    pub(super) fn let_in(&mut self, wished: [f32; 3]) {
        let model = self.network.model();
        let from = self.head.applied;
        // Rounded to the number type of the cells: work and residual must mean the same current.
        let wished = single(from_single::<D::Number>(wished));
        let energy = self.head.level.energy();
        let energy = f64::from(energy.hi) + f64::from(energy.lo);
        let to = admitted(model, [from, wished], energy, self.state, self.contacts);
        let to = single(from_single::<D::Number>(to));
        if to != wished {
            self.flags.insert(Flags::MOTION_CLAMPED);
        }
        if to != from {
            let [old, new] = [from, to].map(|i| work(model, i, self.state, self.contacts));
            self.head.applied = to;
            self.head.level.shift(rounded_up(old - new));
            self.head.level.note_work(rounded_up(new));
            self.head.dynamics.pushed();
        }
        if to != [0.0; 3] {
            self.wake_contacts();
        }
    }

    /// The current stops at once: the cells stay where they are and go on by themselves.
    pub(super) fn cut_off(&mut self) {
        self.head.level.end_work();
        self.head.dynamics.pushed();
        self.wake_contacts();
    }

    /// Notes what the current has done, behind the sweeps.
    pub(super) fn book(&mut self) {
        if let Some(current) = self.current() {
            let work = work(self.network.model(), current, self.state, self.contacts);
            self.head.level.note_work(rounded_up(work));
        }
    }

    fn wake_contacts(&mut self) {
        for contact in &*self.contacts {
            self.head.awake.wake_around(self.network.model(), contact.cell());
        }
    }
}
