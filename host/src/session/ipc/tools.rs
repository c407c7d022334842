//! Version 2 of poses and answers: several tools with an orientation in one message, little-endian,
//! byte for byte as other programs declare it.
//!
//! Of the tools of a message those are moved that `serve` was told of: the ones chosen by their parts,
//! or else tool 0 alone. The others are answered with no force.

use std::mem::{offset_of, size_of};

use chaincell_kernel::Flags;
use iceoryx2::prelude::ZeroCopySend;

use super::payload::{ToolForce, ToolPose};
use crate::engine::tools::{Felt, Poses, is_unit};

/// Type name of [`ToolPoses`] in shared memory.
pub(crate) const TOOL_POSES: &str = "chaincell.ToolPoses.v2";
/// Type name of [`ToolForces`] in shared memory.
pub(crate) const TOOL_FORCES: &str = "chaincell.ToolForces.v2";

/// Most tools of a message.
pub const TOOLS_MAX: usize = 8;

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
    /// Torque of the tissue on it about its position \[N m\].
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
    /// How many tools were chosen by their parts; 0 where [`Self::force`] is all there is.
    pub chosen: u32,
    /// What each of them felt; the flags are its own, [`Flags::RELEASE_FIRST`] too.
    pub felt: [Felt; TOOLS_MAX],
}

impl Answer {
    /// What the chosen tools felt.
    #[must_use]
    pub fn tools(&self) -> &[Felt] {
        self.felt.get(..self.chosen as usize).unwrap_or(&self.felt)
    }

    /// The same, to be changed.
    pub(crate) fn tools_mut(&mut self) -> &mut [Felt] {
        let chosen = TOOLS_MAX.min(self.chosen as usize);
        &mut self.felt[..chosen]
    }

    /// What is told of a tool.
    fn of(&self, number: u32) -> OneToolForce {
        let ToolForce { force_n, contacts, flags, .. } = self.force;
        let felt = match self.tools().get(number as usize) {
            Some(felt) => Felt { flags: Flags(felt.all_flags(flags)), ..*felt },
            None if number == 0 => {
                Felt { force_n, contacts, flags: Flags(flags), ..Felt::default() }
            }
            None => Felt { flags: Flags::SAFE_STATE, ..Felt::default() },
        };
        let Felt { force_n, torque_n_m, contacts, flags } = felt;
        OneToolForce { number, contacts, force_n, torque_n_m, flags: flags.0, reserved: 0 }
    }
}

impl ToolPoses {
    /// The pose of tool 0. That of a bad message is no number and no release.
    #[must_use]
    pub fn pose(&self) -> ToolPose {
        self.pose_of(1)
    }

    /// The pose of tool 0 where so many tools were chosen by their parts.
    pub(crate) fn pose_of(&self, chosen: usize) -> ToolPose {
        let first = self.poses(chosen.max(1)).each().first().copied();
        let first = first.map_or(([f32::NAN; 3], 1), |of| (of.position_m.into(), of.engaged));
        ToolPose { tick: self.tick, position_m: first.0, engaged: first.1 }
    }

    /// The poses of the tools 0 to `tools` - 1. Those of a bad message are no numbers and no
    /// releases.
    #[must_use]
    pub fn poses(&self, tools: usize) -> Poses {
        let is_chosen = |tool: &&OneToolPose| (tool.number as usize) < tools;
        let mut chosen = self.in_use().iter().filter(is_chosen);
        let is_sound = self.has_zeros()
            && self.has_each(tools)
            && chosen.all(|tool| is_unit(tool.orientation));
        let mut poses = Poses::away(tools);
        for (number, pose) in (0..).zip(poses.each_mut()) {
            (pose.position_m, pose.engaged) = ([f32::NAN; 3].into(), 1);
            let of = self.in_use().iter().find(|tool| tool.number == number);
            if let Some(tool) = of.filter(|_| is_sound) {
                let [x, y, z, w] = tool.orientation;
                (pose.position_m, pose.turn) = (tool.position_m.into(), [w, x, y, z]);
                pose.engaged = tool.engaged;
            }
        }
        poses
    }

    /// What the answer repeats where there is tool 0 alone, see [`Self::asked_of`].
    #[must_use]
    pub fn asked(&self) -> Asked {
        self.asked_of(1)
    }

