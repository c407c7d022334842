//! The last line of a session: whether 1 kHz was held, what to change where it was not, and how far the forces are
//! off.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::choice::by_text;
use crate::engine::Engine;
use crate::engine::estimates::ForceEstimate;
use crate::error::{Error, Result};
use crate::session::loops::serve::{ServeReport, SweepBudget};
use crate::terminal;
use crate::words::{counted, percent};

/// What is allowed by default, and what counts as held where anything is allowed.
const DEFAULT_SHARE: f64 = 0.01;

/// Share of late answers that a session may have beyond those of the machine itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LateShare {
    /// Any.
    Off,
    /// So many, 0 to 1.
    AtMost(f64),
}

impl FromStr for LateShare {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "off" {
            return Ok(Self::Off);
        }
        let share = percent(text).map(Self::AtMost);
        share.ok_or_else(|| "give a share from 0% to 100%, as in 1%, or off".into())
    }
}

by_text!(LateShare);

impl fmt::Display for LateShare {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::AtMost(share) => write!(f, "{}%", 100.0 * share),
        }
    }
}

/// When a session has failed.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct VerdictArgs {
    /// Exit code 1 where more answers are late than this, beyond those that the machine itself
    /// makes late; `off` for never
    #[arg(long, value_name = "PERCENT%|off", default_value_t = LateShare::AtMost(DEFAULT_SHARE),
        allow_hyphen_values = true)]
    late_share: LateShare,
}

impl VerdictArgs {
    /// Those of a child process, which leaves the judgement to this one.
    pub fn off() -> Self {
        Self { late_share: LateShare::Off }
    }

    /// Judges what was counted.
    pub fn judge(self, counts: Counts) -> Verdict {
        let share = |late: u64| late as f64 / counts.answers.max(1) as f64;
        let (late_share, floor_share) = (share(counts.late), counts.floor_share);
        let allowed = match self.late_share {
            LateShare::Off => None,
            LateShare::AtMost(allowed) => Some(allowed),
        };
        let beyond = late_share - floor_share;
        let all = counts.overloads == 0 && counts.unanswered == 0;
        let is_held = all && beyond <= allowed.unwrap_or(DEFAULT_SHARE);
        Verdict { is_held, fails: allowed.is_some() && !is_held, late_share, floor_share, counts }
    }
}

/// What a session counted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Answers.
    pub answers: u64,
    /// Of these, the late ones.
    pub late: u64,
    /// Poses without an answer.
    pub unanswered: u64,
    /// Share of late answers that the machine makes by itself.
    pub floor_share: f64,
    /// Times that the force fell to 0 since the tissue could not keep up.
    pub overloads: u64,
    /// Whether every tick makes all its sweeps.
    pub is_fixed: bool,
    /// Whether it could do with fewer.
    pub is_anytime: bool,
    /// Estimated errors of the forces, if they are known.
    pub force_error: Option<ForceEstimate>,
}

impl Counts {
    /// What `serve` counted of the tissue.
    pub fn of_tissue(report: &ServeReport, engine: &Engine<'_>) -> Self {
        Self {
            overloads: report.overloads,
            is_fixed: report.budget_us == SweepBudget::Off,
            is_anytime: engine.is_anytime(),
            force_error: report.force_error_estimate,
            ..Self::default()
        }
    }
}

/// The verdict, for summaries and the last line.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Verdict {
    /// Whether 1 kHz was held.
    pub is_held: bool,
    #[serde(skip)]
    fails: bool,
    late_share: f64,
    floor_share: f64,
    #[serde(skip)]
    counts: Counts,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.counts.answers + self.counts.unanswered == 0 {
            return f.write_str("no pose came, nothing to judge");
        }
        let [late, floor] = [self.late_share, self.floor_share].map(|share| 100.0 * share);
        if self.is_held && self.floor_share > DEFAULT_SHARE {
            write!(
                f,
                "1 kHz held, though this machine itself makes {floor:.2} % of the answers late ({late:.2} % in \
                 all): give each process a free core"
            )?;
        } else {
            let held = if self.is_held { "held" } else { "NOT held" };
            write!(
                f,
                "1 kHz {held}: {late:.2} % of the answers late, {floor:.2} % by the machine itself"
            )?;
        }
        if self.counts.unanswered > 0 {
            write!(f, ", {} without an answer", counted(self.counts.unanswered, "pose"))?;
        }
        if let Some(remedy) = self.remedy() {
            write!(f, "; {remedy}")?;
        }
        match self.counts.force_error {
            Some(error) => write!(f, "; the force {error}"),
            None => Ok(()),
        }
    }
}

