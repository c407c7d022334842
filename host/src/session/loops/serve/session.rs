//! A served session without ports and clock: its inputs are poses and times, its outputs answers.
//!
//! It decides which poses are executed and which force is published; the loop around it receives, waits,
//! measures, records and sends. So any sequence of events can be tested on a simulated clock.

use std::sync::MutexGuard;

use chaincell_kernel::trace::Command;
use chaincell_kernel::{Budget, Flags, TOOLS_MAX, TickOutput};

use super::ServeOptions;
use super::arrived::Arrived;
use super::charge::Charge;
use super::overload::Behind;
use super::speed::SpeedGate;
use super::voice::Voice;
use super::watcher::Shared;
use crate::engine::course::{Course, ToolCourse};
use crate::engine::order::{TickPlace, skipped};
use crate::engine::snapshot::Saved;
use crate::engine::tissue::{Refusal, TissueEngine};
use crate::engine::tools::Felt;
use crate::session::ipc::tools::{Answer, TickForce};

/// After this many consecutive late poses the next new force is reached along a ramp.
const LATE_RUN: u32 = 4;

/// A served tissue.
pub struct Session<'a> {
    pub(super) engine: &'a mut dyn TissueEngine,
    shared: &'a Shared,
    /// Number of tools given by --tool.
    pub(super) chosen: usize,
    watchdog_ms: u32,
    hash_every: u64,
    charge: Charge,
    gate: SpeedGate,
    paused: bool,
    /// True if the last tick was in a pause.
    has_rested: bool,
    last_tick: Option<u64>,
    /// Last tick with sweeps.
    force_tick: u64,
    late_run: u32,
    /// Course of each tool; of held cells the first entry.
    courses: [Course; TOOLS_MAX],
    /// Number of ticks executed.
    pub executed: u64,
    /// Number of poses that never arrived, by their tick numbers.
    pub missing: u64,
}

impl<'a> Session<'a> {
    /// A session that starts at rest, or resumes as `charge` describes; paused or not.
    pub fn new(
        engine: &'a mut dyn TissueEngine,
        shared: &'a Shared,
        options: &ServeOptions,
        (charge, paused): (Charge, bool),
    ) -> Self {
        let chosen = engine.tools();
        let session = Self {
            engine,
            shared,
            chosen,
            watchdog_ms: options.watchdog_ms,
            hash_every: options.hash_every,
            charge,
            gate: SpeedGate::new(options.max_speed_m_per_s),
            paused,
            has_rested: false,
            last_tick: None,
            force_tick: 0,
            late_run: 0,
            courses: [Course::default(); TOOLS_MAX],
            executed: 0,
            missing: 0,
        };
        let has_stage = session.engine.has_stage();
        session.voice().begin(has_stage, session.charge.is_resumed());
        session
    }

