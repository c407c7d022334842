//! The estimated errors of the forces of a run.

use std::fmt;

use serde::Serialize;

use super::convergence::Errors;
use crate::words::counted;

/// Estimated errors of the forces of a run, see
/// [`TissueMut::force_error_n`](chaincell_kernel::TissueMut::force_error_n), as shares of the largest force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ForceEstimate {
    /// Ticks of which the error is known; of several tools each counts.
    pub ticks: usize,
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

/// Gathers the estimates of a run.
#[derive(Debug, Clone, Default)]
pub struct Estimates {
    known_n: Vec<f32>,
    unknown_ticks: u64,
    largest_n: f32,
}

impl Estimates {
    /// Adds the force on a tool in a tick, which is none without `contacts`, and its estimated error.
    pub fn add(&mut self, force_n: [f32; 3], contacts: u32, error_n: Option<f32>) {
        if contacts == 0 {
            return;
        }
        let squares = force_n.map(|of| of * of);
        self.largest_n = self.largest_n.max(squares.iter().sum::<f32>().sqrt());
        match error_n {
            Some(error_n) => self.known_n.push(error_n),
            None => self.unknown_ticks += 1,
        }
    }

    /// The estimates by size; `None` if none is known, or if no force acted.
    #[must_use]
    pub fn result(&self) -> Option<ForceEstimate> {
        let largest_n = f64::from(self.largest_n);
        let shares = self.known_n.iter().map(|&error_n| f64::from(error_n) / largest_n);
        let errors = Errors::of(shares.filter(|share| share.is_finite()))?;
        let (ticks, median, p99) = (errors.count(), errors.within(50), errors.within(99));
        Some(ForceEstimate { ticks, unknown_ticks: self.unknown_ticks, median, p99 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_are_shares_of_the_largest_force() {
        let mut estimates = Estimates::default();
        assert_eq!(estimates.result(), None);
        estimates.add([0.0, 0.0, 9.0], 0, None);
        (0..98).for_each(|_| estimates.add([0.0, 3.0, 4.0], 1, Some(0.05)));
        (0..2).for_each(|_| estimates.add([0.0, 0.0, 1.0], 2, Some(0.1)));
        let result = estimates.result().unwrap();
        assert_eq!((result.ticks, result.unknown_ticks), (100, 0));
        assert!((result.median - 0.01).abs() < 1e-6 && (result.p99 - 0.02).abs() < 1e-6);
        let text = "within 1.0 % of the largest (median), 2.0 % (99 of 100 ticks), by estimate";
        assert_eq!(result.to_string(), text);
        estimates.add([1.0, 0.0, 0.0], 1, None);
        assert!(estimates.result().unwrap().to_string().ends_with("; not known in 1 tick"));
    }
}
