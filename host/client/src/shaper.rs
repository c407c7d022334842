//! Shapes the force that the device shows: it does not jump when the answers stop, come again or
//! change for another cause. Both sides of the shared memory shape it.

use crate::clock::{MILLISECOND_NS, PERIOD_NS};
use crate::ramp::{Ramp, Shown};

/// Shapes the force with a ramp, and takes it to 0 in a silence.
///
/// ```
/// use chaincell_client::clock::MILLISECOND_NS as MS;
/// use chaincell_client::ramp::Shown;
/// use chaincell_client::shaper::ForceShaper;
///
/// let mut shaper = ForceShaper::new(20, 10, f32::INFINITY, 0); // watchdog 20 ms, ramp 10 ms
/// shaper.hear(0);
/// shaper.shape(&Shown::of([0.0, 0.0, 4.0]), 0);
/// assert_eq!(shaper.wait(19 * MS), None); // the last force holds
/// let fall = shaper.wait(20 * MS).ok_or("nothing to show")?;
/// assert!((fall.shown.force_n[0][2] - 3.6).abs() < 1e-6 && !fall.is_done); // [N]
/// assert_eq!(shaper.silences(), 1);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug)]
pub struct ForceShaper {
    ramp: Ramp,
    /// Silence after which the force falls, 0 for never \[ns\].
    watchdog_ns: u64,
    heard_ns: u64,
    /// Time at which the falling force is shown next \[ns\].
    fall_ns: Option<u64>,
    silent: bool,
    silences: u64,
    /// True if a force was shown yet.
    has_shown: bool,
}

/// A force that falls to 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fall {
    /// The forces and torques to show.
    pub shown: Shown,
    /// True if all forces and torques have reached 0.
    pub is_done: bool,
}

impl ForceShaper {
    /// Starts with no force shown, as if a message had arrived at `now_ns`.
    pub fn new(watchdog_ms: u32, ramp_ms: u32, max_slew_n_per_s: f32, now_ns: u64) -> Self {
        Self {
            ramp: Ramp::new(ramp_ms, max_slew_n_per_s),
            watchdog_ns: u64::from(watchdog_ms) * MILLISECOND_NS,
            heard_ns: now_ns,
            fall_ns: None,
            silent: false,
            silences: 0,
            has_shown: false,
        }
    }

    /// Notes that a message arrived: after a silence the force rises from the value shown. Returns true
    /// if there was one; a process that was suspended notices it only here.
    pub fn hear(&mut self, now_ns: u64) -> bool {
        let unseen = !self.silent && self.has_shown && self.is_silent(now_ns);
        let silent = self.silent || unseen;
        self.silences += u64::from(unseen);
        self.silent = silent;
        self.end_silence();
        self.heard_ns = now_ns;
        silent
    }

    /// Ends a silence, if there is one: the force rises from the value shown.
    pub fn end_silence(&mut self) {
        if self.silent {
            self.silent = false;
            self.fall_ns = None;
            self.ramp.begin();
        }
    }

    fn is_silent(&self, now_ns: u64) -> bool {
        let silence_ns = now_ns.saturating_sub(self.heard_ns);
        self.watchdog_ns != 0 && silence_ns >= self.watchdog_ns
    }

    /// Returns the time of the last message \[ns\].
    pub fn heard_ns(&self) -> u64 {
        self.heard_ns
    }

    /// Starts a ramp, since the next force may differ from the last one.
    pub fn begin_ramp(&mut self) {
        self.ramp.begin();
    }

    /// As [`Self::begin_ramp`], for a limit that was changed: a growing force takes at least a second.
    pub fn begin_raise(&mut self) {
        self.ramp.begin_raise();
    }

    /// Starts in a silence, which counts.
    pub fn begin_silent(&mut self) {
        (self.silent, self.silences) = (true, self.silences + 1);
    }

    /// Starts a ramp at 0, for a reader that was shown no force yet.
    pub fn begin_at_zero(&mut self) {
        self.ramp.begin_at_zero();
    }

    /// Starts a ramp to 0, as long as the shaped target is 0.
    pub fn begin_fall(&mut self) {
        self.ramp.begin_fall();
    }

    /// Returns the forces and torques to show at `now_ns`, between those shown last and `target`.
    pub fn shape(&mut self, target: &Shown, now_ns: u64) -> Shown {
        self.has_shown = true;
        self.ramp.show(target, now_ns)
    }

    /// Notes that no message has arrived: returns the falling force when it is time to show it.
    pub fn wait(&mut self, now_ns: u64) -> Option<Fall> {
        if !self.silent && self.is_silent(now_ns) {
            self.silent = true;
            self.silences += 1;
            self.ramp.begin_fall();
            self.fall_ns = Some(now_ns);
        }
        if self.fall_ns.is_none_or(|due_ns| now_ns < due_ns) {
            return None;
        }
        let shown = self.ramp.show(&Shown::ZERO, now_ns);
        let is_done = self.ramp.is_done();
        self.fall_ns = (!is_done).then_some(now_ns + PERIOD_NS);
        Some(Fall { shown, is_done })
    }

    /// Returns the time of the next output of [`Self::wait`], in a silence \[ns\].
    pub fn fall_ns(&self) -> Option<u64> {
        self.fall_ns
    }

    /// Returns true if no ramp is active: the target itself is shown.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.ramp.is_done()
    }

    /// Returns the largest change between two forces shown one after the other \[N\].
    pub fn largest_step_n(&self) -> f32 {
        self.ramp.largest_step_n()
    }

    /// Returns the number of silences longer than the watchdog's time.
    pub fn silences(&self) -> u64 {
        self.silences
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hears(shaper: &mut ForceShaper, now_ns: u64) {
        shaper.hear(now_ns);
        shaper.shape(&Shown::of([5.0, 0.0, 0.0]), now_ns);
    }

    #[test]
    fn the_force_falls_in_a_silence_and_rises_after_it() {
        let mut shaper = ForceShaper::new(20, 10, f32::INFINITY, 0);
        hears(&mut shaper, MILLISECOND_NS);
        let first_n = shaper.largest_step_n();
        for ms in 2..60 {
            shaper.wait(ms * MILLISECOND_NS);
        }
        assert_eq!((shaper.silences(), shaper.ramp.is_done()), (1, true));
        // Delayed answers arrive all at once.
        for _ in 0..100 {
            hears(&mut shaper, 60 * MILLISECOND_NS);
        }
        for half_ms in 121..150 {
            hears(&mut shaper, half_ms * MILLISECOND_NS / 2);
        }
        assert!(shaper.ramp.is_done());
        assert_eq!((shaper.silences(), shaper.largest_step_n()), (1, first_n));
        let mut never = ForceShaper::new(0, 10, f32::INFINITY, 0);
        never.wait(u64::MAX);
        assert_eq!(never.silences(), 0);
    }
}