    fn voice(&self) -> MutexGuard<'a, Voice> {
        self.shared.voice()
    }

    /// The publisher in charge, and the tools that were seen released.
    pub(super) fn charge(&self) -> &Charge {
        &self.charge
    }

    /// Returns true while paused: no tick is executed.
    #[must_use]
    pub fn is_paused(&self) -> bool {
        self.paused
    }

    /// Puts a publisher in charge. Another program may use another frame, and its hand has felt nothing so
    /// far: every tool counts as not engaged until it has been released.
    pub fn take_charge(&mut self, publisher: u128) {
        self.charge.take(publisher);
        self.gate.forget();
        self.voice().shaper.begin_ramp();
    }

    /// Classifies a tick of the publisher in charge. Returns its place, its distance from the tick before,
    /// and the distance between the two before.
    pub fn place(&mut self, tick: u64) -> (TickPlace, [u64; 2]) {
        let (place, steps) = self.charge.judge(tick);
        if place == TickPlace::Next {
            self.missing += steps[0] - 1;
        }
        (place, steps)
    }

    /// Accepts a pose whose tick is the next one, with the distances from [`Self::place`].
    pub fn accept(&mut self, mut arrived: Arrived, [step, usual]: [u64; 2]) -> Arrived {
        arrived.restarts_ramp = self.has_gap([step, usual], arrived.at_ns);
        if arrived.restarts_ramp {
            self.gate.forget();
        }
        self.gate.judge(&mut arrived, step);
        self.charge.release(&mut arrived);
        arrived
    }

    /// Returns true if the device was without a force, by the clock or by the ticks: the ramp then starts. A
    /// controller whose ticks always have larger distances has no gap.
    fn has_gap(&mut self, [step, usual]: [u64; 2], arrival_ns: u64) -> bool {
        let was_silent = self.voice().shaper.hear(arrival_ns);
        let bearable = u64::from(self.watchdog_ms);
        let is_gap = bearable != 0 && step > bearable && step / 2 > usual;
        if is_gap && !was_silent {
            self.voice().shaper.begin_ramp();
        }
        is_gap || was_silent
    }

    /// Prepares the tick of a pose: informs the stage of forces that the device did not apply, of lost
    /// samples and, if it is measured, of the delay.
    pub fn prepare(&mut self, arrived: &mut Arrived, delay_ticks: Option<u16>) {
        arrived.skipped = self.last_tick.map_or(0, |last| skipped(last, arrived.tick));
        self.last_tick = Some(arrived.tick);
        let felt_other = self.voice().take_felt_other();
        if self.paused {
            self.has_rested = true;
            return;
        }
        let has_rested = std::mem::take(&mut self.has_rested);
        arrived.restarts_ramp |= has_rested || felt_other;
        if arrived.restarts_ramp {
            self.engine.restart_ramp();
        }
        self.engine.skipped(arrived.skipped);
        if let Some(ticks) = delay_ticks {
            self.engine.delayed(ticks);
        }
    }

    /// Computes the tick of a pose with a sweep budget; force 0 while paused.
    pub fn tick(&mut self, arrived: &Arrived, budget: Budget<'_>) -> TickOutput {
        if self.paused {
            return self.rest();
        }
        self.engine.tick_by(arrived.poses.each(), budget)
    }

    /// The output while paused: force 0, safe state and no other flag; no cell moves.
    fn rest(&self) -> TickOutput {
        let last = self.voice().answer.map(|answer| answer.force);
        TickOutput {
            energy_j: last.map_or(0.0, |last| last.energy_j),
            contacts: last.map_or(0, |last| last.contacts),
            flags: Flags::SAFE_STATE,
            ..TickOutput::NONE
        }
    }

    /// Returns the answer of a tick, on time or late, with the force of tissue and stage.
    pub fn answer(&mut self, arrived: &Arrived, output: &TickOutput, step_ns: u64) -> Answer {
        self.executed += 1;
        // Start a ramp after a run of late poses.
        let is_late = output.flags.contains(Flags::LATE);
        self.late_run = if is_late { self.late_run + 1 } else { 0 };
        if self.late_run == LATE_RUN {
            self.voice().force_jumps();
        }
        // Collect hash, tool forces and flags.
        let is_hashed =
            !is_late && self.hash_every != 0 && self.executed.is_multiple_of(self.hash_every);
        let state_hash = if is_hashed { self.engine.state_hash() } else { 0 };
        let felt = self.felt(arrived);
        self.note(output, &felt);
        let mut flags = output.flags;
        if arrived.release_first.contains(&true) {
            flags.insert(Flags::RELEASE_FIRST);
        }
        felt.iter().for_each(|felt| flags.insert(felt.flags));
        let is_of_held = self.chosen == 0 && !self.paused;
        let force_error_n =
            if is_of_held { self.engine.force_error_n(0) } else { felt[0].force_error_n };
        let force = TickForce {
            tick: arrived.tick,
            force_n: output.force_n.into(),
            energy_j: output.energy_j,
            contacts: output.contacts,
            flags: flags.0,
            step_ns: u32::try_from(step_ns).unwrap_or(u32::MAX),
            state_hash,
            force_error_n,
        };
        if output.sweeps > 0 {
            self.force_tick = arrived.tick;
        }
        let (force_tick, chosen) = (self.force_tick, self.chosen as u32);
        let sweeps = output.sweeps.into();
        Answer { force, force_tick, sweeps, asked: arrived.asked, chosen, felt }
    }

    /// Notes what each tool does, except while paused.
    fn note(&mut self, output: &TickOutput, felt: &[Felt; TOOLS_MAX]) {
        if self.paused {
            return;
        }
        if let (0, Some(first)) = (self.chosen, self.courses.first_mut()) {
            first.add(output.force_n.into(), output.contacts, None);
        }
        for (tool, (course, felt)) in
            self.courses.iter_mut().zip(felt).enumerate().take(self.chosen)
        {
            course.add(felt.force_n, felt.contacts, self.engine.places_m(tool));
        }
    }

    /// Returns the course of each tool so far; of held cells one entry. Allocates memory.
    pub fn courses(&self) -> Vec<ToolCourse> {
        self.courses.iter().take(self.chosen.max(1)).map(Course::result).collect()
    }

    /// Output of each chosen tool in the tick; no force while paused.
    fn felt(&mut self, arrived: &Arrived) -> [Felt; TOOLS_MAX] {
        let mut all = [Felt::default(); TOOLS_MAX];
        if self.chosen == 0 {
            return all;
        }
        let before = self.voice().answer;
        for (tool, felt) in all.iter_mut().enumerate().take(self.chosen) {
            if self.paused {
                felt.contacts = before.map_or(0, |before| before.felt[tool].contacts);
            } else {
                *felt = self.engine.felt(tool);
            }
            if arrived.release_first[tool] {
                felt.flags.insert(Flags::RELEASE_FIRST);
            }
        }
        all
    }

    /// Returns the published form of an answer.
    pub fn publish(&mut self, answer: Answer, now_ns: u64) -> Answer {
        self.voice().shown(answer, self.charge.withheld(), now_ns)
    }

    /// Returns a message to publish while no pose arrives, if one is due.
    pub fn silence(&mut self, now_ns: u64) -> Option<Answer> {
        self.voice().falling(now_ns)
    }

    /// Notes how far a tick ended after the poses: an overload lowers the force, and its end lets it return.
    pub fn judge(&mut self, behind: Behind, span_ns: [u64; 2]) {
        self.voice().judge(behind, span_ns);
    }

    /// The whole state of tissue and output stage; `None` if it cannot be saved. Allocates memory.
    pub fn saved(&mut self) -> Option<Saved> {
        self.engine.saved()
    }

    /// The last tick, which may be one before the snapshot that the session resumed from; 0 for none.
    #[must_use]
    pub fn last_tick(&self) -> u64 {
        let before = self.charge.last_tick_before();
        self.voice().answer.map_or(before, |last| last.force.tick)
    }

    /// Executes a command other than a snapshot.
    ///
    /// # Errors
    /// The reason for the refusal.
    pub fn obey(&mut self, command: &Command) -> Result<(), Refusal> {
        match command {
            Command::Pause => self.paused = true,
            Command::Resume => self.paused = false,
            other => self.engine.command(other)?,
        }
        let mut voice = self.voice();
        voice.obeyed(command);
        if let (Command::Reset, Some(last)) = (command, &mut voice.answer) {
            let state_hash = self.engine.state_hash();
            last.force = TickForce { energy_j: 0.0, contacts: 0, state_hash, ..last.force };
            last.felt.iter_mut().for_each(|felt| felt.contacts = 0);
        }
        Ok(())
    }
}
