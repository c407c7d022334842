//! The messages of a controller.

use chaincell_kernel::ToolPose;

use crate::engine::motion::Pose;
use crate::session::ipc::tools::{TickForce, ToolForces, ToolPoses};

/// The message of a tick: of several tools the poses of all, else that of the first.
pub(crate) fn message(pose: Pose, send_ns: u64, tools: &[ToolPose]) -> ToolPoses {
    let first = [pose.into()];
    let given = if tools.is_empty() { &first } else { tools };
    let mut poses = ToolPoses::of(pose.tick, send_ns, given);
    // A deliberate fault.
    if pose.position_m.iter().any(|x| x.is_nan()) {
        poses.each[0].position_m = pose.position_m;
    }
    poses
}

/// Reads an answer: the force is that of tool 0, the contacts are those of all tools.
pub(crate) fn tick_force(forces: &ToolForces) -> TickForce {
    let mut force = TickForce {
        tick: forces.tick,
        energy_j: forces.energy_j,
        flags: forces.flags,
        step_ns: forces.step_ns,
        state_hash: forces.state_hash,
        ..TickForce::default()
    };
    for (number, of) in forces.each_tool() {
        if number == 0 {
            force.force_n = of.force_n;
            force.force_error_n = of.error_n();
        }
        force.contacts = force.contacts.saturating_add(of.contacts);
    }
    force
}
