//! An accepted pose on its way to the tissue.

use chaincell_kernel::TOOLS_MAX;

use crate::engine::tools::Poses;
use crate::session::ipc::payload::ToolPose;
use crate::session::ipc::tools::Asked;

/// A pose that was accepted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Arrived {
    /// The pose as it is executed.
    pub pose: ToolPose,
    /// Poses of the tools given by --tool.
    pub tools: Poses,
    /// Request in its message, `None` for version 1.
    pub asked: Option<Asked>,
    /// Arrival time \[ns\].
    pub at_ns: u64,
    /// True after a silence, a gap or a pause, or if the device did not feel the last force: the output
    /// stage's ramp starts anew.
    pub restarts_ramp: bool,
    /// Number of ticks before it that never arrived.
    pub skipped: u16,
    /// Tools without a force, since they have not been released yet.
    pub release_first: [bool; TOOLS_MAX],
}
