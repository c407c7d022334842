//! Sweep budget of a tick: as many sweeps as fit the time between two poses.
//!
//! The minimum that the contact needs is always made. A further sweep is made if it would end in time by the
//! p99 of the last [`COSTS`] sweeps. The time starts at the arrival of the pose. The time after the sweeps
//! (hash, record, send) is measured and reserved. After a miss, that is a pose that arrived before the
//! previous answer was sent, sweeps count twice as long; that fades within a second.

use std::fmt;
use std::str::FromStr;

use super::POSE_HZ;
use crate::choice::by_text;
use crate::session::timing::clock::{PERIOD_NS, SECOND_NS};

/// Number of gaps between poses for the median period.
const GAPS: usize = 64;
/// Number of sweeps for the p99.
const COSTS: usize = 1000;
/// Share of the pose period that a tick may take: the rest is for the transport of the messages.
const SHARE: f64 = 7.0 / 8.0;
/// Largest factor after misses.
const CARE_MAX: f64 = 16.0;
/// Sweeps between two updates of the p99.
const LOOK_SWEEPS: u32 = 64;
/// A gap of more than this many periods is a silence, not a slower controller.
const SILENCE_PERIODS: u64 = 100;
/// Longest budget that is accepted \[us\].
pub const BUDGET_US_MAX: u32 = 1_000_000;

/// Time limit for the sweeps of a tick; as text `auto`, `off` or microseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SweepBudget {
    /// No limit: the number of sweeps in the settings.
    Off,
    /// The pose period.
    #[default]
    Auto,
    /// This long from the arrival of the pose \[us\].
    Us(u32),
}

impl FromStr for SweepBudget {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "off" => Ok(Self::Off),
            "auto" => Ok(Self::Auto),
            _ => match text.parse() {
                Ok(us @ 1..=BUDGET_US_MAX) => Ok(Self::Us(us)),
                _ => Err(format!("give auto, off, or microseconds from 1 to {BUDGET_US_MAX}")),
            },
        }
    }
}

by_text!(SweepBudget);

impl fmt::Display for SweepBudget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::Auto => f.write_str("auto"),
            Self::Us(us) => write!(f, "{us}"),
        }
    }
}

/// State of the budget. Allocates nothing after [`Self::new`].
#[derive(Debug)]
pub(super) struct TimeBudget {
    kind: SweepBudget,
    /// Minimum number of sweeps of a tick.
    least: u16,
    /// Lower bound of the pose period \[ns\].
    shortest_ns: u64,
    gaps_ns: [u64; GAPS],
    gaps: usize,
    costs_ns: Vec<u32>,
    scratch_ns: Vec<u32>,
    next_cost: usize,
    new_costs: u32,
    /// p99 of a sweep \[ns\].
    sweep_ns: u64,
    /// Time after the sweeps \[ns\].
    behind_ns: u64,
    /// Factor after a miss, and the time of the miss.
    care: f64,
    missed_at_ns: u64,
    /// The current tick.
    deadline_ns: u64,
    sweep_from_ns: u64,
    asked: u16,
}

impl TimeBudget {
    pub(super) fn new(kind: SweepBudget, least: u16, max_pose_hz: u32) -> Self {
        Self {
            kind,
            least,
            shortest_ns: SECOND_NS / u64::from(max_pose_hz.max(POSE_HZ)),
            gaps_ns: [PERIOD_NS; GAPS],
            gaps: 0,
            costs_ns: Vec::with_capacity(COSTS),
            scratch_ns: Vec::with_capacity(COSTS),
            next_cost: 0,
            new_costs: 0,
            sweep_ns: 0,
            behind_ns: 0,
            care: 1.0,
            missed_at_ns: 0,
            deadline_ns: 0,
            sweep_from_ns: 0,
            asked: 0,
        }
    }

    /// Notes `poses` poses that arrived within `span_ns` since the last call.
    pub(super) fn arrived(&mut self, poses: u64, span_ns: u64) {
        let gap_ns = span_ns / poses.max(1);
        if gap_ns < SILENCE_PERIODS * PERIOD_NS {
            self.gaps_ns[self.gaps % GAPS] = gap_ns;
            self.gaps += 1;
        }
    }

