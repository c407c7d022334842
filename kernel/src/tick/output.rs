//! Output of a tick.

use super::order::Tick;
use super::sample::{Flags, TickOutput};
use crate::energy::held;
use crate::energy::surface::{IS_BUILT, ToolState};
use crate::number::cell::scale;
use crate::number::clamp::{clamped, finite};
use crate::solver::Dynamics;

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Upper bound of the stiffness at the tool \[N/m\]: E curves by at most half the weight of the links
    /// that a motion of the tool stretches.
    fn stiffness(&self) -> f32 {
        if !self.head.engaged || self.current().is_some() {
            return 0.0;
        }
        let model = self.network.model();
        if IS_BUILT && self.head.has_tools {
            let first = self.touch.tool(0);
            // The term's energy is in units of 2 k_ref.
            return first.map_or(0.0, |tool| 2.0 * model.stiffness_n_per_m() * tool.met.stiffness);
        }
        model.stiffness_n_per_m() * self.head.outer_weight
    }

    /// Returns true if an engaged tool waits inside the tissue without contact.
    fn waits(&self) -> bool {
        IS_BUILT && self.touch.tools().iter().any(ToolState::waits)
    }

    /// Number of cells, or of surface triangles, that the tool acts on.
    fn contact_count(&self) -> u32 {
        let tool = self.touch.tool(0);
        tool.map_or(self.contacts.len() as u32, |tool| tool.met.touched)
    }

    /// Computes force and energy after the last update. A late tick repeats the last force while the tool
    /// stays engaged, with the present energy.
    pub(super) fn output(mut self) -> TickOutput {
        let (model, settings) = (self.network.model(), self.network.settings());
        if self.is_late {
            self.flags.insert(Flags::LATE);
            if self.head.closed {
                self.flags.insert(Flags::BAND_CLOSED);
            }
        }
        // Compute or repeat the force, and clamp it.
        let mut force_n = [0.0; 3];
        if self.head.engaged {
            force_n = if self.is_late {
                self.head.force_n
            } else if IS_BUILT && self.head.has_tools {
                scale(model.force_unit_n(), self.feel())
            } else {
                scale(model.force_unit_n(), held::force(self.terms(), self.state, self.contacts))
            };
            // A repeated force is clamped too: the limit may have changed.
            let (within_n, is_clamped) = clamped(force_n, settings.max_force_n);
            if is_clamped {
                force_n = within_n;
                self.flags.insert(Flags::FORCE_CLAMPED);
            }
        }
        self.head.force_n = force_n;
        if self.waits() {
            self.flags.insert(Flags::STARTS_INSIDE);
        }
        TickOutput {
            force_n: force_n.into(),
            energy_j: finite(self.head.level.published() * model.energy_unit_j()),
            work_j: finite(self.work.hi * model.energy_unit_j()),
            stiffness_n_per_m: finite(self.stiffness()),
            contacts: if self.head.engaged { self.contact_count() } else { 0 },
            sweeps: self.sweeps,
            flags: self.flags,
        }
    }
}
