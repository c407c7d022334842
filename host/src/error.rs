//! One error type for every command: a sentence for the user and the exit code it stands for.

use std::fmt;
use std::path::{Path, PathBuf};

use chaincell_client::Kind;

/// Why a command ended, with the exit code of the contract.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The run failed its own check: exit code 1.
    #[error("{0}")]
    Check(String),
    /// Bad usage or bad input, with the place and the remedy: exit code 2.
    #[error("{0}")]
    Input(String),
    /// Interrupted: exit code 130.
    #[error("interrupted")]
    Interrupted,
    /// Interrupted, with the results so far in this folder: exit code 130.
    #[error("interrupted; the results so far are in {}", .0.display())]
    InterruptedWith(PathBuf),
    /// Interrupted before there were results for this folder: exit code 130.
    #[error("interrupted before there were results; {} holds none", .0.display())]
    InterruptedBefore(PathBuf),
    /// As another error with this exit code, whose cause stands in the report that the parent
    /// process reads and tells: nothing is printed.
    #[error("the report says why")]
    Reported(u8),
}

impl From<chaincell_client::Error> for Error {
    fn from(why: chaincell_client::Error) -> Self {
        match why.kind() {
            Kind::Stopped => Self::Interrupted,
            Kind::Connection | Kind::NoReply => Self::check(why),
            _ => Self::input(why),
        }
    }
}

/// Result of a host operation.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Bad usage or input; the text names the place and the remedy.
    pub fn input(text: impl fmt::Display) -> Self {
        Self::Input(text.to_string())
    }

    /// A run that failed its own check.
    pub fn check(text: impl fmt::Display) -> Self {
        Self::Check(text.to_string())
    }

    /// An interrupted run that has written its results so far to a folder, if it has one.
    #[must_use]
    pub fn interrupted(out: Option<&Path>) -> Self {
        out.map_or(Self::Interrupted, |out| Self::InterruptedWith(out.to_owned()))
    }

    /// Names the folder that has no results yet, where this is an interruption and there is a folder.
    #[must_use]
    pub fn before_results(self, out: Option<&Path>) -> Self {
        match (self, out) {
            (Self::Interrupted, Some(out)) => Self::InterruptedBefore(out.to_owned()),
            (other, _) => other,
        }
    }

    /// A file operation that failed: what was tried, on which path, and why it failed.
    pub fn file(doing: &str, path: &Path, why: impl fmt::Display) -> Self {
        Self::Input(format!("cannot {doing} {}: {why}", path.display()))
    }

    /// Exit code of the process.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Check(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted | Self::InterruptedWith(_) | Self::InterruptedBefore(_) => 130,
            Self::Reported(code) => *code,
        }
    }
}
