//! An accepted pose on its way to the tissue.

use chaincell_kernel::TOOLS_MAX;

use crate::engine::motion::Pose;
use crate::engine::tools::Poses;
use crate::session::ipc::tools::Asked;

/// A pose that was accepted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Arrived {
    /// Number of its tick.
    pub tick: u64,
    /// The poses as they are executed: of the tools given by --tool, else of one.
    pub poses: Poses,
    /// Fields of its message that the answer repeats.
    pub asked: Asked,
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

impl Arrived {
    /// The first tool's row of a path.
    #[must_use]
    pub fn first(&self) -> Pose {
        self.poses.each().first().map_or_else(Pose::default, |pose| Pose::of(self.tick, pose))
    }
}
