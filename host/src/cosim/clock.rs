//! Monotonic time as one number, and sleeping until a moment of it.

use rustix::thread::{ClockId as SleepClock, Timespec, clock_nanosleep_absolute};
use rustix::time::{ClockId, clock_gettime};

/// Nanoseconds in a second.
pub const SECOND_NS: u64 = 1_000_000_000;
/// Nanoseconds in a millisecond.
pub const MILLISECOND_NS: u64 = 1_000_000;
/// The schedule's period: one tick at 1 kHz \[ns\].
pub const PERIOD_NS: u64 = MILLISECOND_NS;

/// `CLOCK_MONOTONIC` \[ns\].
#[must_use]
pub fn now_ns() -> u64 {
    let time = clock_gettime(ClockId::Monotonic);
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    let nanoseconds = u64::try_from(time.tv_nsec).unwrap_or(0);
    seconds * SECOND_NS + nanoseconds
}

/// Sleeps until a moment of [`now_ns`]; a signal ends the sleep early.
pub fn sleep_until_ns(moment_ns: u64) {
    let request = Timespec {
        tv_sec: i64::try_from(moment_ns / SECOND_NS).unwrap_or(i64::MAX),
        tv_nsec: i64::try_from(moment_ns % SECOND_NS).unwrap_or(0),
    };
    // An early end only makes the caller look again.
    let _ = clock_nanosleep_absolute(SleepClock::Monotonic, &request);
}

/// A span in seconds as nanoseconds; negative and non-finite spans are 0.
#[must_use]
pub fn span_ns(seconds: f64) -> u64 {
    std::time::Duration::try_from_secs_f64(seconds)
        .map_or(0, |span| u64::try_from(span.as_nanos()).unwrap_or(u64::MAX))
}
