//! The order of one publisher's ticks: the tick number decides whether a pose is executed.

/// Largest distance from the last tick at which a tick belongs to the same count: an hour at 1 kHz.
pub const TICK_JUMP_MAX: u64 = 3_600_000;

/// Place of a pose's tick number in the count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TickPlace {
    /// It is the next one.
    Next,
    /// It is not above the last one: the pose arrived twice, or too late.
    Repeated,
    /// It is farther than [`TICK_JUMP_MAX`] from the last one: a bad number.
    Bad,
}

/// The ticks of one publisher. A bad tick does not change the order: later poses continue from the last good
/// one. A count that really restarts elsewhere loses one pose, since a tick that follows a refused one is
/// accepted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TickOrder {
    last: Option<u64>,
    refused: Option<u64>,
}

impl TickOrder {
    /// The last accepted tick.
    #[must_use]
    pub fn last(&self) -> Option<u64> {
        self.last
    }

    /// Classifies the next pose's tick, and notes it.
    pub fn take(&mut self, tick: u64) -> TickPlace {
        let is_next = |before: u64| follows(before, tick);
        if self.last.is_none_or(is_next) || self.refused.is_some_and(is_next) {
            *self = Self { last: Some(tick), refused: None };
            return TickPlace::Next;
        }
        if self.last.is_some_and(|last| last.abs_diff(tick) > TICK_JUMP_MAX) {
            self.refused = Some(tick);
            return TickPlace::Bad;
        }
        TickPlace::Repeated
    }
}

/// Returns true if a tick continues the count after `last`.
#[must_use]
pub fn follows(last: u64, tick: u64) -> bool {
    tick > last && tick - last <= TICK_JUMP_MAX
}

/// Number of ticks between two consecutive executed ones, 0 if the count restarted.
#[must_use]
pub fn skipped(last: u64, tick: u64) -> u16 {
    let between = if follows(last, tick) { tick - last - 1 } else { 0 };
    u16::try_from(between).unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::TickPlace::{Bad, Next, Repeated};
    use super::*;

    /// Places of poses with these ticks.
    fn places(ticks: &[u64]) -> Vec<TickPlace> {
        let mut order = TickOrder::default();
        ticks.iter().map(|&tick| order.take(tick)).collect()
    }

    #[test]
    fn a_tick_that_is_lost_or_comes_twice() {
        assert_eq!(places(&[7, 8, 8, 10, 9, 11]), [Next, Next, Repeated, Next, Repeated, Next]);
    }

    #[test]
    fn a_bad_tick_locks_nobody_out() {
        assert_eq!(places(&[5, u64::MAX, 6, 7]), [Next, Bad, Next, Next]);
        assert_eq!(places(&[5, u64::MAX, u64::MAX, 6]), [Next, Bad, Bad, Next]);
        assert_eq!(places(&[u64::MAX, 0, 1, 2]), [Next, Bad, Next, Next]);
    }

    #[test]
    fn the_bound_is_the_last_tick_that_is_taken() {
        let end = 5 + TICK_JUMP_MAX;
        assert_eq!(places(&[5, end]), [Next, Next]);
        assert_eq!(places(&[5, end + 1]), [Next, Bad]);
        assert_eq!(places(&[end, 5]), [Next, Repeated]);
        assert_eq!(places(&[end + 1, 5]), [Next, Bad]);
    }

    #[test]
    fn a_count_that_goes_on_far_ahead_loses_one_pose() {
        let far = 1 << 40;
        assert_eq!(places(&[5, far, far + 1, far + 2]), [Next, Bad, Next, Next]);
        assert_eq!(
            places(&[5, far, 6, far + 1]),
            [Next, Bad, Next, Bad],
            "not one behind the other"
        );
    }
}
