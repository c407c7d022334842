//! `Rate`: a loop whose turns begin on a schedule.

use std::sync::{Mutex, MutexGuard, PoisonError};

use chaincell_client::clock::{SECOND_NS, now_ns, sleep_until_ns};
use pyo3::prelude::*;

use crate::errors::Class;
use crate::numbers::{Arg, brief, whole};
use crate::signals::{LOOK, span_ns};

/// The last stretch before a turn is polled, since a sleep ends late \[ns\].
const APPROACH_NS: u64 = 60_000;

/// A loop at a fixed rate: gives 0, 1, 2 and so on, each at its moment, and leaves none out. A turn
/// that is more than a period late begins at once and moves the schedule: a server sleeps until a pose
/// is due, so poses that caught up would be answered late, and dropped beyond 2,000 a second.
///
/// - `hz`: turns a second, 0.001 to 1,000,000.
/// - `ticks` or `seconds`: number of turns, or length [s]; without both it has no end.
///
/// Raises `ArgumentError` for values out of range.
///
/// >>> [turn for turn in chaincell.Rate(1000, ticks=3)]
/// [0, 1, 2]
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Rate {
    hz: f64,
    ticks: Option<u64>,
    /// Nobody waits with it, or calls Python.
    schedule: Mutex<Schedule>,
}

#[derive(Debug, Default)]
struct Schedule {
    next: u64,
    start_ns: Option<u64>,
    /// Turns that began more than a period late.
    late: u64,
}

impl Rate {
    fn schedule(&self) -> MutexGuard<'_, Schedule> {
        self.schedule.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next turn, which the caller has from here on, and when it is due \[ns\]; none behind the last.
    fn take(&self) -> Option<(u64, u64)> {
        let mut of = self.schedule();
        if self.ticks.is_some_and(|ticks| of.next >= ticks) {
            return None;
        }
        let turn = of.next;
        of.next += 1;
        let start_ns = *of.start_ns.get_or_insert_with(now_ns);
        Some((turn, self.due_ns(start_ns, turn)))
    }

    /// Where a turn is late, by the schedule as another thread's turn may have moved it, moves it.
    fn begin(&self, turn: u64, now_ns: u64) {
        let mut of = self.schedule();
        let Some(start_ns) = of.start_ns else { return };
        let late_ns = now_ns.saturating_sub(self.due_ns(start_ns, turn));
        if late_ns as f64 > self.period_ns() {
            of.late += 1;
            of.start_ns = Some(start_ns + late_ns);
        }
    }

    fn due_ns(&self, start_ns: u64, turn: u64) -> u64 {
        start_ns.saturating_add((turn as f64 * self.period_ns()) as u64)
    }

    fn period_ns(&self) -> f64 {
        SECOND_NS as f64 / self.hz
    }
}

#[pymethods]
impl Rate {
    /// Begins the schedule with the first turn.
    #[new]
    #[pyo3(
        signature = (hz=Arg::Default(1000.0), *, ticks=None, seconds=None),
        text_signature = "(hz=1000.0, *, ticks=None, seconds=None)"
    )]
    fn new(
        hz: Arg<'_, f64>,
        ticks: Option<&Bound<'_, PyAny>>,
        seconds: Option<Arg<'_, f64>>,
    ) -> PyResult<Self> {
        let hz = hz.real("hz")?;
        if !(0.001..=1e6).contains(&hz) {
            let text = format!("`hz` {}: must be from 0.001 to 1000000", brief(hz));
            return Err(Class::Argument.error(text));
        }
        let ticks = match (ticks, seconds) {
            (Some(_), Some(_)) => {
                return Err(Class::Argument.error("`ticks` and `seconds`: give one of both"));
            }
            (None, Some(seconds)) => {
                let span_ns = span_ns("seconds", seconds)?;
                Some((span_ns as f64 * 1e-9 * hz).round() as u64)
            }
            (Some(ticks), None) => Some(whole("ticks", ticks, 0..=i64::MAX as u64)?),
            (None, None) => None,
        };
        Ok(Self { hz, ticks, schedule: Mutex::default() })
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__(&self, py: Python<'_>) -> PyResult<Option<u64>> {
        let Some((turn, due_ns)) = self.take() else { return Ok(None) };
        let look_ns = LOOK.as_nanos() as u64;
        loop {
            let now_ns = now_ns();
            if now_ns >= due_ns {
                self.begin(turn, now_ns);
                return Ok(Some(turn));
            }
            py.detach(|| wait_until(due_ns.min(now_ns + look_ns)));
            py.check_signals().inspect_err(|_| {
                // Without another thread that took the next one, this turn is still to come.
                let mut of = self.schedule();
                of.next = if of.next == turn + 1 { turn } else { of.next };
            })?;
        }
    }

    fn __repr__(&self) -> String {
        let Schedule { next, late, .. } = *self.schedule();
        format!("<chaincell.Rate: {} Hz, turn {next} is next, {late} late>", self.hz)
    }

    /// Number of turns that began more than a period late.
    #[getter]
    fn late(&self) -> u64 {
        self.schedule().late
    }
}

/// Sleeps, then polls.
fn wait_until(due_ns: u64) {
    if due_ns.saturating_sub(now_ns()) > APPROACH_NS {
        sleep_until_ns(due_ns - APPROACH_NS);
    }
    while now_ns() < due_ns {
        std::hint::spin_loop();
    }
}
