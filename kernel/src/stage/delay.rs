//! Delay: age of the force that the device shows, and the stiffness that may be shown with it.
//!
//! A device that applies a force d ticks of length h late and holds it for one more generates energy from a
//! spring k: with `x_i` the motion in tick i,
//!
//! ```text
//! k sum over i of x_i (x_i / 2 + x_{i-1} + ... + x_{i-d})  <=  k (1/2 + d) sum of x_i^2
//! ```
//!
//! by the inequality of Cauchy and Schwarz, for any motion. The device's damping b dissipates at least b / h
//! times the sum of `x_i^2`. So up to
//!
//! ```text
//! k = 2 b / ((1 + 2 d) h)
//! ```
//!
//! no energy is generated, even without control. From [`BOUND`] ticks on the coupling is a spring of at most
//! [`SHARE`] of that; the rest covers the encoder's quantisation. Up to [`FREE`] ticks the controller
//! compensates the delay, and the coupling is that of the settings. In between the compliance is
//! interpolated.
//!
//! A measured delay counts by its mean over about [`MEMORY`] ticks: the sum is linear in it, and one late
//! answer is no reason to show less stiffness. A longer mean softens the coupling at once, a shorter one stiffens it
//! out of contact alone: a spring that stiffens while it is stretched has energy that no hand has put in.
//!
//! Source: J. E. Colgate, G. Schenkel, Passivity of a class of sampled-data systems (1997).

use super::settings::{Coupling, DELAY_MAX};
use crate::number::kept::kept;

/// Share of the passive stiffness that the coupling may show.
const SHARE: f32 = 0.65;
/// Ticks over which a measured delay is averaged.
const MEMORY: f32 = 256.0;
/// Largest delay that is taken from a measurement \[ticks\].
pub const DELAY_TICKS_MAX: u16 = 1000;
/// Delay up to which the coupling is that of the settings \[ticks\].
const FREE: f32 = 1.0;
/// Delay from which on the coupling is bounded \[ticks\].
const BOUND: f32 = 1.25;

/// The largest stiffness that a device with the damping `damping_n_s_per_m` can show without generating
/// energy, with `delay_ticks` of `tick_s` between an answer and its force \[N/m\].
#[must_use]
pub fn passive_stiffness_n_per_m(damping_n_s_per_m: f32, delay_ticks: f32, tick_s: f32) -> f32 {
    2.0 * damping_n_s_per_m / ((1.0 + 2.0 * delay_ticks) * tick_s)
}

kept! {
    /// The delay, from the settings or as a running mean.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(super) struct Delay {
        /// The mean, and the longest one since the tool was last out of contact \[ticks\].
        ticks: f32,
        longest: f32,
    }
}

impl Delay {
    pub(super) fn new(ticks: u8) -> Self {
        Self { ticks: ticks.into(), longest: ticks.into() }
    }

    /// Adds a measured delay to the mean.
    pub(super) fn hear(&mut self, ticks: f32) {
        self.ticks += (ticks - self.ticks) / MEMORY;
        if self.ticks > self.longest {
            self.longest = self.ticks;
        }
    }

    /// Notes that the tool is out of contact, where the coupling's spring is not stretched.
    pub(super) fn release(&mut self) {
        self.longest = self.ticks;
    }

    /// The mean \[ticks\].
    pub(super) fn ticks(&self) -> f32 {
        self.ticks
    }

    /// The mean in whole ticks, at most [`DELAY_MAX`]: the number of forces on their way.
    pub(super) fn whole(&self) -> usize {
        let ticks = self.ticks + 0.5;
        if ticks > f32::from(DELAY_MAX) { DELAY_MAX.into() } else { ticks as usize }
    }

    /// Returns true if the delay is too long for a controller to compensate.
    pub(super) fn is_long(&self) -> bool {
        self.ticks >= BOUND
    }

    /// The coupling that a device with the damping `damping` may show at this delay.
    pub(super) fn admits(&self, of: &Coupling, damping: f32, tick_s: f32) -> Coupling {
        if self.longest <= FREE {
            return *of;
        }
        let late = if self.longest > BOUND { self.longest } else { BOUND };
        let bound = SHARE * passive_stiffness_n_per_m(damping, late, tick_s);
        let wished = of.stiffness_n_per_m;
        if bound >= wished {
            return *of;
        }
        let is_long = self.longest >= BOUND;
        let share = if is_long { 1.0 } else { (self.longest - FREE) / (BOUND - FREE) };
        Coupling {
            stiffness_n_per_m: wished * bound / (bound + share * (wished - bound)),
            damping_n_s_per_m: (1.0 - share) * of.damping_n_s_per_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OF: Coupling = Coupling { stiffness_n_per_m: 2000.0, damping_n_s_per_m: 0.5 };

    // REQ-STG-11
    #[test]
    fn a_long_delay_admits_less_and_a_device_without_damping_nothing() {
        for told in 0..=16 {
            let admitted = Delay::new(told).admits(&OF, 0.5, 1.0e-3);
            let bound = passive_stiffness_n_per_m(0.5, told.into(), 1.0e-3);
            if told < 2 {
                assert_eq!(admitted, OF);
            } else {
                assert!(
                    admitted.stiffness_n_per_m <= 0.651 * bound
                        && admitted.damping_n_s_per_m == 0.0
                );
                assert!(admitted.stiffness_n_per_m >= 0.5 * bound, "{told}: {admitted:?}");
            }
        }
        assert_eq!(Delay::new(2).admits(&OF, 0.0, 1.0e-3).stiffness_n_per_m, 0.0);
        assert_eq!(Delay::new(2).admits(&OF, 50.0, 1.0e-3), OF);
    }

    // REQ-STG-11
    #[test]
    fn a_measured_delay_counts_by_its_mean() {
        let mut delay = Delay::new(1);
        delay.hear(7.0);
        let after_one = delay.admits(&OF, 0.5, 1.0e-3).stiffness_n_per_m;
        assert!((1000.0..2000.0).contains(&after_one), "{after_one}");
        for _ in 0..2000 {
            delay.hear(7.0);
        }
        assert!(delay.is_long() && (delay.ticks() - 7.0).abs() < 0.01);
    }
}
