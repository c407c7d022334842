//! `Rate`: a loop whose turns begin on a schedule.

use chaincell_client::clock::{SECOND_NS, now_ns, sleep_until_ns};
use pyo3::prelude::*;

use crate::errors::Class;
use crate::signals::{LOOK, span_ns};

/// The last stretch before a turn is polled, since a sleep ends late \[ns\].
const APPROACH_NS: u64 = 60_000;

/// Gives 0, 1, 2 and so on, each at its moment of a schedule, and leaves none out. A turn that is more
/// than a period late begins at once and moves the schedule: a server sleeps until a pose is due, so poses
/// that caught up would be answered late, and dropped beyond 2,000 a second.
#[pyclass(module = "chaincell")]
pub(crate) struct Rate {
    hz: f64,
    ticks: Option<u64>,
    next: u64,
    start_ns: Option<u64>,
    /// Turns that began more than a period late.
    #[pyo3(get)]
    late: u64,
}

#[pymethods]
impl Rate {
    /// So many turns a second; so many turns, so many seconds, or without an end.
    #[new]
    #[pyo3(signature = (hz=1000.0, *, ticks=None, seconds=None))]
    fn new(hz: f64, ticks: Option<u64>, seconds: Option<f64>) -> PyResult<Self> {
        if !(0.001..=1e6).contains(&hz) {
            let text = format!("`hz` {hz}: must be from 0.001 to 1000000");
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
            (ticks, None) => ticks,
        };
        Ok(Self { hz, ticks, next: 0, start_ns: None, late: 0 })
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__(&mut self, py: Python<'_>) -> PyResult<Option<u64>> {
        if self.ticks.is_some_and(|ticks| self.next >= ticks) {
            return Ok(None);
        }
        let start_ns = *self.start_ns.get_or_insert_with(now_ns);
        let period_ns = SECOND_NS as f64 / self.hz;
        let due_ns = start_ns + (self.next as f64 * period_ns) as u64;
        let look_ns = LOOK.as_nanos() as u64;
        loop {
            let now_ns = now_ns();
            if now_ns >= due_ns {
                let late_ns = now_ns - due_ns;
                if late_ns as f64 > period_ns {
                    self.late += 1;
                    self.start_ns = Some(start_ns + late_ns);
                }
                break;
            }
            py.detach(|| wait_until(due_ns.min(now_ns + look_ns)));
            py.check_signals()?;
        }
        self.next += 1;
        Ok(Some(self.next - 1))
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
