//! `chaincell stress`: bodies in states and under tools that none should come to, in every scheme
//! and number type.
//!
//! A case is a body, a state or a tool, and what it checks beside [`EVERY_TICK`]; [`selected`]
//! lists them. Each run is played three times: twice with vector units and once without, and the
//! bits must agree. What a number type refuses is no failure and is listed with its reason.
//!
//! The table has a line a case: what it checks, the result, and how near the worst tick came to a
//! bound (force, energy or coordinate, as a part of it). `stress.json` holds the same with every
//! failure and every run; `ok` says whether all cases held, and so does the exit code.

mod case;
mod cases;
mod table;
mod tools;
mod trial;

pub use case::{Case, Failed, Outcome, Run, Scale};
pub use table::table;

use serde::Serialize;

use case::Findings;
use chaincell_host::error::Result;

/// What is checked in every tick of every case.
pub const EVERY_TICK: &str = "force, level, energy and every coordinate finite; every coordinate \
    within K; energy (double precision, at the published positions) at most the certified level \
    but for rounding; no level that rises while nothing acts from outside; energy at most what a \
    tool may load; force at most 2 k sqrt(W E); the same bits in a second run and without vectors";

/// Which cases are done, and how much in each.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Options {
    /// How much.
    pub scale: Scale,
    /// Part of the names of the cases; all if empty.
    pub only: Vec<String>,
}

/// All cases that were done.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Suite {
    /// Whether every case is.
    pub ok: bool,
    /// Whether it is the quick suite.
    pub quick: bool,
    /// Cases done.
    pub done: usize,
    /// Cases that failed.
    pub failed: usize,
    /// Runs of a trial under a scheme in a number type.
    pub runs: usize,
    /// Ticks, each played three times.
    pub ticks: u64,
    /// What is checked in every tick.
    pub every_tick: &'static str,
    /// The cases.
    pub cases: Vec<Outcome>,
}

/// The cases that the options name, in order.
#[must_use]
pub fn selected(options: &Options) -> Vec<Case> {
    let named = |case: &Case| {
        options.only.is_empty() || options.only.iter().any(|part| case.name.contains(part))
    };
    cases::all().filter(named).collect()
}

/// Does the cases and adds each to `suite` as it is done; `each` is told its name before.
///
/// # Errors
/// [`Error::Interrupted`](chaincell_host::error::Error::Interrupted): what is done stands in the
/// suite. A body of the suite that the bake refuses.
pub fn run(options: &Options, suite: &mut Suite, mut each: impl FnMut(&'static str)) -> Result<()> {
    *suite = Suite { quick: options.scale.quick, every_tick: EVERY_TICK, ..Suite::default() };
    for case in selected(options) {
        each(case.name);
        let mut found = Findings::default();
        (case.run)(options.scale, &mut found)?;
        suite.ticks += found.worst.ticks;
        suite.add(Outcome::new(&case, found));
    }
    Ok(())
}

impl Suite {
    fn add(&mut self, outcome: Outcome) {
        self.done += 1;
        self.failed += usize::from(!outcome.ok);
        self.runs += outcome.found.runs.len();
        self.cases.push(outcome);
        self.ok = self.failed == 0;
    }
}
