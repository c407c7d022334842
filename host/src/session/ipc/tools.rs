//! Version 2 of poses and answers: several tools with an orientation in one message, little-endian,
//! byte for byte as other programs declare it.
//!
//! This release has one tool, number 0. The other tools of a message are answered with no force.

use std::mem::{offset_of, size_of};

use chaincell_kernel::Flags;
use iceoryx2::prelude::ZeroCopySend;

use super::payload::{ToolForce, ToolPose};

/// Type name of [`ToolPoses`] in shared memory.
pub(crate) const TOOL_POSES: &str = "chaincell.ToolPoses.v2";
/// Type name of [`ToolForces`] in shared memory.
pub(crate) const TOOL_FORCES: &str = "chaincell.ToolForces.v2";

/// Most tools of a message.
pub const TOOLS_MAX: usize = 8;
/// Number of the tool that this release has.
const TOOL: u32 = 0;
/// Largest difference of a quaternion's length from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// One tool of a [`ToolPoses`]: 40 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.OneToolPose.v2")]
#[repr(C)]
pub struct OneToolPose {
    /// Which tool.
    pub number: u32,
    /// 1 while it holds the contact cells, else 0.
    pub engaged: u32,
    /// Its position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Its orientation, a unit quaternion: x, y, z, w.
    pub orientation: [f32; 4],
    /// Zero.
    pub reserved: u32,
}

/// The samples of all tools in one tick, on their way to the tissue: 344 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolPoses.v2")]
#[repr(C)]
pub struct ToolPoses {
    /// Number of the tick; a publisher counts upwards.
    pub tick: u64,
    /// When it was sent, by the sender's monotonic clock, 0 where unknown \[ns\].
    pub send_ns: u64,
    /// How many of the places below are in use: 1 to 8.
    pub tools: u32,
    /// Zero.
    pub reserved: u32,
    /// The tools; zero behind those in use.
    pub each: [OneToolPose; TOOLS_MAX],
}

/// One tool of a [`ToolForces`]: 40 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.OneToolForce.v2")]
#[repr(C)]
pub struct OneToolForce {
    /// Which tool.
    pub number: u32,
    /// Number of cells it holds.
    pub contacts: u32,
    /// Force of the tissue on it \[N\].
    pub force_n: [f32; 3],
    /// Torque of the tissue on it, zero in this release \[N m\].
    pub torque_n_m: [f32; 3],
    /// What bit, summed: see [`chaincell_kernel::Flags`].
    pub flags: u32,
    /// Zero.
    pub reserved: u32,
}

/// The answer to a [`ToolPoses`]: 384 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolForces.v2")]
#[repr(C)]
pub struct ToolForces {
    /// Number of the tick that this answers.
    pub tick: u64,
    /// The server's session, new for each, never 0.
    pub session_id: u64,
    /// Number of the tick whose pose the force is of.
    pub force_tick: u64,
    /// When the message answered was sent, as it said \[ns\].
    pub send_ns: u64,
    /// Hash of the state after the tick, 0 where none was taken.
    pub state_hash: u64,
    /// Certified upper bound of the elastic energy of the published state \[J\].
    pub energy_j: f32,
    /// What bit during the tick, summed: see [`chaincell_kernel::Flags`].
    pub flags: u32,
    /// Time the tick took, without waiting, hashing and sending \[ns\].
    pub step_ns: u32,
    /// Sweeps made in the tick, 0 in a late one.
    pub sweeps: u32,
    /// How many of the places below are in use.
    pub tools: u32,
    /// Zero.
    pub reserved: u32,
    /// The tools, in the places of the message answered; zero behind those in use.
    pub each: [OneToolForce; TOOLS_MAX],
}

/// What an answer repeats of a [`ToolPoses`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Asked {
    send_ns: u64,
    tools: u32,
    numbers: [u32; TOOLS_MAX],
}

/// An answer of the tissue, for either version.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Answer {
    /// What version 1 tells.
    pub force: ToolForce,
    /// Number of the last tick that made sweeps, 0 before the first.
    pub force_tick: u64,
    /// Sweeps made in the tick.
    pub sweeps: u32,
    /// What the message asked for, `None` for one of version 1.
    pub asked: Option<Asked>,
}

