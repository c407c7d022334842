//! Reads the poses and answers of a scene besides its server and its controller.

use std::collections::VecDeque;
use std::fmt::Debug;

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use crate::error::{Error, Result};
use crate::session::ipc::services::{Ipc, SceneServices, Topic, port_error};
use crate::session::ipc::tools::{ToolForces, ToolPoses};

/// Messages that may be unread, and that are kept: several of the periods at which a viewer looks.
pub const KEPT_MESSAGES: usize = 64;

/// The newest poses and answers of a scene.
#[derive(Debug)]
pub struct WatchPorts {
    poses: Port<ToolPoses>,
    answers: Port<ToolForces>,
}

impl WatchPorts {
    /// Joins a scene, once and for all.
    ///
    /// # Errors
    /// All places of readers are taken.
    pub fn open(scene: &SceneServices) -> Result<Self> {
        Ok(Self { poses: Port::open(&scene.tools)?, answers: Port::open(&scene.forces)? })
    }

    /// Takes the messages that have come since.
    ///
    /// # Errors
    /// Shared memory that failed.
    pub fn take(&mut self) -> Result<()> {
        // A pose is sent before its answer: in this order each answer that was taken has its pose.
        self.answers.take()?;
        self.poses.take()
    }

    /// The poses of the last ticks, oldest first.
    #[must_use]
    pub fn poses(&self) -> &VecDeque<ToolPoses> {
        &self.poses.kept
    }

    /// The answers to the last ticks, oldest first.
    #[must_use]
    pub fn answers(&self) -> &VecDeque<ToolForces> {
        &self.answers.kept
    }
}

/// One topic, and its last messages.
#[derive(Debug)]
struct Port<T: ZeroCopySend + Debug + Copy + 'static> {
    subscriber: Subscriber<Ipc, T, ()>,
    kept: VecDeque<T>,
}

impl<T: ZeroCopySend + Debug + Copy> Port<T> {
    fn open(topic: &Topic<T>) -> Result<Self> {
        let subscriber = topic.subscriber_builder().buffer_size(KEPT_MESSAGES).create();
        let subscriber = subscriber.map_err(|why| port_error(topic.name(), why))?;
        Ok(Self { subscriber, kept: VecDeque::with_capacity(KEPT_MESSAGES) })
    }

    fn take(&mut self) -> Result<()> {
        let failed = |why| Error::check(format!("cannot read the scene's messages: {why:?}"));
        while let Some(message) = self.subscriber.receive().map_err(failed)? {
            if self.kept.len() == KEPT_MESSAGES {
                self.kept.pop_front();
            }
            self.kept.push_back(*message);
        }
        Ok(())
    }
}
