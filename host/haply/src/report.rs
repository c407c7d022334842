//! The report of a session, for people and for programs.

use serde_json::{Map, Value, json};

use crate::doubt::Doubt;
use crate::drive::{Counts, Ended, Report};

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
                write!(f, "the Haply service has gone ({why}): is it still running?")
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
        let counts = self.counts;
        json!({
            "ended_by": self.ended.to_string(),
            "forces_sent": counts.forces_sent,
            "states": counts.states,
            "poses": counts.poses,
            "answered": counts.answered,
            "late": counts.poses - counts.answered,
            "doubts": self.doubts(),
            "largest_force_n": self.largest_force_n,
        })
    }

    /// Returns the doubts that occurred, with their counts.
    fn doubts(&self) -> Map<String, Value> {
        let named = Doubt::ALL.iter().zip(self.doubts).filter(|(_, count)| *count > 0);
        named.map(|((_, name), count)| ((*name).to_owned(), count.into())).collect()
    }
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Counts { forces_sent, states, poses, answered } = self.counts;
        let late = poses - answered;
        writeln!(
            f,
            "{poses} poses sent, {answered} answered within their period, {late} later or not"
        )?;
        writeln!(f, "  service     {forces_sent} forces sent, {states} states")?;
        writeln!(f, "  doubts      {}", Value::Object(self.doubts()))?;
        writeln!(f, "  force       largest {:.4} N", self.largest_force_n)?;
        write!(f, "  ended       {}", self.ended)
    }
}
