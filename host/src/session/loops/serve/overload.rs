//! Overload detection: the tissue falls behind the poses for so long that its force is old.
//!
//! A tick is behind if its sweep took longer than a pose period or, with a fixed number of sweeps, if further
//! poses waited at its end. If enough wait that the force is [`FAR`] milliseconds old, one such tick is
//! enough. After [`TICKS`] consecutive ticks and [`TIME_NS`] behind, the published force falls to 0; it
//! returns after [`CALM`] ticks in time.

use crate::session::timing::clock::MILLISECOND_NS;

/// Consecutive ticks behind.
const TICKS: u32 = 3;
/// Continuous time behind \[ns\].
const TIME_NS: u64 = 10 * MILLISECOND_NS;
/// Ticks in time before the force returns.
const CALM: u32 = 100;

/// Number of waiting poses at which a tick with a fixed number of sweeps is an overload at once.
pub(super) const FAR: usize = 20;

/// State of the overload detection.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Overload {
    behind: u32,
    since_ns: u64,
    calm: u32,
    is_on: bool,
    times: u64,
}

/// Delay of a tick relative to the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Behind {
    /// In time.
    No,
    /// By a tick.
    Yes,
    /// By many poses: one such tick is an overload.
    Far,
}

/// Change caused by a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    None,
    /// The force has to fall.
    Begins,
    /// The force may return.
    Ends,
}

impl Overload {
    /// Notes a tick with its start and end.
    pub(super) fn note(&mut self, behind: Behind, [start_ns, end_ns]: [u64; 2]) -> Change {
        if behind != Behind::No {
            self.calm = 0;
            if self.behind == 0 {
                self.since_ns = start_ns;
            }
            self.behind = self.behind.saturating_add(1);
            let for_ns = end_ns.saturating_sub(self.since_ns);
            let for_long = self.behind >= TICKS && for_ns >= TIME_NS;
            if !self.is_on && (for_long || behind == Behind::Far) {
                self.is_on = true;
                self.times += 1;
                return Change::Begins;
            }
            return Change::None;
        }
        self.behind = 0;
        self.calm = self.calm.saturating_add(1);
        if self.is_on && self.calm >= CALM {
            self.is_on = false;
            return Change::Ends;
        }
        Change::None
    }

    pub(super) fn is_on(&self) -> bool {
        self.is_on
    }

    /// Number of overloads.
    pub(super) fn times(&self) -> u64 {
        self.times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tick, of at most 40 of `tick_ms` each that are all behind, at which the force starts to fall.
    fn begins(tick_ms: u64) -> Option<u64> {
        let mut overload = Overload::default();
        let span = |tick| [tick * tick_ms, (tick + 1) * tick_ms].map(|ms| ms * MILLISECOND_NS);
        (0..40).find(|&tick| overload.note(Behind::Yes, span(tick)) == Change::Begins)
    }

    // REQ-COS-09
    #[test]
    fn three_ticks_and_ten_milliseconds() {
        assert_eq!(begins(2), Some(4));
        assert_eq!(begins(3), Some(3));
        assert_eq!(begins(5), Some(2));
        assert_eq!(begins(100), Some(2), "one that the machine held up is none");
    }

    #[test]
    fn a_tick_in_time_begins_the_count_anew_and_a_hundred_end_it() {
        let mut overload = Overload::default();
        let mut note = |is_behind, ms: u64| {
            let behind = if is_behind { Behind::Yes } else { Behind::No };
            overload.note(behind, [ms * MILLISECOND_NS, (ms + 2) * MILLISECOND_NS])
        };
        for ms in (0..100).step_by(10) {
            assert_eq!(note(true, ms), Change::None);
            assert_eq!(note(true, ms + 2), Change::None);
            assert_eq!(note(false, ms + 4), Change::None);
        }
        let falls = (0..20).map(|tick| note(true, 200 + 2 * tick));
        assert_eq!(falls.filter(|&change| change == Change::Begins).count(), 1);
        for tick in 0..99 {
            assert_eq!(note(false, 300 + tick), Change::None);
        }
        assert_eq!(note(false, 400), Change::Ends);
        assert!(!overload.is_on() && overload.times() == 1);
        assert_eq!(overload.note(Behind::Far, [0, 1]), Change::Begins, "once is enough");
    }
}
