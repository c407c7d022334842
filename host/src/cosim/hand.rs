//! The force that a device at the controller would show: the answers', without a jump when they
//! stop and come again.

use super::clock::{MILLISECOND_NS, PERIOD_NS};
use super::ramp::Ramp;

/// What the hand at a controller's device feels.
#[derive(Debug)]
pub(super) struct Hand {
    ramp: Ramp,
    /// Silence after which the force falls, 0 for never \[ns\].
    watchdog_ns: u64,
    heard_ns: u64,
    /// When the falling force is shown next.
    fall_ns: Option<u64>,
    silent: bool,
    silences: u64,
}

impl Hand {
    /// Feels no force and has just heard of its tissue.
    pub(super) fn new(watchdog_ms: u32, ramp_ms: u32, now_ns: u64) -> Self {
        Self {
            ramp: Ramp::new(ramp_ms, f32::INFINITY),
            watchdog_ns: u64::from(watchdog_ms) * MILLISECOND_NS,
            heard_ns: now_ns,
            fall_ns: None,
            silent: false,
            silences: 0,
        }
    }

    /// A message of the tissue arrived.
    pub(super) fn hears(&mut self, force_n: [f32; 3], now_ns: u64) {
        if self.silent {
            self.silent = false;
            self.fall_ns = None;
            self.ramp.begin();
        }
        self.heard_ns = now_ns;
        self.ramp.show(force_n, now_ns);
    }

    /// No message has arrived.
    pub(super) fn waits(&mut self, now_ns: u64) {
        let silence_ns = now_ns.saturating_sub(self.heard_ns);
        if !self.silent && self.watchdog_ns != 0 && silence_ns >= self.watchdog_ns {
            self.silent = true;
            self.silences += 1;
            self.ramp.begin_fall();
            self.fall_ns = Some(now_ns);
        }
        if self.fall_ns.is_some_and(|due_ns| now_ns >= due_ns) {
            self.ramp.show([0.0; 3], now_ns);
            self.fall_ns = (!self.ramp.is_done()).then_some(now_ns + PERIOD_NS);
        }
    }

    /// Largest change of the force from one moment shown to the next \[N\].
    pub(super) fn largest_step_n(&self) -> f32 {
        self.ramp.largest_step_n()
    }

    /// Times the tissue was not heard of for the watchdog's time.
    pub(super) fn silences(&self) -> u64 {
        self.silences
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_falls_in_a_silence_and_rises_after_it() {
        let mut hand = Hand::new(20, 10, 0);
        hand.hears([5.0, 0.0, 0.0], MILLISECOND_NS);
        let first_n = hand.largest_step_n();
        for ms in 2..60 {
            hand.waits(ms * MILLISECOND_NS);
        }
        assert_eq!((hand.silences(), hand.ramp.is_done()), (1, true));
        // Answers that were held up come all at once.
        for _ in 0..100 {
            hand.hears([5.0, 0.0, 0.0], 60 * MILLISECOND_NS);
        }
        for half_ms in 121..150 {
            hand.hears([5.0, 0.0, 0.0], half_ms * MILLISECOND_NS / 2);
        }
        assert!(hand.ramp.is_done());
        assert_eq!((hand.silences(), hand.largest_step_n()), (1, first_n));
        let mut never = Hand::new(0, 10, 0);
        never.waits(u64::MAX);
        assert_eq!(never.silences(), 0);
    }
}
