//! What is published of the tissue's force: without a jump when poses stop, come again, come from
//! another program, and when a command, a run of bad samples or an overload takes the force away.
//!
//! The clock never enters the tissue: what is recorded is the tissue's own force.

use chaincell_kernel::Flags;

use super::Run;
use crate::session::ipc::payload::ToolForce;

impl Run<'_> {
    /// The published form of an answer of the tissue.
    pub(super) fn shown(&mut self, answer: ToolForce, now_ns: u64) -> ToolForce {
        let safe = Flags::SAFE_STATE.0;
        let before = self.answer.map_or(answer.flags, |last| last.flags);
        if (answer.flags ^ before) & safe != 0 {
            self.shaper.begin_ramp();
        }
        let is_overload = self.overload.is_on();
        let target_n = if is_overload { [0.0; 3] } else { answer.force_n };
        let force_n = self.shaper.shape(target_n, now_ns);
        let overload = if is_overload { Flags::LATE.0 | safe } else { 0 };
        let flags = answer.flags | overload;
        // The flag says that the force is zero; on the way there it is not.
        let flags = if force_n == [0.0; 3] { flags } else { flags & !safe };
        ToolForce { force_n, flags, ..answer }
    }

    /// Lets the published force fall to 0 when poses stop coming, a message a millisecond. The
    /// tissue stays as it is.
    pub(super) fn watch(&mut self, now_ns: u64) {
        let Some(last) = self.answer else { return };
        let Some(fall) = self.shaper.wait(now_ns) else { return };
        let mut flags = Flags(last.flags & !Flags::SAFE_STATE.0);
        flags.insert(Flags::STALE);
        if fall.is_done {
            flags.insert(Flags::SAFE_STATE);
        }
        self.send(ToolForce { force_n: fall.force_n, flags: flags.0, step_ns: 0, ..last });
    }
}
