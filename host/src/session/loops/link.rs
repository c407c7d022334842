//! What a controller sends and hears, by either version of the messages.

use chaincell_kernel::ToolPose as OneTool;
use iceoryx2::port::update_connections::UpdateConnections;

use crate::session::ipc::payload::{ToolForce, ToolPose};
use crate::session::ipc::services::{Ports, Ring, SceneServices, Wake};
use crate::session::ipc::tools::{OneToolPose, ToolForces, ToolPoses};
use crate::session::loops::ramp::Shown;
use crate::session::timing::clock::now_ns;

/// The ports of a controller.
#[derive(Debug)]
pub(crate) enum Link {
    /// Of one tool, version 1.
    One(Ports<ToolForce, ToolPose>),
    /// Of several, version 2.
    Tools(Ports<ToolForces, ToolPoses>),
}

/// An answer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heard {
    /// As version 1 tells it: the force is that of tool 0; the contacts are those of all tools.
    pub(crate) force: ToolForce,
    /// All of it that a device shows.
    pub(crate) shown: Shown,
}

impl Link {
    /// Sends a pose; of several tools those of all.
    ///
    /// # Errors
    /// What shared memory says.
    pub(crate) fn send(&self, pose: ToolPose, tools: &[OneTool]) -> Result<(), String> {
        let sent = match self {
            Self::One(ports) => ports.publisher.send_copy(pose),
            Self::Tools(ports) => ports.publisher.send_copy(message(pose, tools)),
        };
        sent.map(|_| ()).map_err(|why| format!("{why:?}"))
    }

    /// An answer that has arrived. A connection that fails shows as a missing answer.
    pub(crate) fn receive(&self) -> Option<Heard> {
        match self {
            Self::One(ports) => {
                let force = *ports.subscriber.receive().ok()??;
                Some(Heard { force, shown: Shown::of(force.force_n) })
            }
            Self::Tools(ports) => Some(heard(&*ports.subscriber.receive().ok()??)),
        }
    }

    /// Whether a server reads these poses and writes answers to them.
    pub(crate) fn is_served(&self, scene: &SceneServices) -> bool {
        match self {
            Self::One(_) => scene.is_served(),
            Self::Tools(_) => scene.serves_tools(),
        }
    }

    /// Connects to the server's ports.
    ///
    /// # Errors
    /// What shared memory says.
    pub(crate) fn connect(&self) -> Result<(), String> {
        let connected = match self {
            Self::One(ports) => ports.publisher.update_connections(),
            Self::Tools(ports) => ports.publisher.update_connections(),
        };
        connected.map_err(|why| format!("{why:?}"))
    }

    /// Wakes the server.
    pub(crate) fn ring(&self) -> &Ring {
        match self {
            Self::One(ports) => &ports.ring,
            Self::Tools(ports) => &ports.ring,
        }
    }

    /// Woken when an answer was written.
    pub(crate) fn wake(&self) -> &Wake {
        match self {
            Self::One(ports) => &ports.wake,
            Self::Tools(ports) => &ports.wake,
        }
    }
}

/// The message of version 2.
fn message(pose: ToolPose, tools: &[OneTool]) -> ToolPoses {
    let mut poses = ToolPoses {
        tick: pose.tick,
        send_ns: now_ns(),
        tools: tools.len() as u32,
        ..ToolPoses::default()
    };
    for (number, (place, of)) in (0..).zip(poses.each.iter_mut().zip(tools)) {
        *place = OneToolPose {
            number,
            engaged: of.engaged,
            position_m: of.position_m.into(),
            orientation: of.orientation,
            reserved: 0,
        };
    }
    // A fault on purpose.
    if pose.position_m.iter().any(|x| x.is_nan()) {
        poses.each[0].position_m = pose.position_m;
    }
    poses
}

fn heard(forces: &ToolForces) -> Heard {
    let mut force = ToolForce {
        tick: forces.tick,
        energy_j: forces.energy_j,
        flags: forces.flags,
        step_ns: forces.step_ns,
        state_hash: forces.state_hash,
        ..ToolForce::default()
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
