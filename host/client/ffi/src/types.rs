//! What C hands over and gets, byte for byte.

use std::mem::{offset_of, size_of};

use chaincell_client::payload::{NodePosition, ReplyMessage, StateHeader};
use chaincell_client::tools::UNKNOWN_N;
use chaincell_client::wait::Wait;
use chaincell_client::{Answer, ToolOutput, ToolPose, contacts};

use crate::code::{Code, keep};

/// Most tools of a scene.
pub const TOOLS_MAX: usize = 8;

/// What a handle is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Role {
    /// Sends poses; a scene has one.
    Controller = 0,
    /// Looks at states and contacts, and sends commands.
    Viewer = 1,
}

/// How to wait for answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum WaitMode {
    /// Sleep until shortly before the answer is expected, poll for at most 200 us, then short sleeps.
    Hybrid = 0,
    /// Poll all the time: the shortest answers, but only with a free core for each side.
    Spin = 1,
    /// Sleep until the server wakes this process: no polling, the longest answers.
    Event = 2,
}

/// How to open a scene: 24 bytes; `CHAINCELL_CLIENT_OPTIONS_DEFAULT` initialises it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct Options {
    /// One of `chaincell_client_role`.
    pub role: i32,
    /// One of `chaincell_client_wait`.
    pub wait: i32,
    /// Longest wait for a server, or of a viewer for one that shows a session of another place \[ns\], of which an hour
    /// is waited at most; 10 s.
    pub server_wait_ns: u64,
    /// Time without an answer after which the force falls to 0, 0 for never \[ms\]; 20, at most 60,000.
    pub watchdog_ms: u32,
    /// Time in which it falls, and rises when answers come again; 0 for at once \[ms\]; 20, at most
    /// 60,000.
    pub ramp_ms: u32,
}

impl From<chaincell_client::Options> for Options {
    fn from(of: chaincell_client::Options) -> Self {
        Self {
            role: Role::Controller as i32,
            wait: WaitMode::Hybrid as i32,
            server_wait_ns: of.server_wait_ns,
            watchdog_ms: of.watchdog_ms,
            ramp_ms: of.ramp_ms,
        }
    }
}

impl Options {
    /// The options of a scene.
    pub(crate) fn with_scene(
        &self,
        scene: Option<String>,
    ) -> Result<chaincell_client::Options, Code> {
        let role = match self.role {
            0 => chaincell_client::Role::Controller,
            1 => chaincell_client::Role::Viewer,
            role => return Err(none_of("role", role)),
        };
        let wait = match self.wait {
            0 => Wait::Hybrid,
            1 => Wait::Spin,
            2 => Wait::Event,
            wait => return Err(none_of("wait", wait)),
        };
        let &Self { server_wait_ns, watchdog_ms, ramp_ms, .. } = self;
        let domain = chaincell_client::services::Domain::default();
        Ok(chaincell_client::Options {
            scene,
            domain,
            role,
            wait,
            server_wait_ns,
            watchdog_ms,
            ramp_ms,
        })
    }
}

fn none_of(name: &str, value: i32) -> Code {
    keep(&format!("`{name}` {value}: none of its values; take one of chaincell_client_{name}"));
    Code::Argument
}