impl ToolPoses {
    /// The pose of the tool that this release has. That of a bad message is no number and no
    /// release.
    #[must_use]
    pub fn pose(&self) -> ToolPose {
        match self.tool() {
            Some(tool) if self.has_zeros() && is_unit(tool.orientation) => {
                ToolPose { tick: self.tick, position_m: tool.position_m, engaged: tool.engaged }
            }
            _ => ToolPose { tick: self.tick, position_m: [f32::NAN; 3], engaged: 1 },
        }
    }

    /// What the answer repeats. Where the tools are not told apart that is tool 0 alone.
    #[must_use]
    pub fn asked(&self) -> Asked {
        let send_ns = self.send_ns;
        if self.tool().is_none() {
            return Asked { send_ns, tools: 1, numbers: [TOOL; TOOLS_MAX] };
        }
        Asked { send_ns, tools: self.tools, numbers: self.each.map(|tool| tool.number) }
    }

    /// The tool that this release has, if it is there once.
    fn tool(&self) -> Option<&OneToolPose> {
        let in_use = self.each.get(..usize::try_from(self.tools).ok()?)?;
        let mut found = in_use.iter().filter(|tool| tool.number == TOOL);
        found.next().filter(|_| found.next().is_none())
    }

    fn has_zeros(&self) -> bool {
        self.reserved == 0 && self.each.iter().all(|tool| tool.reserved == 0)
    }
}

impl ToolForces {
    /// The message of an answer; one to version 1 goes to tool 0 alone.
    #[must_use]
    pub fn new(answer: &Answer, session_id: u64) -> Self {
        let &Answer { force, force_tick, sweeps, asked } = answer;
        let asked = asked.unwrap_or(Asked { tools: 1, ..Asked::default() });
        let mut each = [OneToolForce::default(); TOOLS_MAX];
        for (place, number) in each.iter_mut().zip(asked.numbers).take(asked.tools as usize) {
            *place = match number {
                TOOL => OneToolForce {
                    number,
                    contacts: force.contacts,
                    force_n: force.force_n,
                    flags: force.flags,
                    ..OneToolForce::default()
                },
                _ => OneToolForce { number, flags: Flags::SAFE_STATE.0, ..OneToolForce::default() },
            };
        }
        Self {
            tick: force.tick,
            session_id,
            force_tick,
            send_ns: asked.send_ns,
            state_hash: force.state_hash,
            energy_j: force.energy_j,
            flags: force.flags,
            step_ns: force.step_ns,
            sweeps,
            tools: asked.tools,
            reserved: 0,
            each,
        }
    }
}

/// Whether a quaternion turns and does nothing else.
fn is_unit(orientation: [f32; 4]) -> bool {
    let squares = orientation.map(|x| f64::from(x) * f64::from(x));
    (libm::sqrt(squares.iter().sum()) - 1.0).abs() <= UNIT_TOLERANCE
}

const _: () = {
    assert!(size_of::<OneToolPose>() == 40);
    assert!(offset_of!(OneToolPose, number) == 0);
    assert!(offset_of!(OneToolPose, engaged) == 4);
    assert!(offset_of!(OneToolPose, position_m) == 8);
    assert!(offset_of!(OneToolPose, orientation) == 20);
    assert!(offset_of!(OneToolPose, reserved) == 36);
    assert!(size_of::<ToolPoses>() == 344);
    assert!(offset_of!(ToolPoses, tick) == 0);
    assert!(offset_of!(ToolPoses, send_ns) == 8);
    assert!(offset_of!(ToolPoses, tools) == 16);
    assert!(offset_of!(ToolPoses, reserved) == 20);
    assert!(offset_of!(ToolPoses, each) == 24);
    assert!(size_of::<OneToolForce>() == 40);
    assert!(offset_of!(OneToolForce, number) == 0);
    assert!(offset_of!(OneToolForce, contacts) == 4);
    assert!(offset_of!(OneToolForce, force_n) == 8);
    assert!(offset_of!(OneToolForce, torque_n_m) == 20);
    assert!(offset_of!(OneToolForce, flags) == 32);
    assert!(offset_of!(OneToolForce, reserved) == 36);
    assert!(size_of::<ToolForces>() == 384);
    assert!(offset_of!(ToolForces, tick) == 0);
    assert!(offset_of!(ToolForces, session_id) == 8);
    assert!(offset_of!(ToolForces, force_tick) == 16);
    assert!(offset_of!(ToolForces, send_ns) == 24);
    assert!(offset_of!(ToolForces, state_hash) == 32);
    assert!(offset_of!(ToolForces, energy_j) == 40);
    assert!(offset_of!(ToolForces, flags) == 44);
    assert!(offset_of!(ToolForces, step_ns) == 48);
    assert!(offset_of!(ToolForces, sweeps) == 52);
    assert!(offset_of!(ToolForces, tools) == 56);
    assert!(offset_of!(ToolForces, reserved) == 60);
    assert!(offset_of!(ToolForces, each) == 64);
};

