//! The ports of `serve`: it receives poses and sends answers.

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher;

use iceoryx2::identifiers::UniquePublisherId;
use iceoryx2::port::ReceiveError;
use iceoryx2::port::SendError;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;

use super::services::{Ipc, Ring, SHOW_PORT, SceneServices, Wake, subscriber};
use super::tools::{Answer, Asked, Asking as _, ToolForces, ToolPoses};
use crate::engine::tools::Poses;
use crate::error;

/// Name of the ports of `serve`, which identifies a second one.
pub(super) const SERVE_PORT: &str = "chaincell.serve";

/// Ports for poses and answers.
#[derive(Debug)]
pub struct ServePorts {
    poses: Subscriber<Ipc, ToolPoses, ()>,
    pub(crate) answers: AnswerPublisher,
    /// Wakes the readers of answers.
    ring: Ring,
    /// Wakes the server when a pose was sent.
    wake: Wake,
}

/// A received message of poses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ReceivedPoses {
    pub tick: u64,
    /// See [`Asking::poses`](super::tools::Asking::poses).
    pub poses: Poses,
    /// Fields that its answer repeats.
    pub asked: Asked,
    pub publisher: UniquePublisherId,
}

impl ServePorts {
    /// Opens the ports of a scene; refuses while another `serve` is alive on it.
    ///
    /// # Errors
    /// Another server; no free port, or too little memory.
    pub fn open(scene: &SceneServices, woken: bool) -> error::Result<Self> {
        scene.refuse_second(&scene.forces, SERVE_PORT, None, "serve")?;
        scene.refuse_second(&scene.tools, SHOW_PORT, None, "follow")?;
        scene.check_room_to_serve()?;
        // Before the publisher, by which a controller sees a server: viewers may read poses too.
        let poses = subscriber(&scene.tools, SERVE_PORT)?;
        let publisher = scene.publisher(&scene.forces, SERVE_PORT, "serve")?;
        let id = publisher.id();
        let (ring, wake) = scene.server_bells(woken)?;
        let ports = Self { poses, answers: AnswerPublisher::new(publisher), ring, wake };
        // Check again: two that started at the same time see each other now.
        scene.refuse_second(&scene.forces, SERVE_PORT, Some(id), "serve")?;
        scene.refuse_second(&scene.tools, SHOW_PORT, None, "follow")?;
        scene.take_memory()?;
        Ok(ports)
    }

    /// Returns the next message of poses, for `chosen` tools.
    pub(crate) fn receive(&self, chosen: usize) -> Result<Option<ReceivedPoses>, ReceiveError> {
        let sample = self.poses.receive()?;
        Ok(sample.map(|sample| ReceivedPoses {
            tick: sample.tick,
            poses: sample.poses(chosen),
            asked: sample.asked(chosen),
            publisher: sample.header().publisher_id(),
        }))
    }

    /// Connects readers that have joined. A failure shows again with the next answer.
    pub(crate) fn connect(&self) {
        let _ = self.answers.publisher.update_connections();
    }

    /// Wakes the readers that sleep.
    pub(crate) fn ring(&self) {
        self.ring.ring();
    }

    /// Returns the waker that signals a sent pose.
    pub(crate) fn wake(&self) -> &Wake {
        &self.wake
    }
}

/// Publishes the answers of one session.
#[derive(Debug)]
pub(crate) struct AnswerPublisher {
    publisher: Publisher<Ipc, ToolForces, ()>,
    session_id: u64,
}

impl AnswerPublisher {
    /// Creates the publisher of a new session.
    fn new(publisher: Publisher<Ipc, ToolForces, ()>) -> Self {
        // The system's random keys make this number unique.
        let session_id = RandomState::new().hash_one(std::process::id()).max(1);
        Self { publisher, session_id }
    }

    /// Sends an answer.
    pub(crate) fn send(&self, answer: &Answer) -> Result<(), SendError> {
        self.publisher.send_copy(answer.message(self.session_id)).map(|_| ())
    }
}