/// What to show at a moment: 400 bytes. Every force is finite, whatever has come.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct Shown {
    /// Number of the tick that was answered last, 0 before the first.
    pub tick: u64,
    /// Session of the server that answered, 0 before the first.
    pub session_id: u64,
    /// Number of the tick whose pose the force is of.
    pub force_tick: u64,
    /// Hash of the state after the tick, 0 where none was taken.
    pub state_hash: u64,
    /// From sending the pose to its answer \[ns\].
    pub round_trip_ns: u64,
    /// How long ago the answer came \[ns\].
    pub age_ns: u64,
    /// Answers that have come.
    pub answers: u64,
    /// Certified upper bound of the elastic energy of the tissue \[J\].
    pub energy_j: f32,
    /// What bit during the tick, a sum of CHAINCELL_FLAG_.
    pub flags: u32,
    /// What the client says itself, a sum of CHAINCELL_CLIENT_NOTE_.
    pub notes: u32,
    /// Time the tick took the server \[ns\].
    pub step_ns: u32,
    /// Sweeps made in the tick, 0 in a late one.
    pub sweeps: u32,
    /// Zero.
    pub reserved: u32,
    /// What each tool feels, by its number.
    pub tools: [ToolOutput; TOOLS_MAX],
    /// Estimated error of each tool's force, before its limit \[N\]; below 0 where it is not known, where an output
    /// stage answers another force than the tissue's, and while the client shows another force than the server's.
    pub force_error_n: [f32; TOOLS_MAX],
    /// Estimated error of each tool's torque likewise, below 0 for held cells too \[N m\].
    pub torque_error_n_m: [f32; TOOLS_MAX],
}

impl From<Answer> for Shown {
    fn from(of: Answer) -> Self {
        Self {
            tick: of.tick,
            session_id: of.session_id,
            force_tick: of.force_tick,
            state_hash: of.state_hash,
            round_trip_ns: of.round_trip_ns,
            age_ns: of.age_ns,
            answers: of.answers,
            energy_j: of.energy_j,
            flags: of.flags,
            notes: of.notes.0,
            step_ns: of.step_ns,
            sweeps: of.sweeps,
            reserved: 0,
            tools: of.tools,
            force_error_n: of.force_error_n.map(|known| known.unwrap_or(UNKNOWN_N)),
            torque_error_n_m: of.torque_error_n_m.map(|known| known.unwrap_or(UNKNOWN_N)),
        }
    }
}

/// A node of a state: 16 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct Node {
    /// Id of the node in the input mesh.
    pub node: u32,
    /// Its position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
}

/// A state: 48 bytes, whose nodes lie in shared memory until it is released.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct State {
    /// Number of the last answered tick, 0 before the first.
    pub tick: u64,
    /// Ticks answered since the server began.
    pub ticks_answered: u64,
    /// Hash of the state.
    pub state_hash: u64,
    /// Every node of the model, by ascending id; null where there are none.
    pub nodes: *const Node,
    /// Number of nodes.
    pub count: usize,
    /// Flags of the last answer, a sum of CHAINCELL_FLAG_.
    pub flags: u32,
    /// Checksum of the model, as chaincell info prints it.
    pub model_checksum: u32,
}

impl State {
    /// No state.
    pub(crate) const NONE: Self = Self {
        tick: 0,
        ticks_answered: 0,
        state_hash: 0,
        nodes: std::ptr::null(),
        count: 0,
        flags: 0,
        model_checksum: 0,
    };

    pub(crate) fn of(header: StateHeader, rows: &[NodePosition]) -> Self {
        let StateHeader { tick, ticks_answered, state_hash, flags, model_checksum, .. } = header;
        let nodes = if rows.is_empty() { std::ptr::null() } else { rows.as_ptr().cast() };
        Self { tick, ticks_answered, state_hash, nodes, count: rows.len(), flags, model_checksum }
    }
}

/// A triangle in contact with a part of a tool: 52 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub struct Contact {
    /// Which tool.
    pub tool: u32,
    /// Which of its parts.
    pub part: u32,
    /// Input id of the triangle's corner that takes the largest share.
    pub node: u32,
    /// Where it acts, in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Pressure on the tool \[N\].
    pub normal_n: [f32; 3],
    /// Friction, or the pull of a grip, on the tool \[N\].
    pub tangential_n: [f32; 3],
    /// Area of the triangle at rest, as far as its points are in contact \[m2\].
    pub area_m2: f32,
}

