//! Rate limit of poses: a token bucket, one token per pose.
//!
//! Each pose is a tick, a millisecond of the tissue's time. A flood of poses would advance the tissue faster
//! than the clock and occupy the core. The bucket holds as many tokens as the queue holds poses, so a
//! controller can catch up after any stall. It fills at `--max-pose-hz`, by default twice the schedule of 1
//! kHz: a controller at 1 kHz never reaches the limit, whatever its jitter. Of a controller at 10 kHz the
//! first 1,024 poses are executed and then two of ten; the others are counted. For 10 ticks per millisecond
//! pass `--max-pose-hz 10000`, or 0 for no limit.

use crate::error::{Error, Result};
use crate::session::ipc::services::QUEUE_MESSAGES;
use crate::session::timing::clock::SECOND_NS;

/// Default limit of poses executed per second, twice the schedule \[Hz\].
pub const POSE_HZ: u32 = 2000;
/// Highest limit that `--max-pose-hz` accepts \[Hz\].
pub const POSE_HZ_MAX: u32 = 1_000_000;

/// The bucket, represented by the time at which it is full again.
#[derive(Debug, Clone, Copy)]
pub(super) struct PoseRate {
    /// Time in which a token returns, 0 for no limit \[ns\].
    token_ns: u64,
    full_at_ns: u64,
}

impl PoseRate {
    /// A full bucket; `hz` 0 means no limit.
    ///
    /// # Errors
    /// A rate out of range.
    pub(super) fn new(hz: u32) -> Result<Self> {
        if hz > POSE_HZ_MAX {
            return Err(Error::input(format!(
                "`max_pose_hz` {hz}: must be from 0 (no limit) to {POSE_HZ_MAX}"
            )));
        }
        let token_ns = if hz == 0 { 0 } else { SECOND_NS / u64::from(hz) };
        Ok(Self { token_ns, full_at_ns: 0 })
    }

    /// Takes a token for a pose that arrives now; false if none is left.
    pub(super) fn takes(&mut self, now_ns: u64) -> bool {
        let full_at_ns = self.full_at_ns.max(now_ns).saturating_add(self.token_ns);
        let room_ns = QUEUE_MESSAGES as u64 * self.token_ns;
        if full_at_ns > now_ns.saturating_add(room_ns) {
            return false;
        }
        self.full_at_ns = full_at_ns;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::timing::clock::MILLISECOND_NS;

    const BURST: u64 = QUEUE_MESSAGES as u64;

    /// Number of poses accepted of `count` that arrive every `span_ns` from `start_ns` on.
    fn taken(rate: &mut PoseRate, start_ns: u64, span_ns: u64, count: u64) -> u64 {
        (0..count).filter(|at| rate.takes(start_ns + at * span_ns)).count() as u64
    }

    #[test]
    fn a_queue_full_at_once_and_then_the_rate() {
        let start_ns = 77 * SECOND_NS;
        let mut rate = PoseRate::new(POSE_HZ).unwrap();
        assert_eq!(taken(&mut rate, start_ns, 0, 3 * BURST), BURST);
        assert!(!rate.takes(start_ns + SECOND_NS / 2000 - 1));
        assert!(rate.takes(start_ns + SECOND_NS / 2000));
        assert!(!rate.takes(start_ns + SECOND_NS / 2000));
        // A second refills 2,000 tokens, of which the bucket holds 1,024.
        assert_eq!(taken(&mut rate, start_ns + 2 * SECOND_NS, 0, 3 * BURST), BURST);
    }

    #[test]
    fn the_schedule_with_stalls_never_meets_the_limit() {
        let mut rate = PoseRate::new(POSE_HZ).unwrap();
        for second in 1..60 {
            // 200 ms of silence, their poses at once, 800 ms on the schedule.
            let stalled_ns = second * SECOND_NS + 200 * MILLISECOND_NS;
            assert_eq!(taken(&mut rate, stalled_ns, 0, 200), 200, "second {second}");
            let scheduled = taken(&mut rate, stalled_ns, MILLISECOND_NS, 800);
            assert_eq!(scheduled, 800, "second {second}");
        }
    }

    #[test]
    fn ten_kilohertz_come_down_to_the_limit() {
        let mut rate = PoseRate::new(POSE_HZ).unwrap();
        let seconds = 10;
        let found = taken(&mut rate, SECOND_NS, SECOND_NS / 10_000, seconds * 10_000);
        assert!(found.abs_diff(BURST + seconds * u64::from(POSE_HZ)) <= 1, "{found}");
        let mut open = PoseRate::new(10_000).unwrap();
        assert_eq!(taken(&mut open, SECOND_NS, SECOND_NS / 10_000, 100_000), 100_000);
    }

    #[test]
    fn no_limit_and_the_ends_of_time() {
        let mut none = PoseRate::new(0).unwrap();
        assert_eq!(taken(&mut none, 5, 0, 10 * BURST), 10 * BURST);
        let mut late = PoseRate::new(1).unwrap();
        assert!(late.takes(u64::MAX), "the end of time is no panic");
        let mut slow = PoseRate::new(1).unwrap();
        assert_eq!(taken(&mut slow, 0, 0, 3 * BURST), BURST);
        let error = PoseRate::new(POSE_HZ_MAX + 1).unwrap_err();
        assert!(error.to_string().contains("`max_pose_hz`"), "{error}");
    }
}
