//! What travels over shared memory, little-endian, byte for byte as other programs declare it.

use std::mem::{offset_of, size_of};

use iceoryx2::prelude::ZeroCopySend;

/// Type name of [`ToolPose`] in shared memory.
pub const TOOL_POSE: &str = "chaincell.ToolPose.v1";
/// Type name of [`ToolForce`] in shared memory.
pub const TOOL_FORCE: &str = "chaincell.ToolForce.v1";

/// One tool sample on its way to the tissue: 24 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolPose.v1")]
#[repr(C)]
pub struct ToolPose {
    /// Number of the tick; a publisher counts upwards.
    pub tick: u64,
    /// Tool position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// 1 while the tool holds the contact cells, else 0.
    pub engaged: u32,
}

/// The answer to one tool sample: 48 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolForce.v1")]
#[repr(C)]
pub struct ToolForce {
    /// Number of the tick that this answers.
    pub tick: u64,
    /// Force of the tissue on the tool \[N\].
    pub force_n: [f32; 3],
    /// Certified upper bound of the elastic energy of the published state \[J\].
    pub energy_j: f32,
    /// Number of cells the tool holds.
    pub contacts: u32,
    /// What bit during the tick, summed: see [`chaincell_kernel::Flags`].
    pub flags: u32,
    /// Time the tick took, without waiting, hashing and sending \[ns\].
    pub step_ns: u32,
    /// Zero.
    pub reserved: u32,
    /// Hash of the state after the tick, 0 where none was taken.
    pub state_hash: u64,
}

/// One node of a published state: 16 bytes. A state has every node of the model, by ascending id.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.NodePosition.v1")]
#[repr(C)]
pub struct NodePosition {
    /// Id of the node in the input mesh.
    pub node: u32,
    /// Its position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
}

/// What a published state belongs to: 32 bytes, the user header of a slice of [`NodePosition`].
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.State.v1")]
#[repr(C)]
pub struct StateHeader {
    /// Number of the last answered tick, 0 before the first.
    pub tick: u64,
    /// Ticks answered since the server began.
    pub ticks_answered: u64,
    /// Hash of the state.
    pub state_hash: u64,
    /// Number of nodes in the slice.
    pub nodes: u32,
    /// Flags of the last answer.
    pub flags: u32,
}

/// A command to the server: 16 bytes; numbers as in [`chaincell_kernel::trace::Command::words`].
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.Command.v1")]
#[repr(C)]
pub struct CommandMessage {
    /// 1 reset, 2 pause, 3 resume, 4 set, 5 grip, 6 let go.
    pub kind: u32,
    /// 0 none; of set: 1 sweeps, 2 max_force_n, 3 max_tool_step_m, 4 unloading; of grip and let go:
    /// the tool.
    pub parameter: u32,
    /// Of set: the value; of unloading 0 off, 1 release, 2 retreat. Of let go: the ticks.
    pub value: f32,
    /// Zero.
    pub reserved: u32,
}

/// The reply to a command: 32 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("chaincell.Reply.v1")]
#[repr(C)]
pub struct ReplyMessage {
    /// Number of the last tick answered before the command, 0 before the first.
    pub tick: u64,
    /// Ticks answered before the command since the server began.
    pub ticks_answered: u64,
    /// Hash of the state after the command.
    pub state_hash: u64,
    /// 0 done, 1 refused: nothing has changed.
    pub result: u32,
    /// Why it was refused, see [`Refusal`](crate::command::Refusal); 0 when done.
    pub reason: u32,
}

impl From<ToolPose> for chaincell_kernel::ToolPose {
    fn from(pose: ToolPose) -> Self {
        Self::at(pose.position_m.into(), pose.engaged)
    }
}

const _: () = {
    assert!(size_of::<ToolPose>() == 24);
    assert!(offset_of!(ToolPose, tick) == 0);
    assert!(offset_of!(ToolPose, position_m) == 8);
    assert!(offset_of!(ToolPose, engaged) == 20);
    assert!(size_of::<ToolForce>() == 48);
    assert!(offset_of!(ToolForce, tick) == 0);
    assert!(offset_of!(ToolForce, force_n) == 8);
    assert!(offset_of!(ToolForce, energy_j) == 20);
    assert!(offset_of!(ToolForce, contacts) == 24);
    assert!(offset_of!(ToolForce, flags) == 28);
    assert!(offset_of!(ToolForce, step_ns) == 32);
    assert!(offset_of!(ToolForce, reserved) == 36);
    assert!(offset_of!(ToolForce, state_hash) == 40);
    assert!(size_of::<NodePosition>() == 16);
    assert!(offset_of!(NodePosition, node) == 0);
    assert!(offset_of!(NodePosition, position_m) == 4);
    assert!(size_of::<StateHeader>() == 32);
    assert!(offset_of!(StateHeader, tick) == 0);
    assert!(offset_of!(StateHeader, ticks_answered) == 8);
    assert!(offset_of!(StateHeader, state_hash) == 16);
    assert!(offset_of!(StateHeader, nodes) == 24);
    assert!(offset_of!(StateHeader, flags) == 28);
    assert!(size_of::<CommandMessage>() == 16);
    assert!(offset_of!(CommandMessage, kind) == 0);
    assert!(offset_of!(CommandMessage, parameter) == 4);
    assert!(offset_of!(CommandMessage, value) == 8);
    assert!(offset_of!(CommandMessage, reserved) == 12);
    assert!(size_of::<ReplyMessage>() == 32);
    assert!(offset_of!(ReplyMessage, tick) == 0);
    assert!(offset_of!(ReplyMessage, ticks_answered) == 8);
    assert!(offset_of!(ReplyMessage, state_hash) == 16);
    assert!(offset_of!(ReplyMessage, result) == 24);
    assert!(offset_of!(ReplyMessage, reason) == 28);
};
