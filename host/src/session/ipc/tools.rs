//! Poses and answers on the server's side: a message holds all tools.
//!
//! A message moves only the tools that `serve` knows: those defined by their parts (the chosen tools), or
//! else tool 0. The others get no force in the answer.

pub use chaincell_client::tools::{
    OneToolForce, OneToolPose, TOOLS_MAX, ToolForces, ToolPoses, UNKNOWN_N,
};
use chaincell_kernel::Flags;

use crate::engine::tools::{Felt, Poses, is_unit};

/// Fields of a [`ToolPoses`] that its answer repeats.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Asked {
    /// Time at which its poses were sent \[ns\], by the sender's clock.
    pub send_ns: u64,
    tools: u32,
    numbers: [u32; TOOLS_MAX],
}

/// The answer to a tick; of several tools the one for tool 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TickForce {
    /// Number of the tick.
    pub tick: u64,
    /// Force of the tissue on the tool \[N\].
    pub force_n: [f32; 3],
    /// Certified upper bound of the elastic energy of the published state \[J\].
    pub energy_j: f32,
    /// Number of cells that the tool holds, or of triangles that it touches.
    pub contacts: u32,
    /// Flags of the tick, a sum of [`Flags`].
    pub flags: u32,
    /// Duration of the tick, without waiting, hashing and sending \[ns\].
    pub step_ns: u32,
    /// Hash of the state after the tick, 0 for none.
    pub state_hash: u64,
    /// Estimated error of the tissue's force, before its limit; `None` where it is not known, and where an output
    /// stage answers another force \[N\].
    pub force_error_n: Option<f32>,
}

/// An answer of the tissue.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Answer {
    /// Answer to the tick.
    pub force: TickForce,
    /// Number of the last tick that made sweeps, 0 before the first.
    pub force_tick: u64,
    /// Sweeps made in the tick.
    pub sweeps: u32,
    /// Fields of the message that the answer repeats.
    pub asked: Asked,
    /// Number of chosen tools; 0 if there is only [`Self::force`].
    pub chosen: u32,
    /// Output of each chosen tool, with the flags of that tool alone, which include [`Flags::RELEASE_FIRST`].
    pub felt: [Felt; TOOLS_MAX],
}

impl Answer {
    /// Returns the outputs of the chosen tools.
    #[must_use]
    pub fn tools(&self) -> &[Felt] {
        self.felt.get(..self.chosen as usize).unwrap_or(&self.felt)
    }

    /// Mutable version of [`Self::tools`].
    pub(crate) fn tools_mut(&mut self) -> &mut [Felt] {
        let chosen = TOOLS_MAX.min(self.chosen as usize);
        &mut self.felt[..chosen]
    }

    /// Returns the part of the message for tool `precision`.
    fn of(&self, number: u32) -> OneToolForce {
        let TickForce { force_n, contacts, flags, force_error_n, .. } = self.force;
        let felt = match self.tools().get(number as usize) {
            Some(felt) => Felt { flags: Flags(felt.all_flags(flags)), ..*felt },
            None if number == 0 => {
                Felt { force_n, contacts, flags: Flags(flags), force_error_n, ..Felt::default() }
            }
            None => Felt { flags: Flags::SAFE_STATE, ..Felt::default() },
        };
        let Felt { force_n, torque_n_m, contacts, flags, force_error_n, torque_error_n_m } = felt;
        OneToolForce {
            number,
            contacts,
            force_n,
            torque_n_m,
            flags: flags.0,
            force_error_n: force_error_n.unwrap_or(UNKNOWN_N),
            torque_error_n_m: torque_error_n_m.unwrap_or(UNKNOWN_N),
        }
    }
}

/// A server's view of a [`ToolPoses`].
pub trait Asking {
    /// Returns the poses of the chosen tools, 0 to `chosen` - 1, or that of tool 0 if none are chosen. In a
    /// bad message all of them are NaN and engaged, so that none counts as a release.
    #[must_use]
    fn poses(&self, chosen: usize) -> Poses;

    /// Returns the fields that the answer repeats. If the message does not have each chosen tool exactly
    /// once, the answer lists the chosen tools, or tool 0 if none are chosen, by ascending number.
    #[must_use]
    fn asked(&self, chosen: usize) -> Asked;
}

impl Asking for ToolPoses {
    fn poses(&self, chosen: usize) -> Poses {
        let tools = chosen.max(1);
        let is_chosen = |tool: &&OneToolPose| (tool.number as usize) < tools;
        let mut all_chosen = in_use(self).iter().filter(is_chosen);
        let is_sound = has_zeros(self)
            && has_each(self, tools)
            && all_chosen.all(|tool| is_unit(tool.orientation));
        let mut poses = Poses::away(tools);
        for (number, pose) in (0..).zip(poses.each_mut()) {
            (pose.position_m, pose.engaged) = ([f32::NAN; 3].into(), 1);
            let of = in_use(self).iter().find(|tool| tool.number == number);
            if let Some(tool) = of.filter(|_| is_sound) {
                (pose.position_m, pose.orientation) = (tool.position_m.into(), tool.orientation);
                pose.engaged = tool.engaged;
                pose.opening_turns_q16 = tool.opening_turns_q16;
            }
        }
        poses
    }

