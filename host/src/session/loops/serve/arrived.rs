//! A pose on its way to the tissue.

use chaincell_kernel::TOOLS_MAX;

use crate::engine::motion::Pose;
use crate::engine::tools::Poses;
use crate::session::ipc::tools::Asked;

/// A pose that was accepted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Arrived {
    /// Number of its tick.
    pub tick: u64,
    /// The poses as they are executed: of the tools that were chosen by their parts, else of one.
    pub poses: Poses,
    /// What its answer repeats.
    pub asked: Asked,
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

impl Arrived {
    /// The first tool's row of a path.
    #[must_use]
    pub fn first(&self) -> Pose {
        self.poses.each().first().map_or_else(Pose::default, |pose| Pose::of(self.tick, pose))
    }
}
