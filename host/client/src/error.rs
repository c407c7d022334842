//! Why something was refused: a kind for programs, a sentence with the place and the remedy for people.

use std::fmt;
use std::path::Path;

/// The kind of a refusal, for programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A scene name, or an option, that cannot be.
    Argument,
    /// No server on the scene.
    NoServer,
    /// The scene speaks messages of another version or make.
    Version,
    /// Another program has the only place there is.
    Taken,
    /// As many programs as can be have joined already.
    Full,
    /// The files of shared memory are somebody else's, or may be written by others.
    Permission,
    /// Shared memory is full.
    Memory,
    /// A service is there with other limits, or cannot be used.
    Service,
    /// Shared memory failed under way.
    Connection,
    /// A pose that is no pose.
    Pose,
    /// No reply to a command in its time.
    NoReply,
    /// The server refused a command.
    Refused,
    /// Somebody asked to stop.
    Stopped,
    /// The handle is that of a viewer, which sends no poses.
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
    /// A refusal of this kind; the text names the place and the remedy.
    pub fn new(kind: Kind, text: impl fmt::Display) -> Self {
        Self { kind, text: text.to_string() }
    }

    /// A file operation that failed: what was tried, on which path, and why it failed.
    pub(crate) fn file(doing: &str, path: &Path, why: impl fmt::Display) -> Self {
        Self::new(Kind::Permission, format!("cannot {doing} {}: {why}", path.display()))
    }

    /// Returns its kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }
}
