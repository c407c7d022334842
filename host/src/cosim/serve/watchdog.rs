//! What is published of the tissue's force: without a jump when poses stop, come again, come from
//! another program, and when a command or a run of bad samples takes the force away.
//!
//! The clock never enters the tissue: what is recorded is the tissue's own force.

use chaincell_kernel::sample::Flags;

use super::Run;
use crate::cosim::clock::{MILLISECOND_NS, PERIOD_NS};
use crate::cosim::payload::ToolForce;

impl Run<'_> {
    /// The published form of an answer of the tissue.
    pub(super) fn shown(&mut self, answer: ToolForce, now_ns: u64) -> ToolForce {
        let safe = Flags::SAFE_STATE.0;
        let before = self.answer.map_or(answer.flags, |last| last.flags);
        if (answer.flags ^ before) & safe != 0 {
            self.ramp.begin();
        }
        let force_n = self.ramp.show(answer.force_n, now_ns);
        // The flag says that the force is zero; on the way there it is not.
        let flags = if force_n == [0.0; 3] { answer.flags } else { answer.flags & !safe };
        ToolForce { force_n, flags, ..answer }
    }

    /// Lets the published force fall to 0 when poses stop coming, a message a millisecond. The
    /// tissue stays as it is.
    pub(super) fn watch(&mut self, now_ns: u64) {
        let limit_ns = u64::from(self.server.options.watchdog_ms) * MILLISECOND_NS;
        let Some(last) = self.answer else { return };
        if limit_ns == 0 || now_ns.saturating_sub(self.last_pose_ns) < limit_ns {
            return;
        }
        if !self.stale {
            self.stale = true;
            self.fired += 1;
            self.ramp.begin_fall();
            self.fall_ns = Some(now_ns);
        }
        if self.fall_ns.is_none_or(|due_ns| now_ns < due_ns) {
            return;
        }
        let force_n = self.ramp.show([0.0; 3], now_ns);
        let mut flags = Flags(last.flags & !Flags::SAFE_STATE.0);
        flags.insert(Flags::STALE);
        if self.ramp.is_done() {
            flags.insert(Flags::SAFE_STATE);
        }
        self.fall_ns = (!self.ramp.is_done()).then_some(now_ns + PERIOD_NS);
        self.send(ToolForce { force_n, flags: flags.0, step_ns: 0, ..last });
    }

    /// Poses come again after a silence: the force rises from what is shown.
    pub(super) fn hears(&mut self) {
        if self.stale {
            self.stale = false;
            self.fall_ns = None;
            self.ramp.begin();
        }
    }
}
