//! Publishes the tissue's force without a jump: when poses stop, resume or come from another program, and
//! when a command, a run of bad samples or an overload takes the force away.
//!
//! An output stage keeps a ledger of the forces that the device received. Every published force goes through
//! one function, `say`, which compares it with the computed force. If the device felt a different force, for
//! any cause, the stage's ramp starts anew with the next tick, and its ledger books nothing for this one.
//!
//! The clock never affects the tissue: the recording holds the tissue's force. The loop and the
//! [watcher](super::watcher) thread share one voice.

use chaincell_kernel::trace::Command;
use chaincell_kernel::{Flags, TOOLS_MAX};

use super::ServeOptions;
use super::overload::{Behind, Change, Overload};
use crate::session::ipc::tools::{Answer, TickForce};
use crate::session::loops::ramp::Shown;
use crate::session::loops::shaper::ForceShaper;
use crate::session::timing::clock::PERIOD_NS;

/// The published force.
#[derive(Debug)]
pub struct Voice {
    pub(super) shaper: ForceShaper,
    overload: Overload,
    /// True if the tissue has an output stage, which makes its own ramps for all events that it sees.
    has_stage: bool,
    /// True if the device has felt another force than the last computed one, and no tick has considered it.
    felt_other: bool,
    /// The tissue's last answer.
    pub(super) answer: Option<Answer>,
    said_ns: u64,
    is_zero: bool,
}

impl Voice {
    /// The published force is 0 so far.
    pub fn new(options: &ServeOptions, now_ns: u64) -> Self {
        let &ServeOptions { watchdog_ms, ramp_ms, max_slew_n_per_s, .. } = options;
        Self {
            shaper: ForceShaper::new(watchdog_ms, ramp_ms, max_slew_n_per_s, now_ns),
            overload: Overload::default(),
            has_stage: false,
            felt_other: false,
            answer: None,
            said_ns: now_ns,
            is_zero: true,
        }
    }

    /// Starts a session, with an output stage or without; one that resumes from a snapshot was silent.
    pub(super) fn begin(&mut self, has_stage: bool, is_resumed: bool) {
        self.has_stage = has_stage;
        if is_resumed {
            self.shaper.begin_silent();
        }
    }

    /// Returns the published form of an answer of the tissue; tools that are `withheld` get no force.
    pub(super) fn shown(
        &mut self,
        answer: Answer,
        withheld: [bool; TOOLS_MAX],
        now_ns: u64,
    ) -> Answer {
        // Start a ramp where the computed force may jump.
        let safe = Flags::SAFE_STATE.0;
        let last = self.answer.unwrap_or(answer);
        if (answer.force.flags ^ last.force.flags) & safe != 0 {
            self.force_jumps();
        }
        // Choose the target force: 0 in an overload and for withheld tools.
        self.shaper.end_silence();
        self.answer = Some(answer);
        let is_overload = self.overload.is_on();
        let mut target = if is_overload { Shown::ZERO } else { felt(&answer) };
        for (tool, _) in withheld.iter().enumerate().filter(|(_, withheld)| **withheld) {
            (target.force_n[tool], target.torque_n_m[tool]) = ([0.0; 3], [0.0; 3]);
        }
        // Shape it, and adjust the flags.
        let shown = self.shape(&target, now_ns);
        let flags = answer.force.flags | if is_overload { Flags::LATE.0 | safe } else { 0 };
        // The flag means that the force is zero; on the way there it is not.
        let flags = if self.is_zero { flags } else { flags & !safe };
        with(answer, &shown, flags)
    }

    /// The computed force may jump for a cause that an output stage handles: without a stage it follows a
    /// ramp.
    pub(super) fn force_jumps(&mut self) {
        // In an overload the force falls to 0; a new ramp would prevent it from getting there.
        if !self.has_stage && !self.overload.is_on() {
            self.shaper.begin_ramp();
        }
    }

    /// Notes an executed command.
    pub(super) fn obeyed(&mut self, command: &Command) {
        match command {
            Command::Snapshot { .. } => {}
            // They bypass the stage.
            Command::Pause | Command::Resume | Command::Reset => self.shaper.begin_ramp(),
            Command::MaxForceN(_) if !self.has_stage => self.shaper.begin_raise(),
            _ => self.force_jumps(),
        }
    }

