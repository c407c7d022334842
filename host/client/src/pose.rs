//! Messages of tool poses to the server, checked before they are sent.

use chaincell_kernel::{OPENING_MAX, ToolPose};

use crate::error::{Error, Kind, Result};
use crate::tools::{TOOLS_MAX, ToolPoses, is_unit};

/// Returns the reason if it is no pose.
fn fault(pose: &ToolPose) -> Option<&'static str> {
    if !pose.position_m.iter().all(|x| x.is_finite()) {
        Some("its position is not finite; give three numbers in metres")
    } else if pose.engaged > 1 {
        Some("its `engaged` is neither 0 nor 1; give 1 while it acts on the tissue")
    } else if pose.opening_turns_q16 > OPENING_MAX {
        Some("its opening is above half a turn; give 0 to pi, in counts 0 to 32768")
    } else if is_unit(pose.orientation) {
        None
    } else {
        Some("its orientation is no unit quaternion x, y, z, w; 0, 0, 0, 1 is not turned")
    }
}

/// Returns the message of a tick. It has [`TOOLS_MAX`] tools: those beyond `poses` stay at the origin and
/// are not engaged, and the server ignores those that it does not have.
///
/// # Errors
/// The first tool without a valid pose, and the reason; no tools, or too many.
pub(crate) fn message(tick: u64, send_ns: u64, poses: &[ToolPose]) -> Result<ToolPoses> {
    if !(1..=TOOLS_MAX).contains(&poses.len()) {
        let text = format!("poses of {} tools: give those of 1 to {TOOLS_MAX}", poses.len());
        return Err(Error::new(Kind::Pose, text));
    }
    for (number, pose) in poses.iter().enumerate() {
        if let Some(why) = fault(pose) {
            return Err(Error::new(Kind::Pose, format!("tool {number}: {why}; nothing was sent")));
        }
    }
    Ok(ToolPoses::of(tick, send_ns, poses))
}

#[cfg(test)]
mod tests {
    use super::*;

    const AWAY: ToolPose = ToolPose::AWAY;

    #[test]
    fn a_message_has_every_tool_in_its_own_place() {
        let at = ToolPose::at([1.0, 2.0, 3.0].into(), 1);
        let turned = ToolPose { orientation: [0.0, 0.6, 0.0, 0.8], ..at }.with_opening_rad(0.5);
        assert_eq!(turned.opening_turns_q16, 5215);
        let message = message(7, 9, &[AWAY, turned]).unwrap();
        assert_eq!((message.tick, message.send_ns, message.tools, message.reserved), (7, 9, 8, 0));
        for (number, tool) in (0..).zip(message.each) {
            let wanted = if number == 1 { turned } else { AWAY };
            assert_eq!((tool.number, tool.reserved), (number, 0));
            assert_eq!(
                (tool.position_m, tool.orientation),
                (wanted.position_m.into(), wanted.orientation)
            );
            assert_eq!(tool.engaged, u16::from(number == 1));
            assert_eq!(tool.opening_turns_q16, wanted.opening_turns_q16);
        }
    }

    #[test]
    fn what_is_no_pose_is_refused_with_the_tool_and_the_remedy() {
        let refusal = |pose: ToolPose| {
            let error = message(0, 0, &[AWAY, pose]).unwrap_err();
            assert_eq!(error.kind(), Kind::Pose);
            assert!(error.to_string().starts_with("tool 1: "), "{error}");
            error.to_string()
        };
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in 0..3 {
                let mut pose = AWAY;
                pose.position_m[axis] = bad;
                assert!(refusal(pose).contains("metres"));
            }
            for axis in 0..4 {
                let mut pose = AWAY;
                pose.orientation[axis] = bad;
                assert!(refusal(pose).contains("unit quaternion"));
            }
        }
        assert!(refusal(ToolPose { engaged: 2, ..AWAY }).contains("give 1"));
        assert!(refusal(AWAY.with_opening_rad(3.2)).contains("0 to pi"));
        for length in [0.0, 0.9989, 1.0011, f32::MAX] {
            let orientation = [0.0, 0.0, 0.0, length];
            assert!(refusal(ToolPose { orientation, ..AWAY }).contains("unit quaternion"));
        }
        let with_w = |w| message(0, 0, &[ToolPose { orientation: [0.0, 0.0, 0.0, w], ..AWAY }]);
        assert!([1.0, -1.0, 1.0009, -0.9991].into_iter().all(|w| with_w(w).is_ok()));
        for count in [0, 9] {
            let error = message(0, 0, &vec![AWAY; count]).unwrap_err();
            assert!(error.to_string().contains("1 to 8"), "{error}");
        }
    }
}
