//! Reach: whether a hand can have come from the last pose to this one.
//!
//! A pose that is wrong, though finite (an exponent bit, a sentinel, another unit in one message), lies
//! farther from the last good one than a hand goes in the time between them. While the tool is engaged
//! such a pose is a bad sample. One that comes back to where a hand can be is good again at once.
//!
//! Where [`AGREEING`] poses in a row are nearer to each other than to the last good one, the device
//! really is elsewhere: another frame, another place after a failure of the sensor. The tool then counts
//! as released for one sample and takes hold anew where it is, so that its force rises from 0.

use crate::number::cell::{dot, sub};
use crate::number::kept::kept;

/// Samples in a row that agree with each other from which on they are believed: longer than the ten
/// bad samples after which the tissue is in its safe state, and than the watchdog of a device.
const AGREEING: u16 = 50;

/// What a pose is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pose {
    /// A hand can have gone there.
    Good,
    /// A hand can have gone there since the last good one, but not in a tick: nobody saw on which way.
    Unseen,
    /// A bad sample.
    Bad,
    /// The device is elsewhere: a release at this place.
    Elsewhere,
}

/// The judge of the poses of one tool. Costs some ten operations a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// The last good position, and the last one of all \[m\].
    good: [f32; 3],
    last: [f32; 3],
    /// Poses in a row that are out of reach and agree.
    agreeing: u16,
    /// Whether the last good pose was an engaged one.
    engaged: bool,
}

kept!(Reach { good: [f32; 3], last: [f32; 3], agreeing: u16, engaged: bool });

impl Reach {
    /// No pose has come yet.
    pub const NEW: Self = Self { good: [0.0; 3], last: [0.0; 3], agreeing: 0, engaged: false };

    /// Judges a finite pose, a hand going at most `reach_m` in a tick \[m\] and `ticks` having passed since
    /// the last good one; an infinite reach admits all.
    pub fn judge(&mut self, position: [f32; 3], engaged: bool, reach_m: f32, ticks: f32) -> Pose {
        let [way, step] = [self.good, self.last].map(|from| sub(position, from));
        let [way, step] = [dot(way, way), dot(step, step)];
        self.last = position;
        // Squares that are beyond the numbers are out of reach.
        let is_within = |reach_m: f32| way <= reach_m * reach_m || reach_m == f32::INFINITY;
        let is_seen = !engaged || !self.engaged || is_within(reach_m);
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

    /// The next pose is taken wherever it is: nobody knows how long ago the last one was.
    pub fn forget(&mut self) {
        (self.engaged, self.agreeing) = (false, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::Pose::{Bad, Elsewhere, Good, Unseen};
    use super::*;

    /// What becomes of engaged poses on a line, a reach of 5 mm apart.
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

    #[test]
    fn one_wrong_pose_is_bad_and_the_next_right_one_is_good() {
        for wrong in [300.0, -1.0, 0.03, 6.5e-3, f32::MAX] {
            let line = [0.0, 1.0e-3, wrong, 2.0e-3, 3.0e-3, 4.0e-3];
            assert_eq!(judged(&line), [Good, Good, Bad, Good, Good, Good], "{wrong}");
        }
        let line = [0.0, 300.0, -7.0, 40.0, 1.0e-3, 2.0e-3];
        assert_eq!(judged(&line), [Good, Bad, Bad, Bad, Good, Good]);
    }

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