    /// What the answer repeats. Where the tools are not told apart those are the chosen ones, by
    /// ascending number.
    #[must_use]
    pub fn asked_of(&self, tools: usize) -> Asked {
        let send_ns = self.send_ns;
        if !self.has_each(tools) {
            let numbers = std::array::from_fn(|number| number as u32);
            return Asked { send_ns, tools: tools as u32, numbers };
        }
        Asked { send_ns, tools: self.tools, numbers: self.each.map(|tool| tool.number) }
    }

    /// The places in use; none where the message has lost count of them.
    fn in_use(&self) -> &[OneToolPose] {
        self.each.get(..self.tools as usize).unwrap_or(&[])
    }

    /// Whether each of so many tools is there once.
    fn has_each(&self, tools: usize) -> bool {
        let count = |number| self.in_use().iter().filter(|tool| tool.number == number).count();
        (0..tools as u32).all(|number| count(number) == 1)
    }

    fn has_zeros(&self) -> bool {
        self.reserved == 0 && self.each.iter().all(|tool| tool.reserved == 0)
    }
}

impl ToolForces {
    /// The message of an answer; one to version 1 goes to tool 0 alone.
    #[must_use]
    pub fn new(answer: &Answer, session_id: u64) -> Self {
        let &Answer { force, force_tick, sweeps, asked, .. } = answer;
        let asked = asked.unwrap_or(Asked { tools: 1, ..Asked::default() });
        let mut each = [OneToolForce::default(); TOOLS_MAX];
        for (place, number) in each.iter_mut().zip(asked.numbers).take(asked.tools as usize) {
            *place = answer.of(number);
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

    /// Three tools in another order, the one in the middle not chosen.
    fn of_two() -> ToolPoses {
        let mut poses = ToolPoses { tools: 3, ..sound() };
        poses.each.swap(0, 2);
        poses.each[0] =
            OneToolPose { number: 1, orientation: [0.0, 0.0, 1.0, 0.0], ..poses.each[1] };
        poses.each.swap(1, 2);
        poses
    }

    #[test]
    fn each_chosen_tool_is_to_be_there_once() {
        let sent = of_two();
        let poses = sent.poses(2);
        assert_eq!(
            poses.each().iter().map(|of| of.turn).collect::<Vec<_>>(),
            [[0.8, 0.0, 0.6, 0.0], [0.0, 0.0, 0.0, 1.0]]
        );
        assert!(poses.are_good() && sent.asked_of(2).numbers[..3] == [1, 5, 0]);
        let bad: [&dyn Fn(&mut ToolPoses); 6] = [
            &|sent| sent.tools = 2,
            &|sent| sent.each[0].number = 0,
            &|sent| sent.each[1].number = 1,
            &|sent| sent.each[2].number = 2,
            &|sent| sent.each[0].orientation = [0.0, 0.0, 0.0, 2.0],
            &|sent| sent.reserved = 1,
        ];
        for (at, change) in bad.iter().enumerate() {
            let mut sent = of_two();
            change(&mut sent);
            let poses = sent.poses(2);
            let is_nan = |of: &chaincell_kernel::ToolPose| of.position_m.iter().all(|x| x.is_nan());
            assert!(poses.each().iter().all(|of| is_nan(of) && of.engaged == 1), "{at}");
            let asked = sent.asked_of(2);
            let are_told_apart = at > 3;
            assert_eq!((asked.tools == 3, asked.numbers[0] == 1), (are_told_apart, are_told_apart));
        }
    }

    #[test]
    fn chosen_tools_have_two_flags_of_their_own() {
        let force = ToolForce { force_n: [9.0; 3], flags: 8 + 32, ..ToolForce::default() };
        let asked = Some(of_two().asked_of(2));
        let mut answer = Answer { force, asked, chosen: 2, ..Answer::default() };
        let torque_n_m = [0.1, 0.2, 0.3];
        answer.felt[0] = Felt { force_n: [9.0; 3], flags: Flags(8), ..Felt::default() };
        answer.felt[1] =
            Felt { force_n: [1.0; 3], torque_n_m, contacts: 6, flags: Flags::RELEASE_FIRST };
        let [second, other, first, ..] = ToolForces::new(&answer, 1).each;
        assert_eq!((first.number, first.force_n, first.flags), (0, [9.0; 3], 8 + 32));
        assert_eq!((second.torque_n_m, second.contacts, second.flags), (torque_n_m, 6, 512 + 32));
        assert_eq!((other.number, other.force_n, other.flags), (5, [0.0; 3], 16));
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
        let asked = Some(sound().asked());
        let answer = Answer { force, force_tick: 3, sweeps: 8, asked, ..Answer::default() };
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