/// Contacts: 40 bytes; they lie in shared memory until they are released.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct Contacts {
    /// Number of the last answered tick, 0 before the first.
    pub tick: u64,
    /// Ticks answered since the server began.
    pub ticks_answered: u64,
    /// The contacts; null where nothing is in contact.
    pub contacts: *const Contact,
    /// Number of contacts.
    pub count: usize,
    /// Flags of the last answer, a sum of CHAINCELL_FLAG_.
    pub flags: u32,
    /// Zero.
    pub reserved: u32,
}

impl Contacts {
    /// None.
    pub(crate) const NONE: Self = Self {
        tick: 0,
        ticks_answered: 0,
        contacts: std::ptr::null(),
        count: 0,
        flags: 0,
        reserved: 0,
    };

    pub(crate) fn of(header: contacts::ContactsHeader, rows: &[contacts::Contact]) -> Self {
        let contacts::ContactsHeader { tick, ticks_answered, flags, .. } = header;
        let contacts = if rows.is_empty() { std::ptr::null() } else { rows.as_ptr().cast() };
        Self { tick, ticks_answered, contacts, count: rows.len(), flags, reserved: 0 }
    }
}

/// The reply to a command: 32 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Reply {
    /// Number of the last tick answered before the command, 0 before the first.
    pub tick: u64,
    /// Ticks answered before the command since the server began.
    pub ticks_answered: u64,
    /// Hash of the state after the command.
    pub state_hash: u64,
    /// 0 done, 1 refused: nothing has changed.
    pub result: u32,
    /// Why it was refused, the number of the contract; when done, of a pin its number, else 0.
    pub reason: u32,
}

impl From<ReplyMessage> for Reply {
    fn from(of: ReplyMessage) -> Self {
        let ReplyMessage { tick, ticks_answered, state_hash, result, reason } = of;
        Self { tick, ticks_answered, state_hash, result, reason }
    }
}

const _: () = {
    assert!(TOOLS_MAX == chaincell_client::tools::TOOLS_MAX);
    assert!(size_of::<Options>() == 24);
    // A pose and what a tool feels are those of chaincell.h.
    assert!(size_of::<ToolPose>() == 32 && align_of::<ToolPose>() == 4);
    assert!(offset_of!(ToolPose, position_m) == 0);
    assert!(offset_of!(ToolPose, orientation) == 12);
    assert!(offset_of!(ToolPose, engaged) == 28);
    assert!(offset_of!(ToolPose, opening_turns_q16) == 30);
    assert!(size_of::<ToolOutput>() == 32 && align_of::<ToolOutput>() == 4);
    assert!(offset_of!(ToolOutput, force_n) == 0);
    assert!(offset_of!(ToolOutput, torque_n_m) == 12);
    assert!(offset_of!(ToolOutput, contacts) == 24);
    assert!(offset_of!(ToolOutput, flags) == 28);
    assert!(size_of::<Shown>() == 400);
    assert!(offset_of!(Shown, energy_j) == 56);
    assert!(offset_of!(Shown, tools) == 80);
    assert!(size_of::<Reply>() == 32);
    assert!(size_of::<State>() == 48 || size_of::<usize>() < 8);
    assert!(size_of::<Contacts>() == 40 || size_of::<usize>() < 8);
    // A node and a contact of C are those of the messages.
    assert!(size_of::<Node>() == size_of::<NodePosition>());
    assert!(align_of::<Node>() == align_of::<NodePosition>());
    assert!(offset_of!(Node, position_m) == offset_of!(NodePosition, position_m));
    assert!(size_of::<Contact>() == size_of::<contacts::Contact>());
    assert!(align_of::<Contact>() == align_of::<contacts::Contact>());
    assert!(offset_of!(Contact, position_m) == offset_of!(contacts::Contact, position_m));
    assert!(offset_of!(Contact, normal_n) == offset_of!(contacts::Contact, normal_n));
    assert!(offset_of!(Contact, tangential_n) == offset_of!(contacts::Contact, tangential_n));
    assert!(offset_of!(Contact, area_m2) == offset_of!(contacts::Contact, area_m2));
};
