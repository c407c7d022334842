//! Figures of a session under load, and its verdict.

use serde::Serialize;

use super::histogram::{self, Histograms};
use crate::error::{Error, Result};
use crate::session::loops::control::ControlReport;
use crate::session::loops::load::LoadFigures;
use crate::session::timing::machine::Machine;
use crate::session::timing::memory::Growth;
use crate::terminal;
use crate::words::counted;

/// Answers that came more than 1 ms after the scheduled send, by their cause.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Missed {
    /// Number of these answers.
    pub total: u64,
    /// The pose was itself sent more than 1 ms late: the controller was not woken.
    pub sent_late: u64,
    /// The tick took more than 1 ms.
    pub in_step: u64,
    /// The others: a process was woken late on the way, or the pose waited in the queue.
    pub on_the_way: u64,
    /// Number of answers in all.
    pub ticks: u64,
    /// Number of these answers in a million.
    pub in_a_million: f64,
}

impl Missed {
    /// Returns the missed deadlines of a controller's run.
    #[must_use]
    pub fn of(run: &ControlReport) -> Self {
        let (total, sent_late, in_step) =
            (run.missed_deadlines, run.missed_sent_late, run.missed_in_step);
        let on_the_way = total.saturating_sub(sent_late + in_step);
        let ticks = run.ticks_answered;
        Self { total, sent_late, in_step, on_the_way, ticks, ..Self::default() }.counted()
    }

    /// Returns the sum of both.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        Self {
            total: self.total + other.total,
            sent_late: self.sent_late + other.sent_late,
            in_step: self.in_step + other.in_step,
            on_the_way: self.on_the_way + other.on_the_way,
            ticks: self.ticks + other.ticks,
            in_a_million: 0.0,
        }
        .counted()
    }

    fn counted(self) -> Self {
        Self { in_a_million: self.total as f64 * 1e6 / self.ticks.max(1) as f64, ..self }
    }
}

/// Missed deadlines of the machine itself: the same loops under the same load, without a tissue.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct FloorMissed {
    /// Those before the session.
    pub before: Missed,
    /// Those after it; zero if the session was interrupted.
    pub after: Missed,
    /// Their sum.
    pub both: Missed,
}

/// Report of a session under load, in `summary.json`.
#[derive(Debug, Clone, Default, Serialize)]
pub struct LoadReport {
    /// The command line.
    pub command: String,
    /// The machine.
    pub machine: Machine,
    /// The load.
    #[serde(flatten)]
    pub load: LoadFigures,
    /// Length of one press, which is played over and over \[s\].
    pub press_s: f64,
    /// Answers later than 1 ms after the scheduled send.
    pub missed: Missed,
    /// Those of the machine itself.
    pub floor_missed: FloorMissed,
    /// The histograms.
    pub histograms: Histograms,
    /// Memory of the tissue's process.
    pub memory_serve: Growth,
    /// Memory of the controller's process.
    pub memory_control: Growth,
}

impl LoadReport {
    /// Compares a controller's run under load with those without a tissue before and after it.
    #[must_use]
    pub fn of(run: &ControlReport, before: &ControlReport, after: Option<&ControlReport>) -> Self {
        let missed = |run: Option<&ControlReport>| run.map(Missed::of).unwrap_or_default();
        let spans = |run: Option<&ControlReport>| {
            run.and_then(|run| run.histogram.clone()).unwrap_or_default()
        };
        let (first, last) = (missed(Some(before)), missed(after));
        let (own, one, two) = (spans(Some(run)), spans(Some(before)), spans(after));
        Self {
            command: std::env::args().collect::<Vec<_>>().join(" "),
            machine: Machine::read(),
            missed: Missed::of(run),
            floor_missed: FloorMissed { before: first, after: last, both: first.and(&last) },
            histograms: Histograms {
                wakeup: own.send_late,
                round_trip: own.round_trip,
                floor_wakeup: one.send_late.and(&two.send_late),
                floor_round_trip: one.round_trip.and(&two.round_trip),
                ..Histograms::default()
            },
            ..Self::default()
        }
    }

