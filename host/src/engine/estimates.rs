//! The estimated errors of the forces of a run.

use std::fmt;

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::words::counted;

/// Unit of the histogram, and its largest value: a micronewton and some kilonewtons \[N\].
const UNIT_N: f64 = 1e-6;
const LARGEST: u64 = 1 << 32;
/// Significant decimal digits of a percentile.
const DIGITS: u8 = 3;

/// Estimated errors of the forces of a run or a session, see
/// [`TissueMut::force_error_n`](chaincell_kernel::TissueMut::force_error_n), as shares of the largest force whose error
/// is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForceEstimate {
    /// Ticks of which the error is known; of several tools each counts.
    pub ticks: u64,
    /// Ticks with a force of which it is not.
    pub unknown_ticks: u64,
    /// Half of the known ones are within.
    pub median: f64,
    /// 99 of 100 are.
    pub p99: f64,
}

impl fmt::Display for ForceEstimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [median, p99] = [self.median, self.p99].map(|share| format!("{:.1} %", 100.0 * share));
        write!(f, "within {median} of the largest (median), {p99} (99 of 100 ticks), by estimate")?;
        match self.unknown_ticks {
            0 => Ok(()),
            ticks => write!(f, "; not known in {}", counted(ticks, "tick")),
        }
    }
}

/// Gathers the estimates of a run or a session, in memory of fixed size.
#[derive(Debug, Clone)]
pub struct Estimates {
    known: Histogram<u64>,
    unknown_ticks: u64,
    largest_n: f32,
}

impl Estimates {
    /// None yet; all memory is allocated.
    ///
    /// # Errors
    /// Too little memory.
    pub fn new() -> Result<Self> {
        let known = Histogram::new_with_bounds(1, LARGEST, DIGITS)
            .map_err(|why| Error::check(format!("cannot set up a histogram of errors: {why}")))?;
        Ok(Self { known, unknown_ticks: 0, largest_n: 0.0 })
    }

    /// Adds the force on a tool in a tick, which is none without `contacts`, and its estimated error. Does not
    /// allocate.
    pub fn add(&mut self, force_n: [f32; 3], contacts: u32, error_n: Option<f32>) {
        if contacts == 0 {
            return;
        }
        let Some(error_n) = error_n else {
            self.unknown_ticks += 1;
            return;
        };
        let squares = force_n.map(|of| of * of);
        self.largest_n = self.largest_n.max(squares.iter().sum::<f32>().sqrt());
        self.known.saturating_record((f64::from(error_n) / UNIT_N) as u64);
    }

    /// The estimates by size; `None` if none is known, or if no force acted.
    #[must_use]
    pub fn result(&self) -> Option<ForceEstimate> {
        let (ticks, unknown_ticks) = (self.known.len(), self.unknown_ticks);
        if ticks == 0 || self.largest_n <= 0.0 {
            return None;
        }
        let share = UNIT_N / f64::from(self.largest_n);
        let [median, p99] = [0.5, 0.99].map(|of| share * self.known.value_at_quantile(of) as f64);
        Some(ForceEstimate { ticks, unknown_ticks, median, p99 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_are_shares_of_the_largest_force() {
        let mut estimates = Estimates::new().unwrap();
        assert_eq!(estimates.result(), None);
        estimates.add([0.0, 0.0, 9.0], 0, None);
        (0..98).for_each(|_| estimates.add([0.0, 3.0, 4.0], 1, Some(0.05)));
        (0..2).for_each(|_| estimates.add([0.0, 0.0, 1.0], 2, Some(0.1)));
        let result = estimates.result().unwrap();
        assert_eq!((result.ticks, result.unknown_ticks), (100, 0));
        assert!((result.median - 0.01).abs() < 1e-5 && (result.p99 - 0.02).abs() < 2e-5);
        let text = "within 1.0 % of the largest (median), 2.0 % (99 of 100 ticks), by estimate";
        assert_eq!(result.to_string(), text);
        // A force whose error is not known sets no scale.
        estimates.add([50.0, 0.0, 0.0], 1, None);
        assert_eq!(estimates.result().unwrap().p99, result.p99);
        assert!(estimates.result().unwrap().to_string().ends_with("; not known in 1 tick"));
    }
}
