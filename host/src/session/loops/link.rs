//! The messages of a controller.

use chaincell_kernel::ToolPose;

use crate::engine::motion::Pose;
use crate::session::ipc::tools::{TickForce, ToolForces, ToolPoses};
use crate::session::loops::ramp::Shown;
use crate::session::timing::clock::now_ns;

/// An answer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heard {
    /// The force is that of tool 0; the contacts are those of all tools.
    pub(crate) force: TickForce,
    /// The forces and torques that a device shows.
    pub(crate) shown: Shown,
}

/// The message of a tick: of several tools the poses of all, else that of the first.
pub(crate) fn message(pose: Pose, tools: &[ToolPose]) -> ToolPoses {
    let first = [pose.into()];
    let given = if tools.is_empty() { &first } else { tools };
    let mut poses = ToolPoses::of(pose.tick, now_ns(), given);
    // A deliberate fault.
    if pose.position_m.iter().any(|x| x.is_nan()) {
        poses.each[0].position_m = pose.position_m;
    }
    poses
}

/// Reads an answer.
pub(crate) fn heard(forces: &ToolForces) -> Heard {
    let mut force = TickForce {
        tick: forces.tick,
        energy_j: forces.energy_j,
        flags: forces.flags,
        step_ns: forces.step_ns,
        state_hash: forces.state_hash,
        ..TickForce::default()
    };
    let mut shown = Shown::ZERO;
    for (at, of) in forces.each_tool() {
        (shown.force_n[at], shown.torque_n_m[at]) = (of.force_n, of.torque_n_m);
        force.contacts = force.contacts.saturating_add(of.contacts);
    }
    force.force_n = shown.force_n[0];
    Heard { force, shown }
}
