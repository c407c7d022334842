//! Reports of both commands, for people and for programs.

use serde_json::{Value, json};

use crate::agent::Counts;
use crate::controller::Dropped;
use crate::trips::quantile_ns;

/// Round trips at p50, p99 and p99.9 \[ns\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RoundTrips {
    /// One in two takes at most this long \[ns\].
    pub p50: u64,
    /// 99 in 100 take at most this long \[ns\].
    pub p99: u64,
    /// 999 in 1,000 take at most this long \[ns\].
    pub p999: u64,
}

impl RoundTrips {
    /// Returns those of a list, which it sorts.
    #[must_use]
    pub fn of(mut all_ns: Vec<u64>) -> Self {
        all_ns.sort_unstable();
        let [p50, p99, p999] = [500, 990, 999].map(|of_1000| quantile_ns(&all_ns, of_1000));
        Self { p50, p99, p999 }
    }

    fn to_json(self) -> Value {
        json!({"p50": self.p50, "p99": self.p99, "p999": self.p999})
    }
}

impl std::fmt::Display for RoundTrips {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [p50, p99, p999] = [self.p50, self.p99, self.p999].map(|ns| ns as f64 * 1e-3);
        write!(f, "p50 {p50:8.1}  p99 {p99:8.1}  p99.9 {p999:8.1} us")
    }
}

/// A session of the agent.
#[derive(Debug, Clone)]
pub struct AgentReport {
    /// How it ended.
    pub ended: String,
    /// Its counts.
    pub counts: Counts,
}

impl AgentReport {
    /// Returns the object that `--json` prints.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Counts { hands, poses, recovered, lost, late, answers, refused, old, forged, foreign } =
            self.counts;
        json!({
            "ended_by": self.ended, "hands": hands, "poses": poses, "recovered": recovered, "lost": lost,
            "late": late, "answers": answers, "refused": refused, "old": old, "forged": forged,
            "foreign": foreign,
        })
    }
}

impl std::fmt::Display for AgentReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Counts { hands, poses, recovered, lost, late, answers, refused, old, forged, foreign } =
            self.counts;
        writeln!(f, "{hands} hands, {refused} of them refused; {poses} poses, {answers} answers")?;
        writeln!(f, "  recovered   {recovered} poses of lost datagrams; {lost} poses never came")?;
        writeln!(f, "  dropped     {late} late, {old} old, {forged} forged, {foreign} foreign")?;
        write!(f, "  ended       {}", self.ended)
    }
}

/// A path that was played.
#[derive(Debug, Clone)]
pub struct PlayReport {
    /// How it ended.
    pub ended: String,
    /// True if it ended before its time.
    pub is_failed: bool,
    /// Poses sent, and those answered.
    pub poses: u64,
    /// See `poses`.
    pub answered: u64,
    /// Times from a pose to its answer.
    pub round_trips: RoundTrips,
    /// Silences of the watchdog's length.
    pub silences: u64,
    /// Largest force shown \[N\].
    pub largest_force_n: f32,
    /// Datagrams that were dropped.
    pub dropped: Dropped,
}

impl PlayReport {
    /// Returns the object that `--json` prints.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Dropped { forged, foreign, old, late } = self.dropped;
        json!({
            "ended_by": self.ended, "poses": self.poses, "answered": self.answered,
            "lost": self.poses - self.answered, "round_trip_ns": self.round_trips.to_json(),
            "silences": self.silences, "largest_force_n": self.largest_force_n, "late": late, "old": old,
            "forged": forged, "foreign": foreign,
        })
    }
}

impl std::fmt::Display for PlayReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Dropped { forged, foreign, old, late } = self.dropped;
        let (poses, answered) = (self.poses, self.answered);
        writeln!(f, "{poses} poses sent, {answered} answered, {} lost", poses - answered)?;
        writeln!(f, "  round trip  {}", self.round_trips)?;
        writeln!(
            f,
            "  force       largest {:.4} N; silences {}",
            self.largest_force_n, self.silences
        )?;
        writeln!(f, "  dropped     {late} late, {old} old, {forged} forged, {foreign} foreign")?;
        write!(f, "  ended       {}", self.ended)
    }
}
