//! The report of a session, for people and for programs.

use serde_json::{Value, json};

use crate::doubt::Doubt;
use crate::drive::{Ended, Report};

impl Ended {
    /// Returns the exit code: 0 for an end that was asked for, 1 for one that was not.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        u8::from(!matches!(self, Self::Stopped | Self::TimeUp | Self::SessionEnded))
    }
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Stopped => write!(f, "stopped"),
            Self::TimeUp => write!(f, "time up"),
            Self::SessionEnded => write!(f, "the tissue's session has ended"),
            Self::ServiceClosed(why) => {
                write!(
                    f,
                    "the connection to the Haply service has ended ({why}): is it still running?"
                )
            }
            Self::ServiceGone(Some(doubt)) => write!(f, "2 s without a good state: {doubt}"),
            Self::ServiceGone(None) => write!(f, "2 s without a state: is a device plugged in?"),
            Self::TissueGone => {
                write!(f, "2 s without an answer of the tissue: does `chaincell serve` still run?")
            }
            Self::TissueFailed(why) => write!(f, "the scene takes no pose: {why}"),
            Self::Panicked => write!(f, "a panic, which is a bug: the message is above"),
        }
    }
}

impl Report {
    /// Returns the object that `--json` prints.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let doubts = Doubt::ALL.iter().zip(self.doubts).filter(|(_, count)| *count > 0);
        let doubts: serde_json::Map<String, Value> =
            doubts.map(|(doubt, count)| (doubt.name().to_owned(), count.into())).collect();
        json!({
            "ended_by": self.ended.to_string(),
            "forces_sent": self.forces_sent,
            "states": self.states,
            "poses": self.poses,
            "answered": self.answered,
            "late": self.poses - self.answered,
            "doubts": doubts,
            "largest_force_n": self.largest_force_n,
        })
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(
            f,
            "{} poses sent, {} answered within their period, {} later or not",
            self.poses,
            self.answered,
            self.poses - self.answered
        )?;
        writeln!(f, "  service   {} forces sent, {} states", self.forces_sent, self.states)?;
        write!(f, "  doubts   ")?;
        let mut doubts =
            Doubt::ALL.iter().zip(self.doubts).filter(|(_, count)| *count > 0).peekable();
        if doubts.peek().is_none() {
            write!(f, " none")?;
        }
        for (doubt, count) in doubts {
            write!(f, " {} {count}", doubt.name())?;
        }
        writeln!(f, "\n  force     largest {:.4} N", self.largest_force_n)?;
        write!(f, "  ended     {}", self.ended)
    }
}
