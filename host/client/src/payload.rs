//! States and commands as they are sent over shared memory, little-endian, byte for byte as other programs
//! declare them.

use iceoryx2::prelude::ZeroCopySend;

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

/// Tick and model that a published state belongs to: 40 bytes, the user header of a slice of
/// [`NodePosition`].
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.State.v2")]
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
    /// Checksum of the model image, as `chaincell info` prints it.
    pub model_checksum: u32,
    /// Zero.
    pub reserved: u32,
}

/// The type name of [`CommandMessage`].
pub const COMMAND: &str = "chaincell.Command.v2";

/// A command to the server: 32 bytes; numbers as in [`chaincell_kernel::trace::Command::words`].
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.Command.v2")]
#[repr(C)]
pub struct CommandMessage {
    /// 1 reset, 2 pause, 3 resume, 4 set, 5 grip, 6 let go, 7 snapshot, 8 pin, 9 unpin, 10 pin at a place.
    pub kind: u32,
    /// 0 none; of set: 1 sweeps, 2 max_force_n, 3 max_tool_step_m, 4 unloading, 7 cut; of grip,
    /// let go and pin: the tool; of unpin: the pin.
    pub parameter: u32,
    /// Of set: the value; of unloading 0 off, 1 release, 2 retreat; of cut 0 on, 1 off. Of let go and unpin: the
    /// ticks. Of pin and of pin at a place: the stiffness \[N/m\], infinite for a rigid one.
    pub value: f32,
    /// Zero.
    pub reserved: u32,
    /// Of pin at a place: the point in the frame of the input mesh \[m\]; of all others zeros.
    pub point_m: [f32; 3],
    /// Of pin at a place: the radius around it, above 0 \[m\]; of all others zero.
    pub radius_m: f32,
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
    /// Reason of a refusal, see [`Refusal`](crate::command::Refusal). When done, of a pin its number, else 0.
    pub reason: u32,
}

// The offsets follow from the order of the fields, which the tables of the reference are compared with.
const _: () = {
    assert!(size_of::<NodePosition>() == 16);
    assert!(size_of::<StateHeader>() == 40);
    assert!(size_of::<CommandMessage>() == 32);
    assert!(size_of::<ReplyMessage>() == 32);
};
