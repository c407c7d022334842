//! What travels over shared memory, little-endian, byte for byte as other programs declare it.

use std::mem::{offset_of, size_of};

use chaincell_kernel::sample::ToolSample;
use iceoryx2::prelude::ZeroCopySend;
use nalgebra::Vector3;

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
    /// What bit during the tick, summed: see [`chaincell_kernel::sample::Flags`].
    pub flags: u32,
    /// Time the tick took, without waiting, hashing and sending \[ns\].
    pub step_ns: u32,
    /// Zero.
    pub reserved: u32,
    /// Hash of the state after the tick, 0 where none was taken.
    pub state_hash: u64,
}

impl From<ToolPose> for ToolSample {
    fn from(pose: ToolPose) -> Self {
        Self { position_m: Vector3::from(pose.position_m), engaged: pose.engaged }
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
};
