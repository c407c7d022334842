//! Arguments of the time that a tick may take: `serve`, `cosim`.

use chaincell_kernel::Choice;
use serde::{Deserialize, Serialize};

use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::session::loops::serve::SweepBudget;

/// Number of sweeps that a tick makes under a clock.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct BudgetArgs {
    /// Time for a tick from the arrival of its pose [us]: `auto` is the time between two poses,
    /// `off` makes all --sweeps whatever it takes. A tick makes at least one sweep, with links under a
    /// moving tool four, and at most --sweeps [default: auto under track and predict, else
    /// off]
    #[arg(long, value_name = "US|auto|off", allow_hyphen_values = true)]
    budget_us: Option<SweepBudget>,
}

impl BudgetArgs {
    /// The budget for an engine.
    ///
    /// # Errors
    /// One for a scheme whose sweeps are the tissue's time.
    pub fn of(self, engine: &Engine<'_>) -> Result<SweepBudget> {
        match self.budget_us {
            None if engine.is_anytime() => Ok(SweepBudget::Auto),
            None => Ok(SweepBudget::Off),
            Some(budget) if engine.is_anytime() || budget == SweepBudget::Off => Ok(budget),
            Some(budget) => Err(Error::input(format!(
                "--budget-us {budget}: under --scheme {} the sweeps are the tissue's time, so \
                 their number is fixed; leave it out, or take --scheme track",
                engine.scheme().name()
            ))),
        }
    }
}
