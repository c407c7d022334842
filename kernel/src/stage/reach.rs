//! Reach: rejects poses that a hand cannot reach from the last one.
//!
//! A finite but wrong pose (a flipped exponent bit, a sentinel, another unit in one message) is farther from
//! the last good pose than a hand moves in the time between them. While the tool is engaged, such a pose is a
//! bad sample. A pose that is back within reach is good again at once.
//!
//! If [`AGREEING`] poses in a row are nearer to each other than to the last good one, the device really is
//! elsewhere: in another frame, or at another place after a sensor failure. The tool then counts as released
//! for one sample and engages anew at its place, so that its force rises from 0.

use crate::number::cell::{dot, sub};
use crate::number::kept::kept;

/// After this many consecutive samples that agree with each other they are accepted. Longer than the ten bad
/// samples after which the tissue is in its safe state, and than a device's watchdog.
const AGREEING: u16 = 50;

/// Verdict on a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pose {
    /// Within reach of a hand.
    Good,
    /// Within reach since the last good pose, but not in one tick: the path between is unknown.
    Unseen,
    /// A bad sample.
    Bad,
    /// The device is elsewhere: counts as a release at this place.
    Elsewhere,
}

kept! {
    /// Checks the poses of one tool. Costs about ten operations per pose.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Reach {
        /// The last good position, and the last position of all \[m\].
        good: [f32; 3],
        last: [f32; 3],
        /// Consecutive poses that are out of reach and agree.
        agreeing: u16,
        /// True if the last good pose was engaged.
        engaged: bool,
    }
}

impl Reach {
    /// No pose has come yet.
    pub const NEW: Self = Self { good: [0.0; 3], last: [0.0; 3], agreeing: 0, engaged: false };

    /// Judges a finite pose: a hand moves at most `reach_m` per tick \[m\], and `ticks` have passed since the
    /// last good pose. An infinite reach accepts all.
    pub fn judge(&mut self, position: [f32; 3], engaged: bool, reach_m: f32, ticks: f32) -> Pose {
        // Squared distances from the last good pose and from the last pose of all.
        let [way, step] = [self.good, self.last].map(|from| sub(position, from));
        let [way, step] = [dot(way, way), dot(step, step)];
        self.last = position;
        // A square that overflows is out of reach.
        let is_within = |reach_m: f32| way <= reach_m * reach_m || reach_m == f32::INFINITY;
        let is_seen = !engaged || !self.engaged || is_within(reach_m);
        // Out of reach, or next to rejected poses: bad until enough of them agree.
        if engaged && self.engaged && !(is_seen && self.agreeing == 0) {
            let agrees = self.agreeing > 0 && step < way;
            if !is_within(reach_m * ticks) || agrees {
                self.agreeing = if agrees { self.agreeing.saturating_add(1) } else { 1 };
                if self.agreeing <= AGREEING {
                    return Pose::Bad;
                }
                *self = Self { last: position, ..Self::NEW };
                return Pose::Elsewhere;
            }
        }
        *self = Self { good: position, last: position, agreeing: 0, engaged };
        if is_seen { Pose::Good } else { Pose::Unseen }
    }

    /// Accepts the next pose at any place: the time since the last one is unknown.
    pub fn forget(&mut self) {
        (self.engaged, self.agreeing) = (false, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::Pose::{Bad, Elsewhere, Good, Unseen};
    use super::*;

    /// Verdicts on engaged poses on a line, with a reach of 5 mm per tick.
    fn judged(x_m: &[f32]) -> std::vec::Vec<Pose> {
        let mut reach = Reach::NEW;
        let mut ticks = 1.0;
        let judge = |&x: &f32| {
            let pose = reach.judge([x, 0.0, 0.0], true, 5.0e-3, ticks);
            ticks = if pose == Good { 1.0 } else { ticks + 1.0 };
            pose
        };
        x_m.iter().map(judge).collect()
    }

    // REQ-STG-15
    #[test]
    fn one_wrong_pose_is_bad_and_the_next_right_one_is_good() {
        for wrong in [300.0, -1.0, 0.03, 6.5e-3, f32::MAX] {
            let line = [0.0, 1.0e-3, wrong, 2.0e-3, 3.0e-3, 4.0e-3];
            assert_eq!(judged(&line), [Good, Good, Bad, Good, Good, Good], "{wrong}");
        }
        let line = [0.0, 300.0, -7.0, 40.0, 1.0e-3, 2.0e-3];
        assert_eq!(judged(&line), [Good, Bad, Bad, Bad, Good, Good]);
    }

    // REQ-STG-15
    #[test]
    fn a_device_that_is_elsewhere_takes_hold_there_anew() {
        for elsewhere in [300.0, 0.02] {
            let mut line = std::vec![0.0; 10];
            line.extend((0..60_u8).map(|tick| elsewhere + 1.0e-4 * f32::from(tick)));
            let poses = judged(&line);
            assert_eq!(poses[..10], [Good; 10]);
            assert_eq!(poses[10..60], [Bad; 50], "{elsewhere}");
            assert_eq!((poses[60], &poses[61..]), (Elsewhere, &[Good; 9][..]));
        }
    }

    #[test]
    fn after_a_silence_nobody_saw_how_a_hand_went_far() {
        let mut reach = Reach::NEW;
        let mut judge = |x: f32, ticks: f32| reach.judge([x, 0.0, 0.0], true, 5.0e-3, ticks);
        assert_eq!([judge(0.0, 1.0), judge(4.0e-3, 9.0), judge(0.03, 9.0)], [Good, Good, Unseen]);
        assert_eq!([judge(0.03, 1.0), judge(0.09, 9.0), judge(0.031, 10.0)], [Good, Bad, Good]);
    }

    #[test]
    fn a_released_tool_may_be_anywhere() {
        let mut reach = Reach::NEW;
        for (x, engaged) in [(0.0, true), (9.0, false), (-9.0, false), (9.0, true)] {
            assert_eq!(reach.judge([x, 0.0, 0.0], engaged, 5.0e-3, 1.0), Good);
        }
        assert_eq!(reach.judge([0.0; 3], true, 5.0e-3, 1.0), Bad);
        reach.forget();
        assert_eq!(reach.judge([0.0; 3], true, 5.0e-3, 1.0), Good);
        assert_eq!(reach.judge([900.0; 3], true, f32::INFINITY, 1.0), Good);
    }
}