#[cfg(test)]
mod tests {
    use super::*;

    fn sound() -> ToolPoses {
        let mut poses = ToolPoses { tick: 7, send_ns: 9, tools: 2, ..ToolPoses::default() };
        poses.each[0] = OneToolPose { number: 5, ..OneToolPose::default() };
        poses.each[1] = OneToolPose {
            engaged: 1,
            position_m: [1.0, 2.0, 3.0],
            orientation: [0.0, 0.6, 0.0, 0.8],
            ..OneToolPose::default()
        };
        poses
    }

    fn is_bad(change: impl FnOnce(&mut ToolPoses)) -> bool {
        let mut poses = sound();
        change(&mut poses);
        let ToolPose { tick, position_m, engaged } = poses.pose();
        assert!(position_m == [1.0, 2.0, 3.0] || position_m.iter().all(|x| x.is_nan()));
        assert_eq!((tick, engaged), (7, 1));
        position_m[0].is_nan()
    }

    #[test]
    fn what_a_message_may_not_be() {
        assert!(!is_bad(|_| {}));
        assert!(!is_bad(|poses| poses.each[0].orientation = [f32::NAN; 4]), "another tool's");
        for tools in [0, 1, 3, 9, u32::MAX] {
            assert!(is_bad(|poses| poses.tools = tools), "{tools}: none, beyond, or two of them");
        }
        assert!(is_bad(|poses| poses.each[0].number = 0), "twice");
        assert!(is_bad(|poses| poses.each[1].number = 1), "missing");
        assert!(is_bad(|poses| poses.reserved = 1));
        for place in 0..TOOLS_MAX {
            assert!(is_bad(|poses| poses.each[place].reserved = 1), "{place}");
        }
    }

    #[test]
    fn a_quaternion_has_length_one_within_a_thousandth() {
        let with_w = |w: f32| is_bad(|poses| poses.each[1].orientation = [0.0, 0.0, 0.0, w]);
        assert!([1.0, -1.0, 1.0009, -0.9991].into_iter().all(|w| !with_w(w)));
        let bad = [0.0, 1.0011, 0.9989, f32::NAN, f32::INFINITY, f32::MAX, f32::MIN_POSITIVE];
        assert!(bad.into_iter().all(with_w));
    }

    #[test]
    fn every_tool_is_answered_in_its_place() {
        let force = ToolForce {
            tick: 7,
            force_n: [1.0, 2.0, 3.0],
            energy_j: 0.5,
            contacts: 4,
            flags: 32,
            step_ns: 6,
            reserved: 0,
            state_hash: 11,
        };
        let answer = Answer { force, force_tick: 3, sweeps: 8, asked: Some(sound().asked()) };
        let found = ToolForces::new(&answer, 12);
        let none = OneToolForce::default();
        let mut each = [none; TOOLS_MAX];
        each[0] = OneToolForce { number: 5, flags: 16, ..none };
        each[1] = OneToolForce { contacts: 4, force_n: [1.0, 2.0, 3.0], flags: 32, ..none };
        let wanted = ToolForces {
            tick: 7,
            session_id: 12,
            force_tick: 3,
            send_ns: 9,
            state_hash: 11,
            energy_j: 0.5,
            flags: 32,
            step_ns: 6,
            sweeps: 8,
            tools: 2,
            reserved: 0,
            each,
        };
        assert_eq!(found, wanted);
        // A message that has lost count of its tools, and one of version 1: tool 0 alone.
        let lost = ToolPoses { tools: 9, ..sound() };
        for asked in [Some(lost.asked()), None] {
            let found = ToolForces::new(&Answer { asked, ..answer }, 12);
            assert_eq!((found.tools, found.each[0], found.each[1]), (1, each[1], none));
        }
    }
}
