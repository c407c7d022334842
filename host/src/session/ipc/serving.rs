//! The ports of `serve`: poses of both versions come in, each answer goes out as the version of its
//! pose.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;

use iceoryx2::identifiers::UniquePublisherId;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::SendError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;

use super::payload::{ToolForce, ToolPose};
use super::services::{Ipc, Ring, SceneServices, Wake, subscriber};
use super::tools::{Answer, Asked, Asking as _, ToolForces, ToolPoses};
use crate::engine::tools::Poses;
use crate::error;

/// Name of the ports of `serve`, by which a second one is recognised.
const SERVE_PORT: &str = "chaincell.serve";

/// Poses and answers of both versions.
#[derive(Debug)]
pub struct ServePorts {
    pose: Subscriber<Ipc, ToolPose, ()>,
    tools: Subscriber<Ipc, ToolPoses, ()>,
    pub(crate) mouth: Mouth,
    /// Wakes the readers of answers.
    ring: Ring,
    /// Woken when a pose was written.
    wake: Wake,
}

/// A pose that has come.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Came {
    pub pose: ToolPose,
    /// Of a message of version 2 the poses of the tools that were chosen by their parts.
    pub tools: Poses,
    /// What its message asks for, `None` for one of version 1.
    pub asked: Option<Asked>,
    pub publisher: UniquePublisherId,
}

impl ServePorts {
    /// The ports of a scene; refused while another `serve` is alive on it.
    ///
    /// # Errors
    /// Another server; no places, or too little memory.
    pub fn open(scene: &SceneServices, woken: bool) -> error::Result<Self> {
        scene.refuse_second(&scene.force, SERVE_PORT, None, "serve")?;
        scene.check_room_to_serve()?;
        let force = scene.publisher(&scene.force, SERVE_PORT, "serve")?;
        let id = force.id();
        let forces = scene.publisher(&scene.forces, SERVE_PORT, "serve")?;
        let (ring, wake) = scene.server_bells(woken)?;
        let ports = Self {
            pose: subscriber(&scene.pose, SERVE_PORT)?,
            tools: subscriber(&scene.tools, SERVE_PORT)?,
            mouth: Mouth::new(force, forces),
            ring,
            wake,
        };
        // Two that started at once see each other now.
        scene.refuse_second(&scene.force, SERVE_PORT, Some(id), "serve")?;
        scene.take_memory()?;
        Ok(ports)
    }

    /// The next pose of one version, or else of the other: asked in turn, neither holds up the other.
    /// So many tools were chosen by their parts.
    pub(crate) fn receive(
        &self,
        tools_first: bool,
        chosen: usize,
    ) -> Result<Option<Came>, ReceiveError> {
        let came = if tools_first { self.of_tools(chosen) } else { self.of_pose() }?;
        match came {
            Some(came) => Ok(Some(came)),
            None if tools_first => self.of_pose(),
            None => self.of_tools(chosen),
        }
    }

    fn of_pose(&self) -> Result<Option<Came>, ReceiveError> {
        let sample = self.pose.receive()?;
        Ok(sample.map(|sample| Came {
            pose: *sample,
            tools: Poses::NONE,
            asked: None,
            publisher: sample.header().publisher_id(),
        }))
    }

    fn of_tools(&self, chosen: usize) -> Result<Option<Came>, ReceiveError> {
        let sample = self.tools.receive()?;
        Ok(sample.map(|sample| Came {
            pose: sample.pose_of(chosen),
            tools: sample.poses(chosen),
            asked: Some(sample.asked_of(chosen.max(1))),
            publisher: sample.header().publisher_id(),
        }))
    }

    /// Connects readers that have joined. What fails is seen again with the next answer.
    pub(crate) fn connect(&self) {
        let _ = self.mouth.force.update_connections();
        let _ = self.mouth.forces.update_connections();
    }

    /// Wakes the readers that sleep.
    pub(crate) fn ring(&self) {
        self.ring.ring();
    }

    /// Woken when a pose was written.
    pub(crate) fn wake(&self) -> &Wake {
        &self.wake
    }
}

/// Where answers leave.
#[derive(Debug)]
pub(crate) struct Mouth {
    force: Publisher<Ipc, ToolForce, ()>,
    forces: Publisher<Ipc, ToolForces, ()>,
    session_id: u64,
}

impl Mouth {
    /// Of a new session.
    fn new(force: Publisher<Ipc, ToolForce, ()>, forces: Publisher<Ipc, ToolForces, ()>) -> Self {
        // Random keys of the system: no other session has this number.
        let session_id = RandomState::new().hash_one(std::process::id()).max(1);
        Self { force, forces, session_id }
    }

    /// Sends an answer as the version of its pose.
    pub(crate) fn send(&self, answer: &Answer) -> Result<(), SendError> {
        match answer.asked {
            None => self.force.send_copy(answer.force).map(|_| ()),
            Some(_) => self.forces.send_copy(answer.message(self.session_id)).map(|_| ()),
        }
    }
}
