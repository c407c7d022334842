//! `cosim --load N`: a session for minutes to weeks while busy threads take the other cores and the memory.
//!
//! A press is played over and over. The floor of the machine is measured under the same load, before and
//! after the session, for a tenth of its time each.

pub mod histogram;
pub mod report;

use std::ops::RangeInclusive;
use std::time::Duration;

use super::press::ticks;
use crate::bake::tissue::DEVICE_HZ;
use crate::error::{Error, Result};
use crate::session::supervise::Underway;
use crate::session::timing::memory::{Growth, Memory, Watch};

/// Shortest and longest session under load \[s\].
const SECONDS_RANGE: RangeInclusive<f64> = 3.0..=31.0 * 86_400.0;
/// Longest press under load \[s\].
const PRESS_S: f64 = 10.0;
/// Least number of presses under load.
const PRESSES_MIN: f64 = 4.0;
/// The memory counts from this time after the first press, but at the latest from the middle \[s\].
const WARM_UP_S: f64 = 10.0;
/// Range of a measurement of the floor under load, else a tenth of the session \[s\].
const FLOOR_S: [f64; 2] = [1.0, 600.0];
/// Ticks of a measurement of the floor without load: a second and a half.
const FLOOR_TICKS: u64 = 1500;
/// Longest session under load that is recorded and replayed, an hour \[ticks\].
const RECORDED_TICKS_MAX: u64 = 3_600_000;

/// Lengths of a session.
#[derive(Debug, Clone, Copy)]
pub struct Lengths {
    /// Length of a press.
    pub press_ticks: u64,
    /// Number of presses.
    pub presses: u64,
    /// Length of a measurement of the floor.
    pub floor_ticks: u64,
    /// True if the session is recorded and replayed.
    pub is_recorded: bool,
    warm_up: Duration,
}

impl Lengths {
    /// Returns the lengths of a session without load: one press.
    ///
    /// # Errors
    /// As [`ticks`].
    pub fn of_press(seconds: f64) -> Result<Self> {
        Ok(Self {
            press_ticks: ticks(seconds, DEVICE_HZ)?,
            presses: 1,
            floor_ticks: FLOOR_TICKS,
            is_recorded: true,
            warm_up: Duration::ZERO,
        })
    }

    /// Returns the lengths of a session under load.
    ///
    /// # Errors
    /// A session that is too short to measure its memory, or longer than a month.
    pub fn under_load(seconds: f64) -> Result<Self> {
        if !SECONDS_RANGE.contains(&seconds) {
            return Err(Error::input(format!(
                "--seconds {seconds}: with --load it must be from {} to {} (31 days)",
                SECONDS_RANGE.start(),
                SECONDS_RANGE.end()
            )));
        }
        let presses = (seconds / PRESS_S).ceil().max(PRESSES_MIN);
        let press_s = seconds / presses;
        let lengths = Self {
            floor_ticks: ticks((0.1 * seconds).clamp(FLOOR_S[0], FLOOR_S[1]), DEVICE_HZ)?,
            warm_up: Duration::from_secs_f64((press_s + WARM_UP_S).min(0.5 * seconds)),
            presses: presses as u64,
            ..Self::of_press(press_s)?
        };
        Ok(Self { is_recorded: lengths.ticks() <= RECORDED_TICKS_MAX, ..lengths })
    }

    /// Length of the session.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.press_ticks * self.presses
    }
}

/// Looks at the memory of both sides after the warm-up.
#[derive(Debug)]
pub struct MemoryWatch {
    length: Duration,
    next_look: Duration,
    serve: Watch,
    control: Watch,
}

impl MemoryWatch {
    /// Starts without a look.
    pub fn new(lengths: &Lengths) -> Self {
        let length = Duration::from_millis(lengths.ticks());
        let (serve, control) = (Watch::default(), Watch::default());
        Self { length, next_look: lengths.warm_up, serve, control }
    }

    /// Looks at both sides if it is time to.
    pub fn look(&mut self, underway: Underway) {
        let now = underway.elapsed;
        // The controller started before it began to play, so it still plays up to this time.
        if now < self.next_look || now >= self.length {
            return;
        }
        self.next_look = now + (self.length / 100).min(Duration::from_secs(1));
        let sides =
            [(underway.serve_pid, &mut self.serve), (underway.control_pid, &mut self.control)];
        for (pid, watch) in sides {
            if let Some(memory) = Memory::of(pid) {
                watch.look(memory);
            }
        }
    }

    /// Returns the growth of the tissue's side and of the controller's.
    #[must_use]
    pub fn growth(&self) -> [Growth; 2] {
        [self.serve.growth(), self.control.growth()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presses_fill_the_time() {
        let ten_minutes = Lengths::under_load(600.0).unwrap();
        assert_eq!((ten_minutes.presses, ten_minutes.press_ticks), (60, 10_000));
        assert_eq!((ten_minutes.floor_ticks, ten_minutes.warm_up.as_secs()), (60_000, 20));
        assert!(ten_minutes.is_recorded);
        let short = Lengths::under_load(4.0).unwrap();
        assert_eq!((short.presses, short.press_ticks, short.floor_ticks), (4, 1000, 1000));
        assert_eq!(short.warm_up, Duration::from_secs(2));
        let long = Lengths::under_load(8.0 * 3600.0).unwrap();
        assert_eq!((long.ticks(), long.floor_ticks), (28_800_000, 600_000));
        assert!(!long.is_recorded);
        let alone = Lengths::of_press(30.0).unwrap();
        assert_eq!((alone.presses, alone.ticks(), alone.floor_ticks), (1, 30_000, 1500));
        for bad in [2.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            let error = Lengths::under_load(bad).unwrap_err();
            assert!(error.to_string().contains("--seconds"), "{error}");
        }
    }

    // REQ-COS-08
    #[test]
    fn memory_is_looked_at_after_the_warm_up_and_before_the_end() {
        let mut watch = MemoryWatch::new(&Lengths::under_load(4.0).unwrap());
        let pid = std::process::id();
        let mut at = |ms| {
            let elapsed = Duration::from_millis(ms);
            watch.look(Underway { elapsed, serve_pid: pid, control_pid: pid });
            watch.growth().map(|growth| growth.looks)
        };
        assert_eq!(at(1999), [0, 0]);
        assert_eq!(at(2000), [1, 1]);
        assert_eq!(at(2030), [1, 1], "a look every hundredth of the run");
        assert_eq!(at(2040), [2, 2]);
        assert_eq!(at(4000), [2, 2]);
    }
}
