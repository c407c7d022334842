//! The ticks: with sweeps for the newest pose, without sweeps for a pose that newer ones have overtaken.

use chaincell_kernel::{Budget, Flags, TickOutput};

use super::arrived::Arrived;
use super::overload::{Behind, FAR};
use super::{Run, ServeOptions};
use crate::session::timing::clock::now_ns;

impl Run<'_> {
    /// Executes a tick with sweeps, for the newest pose or with a fixed number of sweeps.
    pub(super) fn execute(&mut self, mut arrived: Arrived) {
        let start_ns = now_ns();
        self.behind_gap = false;
        // Compute, measure and publish.
        self.shared.begin_tick();
        let output = self.tick(&mut arrived, start_ns);
        self.shared.end_tick();
        let end_ns = now_ns();
        let step_ns = end_ns - start_ns;
        self.delay.took(step_ns);
        let is_anytime = self.is_anytime();
        self.publish(&arrived, &output, step_ns);
        if self.session.is_paused() {
            self.paused_ticks += 1;
            return;
        }
        self.step.record(step_ns);
        self.sweeps.record(u64::from(output.sweeps));
        self.changed();
        // Check for poses that arrived meanwhile, and judge the load.
        let sent_ns = now_ns();
        self.take_in();
        let is_behind = !self.inbox.is_empty();
        self.budget.answered(sent_ns.saturating_sub(end_ns), is_behind, sent_ns);
        let behind = match is_anytime {
            true if self.budget.is_behind(output.sweeps, step_ns) => Behind::Yes,
            true => Behind::No,
            false if self.inbox.len() >= FAR => Behind::Far,
            false if is_behind => Behind::Yes,
            false => Behind::No,
        };
        self.session.judge(behind, [start_ns, sent_ns]);
    }

    /// Prepares the stage, then makes as many sweeps as fit the time.
    fn tick(&mut self, arrived: &mut Arrived, start_ns: u64) -> TickOutput {
        self.prepare(arrived, start_ns);
        if self.session.is_paused() {
            return self.session.tick(arrived, Budget::All);
        }
        // Stretch sweeps for a fault on purpose.
        let &ServeOptions { sweep_ns, sweep_after, .. } = &self.server.options;
        let stretch_ns = if self.session.executed < sweep_after { 0 } else { sweep_ns };
        let stretched = |sweeps: u16| {
            while now_ns() < start_ns + u64::from(sweeps) * stretch_ns {
                std::hint::spin_loop();
            }
            now_ns()
        };
        // A fixed number of sweeps.
        if !self.is_anytime() {
            let output = self.session.tick(arrived, Budget::All);
            stretched(output.sweeps);
            return output;
        }
        // As many sweeps as the budget allows.
        let budget = &mut self.budget;
        budget.begin(arrived.at_ns, start_ns);
        let mut done_ns = 0;
        let mut more = |done| {
            done_ns = stretched(done);
            budget.more(done_ns)
        };
        let budget_of_tick = match self.server.options.force_error {
            Some(share) => Budget::Within { share, more: Some(&mut more) },
            None => Budget::While(&mut more),
        };
        let output = self.session.tick(arrived, budget_of_tick);
        let end_ns = stretched(output.sweeps);
        budget.end(end_ns, output.sweeps);
        output
    }

    fn prepare(&mut self, arrived: &mut Arrived, start_ns: u64) {
        self.delay.told = None;
        if !self.session.is_paused() {
            self.measure_delay(arrived, start_ns);
        }
        self.session.prepare(arrived, self.delay.told);
    }

    /// A tick without a sweep, for a pose that newer ones have overtaken.
    pub(super) fn execute_late(&mut self, mut arrived: Arrived) {
        let start_ns = now_ns();
        self.prepare(&mut arrived, start_ns);
        let output = self.session.tick(&arrived, Budget::LATE);
        let late = u64::from(output.flags.contains(Flags::LATE));
        self.behind_gap |= arrived.restarts_ramp;
        self.late += late;
        self.late_behind_gaps += if self.behind_gap { late } else { 0 };
        self.publish(&arrived, &output, now_ns() - start_ns);
    }
}
