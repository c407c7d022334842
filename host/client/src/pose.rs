//! Poses of tools on their way to the server, checked before anything is sent.

use crate::error::{Error, Kind, Result};
use crate::tools::{OneToolPose, TOOLS_MAX, ToolPoses};

/// Largest difference of an orientation's length from 1, as the server has it.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Where a tool is and whether it is engaged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Its position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Its orientation, a unit quaternion: x, y, z, w.
    pub orientation: [f32; 4],
    /// Whether it acts on the tissue.
    pub engaged: bool,
}

impl Pose {
    /// A tool at the origin that is not engaged.
    pub const AWAY: Self = Self::at([0.0; 3], false);

    /// A tool at a place, not turned.
    #[must_use]
    pub const fn at(position_m: [f32; 3], engaged: bool) -> Self {
        Self { position_m, orientation: [0.0, 0.0, 0.0, 1.0], engaged }
    }

    /// Why it is no pose.
    fn fault(&self) -> Option<&'static str> {
        let length = self.orientation.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>();
        if !self.position_m.iter().all(|x| x.is_finite()) {
            Some("its position is not finite; give three numbers in metres")
        } else if (length.sqrt() - 1.0).abs() <= UNIT_TOLERANCE {
            None
        } else {
            Some("its orientation is no unit quaternion x, y, z, w; 0, 0, 0, 1 is not turned")
        }
    }
}

/// The message of a tick. It has all tools that there can be: those beyond `poses` stay at the origin
/// and are not engaged, and those that the server was not told of are none of its business.
///
/// # Errors
/// The first tool that has no pose, and why; no tools, or too many.
pub(crate) fn message(tick: u64, send_ns: u64, poses: &[Pose]) -> Result<ToolPoses> {
    if !(1..=TOOLS_MAX).contains(&poses.len()) {
        let text = format!("poses of {} tools: give those of 1 to {TOOLS_MAX}", poses.len());
        return Err(Error::new(Kind::Pose, text));
    }
    let mut message = ToolPoses { tick, send_ns, tools: TOOLS_MAX as u32, ..ToolPoses::default() };
    for (number, place) in (0_u32..).zip(&mut message.each) {
        let pose = poses.get(number as usize).unwrap_or(&Pose::AWAY);
        if let Some(why) = pose.fault() {
            return Err(Error::new(Kind::Pose, format!("tool {number}: {why}; nothing was sent")));
        }
        *place = OneToolPose {
            number,
            engaged: pose.engaged.into(),
            position_m: pose.position_m,
            orientation: pose.orientation,
            reserved: 0,
        };
    }
    Ok(message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_has_every_tool_in_its_own_place() {
        let turned = Pose { orientation: [0.0, 0.6, 0.0, 0.8], ..Pose::at([1.0, 2.0, 3.0], true) };
        let message = message(7, 9, &[Pose::AWAY, turned]).unwrap();
        assert_eq!((message.tick, message.send_ns, message.tools, message.reserved), (7, 9, 8, 0));
        for (number, tool) in (0..).zip(message.each) {
            let wanted = if number == 1 { turned } else { Pose::AWAY };
            assert_eq!((tool.number, tool.reserved), (number, 0));
            assert_eq!(
                (tool.position_m, tool.orientation),
                (wanted.position_m, wanted.orientation)
            );
            assert_eq!(tool.engaged, u32::from(number == 1));
        }
    }

    #[test]
    fn what_is_no_pose_is_refused_with_the_tool_and_the_remedy() {
        let refusal = |pose: Pose| {
            let error = message(0, 0, &[Pose::AWAY, pose]).unwrap_err();
            assert_eq!(error.kind(), Kind::Pose);
            assert!(error.to_string().starts_with("tool 1: "), "{error}");
            error.to_string()
        };
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in 0..3 {
                let mut pose = Pose::AWAY;
                pose.position_m[axis] = bad;
                assert!(refusal(pose).contains("metres"));
            }
            for axis in 0..4 {
                let mut pose = Pose::AWAY;
                pose.orientation[axis] = bad;
                assert!(refusal(pose).contains("unit quaternion"));
            }
        }
        for length in [0.0, 0.9989, 1.0011, f32::MAX] {
            let orientation = [0.0, 0.0, 0.0, length];
            assert!(refusal(Pose { orientation, ..Pose::AWAY }).contains("unit quaternion"));
        }
        let with_w = |w| message(0, 0, &[Pose { orientation: [0.0, 0.0, 0.0, w], ..Pose::AWAY }]);
        assert!([1.0, -1.0, 1.0009, -0.9991].into_iter().all(|w| with_w(w).is_ok()));
        for count in [0, 9] {
            let error = message(0, 0, &vec![Pose::AWAY; count]).unwrap_err();
            assert!(error.to_string().contains("1 to 8"), "{error}");
        }
    }
}