    fn asked(&self, chosen: usize) -> Asked {
        let (send_ns, tools) = (self.send_ns, chosen.max(1));
        if !has_each(self, tools) {
            let numbers = std::array::from_fn(|number| number as u32);
            return Asked { send_ns, tools: tools as u32, numbers };
        }
        Asked { send_ns, tools: self.tools, numbers: self.each.map(|tool| tool.number) }
    }
}

/// Returns the entries in use, or none if their number is out of range.
fn in_use(poses: &ToolPoses) -> &[OneToolPose] {
    poses.each.get(..poses.tools as usize).unwrap_or(&[])
}

/// Returns true if each of the tools 0 to `tools` - 1 has exactly one entry.
fn has_each(poses: &ToolPoses, tools: usize) -> bool {
    let count = |number| in_use(poses).iter().filter(|tool| tool.number == number).count();
    (0..tools as u32).all(|number| count(number) == 1)
}

fn has_zeros(poses: &ToolPoses) -> bool {
    poses.reserved == 0 && poses.each.iter().all(|tool| tool.reserved == 0)
}

impl Answer {
    /// Returns the answer as a message.
    #[must_use]
    pub fn message(&self, session_id: u64) -> ToolForces {
        let &Answer { force, force_tick, sweeps, asked, .. } = self;
        let mut each = [OneToolForce::default(); TOOLS_MAX];
        for (place, number) in each.iter_mut().zip(asked.numbers).take(asked.tools as usize) {
            *place = self.of(number);
        }
        ToolForces {
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

#[cfg(test)]
mod tests {
    use chaincell_kernel::ToolPose;
    use nalgebra::Vector3;

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
        let found = poses.poses(0);
        let [ToolPose { position_m, engaged, .. }] = found.each() else { panic!() };
        assert!(
            *position_m == Vector3::new(1.0, 2.0, 3.0) || position_m.iter().all(|x| x.is_nan())
        );
        assert_eq!(*engaged, 1);
        position_m.x.is_nan()
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

    /// Three tools in another order; the middle one is not chosen.
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
            poses.each().iter().map(|of| of.orientation).collect::<Vec<_>>(),
            [[0.0, 0.6, 0.0, 0.8], [0.0, 0.0, 1.0, 0.0]]
        );
        assert!(poses.are_good() && sent.asked(2).numbers[..3] == [1, 5, 0]);
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
            let is_nan = |of: &ToolPose| of.position_m.iter().all(|x| x.is_nan());
            assert!(poses.each().iter().all(|of| is_nan(of) && of.engaged == 1), "{at}");
            let asked = sent.asked(2);
            let are_told_apart = at > 3;
            assert_eq!((asked.tools == 3, asked.numbers[0] == 1), (are_told_apart, are_told_apart));
        }
    }

    #[test]
    fn chosen_tools_have_two_flags_of_their_own() {
        let force = TickForce { force_n: [9.0; 3], flags: 8 + 32, ..TickForce::default() };
        let asked = of_two().asked(2);
        let mut answer = Answer { force, asked, chosen: 2, ..Answer::default() };
        let torque_n_m = [0.1, 0.2, 0.3];
        answer.felt[0] = Felt { force_n: [9.0; 3], flags: Flags(8), ..Felt::default() };
        answer.felt[1] = Felt {
            force_n: [1.0; 3],
            torque_n_m,
            contacts: 6,
            flags: Flags::RELEASE_FIRST,
            force_error_n: Some(0.5),
            torque_error_n_m: Some(0.25),
        };
        let [second, other, first, ..] = answer.message(1).each;
        assert_eq!([second, other, first].map(|of| of.error_n()), [Some(0.5), None, None]);
        let of_torques = [second, other, first].map(|of| of.torque_error_n_m());
        assert_eq!(of_torques, [Some(0.25), None, None]);
        assert_eq!((first.number, first.force_n, first.flags), (0, [9.0; 3], 8 + 32));
        assert_eq!((second.torque_n_m, second.contacts, second.flags), (torque_n_m, 6, 512 + 32));
        assert_eq!((other.number, other.force_n, other.flags), (5, [0.0; 3], 16));
    }

    #[test]
    fn every_tool_is_answered_in_its_place() {
        let force = TickForce {
            tick: 7,
            force_n: [1.0, 2.0, 3.0],
            energy_j: 0.5,
            contacts: 4,
            flags: 32,
            step_ns: 6,
            state_hash: 11,
            force_error_n: Some(0.25),
        };
        // Answer a message of two tools.
        let asked = sound().asked(0);
        let answer = Answer { force, force_tick: 3, sweeps: 8, asked, ..Answer::default() };
        let found = answer.message(12);
        // Each tool has its place, and the one that is not chosen no force.
        let none = OneToolForce {
            force_error_n: UNKNOWN_N,
            torque_error_n_m: UNKNOWN_N,
            ..OneToolForce::default()
        };
        let mut each = [OneToolForce::default(); TOOLS_MAX];
        each[0] = OneToolForce { number: 5, flags: 16, ..none };
        each[1] = OneToolForce {
            contacts: 4,
            force_n: [1.0, 2.0, 3.0],
            flags: 32,
            force_error_n: 0.25,
            torque_error_n_m: UNKNOWN_N,
            ..none
        };
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
        // If the number of tools is out of range, the answer has only tool 0.
        let lost = ToolPoses { tools: 9, ..sound() };
        let found = Answer { asked: lost.asked(0), ..answer }.message(12);
        assert_eq!(
            (found.tools, found.each[0], found.each[1]),
            (1, each[1], OneToolForce::default())
        );
    }
}
