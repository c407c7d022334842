//! Sends a controller's poses and receives its answers.

use chaincell_kernel::ToolPose;
use iceoryx2::port::update_connections::UpdateConnections;

use crate::engine::motion::Pose;
use crate::engine::tools::Poses;
use crate::session::ipc::services::{Ports, Ring, SceneServices, Wake};
use crate::session::ipc::tools::{OneToolPose, TOOLS_MAX, TickForce, ToolForces, ToolPoses};
use crate::session::loops::ramp::Shown;
use crate::session::timing::clock::now_ns;

/// The ports of a controller.
#[derive(Debug)]
pub(crate) struct Link(Ports<ToolForces, ToolPoses>);

/// An answer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heard {
    /// The force is that of tool 0; the contacts are those of all tools.
    pub(crate) force: TickForce,
    /// The forces and torques that a device shows.
    pub(crate) shown: Shown,
}

impl Link {
    /// Opens the controller's side of a scene.
    ///
    /// # Errors
    /// Another controller; no free port, or too little memory.
    pub(crate) fn open(scene: &SceneServices, woken: bool) -> chaincell_client::Result<Self> {
        Ok(Self(scene.control_ports(woken)?))
    }

    /// Sends the pose of a tick, or those of all tools if there are several.
    ///
    /// # Errors
    /// The error of shared memory.
    pub(crate) fn send(&self, pose: Pose, tools: &[ToolPose]) -> Result<(), String> {
        let sent = self.0.publisher.send_copy(message(pose, tools));
        sent.map(|_| ()).map_err(|why| format!("{why:?}"))
    }

    /// Returns an answer that has arrived. A failed connection shows as a missing answer.
    pub(crate) fn receive(&self) -> Option<Heard> {
        Some(heard(&*self.0.subscriber.receive().ok()??))
    }

    /// Connects to the server's ports.
    ///
    /// # Errors
    /// The error of shared memory.
    pub(crate) fn connect(&self) -> Result<(), String> {
        self.0.publisher.update_connections().map_err(|why| format!("{why:?}"))
    }

    /// Returns the bell that wakes the server.
    pub(crate) fn ring(&self) -> &Ring {
        &self.0.ring
    }

    /// Returns the waker that signals a sent answer.
    pub(crate) fn wake(&self) -> &Wake {
        &self.0.wake
    }
}

/// Returns the message of a tick. It has the maximal number of tools; those beyond the path's stay at the
/// origin and are not engaged.
fn message(pose: Pose, tools: &[ToolPose]) -> ToolPoses {
    let first = [pose.into()];
    let given = if tools.is_empty() { &first } else { tools };
    let mut poses = ToolPoses {
        tick: pose.tick,
        send_ns: now_ns(),
        tools: TOOLS_MAX as u32,
        ..ToolPoses::default()
    };
    let all = Poses::of_tools(TOOLS_MAX, given);
    for (number, (place, of)) in (0..).zip(poses.each.iter_mut().zip(all.each())) {
        *place = OneToolPose {
            number,
            engaged: of.engaged,
            position_m: of.position_m.into(),
            orientation: of.orientation,
            reserved: 0,
        };
    }
    // A deliberate fault.
    if pose.position_m.iter().any(|x| x.is_nan()) {
        poses.each[0].position_m = pose.position_m;
    }
    poses
}

fn heard(forces: &ToolForces) -> Heard {
    let mut force = TickForce {
        tick: forces.tick,
        energy_j: forces.energy_j,
        flags: forces.flags,
        step_ns: forces.step_ns,
        state_hash: forces.state_hash,
        ..TickForce::default()
    };
    let mut shown = Shown::ZERO;
    for of in forces.each.iter().take(forces.tools as usize) {
        let place = of.number as usize;
        if let (Some(force_n), Some(torque_n_m)) =
            (shown.force_n.get_mut(place), shown.torque_n_m.get_mut(place))
        {
            (*force_n, *torque_n_m) = (of.force_n, of.torque_n_m);
            force.contacts = force.contacts.saturating_add(of.contacts);
        }
    }
    force.force_n = shown.force_n[0];
    Heard { force, shown }
}
