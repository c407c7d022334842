//! Delay of the loop, measured from send times.
//!
//! The delay is the time from a pose until the device applies its answer. The time from the pose's send time
//! to its arrival is known. So are the pose's waiting time and the duration of the last tick. The answer's
//! transport is assumed to take as long as the pose's, and the device to apply an answer in its next tick:
//!
//! ```text
//! ticks = max(1, ceil((2 there + waited + tick) / h))
//! ```
//!
//! A send time in the future, or more than a second ago, is of another clock: the delay is then
//! [`DELAY_MAX`], the longest that the loop reports to the stage, and the loop logs it.

use chaincell_kernel::stage::DELAY_MAX;

use super::Run;
use super::arrived::Arrived;
use crate::session::ipc::complain::complain;
use crate::session::timing::clock::SECOND_NS;

/// Oldest send time that is accepted \[ns\].
const AGE_MAX_NS: u64 = SECOND_NS;

/// Measurements of a loop.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LoopDelay {
    /// A tick of the device \[ns\]; `None` if the delay is not measured.
    period_ns: Option<u64>,
    /// Duration of the last tick \[ns\].
    tick_ns: u64,
    /// Delay passed to the stage before this tick.
    pub told: Option<u16>,
    /// Number of send times that were ignored.
    pub disbelieved: u64,
}

impl LoopDelay {
    pub(super) fn new(period_ns: Option<u64>) -> Self {
        Self { period_ns, ..Self::default() }
    }

    /// Notes the duration of a tick, up to its answer.
    pub(super) fn took(&mut self, tick_ns: u64) {
        self.tick_ns = tick_ns;
    }
}

/// Delay of the answer to a pose that was sent at `sent_ns`, arrived at `at_ns` and is executed at `now_ns`
/// \[ticks of `period_ns`\]; `None` for a send time of another clock.
fn ticks(sent_ns: u64, [at_ns, now_ns]: [u64; 2], [tick_ns, period_ns]: [u64; 2]) -> Option<u16> {
    let there_ns = at_ns.checked_sub(sent_ns).filter(|&age_ns| age_ns <= AGE_MAX_NS)?;
    let waited_ns = now_ns.saturating_sub(at_ns);
    let whole_ns = there_ns.saturating_mul(2).saturating_add(waited_ns).saturating_add(tick_ns);
    let ticks = whole_ns.div_ceil(period_ns.max(1)).max(1);
    Some(u16::try_from(ticks).unwrap_or(u16::MAX).min(DELAY_MAX.into()))
}

impl Run<'_> {
    /// Measures the delay of the answer to this pose, if the option is on, for the stage.
    pub(super) fn measure_delay(&mut self, arrived: &Arrived, now_ns: u64) {
        let Some(period_ns) = self.delay.period_ns else { return };
        let times_ns = [arrived.at_ns, now_ns];
        let told = ticks(arrived.asked.send_ns, times_ns, [self.delay.tick_ns, period_ns])
            .unwrap_or_else(|| {
                let what =
                    "the send time of a pose is of another clock; its delay is taken as 16 ticks";
                complain(&mut self.delay.disbelieved, what, arrived.tick);
                DELAY_MAX.into()
            });
        self.delay.told = Some(told);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_NS: u64 = 1_000_000;

    fn of(sent_ns: u64, at_ns: u64, now_ns: u64, tick_ns: u64) -> Option<u16> {
        ticks(sent_ns, [at_ns, now_ns], [tick_ns, PERIOD_NS])
    }

    // REQ-STG-14
    #[test]
    fn the_way_counts_twice_and_the_wait_and_the_tick_once() {
        let start = 5_000_000_000;
        assert_eq!(of(start, start + 100_000, start + 150_000, 300_000), Some(1));
        assert_eq!(of(start, start + 400_000, start + 400_000, 300_000), Some(2));
        assert_eq!(of(start, start + 100_000, start + 2_100_000, 300_000), Some(3));
        assert_eq!(of(start, start, start, 0), Some(1));
        // Twice as many poses a second.
        assert_eq!(ticks(start, [start + 400_000; 2], [300_000, PERIOD_NS / 2]), Some(3));
    }

    // REQ-STG-14
    #[test]
    fn what_is_long_is_bounded_and_another_clock_is_seen() {
        let start = 5_000_000_000;
        assert_eq!(of(start, start + 900_000_000, start + 900_000_000, 0), Some(16));
        assert_eq!(of(start, start + 10, start + 20, u64::MAX), Some(16));
        assert_eq!(of(start + 1, start, start, 0), None);
        assert_eq!(of(0, start, start, 0), None);
        assert_eq!(of(u64::MAX, start, start, 0), None);
        assert_eq!(of(start, start + AGE_MAX_NS, start + AGE_MAX_NS, 0), Some(16));
        assert_eq!(of(start, start + AGE_MAX_NS + 1, start + AGE_MAX_NS + 1, 0), None);
    }
}
