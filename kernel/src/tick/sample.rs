//! Inputs and outputs of a tick.

use super::tables::flags;
use crate::contact::pose::ToolPose;
use crate::energy::surface::ToolState;
use crate::number::kept::kept;
use nalgebra::Vector3;

kept! {
    /// The part of good poses that the tick keeps: the first tool's position, and whether a tool is engaged.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(crate) struct ToolSample {
        /// Position in the frame of the input mesh \[m\].
        pub position_m: Vector3<f32>,
        /// 1 while a tool holds or loads the body, else 0.
        pub engaged: u32,
    }
}

impl ToolSample {
    /// Joins the poses of these tools into a sample: the first pose's position, engaged if any pose is or a tool
    /// beyond the poses is. `None` if a pose is bad, or there is none.
    pub fn joined(poses: &[ToolPose], tools: &[ToolState]) -> Option<Self> {
        let first = poses.first()?;
        if !poses.iter().all(ToolPose::is_good) {
            return None;
        }
        let stays = tools.iter().skip(poses.len()).any(|tool| tool.is_in);
        let moved = poses.get(..tools.len().max(1)).unwrap_or(poses);
        let engaged = u32::from(stays || moved.iter().any(|pose| pose.engaged == 1));
        Some(Self { position_m: first.position_m, engaged })
    }
}

/// The output of one tick. It describes the state after the last update; of tools, force, stiffness and contacts
/// are taken at the points of the next pass ([`contact_position`](crate::TissueMut::contact_position)).
///
/// ```
/// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
/// use chaincell_kernel::{Flags, TickOutput};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
/// # tissue.choose_contacts(&network, &[47])?;
/// # tissue.tick(&network, &[ToolPose::at([0.0; 3].into(), 1)], Budget::All);
/// # let pose = ToolPose::at([0.0, 0.0, -0.002].into(), 1);
/// let TickOutput { force_n, energy_j, work_j, .. } = tissue.tick(&network, &[pose], Budget::All);
/// assert!(force_n.z > 0.0); // [N], on the tool that moved 2 mm downwards
/// assert!(energy_j > 0.0 && work_j >= energy_j); // [J], the tool has paid for all of it
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TickOutput {
    /// Force of the tissue on the tool, exerted by the links on the contact cells \[N\].
    pub force_n: Vector3<f32>,
    /// Certified upper bound of the elastic energy E of the published state \[J\]. It never rises while
    /// nothing external acts. A current's work is external ([`Drive::Current`](crate::Drive)): under it the
    /// level of E less that work never rises, and this value is that level plus the work, rounded up.
    pub energy_j: f32,
    /// Work of the tool's motion in this tick on the tissue: the exact change of E over the links of the
    /// moved cells, rounded once \[J\]. Its sum is the tissue's side of an energy ledger. 0 if nothing moved,
    /// and under a current.
    pub work_j: f32,
    /// Upper bound of the stiffness at the tool within a tick: the stiffness of the links of its contact
    /// cells if all other cells stood still. 0 without contact cells \[N/m\].
    pub stiffness_n_per_m: f32,
    /// Number of cells that the tool acts on.
    pub contacts: u32,
    /// Sweeps made: 0 if the sample was late, and in the safe state.
    pub sweeps: u16,
    /// Limits and events of this tick.
    pub flags: Flags,
}

impl TickOutput {
    /// No force, no contact, no flag.
    pub const NONE: Self = Self {
        force_n: Vector3::new(0.0, 0.0, 0.0),
        energy_j: 0.0,
        work_j: 0.0,
        stiffness_n_per_m: 0.0,
        contacts: 0,
        sweeps: 0,
        flags: Flags(0),
    };
}

flags! {
    /// Limits and faults that acted during a tick; files and messages hold their sum.
    ///
    /// ```
    /// use chaincell_kernel::Flags;
    ///
    /// let flags = Flags(1 + 64); // as a message has them
    /// assert!(flags.contains(Flags::MOTION_CLAMPED) && flags.contains(Flags::ROLLED_BACK));
    /// assert!(!flags.contains(Flags::SAFE_STATE));
    /// ```
    Flags {
        /// The step limit or the energy limit shortened the tool's motion or the change of its current.
        MOTION_CLAMPED = 1;
        /// A bad sample, no number or farther than a hand moves: the last good one is used, or the safe
        /// state is on.
        BAD_SAMPLE = 2;
        /// No sample within the watchdog's time (set by the output stage or the calling process).
        STALE = 4;
        /// Force or torque was clamped to its limit.
        FORCE_CLAMPED = 8;
        /// Safe state: the force is zero.
        SAFE_STATE = 16;
        /// The links' bands are closed (unloading).
        BAND_CLOSED = 32;
        /// The energy guard discarded a pass.
        ROLLED_BACK = 64;
        /// More triangles are in reach of the tools, or more samples in contact, than the tissue has memory
        /// for: the farthest ones are left out.
        CONTACT_CAPACITY = 128;
        /// The sample was late, as newer ones waited or the tissue cannot keep up: it was executed without a
        /// sweep, and the force is that of an earlier tick.
        LATE = 256;
        /// The tool counts as not engaged until it has been released once (set by the calling process).
        RELEASE_FIRST = 512;
        /// The output stage lowers the force along its ramp or holds it back: passivity control cannot
        /// compensate the energy that sampling and delay generate, or the hand has put in too little energy.
        FORCE_WITHHELD = 1024;
        /// A tool engaged inside the tissue, or the tissue closed over it while it grew: it has no contact and
        /// no force until it has been outside once.
        STARTS_INSIDE = 2048;
    }
}
