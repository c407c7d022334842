//! Poses and answers of all tools in one message, little-endian, byte for byte as other programs declare
//! them.

use chaincell_kernel::ToolPose;
use iceoryx2::prelude::ZeroCopySend;

/// Type name of [`ToolPoses`] in shared memory.
pub const TOOL_POSES: &str = "chaincell.ToolPoses.v2";
/// Type name of [`ToolForces`] in shared memory.
pub const TOOL_FORCES: &str = "chaincell.ToolForces.v2";

/// Most tools of a message.
pub const TOOLS_MAX: usize = 8;

/// Largest difference of an orientation's length from 1.
const UNIT_TOLERANCE: f64 = 1e-3;

/// The error of a force of which none is known \[N\].
pub const UNKNOWN_N: f32 = -1.0;

/// Length of a quaternion.
#[must_use]
pub fn length_of(quaternion: [f32; 4]) -> f64 {
    quaternion.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt()
}

/// Returns true if a quaternion is a pure rotation: its length is 1 within a thousandth.
#[must_use]
pub fn is_unit(quaternion: [f32; 4]) -> bool {
    (length_of(quaternion) - 1.0).abs() <= UNIT_TOLERANCE
}

/// One tool of a [`ToolPoses`]: 40 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.OneToolPose.v2")]
#[repr(C)]
pub struct OneToolPose {
    /// Number of the tool.
    pub number: u32,
    /// 1 while it holds the contact cells, else 0.
    pub engaged: u16,
    /// Opening of scissors in 2^-16 of a full turn, 0 to 32768; other tools ignore it.
    pub opening_turns_q16: u16,
    /// Its position in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Its orientation, a unit quaternion: x, y, z, w.
    pub orientation: [f32; 4],
    /// Zero.
    pub reserved: u32,
}

/// The poses of all tools in one tick, sent to the tissue: 344 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolPoses.v2")]
#[repr(C)]
pub struct ToolPoses {
    /// Number of the tick; a publisher counts upwards.
    pub tick: u64,
    /// Send time by the sender's monotonic clock, 0 if unknown \[ns\].
    pub send_ns: u64,
    /// Number of entries of `each` in use: 1 to 8.
    pub tools: u32,
    /// Zero.
    pub reserved: u32,
    /// The tools; zero after those in use.
    pub each: [OneToolPose; TOOLS_MAX],
}

impl ToolPoses {
    /// The message of a tick, with every tool in the place of its number: those of `poses`, number 0 first,
    /// and the others [`ToolPose::AWAY`].
    #[must_use]
    pub fn of(tick: u64, send_ns: u64, poses: &[ToolPose]) -> Self {
        let mut message = Self { tick, send_ns, tools: TOOLS_MAX as u32, ..Self::default() };
        for (number, place) in (0_u32..).zip(&mut message.each) {
            let pose = poses.get(number as usize).unwrap_or(&ToolPose::AWAY);
            *place = OneToolPose {
                number,
                engaged: pose.engaged,
                opening_turns_q16: pose.opening_turns_q16,
                position_m: pose.position_m.into(),
                orientation: pose.orientation,
                reserved: 0,
            };
        }
        message
    }
}

/// One tool of a [`ToolForces`]: 44 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.OneToolForce.v2")]
#[repr(C)]
pub struct OneToolForce {
    /// Number of the tool.
    pub number: u32,
    /// Number of cells it holds.
    pub contacts: u32,
    /// Force of the tissue on it \[N\].
    pub force_n: [f32; 3],
    /// Torque of the tissue on it about its position \[N m\].
    pub torque_n_m: [f32; 3],
    /// Limits and events of the tool, a sum: see [`chaincell_kernel::Flags`].
    pub flags: u32,
    /// Estimated error of the tissue's force, before its limit; [`UNKNOWN_N`] where it is not known, and where an
    /// output stage answers another force \[N\].
    pub force_error_n: f32,
    /// Estimated error of its torque likewise, also [`UNKNOWN_N`] for held cells \[N m\].
    pub torque_error_n_m: f32,
}

impl OneToolForce {
    /// Estimated error of the force, if it is known \[N\].
    #[must_use]
    pub fn error_n(&self) -> Option<f32> {
        (self.force_error_n >= 0.0).then_some(self.force_error_n)
    }

    /// Estimated error of the torque, if it is known \[N m\].
    #[must_use]
    pub fn torque_error_n_m(&self) -> Option<f32> {
        (self.torque_error_n_m >= 0.0).then_some(self.torque_error_n_m)
    }
}

/// The answer to a [`ToolPoses`]: 416 bytes.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolForces.v2")]
#[repr(C)]
pub struct ToolForces {
    /// Number of the tick that this answers.
    pub tick: u64,
    /// The server's session, new for each, never 0.
    pub session_id: u64,
    /// Number of the tick whose pose the force belongs to.
    pub force_tick: u64,
    /// Send time of the message answered, as given in it \[ns\].
    pub send_ns: u64,
    /// Hash of the state after the tick, 0 if none was computed.
    pub state_hash: u64,
    /// Certified upper bound of the elastic energy of the published state \[J\].
    pub energy_j: f32,
    /// Limits and events of the tick, a sum: see [`chaincell_kernel::Flags`].
    pub flags: u32,
    /// Duration of the tick, without waiting, hashing and sending \[ns\].
    pub step_ns: u32,
    /// Sweeps made in the tick, 0 in a late one.
    pub sweeps: u32,
    /// Number of entries of `each` in use.
    pub tools: u32,
    /// Zero.
    pub reserved: u32,
    /// The tools, in the order of the message answered; zero after those in use.
    pub each: [OneToolForce; TOOLS_MAX],
}

impl ToolForces {
    /// The tools in use, each with its number; without those whose number is no tool's.
    pub fn each_tool(&self) -> impl Iterator<Item = (usize, &OneToolForce)> {
        let in_use = self.each.iter().take(self.tools as usize);
        in_use.map(|tool| (tool.number as usize, tool)).filter(|(number, _)| *number < TOOLS_MAX)
    }
}

// The offsets follow from the order of the fields, which the tables of the reference are compared with.
const _: () = {
    assert!(size_of::<OneToolPose>() == 40);
    assert!(size_of::<ToolPoses>() == 344);
    assert!(size_of::<OneToolForce>() == 44);
    assert!(size_of::<ToolForces>() == 416);
};