    /// Notes the end of a tick: an overload lowers the force, its end lets it return.
    pub(super) fn judge(&mut self, behind: Behind, span_ns: [u64; 2]) {
        match self.overload.note(behind, span_ns) {
            Change::None => {}
            Change::Begins => self.shaper.begin_fall(),
            Change::Ends => self.shaper.begin_ramp(),
        }
    }

    /// Returns a message to publish while no answer comes: in a silence the force falls to 0, with a message
    /// per millisecond. The tissue is unchanged.
    pub fn falling(&mut self, now_ns: u64) -> Option<Answer> {
        let last = self.answer?;
        let fall = self.shaper.wait(now_ns)?;
        self.say(&fall.shown, now_ns);
        self.is_zero = fall.is_done;
        Some(stale(last, &fall.shown, fall.is_done))
    }

    /// Like [`Self::falling`], in a tick that does not end, and in an overload between two answers.
    pub fn falling_in_tick(&mut self, now_ns: u64) -> Option<Answer> {
        if !self.overload.is_on() {
            return self.falling(now_ns);
        }
        let last = self.answer?;
        if self.is_zero || now_ns.saturating_sub(self.said_ns) < PERIOD_NS {
            return None;
        }
        let shown = self.shape(&Shown::ZERO, now_ns);
        Some(stale(last, &shown, self.is_zero))
    }

    /// Number of overloads.
    pub(super) fn overloads(&self) -> u64 {
        self.overload.times()
    }

    /// Returns true if the watcher may have a message soon.
    pub(super) fn is_urgent(&self) -> bool {
        (self.overload.is_on() && !self.is_zero) || self.shaper.fall_ns().is_some()
    }

    /// Returns true if the device has felt another force than the computed one since the last call; the stage
    /// has to be informed.
    pub(super) fn take_felt_other(&mut self) -> bool {
        std::mem::take(&mut self.felt_other)
    }

    fn shape(&mut self, target: &Shown, now_ns: u64) -> Shown {
        let shown = self.shaper.shape(target, now_ns);
        self.say(&shown, now_ns);
        shown
    }

    /// Notes a published force, and compares it with the last computed one.
    fn say(&mut self, shown: &Shown, now_ns: u64) {
        (self.said_ns, self.is_zero) = (now_ns, *shown == Shown::ZERO);
        let Some(answer) = self.answer.filter(|_| self.has_stage) else { return };
        let computed = felt(&answer);
        let touches = answer.force.contacts > 0 || answer.tools().iter().any(|of| of.contacts > 0);
        // A force of 0 on a ramp may differ from the computed one in the next tick.
        let is_on_way = touches && self.is_zero && !self.shaper.is_done();
        self.felt_other |= computed != *shown || is_on_way;
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

/// An answer with other forces, torques and flags. The error of a force that is not the computed one is not known.
fn with(mut answer: Answer, shown: &Shown, flags: u32) -> Answer {
    let error =
        |of: Option<f32>, force_n, tool: usize| of.filter(|_| force_n == shown.force_n[tool]);
    let force_error_n = error(answer.force.force_error_n, answer.force.force_n, 0);
    answer.force = TickForce { force_n: shown.force_n[0], flags, force_error_n, ..answer.force };
    for (tool, of) in answer.tools_mut().iter_mut().enumerate() {
        of.force_error_n = error(of.force_error_n, of.force_n, tool);
        of.torque_error_n_m = error(of.torque_error_n_m, of.force_n, tool);
        (of.force_n, of.torque_n_m) = (shown.force_n[tool], shown.torque_n_m[tool]);
    }
    answer
}

/// A message without an answer: the force on its way to 0, with the data of the last tick.
fn stale(last: Answer, shown: &Shown, is_zero: bool) -> Answer {
    let mut flags = Flags(last.force.flags & !Flags::SAFE_STATE.0);
    flags.insert(Flags::STALE);
    if is_zero {
        flags.insert(Flags::SAFE_STATE);
    }
    let force = TickForce { step_ns: 0, ..last.force };
    with(Answer { force, sweeps: 0, ..last }, shown, flags.0)
}
