//! Monotonic time as one number, and a sleep until a given time.

use std::time::Duration;

use rustix::thread::{ClockId as SleepClock, Timespec, clock_nanosleep_absolute};
use rustix::time::{ClockId, clock_gettime};

use crate::error::{Error, Kind, Result};

/// Nanoseconds in a second.
pub const SECOND_NS: u64 = 1_000_000_000;
/// Nanoseconds in a millisecond.
pub const MILLISECOND_NS: u64 = 1_000_000;
/// The schedule's period: one tick at 1 kHz \[ns\].
pub const PERIOD_NS: u64 = MILLISECOND_NS;

/// Returns the time of `CLOCK_MONOTONIC` \[ns\]. Cost: one system call, as a rule without entering
/// the kernel.
///
/// ```
/// use chaincell_client::clock::{PERIOD_NS, now_ns, sleep_until_ns};
///
/// let start_ns = now_ns();
/// for tick in 1..=3 {
///     sleep_until_ns(start_ns + tick * PERIOD_NS); // a loop of 1 kHz that does not drift
/// }
/// assert!(now_ns() - start_ns >= 3_000_000); // [ns]
/// ```
#[must_use]
pub fn now_ns() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let nanoseconds = u64::try_from(time.tv_nsec).unwrap_or(0);
    seconds * SECOND_NS + nanoseconds
}

/// Sleeps until [`now_ns`] is `moment_ns`; a signal ends the sleep early.
pub fn sleep_until_ns(moment_ns: u64) {
    let request = Timespec {
        tv_sec: i64::try_from(moment_ns / SECOND_NS).unwrap_or(i64::MAX),
        tv_nsec: i64::try_from(moment_ns % SECOND_NS).unwrap_or(0),
    };
    // After an early end the caller checks the time again.
    let _ = clock_nanosleep_absolute(SleepClock::Monotonic, &request);
}

/// Longest time span of an option \[s\].
const SPAN_S_MAX: f64 = 1e9;

/// Converts the time span of an option from seconds to nanoseconds.
///
/// ```
/// use chaincell_client::clock::span_ns;
///
/// assert_eq!(span_ns("--seconds", 1.5), Ok(1_500_000_000)); // [ns]
/// let error = span_ns("--seconds", -1.0).unwrap_err();
/// assert_eq!(error.to_string(), "--seconds -1: must be from 0 to 1000000000 [s]");
/// ```
///
/// # Errors
/// A number that is negative, above 1e9 s or not finite, as [`Kind::Argument`].
pub fn span_ns(option: &str, seconds: f64) -> Result<u64> {
    Duration::try_from_secs_f64(seconds)
        .ok()
        .filter(|_| seconds <= SPAN_S_MAX)
        .and_then(|span| u64::try_from(span.as_nanos()).ok())
        .ok_or_else(|| {
            Error::new(
                Kind::Argument,
                format!("{option} {seconds}: must be from 0 to {SPAN_S_MAX} [s]"),
            )
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_finite_and_not_negative() {
        assert_eq!(span_ns("`seconds`", 1.5).unwrap(), 1_500_000_000);
        for bad in [-1.0, f64::NAN, f64::INFINITY, 1e30] {
            let error = span_ns("`seconds`", bad).unwrap_err();
            assert_eq!(error.kind(), Kind::Argument);
            assert!(error.to_string().contains("`seconds`"), "{error}");
        }
    }

    #[test]
    fn a_sleep_never_ends_early() {
        let moment_ns = now_ns() + MILLISECOND_NS;
        sleep_until_ns(moment_ns);
        assert!(now_ns() >= moment_ns);
        sleep_until_ns(0);
    }
}
