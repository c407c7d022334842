//! All figures of a long run, and the verdict.

use serde::Serialize;

use super::load::LoadFigures;
use super::memory::Growth;
use crate::experiments::report::machine::Machine;
use chaincell_host::error::{Error, Result};
use chaincell_host::session::loops::control::ControlReport;
use chaincell_host::session::timing::spans::Spans;

/// Answers that came more than 1 ms after the scheduled send, by what kept them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Missed {
    /// All of them.
    pub total: u64,
    /// The pose was itself sent more than 1 ms late: the controller was not woken.
    pub sent_late: u64,
    /// The tick took more than 1 ms.
    pub in_step: u64,
    /// The others: woken late on the way, or queued behind such a one.
    pub on_the_way: u64,
    /// Ticks among which these are.
    pub ticks: u64,
    /// All of them, of a million ticks.
    pub in_a_million: f64,
}

impl Missed {
    /// The missed deadlines of a controller's run.
    #[must_use]
    pub fn of(run: &ControlReport) -> Self {
        let (total, sent_late, in_step) =
            (run.missed_deadlines, run.missed_sent_late, run.missed_in_step);
        let on_the_way = total.saturating_sub(sent_late + in_step);
        let ticks = run.ticks_answered;
        Self { total, sent_late, in_step, on_the_way, ticks, ..Self::default() }.counted()
    }

    /// These and those together.
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

/// The machine's own: the same loops under the same load, without a tissue.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct SoakFloor {
    /// Missed deadlines before the run.
    pub before: Missed,
    /// Missed deadlines after it.
    pub after: Missed,
    /// Both.
    pub both: Missed,
    /// How late the controller woke up.
    pub wakeup: Spans,
    /// From a send to its answer.
    pub round_trip: Spans,
}

impl SoakFloor {
    /// The floor of the loops before and after a run; without the latter where it was interrupted.
    #[must_use]
    pub fn of(before: &ControlReport, after: Option<&ControlReport>) -> Self {
        let missed = |run: Option<&ControlReport>| run.map(Missed::of).unwrap_or_default();
        let spans = |run: Option<&ControlReport>| {
            run.and_then(|run| run.histogram.clone()).unwrap_or_default()
        };
        let (first, last) = (missed(Some(before)), missed(after));
        let (one, two) = (spans(Some(before)), spans(after));
        Self {
            before: first,
            after: last,
            both: first.and(&last),
            wakeup: one.send_late.and(&two.send_late),
            round_trip: one.round_trip.and(&two.round_trip),
        }
    }
}

/// A long run: soak.json.
#[derive(Debug, Clone, Default, Serialize)]
pub struct SoakReport {
    /// The command line.
    pub command: String,
    /// Where it ran.
    pub machine: Machine,
    /// Release of the running kernel, as `uname -r` prints it.
    pub kernel: String,
    /// The load beside it.
    pub load: LoadFigures,
    /// Cells of the model.
    pub cells: usize,
    /// Links of the model.
    pub links: usize,
    /// Length of one press, played over and over \[s\].
    pub press_s: f64,
    /// Poses sent, one a millisecond.
    pub ticks_sent: u64,
    /// Poses answered.
    pub ticks_answered: u64,
    /// Answers later than 1 ms after the scheduled send.
    pub missed: Missed,
    /// The same of the machine alone.
    pub floor: SoakFloor,
    /// How late the controller woke up.
    pub wakeup: Spans,
    /// Time of a tick.
    pub step: Spans,
    /// From a send to its answer.
    pub round_trip: Spans,
    /// Memory of the tissue's process.
    pub memory_serve: Growth,
    /// Memory of the controller's process.
    pub memory_control: Growth,
    /// Hash of the final state.
    pub state_hash: String,
    /// Whether the user asked to stop before the end.
    pub interrupted: bool,
    /// Privileges that were refused, with the reason.
    pub refused: Vec<String>,
}

impl SoakReport {
    /// The histograms with their names, in the order of columns.
    #[must_use]
    pub fn histograms(&self) -> [(&'static str, &Spans); 5] {
        [
            ("wakeup", &self.wakeup),
            ("step", &self.step),
            ("round_trip", &self.round_trip),
            ("floor_wakeup", &self.floor.wakeup),
            ("floor_round_trip", &self.floor.round_trip),
        ]
    }

    /// Whether the run passed.
    ///
    /// # Errors
    /// The user's wish to stop; ticks without an answer; memory that grew, or was not looked at
    /// twice.
    pub fn judge(&self) -> Result<()> {
        if self.interrupted {
            return Err(Error::Interrupted);
        }
        if self.ticks_answered != self.ticks_sent {
            return Err(Error::check(format!(
                "{} of {} ticks were answered",
                self.ticks_answered, self.ticks_sent
            )));
        }
        for (side, memory) in [("serve", &self.memory_serve), ("control", &self.memory_control)] {
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
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::experiments::soak) fn report() -> SoakReport {
        let steady = Growth { first_kb: 100, most_kb: 100, looks: 3, ..Growth::default() };
        SoakReport {
            ticks_sent: 4000,
            ticks_answered: 4000,
            memory_serve: steady,
            memory_control: steady,
            ..SoakReport::default()
        }
    }

    #[test]
    fn a_lost_tick_or_a_page_more_fails() {
        report().judge().unwrap();
        let lost = SoakReport { ticks_answered: 3999, ..report() };
        assert!(lost.judge().unwrap_err().to_string().contains("3999 of 4000"));
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
        let stopped = SoakReport { interrupted: true, ticks_answered: 3999, ..report() };
        assert_eq!(stopped.judge().unwrap_err().exit_code(), 130);
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
