//! The limit of the stress that `run`, `serve` and `cosim` watch.

use serde::{Deserialize, Serialize};

use crate::engine::Engine;
use crate::engine::stress_limit::{StressLimit, StressReport};
use crate::engine::stress_rows::StressRows;
use crate::engine::tissue::TissueEngine;
use crate::error::{Error, Result};
use crate::terminal;
use crate::words::counted;

/// A limit of the stress.
#[derive(Debug, Clone, Default, Serialize, Deserialize, clap::Args)]
pub struct StressArgs {
    /// Warn once a node's stress after von Mises is above this, and count all such nodes [Pa]. `run` looks at all
    /// after every tick, sessions at some between two ticks and at all at their end; of a node that is cut the side
    /// with more counts
    #[arg(long, value_name = "PA", allow_negative_numbers = true)]
    stress_limit_pa: Option<f32>,
}

impl StressArgs {
    /// The limit, if one was given.
    ///
    /// # Errors
    /// A limit that is no stress; a body without stress.
    pub fn limit(&self, engine: &mut Engine<'_>) -> Result<Option<StressLimit>> {
        let Some(limit_pa) = self.stress_limit_pa else { return Ok(None) };
        if engine.stressed_cells().is_none() {
            return Err(Error::input(
                "--stress-limit-pa: this body has no stress: take one of chaincell bake with --young-pa or --tissue",
            ));
        }
        StressLimit::new(limit_pa, engine.node_count()).map(Some)
    }
}

/// Watches the limit at every node after every tick.
pub struct StressWatch {
    limit: StressLimit,
    rows: StressRows,
}

impl StressWatch {
    /// A watch over the body of an engine.
    pub fn new(limit: StressLimit, engine: &Engine<'_>) -> Self {
        Self { limit, rows: StressRows::new(engine.node_count(), engine.network().model().cells()) }
    }

    /// Computes and judges the stresses after a tick, and returns the warning for the first node above the limit.
    pub fn after(&mut self, tick: u64, engine: &mut dyn TissueEngine) -> Option<String> {
        self.rows.read_all(engine);
        self.limit.take(self.rows.rows(), tick)
    }

    /// The report so far.
    pub fn report(&self) -> StressReport {
        self.limit.report()
    }
}

/// Prints what a limit has seen.
pub fn tell_stress(width: usize, report: Option<&StressReport>) -> Result<()> {
    let Some(of) = report else { return Ok(()) };
    terminal::say(format_args!(
        "  {:<width$}up to {:.0} Pa after von Mises, at node {} in tick {}; {} above the limit of {} Pa",
        "stress",
        of.largest_von_mises_pa,
        of.node,
        of.tick,
        counted(of.nodes_above, "node"),
        of.limit_pa
    ))
}
