//! How a program opens a scene.

use crate::clock::SECOND_NS;
use crate::services::Domain;
use crate::wait::Wait;

/// Longest watchdog and ramp \[ms\].
pub const MS_MAX: u32 = 60_000;
/// Purpose of a handle.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Role {
    /// Sends poses; a scene has one.
    #[default]
    Controller,
    /// Looks at states and contacts, and sends commands.
    Viewer,
}

/// How to open a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Name of the scene, `None` for the unnamed one.
    pub scene: Option<String>,
    /// Place of iceoryx2's files.
    pub domain: Domain,
    /// Purpose of the handle.
    pub role: Role,
    /// How to wait for answers.
    pub wait: Wait,
    /// Longest wait for a server, or for a viewer one that shows a session of another place \[ns\].
    pub server_wait_ns: u64,
    /// Time without an answer after which the force falls to 0; 0 for never; at most [`MS_MAX`] \[ms\].
    pub watchdog_ms: u32,
    /// Time in which it falls, and in which it rises when answers come again; 0 for at once \[ms\].
    pub ramp_ms: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scene: None,
            domain: Domain::default(),
            role: Role::Controller,
            wait: Wait::Hybrid,
            server_wait_ns: 10 * SECOND_NS,
            watchdog_ms: 20,
            ramp_ms: 20,
        }
    }
}