    /// Median of the last gaps between poses \[ns\]. It is at least that of the largest rate, since a program
    /// that waits for each answer sends poses as fast as the answers.
    pub(super) fn period_ns(&self) -> u64 {
        let mut gaps_ns = self.gaps_ns;
        (*gaps_ns.select_nth_unstable(GAPS / 2).1).max(self.shortest_ns)
    }

    /// Starts the sweeps of a tick, for a pose that arrived at `arrival_ns`.
    pub(super) fn begin(&mut self, arrival_ns: u64, now_ns: u64) {
        let span_ns = match self.kind {
            SweepBudget::Off => u64::MAX,
            SweepBudget::Auto => {
                ((self.period_ns() as f64 * SHARE) as u64).saturating_sub(self.behind_ns)
            }
            SweepBudget::Us(us) => 1000 * u64::from(us),
        };
        self.deadline_ns = arrival_ns.saturating_add(span_ns);
        self.sweep_from_ns = now_ns;
        self.asked = 0;
    }

    /// Notes the end of a sweep. Returns true if another one fits.
    pub(super) fn more(&mut self, now_ns: u64) -> bool {
        self.asked += 1;
        self.note(now_ns);
        let sweep_ns = (self.sweep_ns as f64 * self.care(now_ns)) as u64;
        self.asked < self.least || now_ns.saturating_add(sweep_ns) <= self.deadline_ns
    }

    /// Returns true if a tick with this many sweeps was as short as possible and still longer than the
    /// period.
    pub(super) fn is_behind(&self, sweeps: u16, step_ns: u64) -> bool {
        sweeps <= self.least && step_ns > self.period_ns()
    }

    /// Ends a tick of `sweeps` sweeps, and notes the last one if [`Self::more`] was not called after it.
    pub(super) fn end(&mut self, now_ns: u64, sweeps: u16) {
        if self.asked < sweeps {
            self.note(now_ns);
        }
    }

    /// Notes that the answer was sent `span_ns` after the last sweep; `missed` if the next pose had arrived
    /// before.
    pub(super) fn answered(&mut self, span_ns: u64, missed: bool, now_ns: u64) {
        self.behind_ns = span_ns.max(self.behind_ns - self.behind_ns / 64);
        if missed {
            self.care = (2.0 * self.care(now_ns)).min(CARE_MAX);
            self.missed_at_ns = now_ns;
        }
    }

    /// Factor by which a sweep counts longer than it takes, after a miss.
    fn care(&self, now_ns: u64) -> f64 {
        let since = now_ns.saturating_sub(self.missed_at_ns) as f64 / SECOND_NS as f64;
        1.0 + (self.care - 1.0) * (1.0 - since).max(0.0)
    }

