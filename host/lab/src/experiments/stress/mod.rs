//! `chaincell stress`: bodies of links and of nodal shapes in states and under tools that none should
//! come to, in every scheme and number type.
//!
//! A case is a body, a state or a tool, and what it checks beyond [`EVERY_TICK`]; [`selected`] lists them.
//! [`play`](crate::monitor::play()) plays each run three times: twice with vector units and once without them
//! and without sleep, and the bits must agree. What a number type refuses is no failure and is listed with its
//! reason. The property tests do the same on random bodies.
//!
//! The table has a line a case: the result, and how near the worst tick came to a bound (force, energy or
//! coordinate, as a part of it). `stress.json` holds the same with every failure and every run; `ok` says
//! whether all cases held, and so does the exit code.

mod case;
mod cases;
mod trial;

pub use case::{Case, Failed, Outcome, Run, Scale};

use std::fmt::Write;

use serde::Serialize;

use case::Findings;
use chaincell_host::error::Result;
use chaincell_host::words::counted;

/// What is checked in every tick of every case.
pub const EVERY_TICK: &str = "force, level, energy and every coordinate finite; every coordinate \
    within K; energy (double precision, at the published positions) at most the certified level \
    but for rounding; no level that rises while nothing acts from outside; energy at most what a \
    tool may load; force at most 2 k sqrt(W E); no bit of a body at rest moves; as many sweeps as \
    asked for; held, then safe, then back after bad samples; the same bits in a second run and \
    without vectors and sleep";

/// Failures that are shown of a case; all stand in the JSON.
const SHOWN: usize = 5;

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
        suite.add(Outcome::new(&case, found));
    }
    Ok(())
}

impl Suite {
    fn add(&mut self, outcome: Outcome) {
        self.done += 1;
        self.failed += usize::from(!outcome.ok);
        self.runs += outcome.found.runs.len();
        self.ticks += outcome.found.worst.ticks;
        self.cases.push(outcome);
        self.ok = self.failed == 0;
    }

    /// A line a case, the failures, what number types refuse.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{:<20} {:<8} nearest to its bound, which is 1\n", "case", "result");
        for case in &self.cases {
            let result = if case.ok { "ok" } else { "FAILED" };
            let _ = writeln!(text, "{:<20} {result:<8} {}", case.name, case.nearest());
        }
        text += "\nE of what a tool may load, F of 2 k sqrt(W E), x of K, r of the rounding allowed; \
                 see --list\n";
        for case in self.cases.iter().filter(|case| !case.ok) {
            let failures = &case.found.failures;
            let _ = writeln!(text, "\n{} FAILED, {}:", case.name, counted(failures.len(), "check"));
            for Failed { place, failure } in failures.iter().take(SHOWN) {
                let (tick, check, what) = (failure.tick, failure.check, &failure.what);
                let _ = writeln!(text, "  {place}, tick {tick}: {check:?}: {what}");
            }
        }
        let refused = self.cases.iter().flat_map(|case| {
            case.found.refused.iter().map(move |why| format!("  {}: {why}\n", case.name))
        });
        let refused: String = refused.collect();
        if !refused.is_empty() {
            let _ = write!(text, "\nRefused, with the reason:\n{refused}");
        }
        let (cases, runs) = (counted(self.done, "case"), counted(self.runs, "run"));
        let (ok, ticks) = (self.done - self.failed, counted(self.ticks, "tick"));
        let _ = write!(text, "\n{ok} of {cases} ok, {runs}, {ticks}");
        text
    }
}
