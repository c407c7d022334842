//! What is published of the tissue's force: without a jump when poses stop, come again, come from
//! another program, and when a command, a run of bad samples or an overload takes the force away.
//!
//! The clock never enters the tissue: what is recorded is the tissue's own force. The loop and the
//! [watcher](super::watcher) beside it speak through one voice.

use chaincell_kernel::Flags;

use super::ServeOptions;
use super::overload::{Behind, Change, Overload};
use crate::session::ipc::payload::ToolForce;
use crate::session::ipc::tools::Answer;
use crate::session::loops::ramp::Shown;
use crate::session::loops::shaper::ForceShaper;
use crate::session::timing::clock::PERIOD_NS;

/// The published force.
#[derive(Debug)]
pub(super) struct Voice {
    pub shaper: ForceShaper,
    overload: Overload,
    /// The tissue's last answer.
    pub answer: Option<Answer>,
    said_ns: u64,
    is_zero: bool,
}

impl Voice {
    pub(super) fn new(options: &ServeOptions, now_ns: u64) -> Self {
        let &ServeOptions { watchdog_ms, ramp_ms, max_slew_n_per_s, .. } = options;
        Self {
            shaper: ForceShaper::new(watchdog_ms, ramp_ms, max_slew_n_per_s, now_ns),
            overload: Overload::default(),
            answer: None,
            said_ns: now_ns,
            is_zero: true,
        }
    }

    /// The published form of an answer of the tissue.
    pub(super) fn shown(&mut self, answer: Answer, now_ns: u64) -> Answer {
        let safe = Flags::SAFE_STATE.0;
        let last = self.answer.unwrap_or(answer);
        if (answer.force.flags ^ last.force.flags) & safe != 0 {
            self.shaper.begin_ramp();
        }
        // The readers of another version were shown nothing of the force so far.
        if answer.asked.is_some() != last.asked.is_some() {
            self.shaper.begin_at_zero();
        }
        self.shaper.end_silence();
        let is_overload = self.overload.is_on();
        let target = if is_overload { Shown::ZERO } else { felt(&answer) };
        let shown = self.say(&target, now_ns);
        let flags = answer.force.flags | if is_overload { Flags::LATE.0 | safe } else { 0 };
        // The flag says that the force is zero; on the way there it is not.
        let flags = if self.is_zero { flags } else { flags & !safe };
        self.answer = Some(answer);
        with(answer, &shown, flags)
    }

    /// A tick has ended: an overload lets the force fall, its end lets it come back.
    pub(super) fn judge(&mut self, behind: Behind, span_ns: [u64; 2]) {
        match self.overload.note(behind, span_ns) {
            Change::None => {}
            Change::Begins => self.shaper.begin_fall(),
            Change::Ends => self.shaper.begin_ramp(),
        }
    }

    /// What to publish where no answer comes: the force falls to 0 in a silence, a message a
    /// millisecond. The tissue stays as it is.
    pub(super) fn falling(&mut self, now_ns: u64) -> Option<Answer> {
        let last = self.answer?;
        let fall = self.shaper.wait(now_ns)?;
        self.said_ns = now_ns;
        self.is_zero = fall.is_done;
        Some(stale(last, &fall.shown, fall.is_done))
    }

    /// As [`Self::falling`], in a tick that does not end, and under an overload between two answers.
    pub(super) fn falling_in_tick(&mut self, now_ns: u64) -> Option<Answer> {
        if !self.overload.is_on() {
            return self.falling(now_ns);
        }
        let last = self.answer?;
        if self.is_zero || now_ns.saturating_sub(self.said_ns) < PERIOD_NS {
            return None;
        }
        let shown = self.say(&Shown::ZERO, now_ns);
        Some(stale(last, &shown, self.is_zero))
    }

    /// Times that an overload began.
    pub(super) fn overloads(&self) -> u64 {
        self.overload.times()
    }

    /// Whether the watcher has something to say before long.
    pub(super) fn is_urgent(&self) -> bool {
        (self.overload.is_on() && !self.is_zero) || self.shaper.fall_ns().is_some()
    }

    fn say(&mut self, target: &Shown, now_ns: u64) -> Shown {
        let shown = self.shaper.shape(target, now_ns);
        self.said_ns = now_ns;
        self.is_zero = shown == Shown::ZERO;
        shown
    }
}

/// Forces and torques of an answer.
fn felt(answer: &Answer) -> Shown {
    let mut felt = Shown::of(answer.force.force_n);
    for (tool, of) in answer.tools().iter().enumerate() {
        (felt.force_n[tool], felt.torque_n_m[tool]) = (of.force_n, of.torque_n_m);
    }
    felt
}

/// An answer with other forces, torques and flags.
fn with(mut answer: Answer, shown: &Shown, flags: u32) -> Answer {
    answer.force = ToolForce { force_n: shown.force_n[0], flags, ..answer.force };
    for (tool, of) in answer.tools_mut().iter_mut().enumerate() {
        (of.force_n, of.torque_n_m) = (shown.force_n[tool], shown.torque_n_m[tool]);
    }
    answer
}

/// A message that is no answer: the force on its way to 0, of the last tick.
fn stale(last: Answer, shown: &Shown, is_zero: bool) -> Answer {
    let mut flags = Flags(last.force.flags & !Flags::SAFE_STATE.0);
    flags.insert(Flags::STALE);
    if is_zero {
        flags.insert(Flags::SAFE_STATE);
    }
    let force = ToolForce { step_ns: 0, ..last.force };
    with(Answer { force, sweeps: 0, ..last }, shown, flags.0)
}
