//! Errors: a kind for programs, a sentence with the place and the remedy for people.

use std::fmt;
use std::path::Path;

/// The kind of a refusal, for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A scene name or an option is invalid.
    Argument,
    /// No server on the scene.
    NoServer,
    /// The scene's messages are of another version or program.
    Version,
    /// Another program has the only place.
    Taken,
    /// The largest number of programs has joined already.
    Full,
    /// The files of shared memory belong to another user, or others may write them.
    Permission,
    /// Shared memory is full.
    Memory,
    /// A service exists with other limits, or cannot be used.
    Service,
    /// Shared memory failed during the session.
    Connection,
    /// A pose is invalid.
    Pose,
    /// No reply to a command came in time.
    NoReply,
    /// The server refused a command.
    Refused,
    /// The caller asked to stop.
    Stopped,
    /// The handle belongs to a viewer, which sends no poses.
    Viewer,
}

/// A refusal.
///
/// ```
/// use chaincell_client::{Error, Kind};
///
/// let error = Error::new(Kind::NoServer, "no server on scene \"left\": start `chaincell serve`");
/// let may_come_later = matches!(error.kind(), Kind::NoServer | Kind::Taken | Kind::Full);
/// assert!(may_come_later && error.to_string().starts_with("no server"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text}")]
pub struct Error {
    kind: Kind,
    text: String,
}

/// Result of an operation of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Creates an error of this kind; the text names the place and the remedy.
    pub fn new(kind: Kind, text: impl fmt::Display) -> Self {
        Self { kind, text: text.to_string() }
    }

    /// Creates the error of a failed file operation, with the operation, the path and the cause.
    pub(crate) fn file(doing: &str, path: &Path, why: impl fmt::Display) -> Self {
        Self::new(Kind::Permission, format!("cannot {doing} {}: {why}", path.display()))
    }

    /// Returns its kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }
}