    fn note(&mut self, now_ns: u64) {
        let cost_ns = now_ns.saturating_sub(self.sweep_from_ns);
        self.sweep_from_ns = now_ns;
        let cost_ns = u32::try_from(cost_ns).unwrap_or(u32::MAX);
        if self.costs_ns.len() < COSTS {
            self.costs_ns.push(cost_ns);
        } else {
            self.costs_ns[self.next_cost] = cost_ns;
        }
        self.next_cost = (self.next_cost + 1) % COSTS;
        self.new_costs += 1;
        let few = self.costs_ns.len() < LOOK_SWEEPS as usize;
        if few || self.new_costs >= LOOK_SWEEPS {
            self.new_costs = 0;
            self.scratch_ns.clear();
            self.scratch_ns.extend_from_slice(&self.costs_ns);
            let place = (self.scratch_ns.len() - 1) * 99 / 100;
            self.sweep_ns = u64::from(*self.scratch_ns.select_nth_unstable(place).1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const US: u64 = 1000;

    /// Number of sweeps, at most `most`, of a tick that starts at `start_ns` with `sweep_ns` per sweep.
    fn sweeps(budget: &mut TimeBudget, start_ns: u64, sweep_ns: u64, most: u64) -> u64 {
        budget.begin(start_ns, start_ns);
        let mut more = |done: &u64| budget.more(start_ns + done * sweep_ns);
        let done = (1..most).find(|done| !more(done)).unwrap_or(most);
        budget.end(start_ns + done * sweep_ns, done as u16);
        done
    }

    // REQ-COS-09
    #[test]
    fn as_many_sweeps_as_fit_the_period() {
        let mut budget = TimeBudget::new(SweepBudget::Auto, 1, POSE_HZ);
        assert_eq!(sweeps(&mut budget, SECOND_NS, 100 * US, 64), 8, "7/8 of a millisecond");
        assert_eq!(sweeps(&mut budget, SECOND_NS, 100 * US, 4), 4, "never more than the settings'");
        (0..64).for_each(|_| budget.arrived(1, 500 * US));
        assert_eq!(sweeps(&mut budget, SECOND_NS, 100 * US, 64), 4, "a controller at 2 kHz");
        (0..64).for_each(|_| budget.arrived(1, 50 * US));
        assert_eq!(budget.period_ns(), 500 * US, "who waits for the answer");
        budget.arrived(1, 3 * SECOND_NS);
        assert_eq!(budget.period_ns(), 500 * US, "a silence is no period");
        (0..40).for_each(|_| budget.arrived(3, 3000 * US));
        assert_eq!(budget.period_ns(), 1000 * US, "three poses at once in three milliseconds");
        budget.answered(200 * US, false, SECOND_NS);
        assert_eq!(sweeps(&mut budget, SECOND_NS, 100 * US, 64), 6, "the answer takes time too");
        assert_eq!(sweeps(&mut budget, SECOND_NS, 5000 * US, 64), 1, "one at least");
    }

    #[test]
    fn no_fewer_than_the_contact_needs() {
        let mut budget = TimeBudget::new(SweepBudget::Us(1), 4, POSE_HZ);
        assert_eq!(sweeps(&mut budget, SECOND_NS, 300 * US, 64), 4);
        assert_eq!(sweeps(&mut budget, SECOND_NS, 300 * US, 2), 2, "the settings' are the most");
        assert!(budget.is_behind(4, 1200 * US) && budget.is_behind(2, 1200 * US));
        assert!(!budget.is_behind(5, 1200 * US) && !budget.is_behind(4, 900 * US));
    }

    #[test]
    fn a_miss_makes_it_careful_for_a_second() {
        let mut budget = TimeBudget::new(SweepBudget::Auto, 1, POSE_HZ);
        let at = |budget: &mut TimeBudget, ns| sweeps(budget, ns, 100 * US, 64);
        assert_eq!(at(&mut budget, SECOND_NS), 8);
        budget.answered(0, true, SECOND_NS);
        assert_eq!(at(&mut budget, SECOND_NS), 7);
        budget.answered(0, true, SECOND_NS);
        assert_eq!(at(&mut budget, SECOND_NS), 5);
        assert_eq!(at(&mut budget, SECOND_NS + SECOND_NS / 2), 7);
        assert_eq!(at(&mut budget, 2 * SECOND_NS), 8);
    }

    #[test]
    fn one_slow_sweep_in_a_hundred_and_more_counts() {
        let mut budget = TimeBudget::new(SweepBudget::Us(1000), 1, POSE_HZ);
        for tick in 0..200 {
            sweeps(&mut budget, tick, if tick % 20 == 0 { 400 * US } else { 100 * US }, 2);
        }
        assert_eq!(sweeps(&mut budget, SECOND_NS, 100 * US, 64), 7, "the next may take 400 us");
        let mut off = TimeBudget::new(SweepBudget::Off, 1, POSE_HZ);
        assert_eq!(sweeps(&mut off, SECOND_NS, SECOND_NS, 64), 64);
    }

    #[test]
    fn the_option_reads_back() {
        for text in ["off", "auto", "1", "750"] {
            assert_eq!(text.parse::<SweepBudget>().unwrap().to_string(), text);
        }
        for text in ["0", "-1", "1e3", "2000000", "fast"] {
            assert!(text.parse::<SweepBudget>().is_err(), "{text}");
        }
    }
}
