//! The ticks: one with sweeps for the newest pose, one without for a pose that newer ones have
//! overtaken.

use chaincell_kernel::{Flags, TickOutput};

use super::intake::Arrived;
use super::overload::{Behind, FAR};
use super::{Run, ServeOptions};
use crate::engine::tissue::{Sweeps, TissueEngine};
use crate::session::timing::clock::now_ns;

/// Late poses on end from which on the next new force is gone to along a ramp.
const LATE_RUN: u32 = 4;

impl Run<'_> {
    /// A tick of its own, with sweeps, for the newest pose or where the count is fixed.
    pub(super) fn execute(&mut self, mut arrived: Arrived) {
        let start_ns = now_ns();
        self.resumes(&mut arrived);
        (self.late_run, self.behind_gap) = (0, false);
        self.shared.begin_tick();
        self.delay.told = None;
        let output = if self.paused { self.rest() } else { self.tick(arrived, start_ns) };
        self.shared.end_tick();
        let end_ns = now_ns();
        let step_ns = end_ns - start_ns;
        self.delay.took(step_ns);
        self.executed += 1;
        let every = self.server.options.hash_every;
        let hashed = every != 0 && self.executed.is_multiple_of(every);
        let state_hash = if hashed { self.engine.state_hash() } else { 0 };
        let is_anytime = self.is_anytime();
        self.publish(arrived, &output, step_ns, state_hash);
        if self.paused {
            self.paused_ticks += 1;
            return;
        }
        self.step.record(step_ns);
        self.sweeps.record(u64::from(output.sweeps));
        self.changed();
        let sent_ns = now_ns();
        self.take_in();
        let is_behind = !self.inbox.is_empty();
        self.budget.answered(sent_ns.saturating_sub(end_ns), is_behind, sent_ns);
        let behind = match is_anytime {
            true if output.sweeps == 1 && step_ns > self.budget.period_ns() => Behind::Yes,
            true => Behind::No,
            false if self.inbox.len() >= FAR => Behind::Far,
            false if is_behind => Behind::Yes,
            false => Behind::No,
        };
        self.shared.voice().judge(behind, [start_ns, sent_ns]);
    }

    /// The first tick after a pause: the device had no force, and the stage did not see it move.
    fn resumes(&mut self, arrived: &mut Arrived) {
        arrived.restarts_ramp |= self.has_rested && !self.paused;
        self.has_rested = self.paused;
    }

    /// The tissue's tick: as many sweeps as its time has room for.
    fn tick(&mut self, arrived: Arrived, start_ns: u64) -> TickOutput {
        self.measure_delay(&arrived, start_ns);
        if arrived.restarts_ramp {
            self.engine.restart_ramp();
        }
        let &ServeOptions { sweep_ns, sweep_after, .. } = &self.server.options;
        let stretch_ns = if self.executed < sweep_after { 0 } else { sweep_ns };
        let stretched = |sweeps: u16| {
            while now_ns() < start_ns + u64::from(sweeps) * stretch_ns {
                std::hint::spin_loop();
            }
            now_ns()
        };
        if !self.is_anytime() {
            let output = advance(self.engine, &arrived, Sweeps::ALL);
            stretched(output.sweeps);
            return output;
        }
        let budget = &mut self.budget;
        budget.begin(arrived.at_ns, start_ns);
        let mut done_ns = 0;
        let mut more = |done| {
            done_ns = stretched(done);
            budget.more(done_ns)
        };
        let output = advance(self.engine, &arrived, Sweeps::While(&mut more));
        let end_ns = stretched(output.sweeps);
        budget.end(end_ns, output.sweeps);
        output
    }

    /// A tick without a sweep, for a pose that newer ones have overtaken.
    pub(super) fn execute_late(&mut self, mut arrived: Arrived) {
        let start_ns = now_ns();
        self.resumes(&mut arrived);
        self.measure_delay(&arrived, start_ns);
        if arrived.restarts_ramp {
            self.engine.restart_ramp();
        }
        let output = advance(self.engine, &arrived, Sweeps::LATE);
        self.executed += 1;
        let late = u64::from(output.flags.contains(Flags::LATE));
        self.behind_gap |= arrived.restarts_ramp;
        self.late += late;
        self.late_behind_gaps += if self.behind_gap { late } else { 0 };
        self.late_run += 1;
        if self.late_run == LATE_RUN {
            self.shared.voice().shaper.begin_ramp();
        }
        self.publish(arrived, &output, now_ns() - start_ns, 0);
    }
}

/// The tissue's tick for a pose, or for the poses of all tools.
fn advance(engine: &mut dyn TissueEngine, arrived: &Arrived, sweeps: Sweeps<'_>) -> TickOutput {
    match arrived.tools.each() {
        [] => engine.tick_by(&arrived.pose.into(), sweeps),
        _ => engine.tick_tools(&arrived.tools, sweeps),
    }
}
