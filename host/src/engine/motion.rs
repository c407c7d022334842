//! The built-in motion: approach, press, hold with a hand's tremor, retreat.

use std::f64::consts::TAU;

use chaincell_kernel::ToolPose;
use nalgebra::Vector3;

use crate::bake::tissue::DEVICE_HZ;
use crate::error::{Error, Result};
use crate::words::counted;

/// Tremor of the hand: physiological tremor lies between 8 and 12 Hz \[Hz\].
const TREMOR_HZ: [f64; 3] = [8.3, 9.7, 11.9];
/// Shares of the ticks at which press, hold and retreat start.
const PHASES: [f64; 3] = [0.1, 0.4, 0.75];
/// Fewest ticks that can hold every phase.
pub const TICKS_MIN: u64 = 20;

/// The tool in one tick, as in a row of a path file: it may contain any number.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pose {
    /// Number of the tick.
    pub tick: u64,
    /// Tool position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// 1 while the tool holds the contact cells, else 0.
    pub engaged: u32,
    /// Sweeps of the tick: 0 for a late one, `None` for those of the settings.
    pub sweeps: Option<u16>,
}

impl Pose {
    /// The pose of the first tool in a tick, with the settings' sweeps.
    #[must_use]
    pub fn of(tick: u64, pose: &ToolPose) -> Self {
        let (position_m, engaged) = (pose.position_m.into(), pose.engaged.into());
        Self { tick, position_m, engaged, sweeps: None }
    }
}

impl From<Pose> for ToolPose {
    fn from(pose: Pose) -> Self {
        Self::at(pose.position_m.into(), pose.engaged)
    }
}

/// A press along a line: a pure function of the tick, equal on every machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Press {
    touch_m: Vector3<f64>,
    direction: Vector3<f64>,
    depth_m: f64,
    ticks: u64,
    hz: u32,
}

impl Press {
    /// A press from the point of touch \[m\] along a direction, to a depth \[m\], in `ticks` ticks of 1 ms.
    pub fn new(touch_m: [f64; 3], direction: [f64; 3], depth_m: f64, ticks: u64) -> Result<Self> {
        let direction = Vector3::from(direction);
        let length = libm::sqrt(direction.dot(&direction));
        if !(length.is_finite() && length > 0.0) {
            return Err(Error::input("`direction`: its length must be finite and above 0"));
        }
        if !(depth_m.is_finite() && depth_m > 0.0) {
            return Err(Error::input(format!("`depth_m` {depth_m}: must be above 0 and finite")));
        }
        if ticks < TICKS_MIN {
            return Err(Error::input(format!(
                "{} cannot hold the built-in press: give at least {TICKS_MIN}",
                counted(ticks, "tick")
            )));
        }
        let (touch_m, direction) = (Vector3::from(touch_m), direction / length);
        Ok(Self { touch_m, direction, depth_m, ticks, hz: DEVICE_HZ })
    }

    /// The same press by a hand whose device has another rate of ticks \[Hz\].
    #[must_use]
    pub fn at_rate(self, hz: u32) -> Self {
        Self { hz, ..self }
    }

    /// The pose of a tick; the first tick is 0. After the end the tool stays at its start position.
    #[must_use]
    pub fn pose(&self, tick: u64) -> Pose {
        // Depth along the line in each phase.
        let [press, hold, retreat] = PHASES.map(|share| (share * self.ticks as f64) as u64);
        // The tool is released in the last tick.
        let end = self.ticks - 1;
        let depth_m = match tick {
            _ if tick < press => self.depth_m * (minimum_jerk(share(0, press, tick)) - 1.0),
            _ if tick < hold => self.depth_m * minimum_jerk(share(press, hold, tick)),
            _ if tick < retreat => self.depth_m,
            _ => self.depth_m * (1.0 - minimum_jerk(share(retreat, end, tick))),
        };
        // Add the tremor during the hold.
        let window = rise_and_fall(share(hold, retreat, tick));
        let tremor = tremor(tick as f64 / f64::from(self.hz)) * (0.01 * self.depth_m * window);
        let position_m = self.touch_m + self.direction * depth_m + tremor;
        Pose {
            tick,
            position_m: position_m.map(|coordinate| coordinate as f32).into(),
            engaged: u32::from((press..end).contains(&tick)),
            sweeps: None,
        }
    }

    /// All poses, in order.
    #[must_use]
    pub fn poses(&self) -> Vec<Pose> {
        (0..self.ticks).map(|tick| self.pose(tick)).collect()
    }
}

/// Progress of a tick in a phase, from 0 to 1.
fn share(from: u64, to: u64, tick: u64) -> f64 {
    let done = tick.saturating_sub(from) as f64;
    (done / (to - from) as f64).min(1.0)
}

/// From 0 to 1 with minimum jerk: zero speed and acceleration at both ends.
fn minimum_jerk(share: f64) -> f64 {
    share * share * share * (10.0 + share * (6.0 * share - 15.0))
}

/// From 0 to 1 and back, exactly 0 at both ends, so that the tremor starts and ends smoothly.
fn rise_and_fall(share: f64) -> f64 {
    let arch = 4.0 * share * (1.0 - share);
    arch * arch
}

/// Two sines on each axis, together at most 1.
fn tremor(time_s: f64) -> Vector3<f64> {
    let sine = |hz: f64| libm::sin(TAU * hz * time_s);
    let [a, b, c] = TREMOR_HZ.map(sine);
    Vector3::new(a + b, b + c, c + a) / 2.0
}