    /// Checks the memory.
    ///
    /// # Errors
    /// Memory that grew, or that was looked at less than twice.
    pub fn judge(&self) -> Result<()> {
        for (side, memory) in self.sides() {
            if memory.looks < 2 {
                return Err(Error::check(format!(
                    "the memory of chaincell {side} could not be looked at twice: run longer"
                )));
            }
            if memory.growth_kb > 0 {
                return Err(Error::check(format!(
                    "chaincell {side} grew by {} kB after its warm-up, from {} kB",
                    memory.growth_kb, memory.first_kb
                )));
            }
        }
        Ok(())
    }

    /// Prints the report.
    ///
    /// # Errors
    /// Standard output that cannot be written.
    pub fn print(&self) -> Result<()> {
        // Print the machine, its load and the command.
        let machine = &self.machine;
        terminal::say(format_args!(
            "{}, {}, {}; load: {}, {:.1} GB/s{}",
            machine.processor,
            counted(machine.cores, "core"),
            machine.system,
            counted(self.load.threads, "thread"),
            self.load.gb_per_s,
            if machine.optimised { "" } else { "; a debug build" }
        ))?;
        terminal::say(format_args!("{}", self.command))?;
        // Print the largest times, and the deadlines missed.
        terminal::say(histogram::maxima(&self.histograms).trim_end())?;
        let (missed, floor) = (&self.missed, &self.floor_missed.both);
        for (name, missed) in [("later than 1 ms", missed), ("machine alone", floor)] {
            terminal::say(format_args!(
                "  {name:<18}{} of {} ({:.1} in a million): {} sent late, {} in the step, {} on the way",
                missed.total,
                missed.ticks,
                missed.in_a_million,
                missed.sent_late,
                missed.in_step,
                missed.on_the_way
            ))?;
        }
        // Print the memory of both sides, and the histograms.
        for (side, memory) in self.sides() {
            terminal::say(format_args!(
                "  {:<18}{} kB after the warm-up, growth {} kB, {} page faults, {} looks",
                format!("memory {side}"),
                memory.first_kb,
                memory.growth_kb,
                memory.minor_faults + memory.major_faults,
                memory.looks
            ))?;
        }
        terminal::say(histogram::text(&self.histograms).trim_end())
    }

    fn sides(&self) -> [(&'static str, &Growth); 2] {
        [("serve", &self.memory_serve), ("control", &self.memory_control)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_more_fails() {
        let steady = Growth { first_kb: 100, most_kb: 100, looks: 3, ..Growth::default() };
        let report =
            || LoadReport { memory_serve: steady, memory_control: steady, ..LoadReport::default() };
        report().judge().unwrap();
        for side in ["serve", "control"] {
            let mut grown = report();
            let memory = match side {
                "serve" => &mut grown.memory_serve,
                _ => &mut grown.memory_control,
            };
            memory.growth_kb = 4;
            let error = grown.judge().unwrap_err();
            assert_eq!(error.exit_code(), 1);
            assert!(error.to_string().contains(&format!("{side} grew by 4 kB")), "{error}");
        }
        let mut smaller = report();
        smaller.memory_serve.growth_kb = -4;
        smaller.judge().unwrap();
        let mut blind = report();
        blind.memory_control.looks = 1;
        assert!(blind.judge().unwrap_err().to_string().contains("run longer"));
    }

    #[test]
    fn missed_deadlines_add_up() {
        let part = Missed {
            total: 5,
            sent_late: 1,
            in_step: 2,
            on_the_way: 2,
            ticks: 1000,
            ..Missed::default()
        };
        let both = part.and(&part);
        assert_eq!((both.total, both.ticks, both.on_the_way), (10, 2000, 4));
        assert!((both.in_a_million - 5000.0).abs() < 1e-9);
        assert_eq!(Missed::default().and(&Missed::default()).in_a_million, 0.0);
    }
}
