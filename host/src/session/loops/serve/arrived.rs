//! A pose on its way to the tissue.

use chaincell_kernel::TOOLS_MAX;

use crate::engine::tools::Poses;
use crate::session::ipc::payload::ToolPose;
use crate::session::ipc::tools::Asked;

/// A pose that was accepted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Arrived {
    /// The pose, as it is executed.
    pub pose: ToolPose,
    /// Poses of the tools that were chosen by their parts.
    pub tools: Poses,
    /// What its message asks for, `None` for one of version 1.
    pub asked: Option<Asked>,
    /// When it came \[ns\].
    pub at_ns: u64,
    /// There was a silence, a gap or a pause before it, or the device did not feel the last force: the
    /// output stage's ramp begins anew.
    pub restarts_ramp: bool,
    /// Ticks in front of it that never came.
    pub skipped: u16,
    /// Which tools have no force, since they were not seen released yet.
    pub release_first: [bool; TOOLS_MAX],
}