impl Verdict {
    /// What to change.
    fn remedy(&self) -> Option<&'static str> {
        let Counts { overloads, is_fixed, is_anytime, .. } = self.counts;
        if overloads > 0 {
            return Some(match (is_fixed, is_anytime) {
                (true, true) => {
                    "all sweeps of a tick together longer than a pose period let the force fall to \
                     0: take --budget-us auto, or fewer --sweeps"
                }
                (true, false) => {
                    "all sweeps of a tick together longer than a pose period let the force fall to \
                     0: take fewer --sweeps, --scheme track, or fewer cells (`bake --cells N` \
                     for links, a coarser mesh for tissue)"
                }
                (false, _) => {
                    "the fewest sweeps of a tick, longer than a pose period, let the force fall to \
                     0: bake fewer cells (`--cells N` for links, a coarser mesh for tissue), or \
                     take a faster core"
                }
            });
        }
        if self.is_held {
            return None;
        }
        if self.counts.unanswered > 0 && self.late_share - self.floor_share <= DEFAULT_SHARE {
            return None;
        }
        if self.floor_share > self.late_share / 2.0 {
            return Some("the machine itself is late: give each process a free core");
        }
        Some(
            "give each process a free core, or bake fewer cells (`--cells N` for links, a coarser mesh \
             for tissue)",
        )
    }

    /// Prints the line.
    pub fn tell(&self) -> Result<()> {
        terminal::say(format_args!("  {:<18}{self}", "verdict"))
    }

    /// The exit code; `is_told` where the line was printed.
    ///
    /// # Errors
    /// More late answers than the user allows, or an overload.
    pub fn check(&self, is_told: bool) -> Result<()> {
        match (self.fails, is_told) {
            (false, _) => Ok(()),
            (true, true) => Err(Error::Reported(1)),
            (true, false) => Err(Error::check(self)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn verdict(share: &str, late: u64, overloads: u64) -> Verdict {
        let counts =
            Counts { answers: 1000, late, floor_share: 0.02, overloads, ..Counts::default() };
        VerdictArgs { late_share: share.parse().unwrap() }.judge(counts)
    }

    #[test]
    fn late_answers_count_beyond_the_machines_own() {
        assert!(verdict("1%", 30, 0).check(false).is_ok());
        assert!(verdict("1%", 31, 0).check(true).is_err());
        assert!(verdict("off", 900, 0).check(false).is_ok() && !verdict("off", 900, 0).is_held);
        assert!(verdict("50%", 0, 1).check(true).is_err(), "an overload fails");
        assert!(
            verdict("1%", 31, 0).to_string().starts_with("1 kHz NOT held: 3.10 % of the answers")
        );
        assert_eq!(
            verdict("1%", 30, 0).to_string(),
            "1 kHz held, though this machine itself makes 2.00 % of the answers late (3.00 % in all): give \
             each process a free core"
        );
        let known = ForceEstimate { ticks: 9, unknown_ticks: 0, median: 0.004, p99: 0.021 };
        let counts = Counts { answers: 1000, force_error: Some(known), ..Counts::default() };
        assert_eq!(
            VerdictArgs::off().judge(counts).to_string(),
            "1 kHz held: 0.00 % of the answers late, 0.00 % by the machine itself; the force within 0.4 % of the \
             largest (median), 2.1 % (99 of 100 ticks), by estimate"
        );
        let text = verdict("1%", 0, 3).to_string();
        assert!(text.contains("longer than a pose period") && text.contains("--cells"), "{text}");
    }

    #[test]
    fn shares_read_back() {
        for text in ["off", "1%", "0%", "2.5%", "100%"] {
            assert_eq!(text.parse::<LateShare>().unwrap().to_string(), text);
        }
        for text in ["1", "101%", "-1%", "NaN%", ""] {
            assert!(text.parse::<LateShare>().is_err(), "{text}");
        }
    }
}
