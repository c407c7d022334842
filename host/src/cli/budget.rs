//! Arguments of the time that a tick may take: `serve`, `cosim`.

use chaincell_kernel::{Budget, Choice};
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
    /// Sweep until the estimated error of each force is this share of it, as far as the time and --sweeps allow
    #[arg(long, value_name = "SHARE", value_parser = share)]
    force_error: Option<f32>,
}

/// A share of a force above the error of a body at rest.
///
/// # Errors
/// A text that is none.
pub fn share(text: &str) -> std::result::Result<f32, String> {
    let share = text.parse().ok().filter(|share| (0.001..=1.0).contains(share));
    share.ok_or_else(|| "a number from 0.001 to 1, as 0.01 for a hundredth of the force".into())
}

/// Budget of a tick without a clock: the recorded sweeps, else until the errors of the forces are within a share of
/// them, if one is given, else all sweeps.
#[must_use]
pub fn timeless(sweeps: Option<u16>, share: Option<f32>) -> Budget<'static> {
    match (sweeps, share) {
        (None, Some(share)) => Budget::Within { share, more: None },
        (sweeps, _) => Budget::again(sweeps),
    }
}

/// Refuses a share of the force where no error of it is known.
///
/// # Errors
/// That there is none, with the bodies that have one.
pub fn check_force_error(share: Option<f32>, engine: &mut Engine<'_>) -> Result<()> {
    if share.is_none() || engine.tells_force_error() {
        return Ok(());
    }
    Err(Error::input(
        "--force-error: an error of the force is known under --scheme predict, of bodies of --young-pa with a \
         coarse level; leave it out",
    ))
}

impl BudgetArgs {
    /// The sweeps that each tick makes where the time is enough; `None` where the force's error ends it.
    pub fn all_sweeps(self, most: u16) -> Option<u16> {
        self.force_error.is_none().then_some(most)
    }

    /// Share of the force to which its error is brought, in an engine that knows one.
    ///
    /// # Errors
    /// An engine that does not; ticks that make all sweeps.
    pub fn force_error(self, engine: &mut Engine<'_>) -> Result<Option<f32>> {
        check_force_error(self.force_error, engine)?;
        if self.force_error.is_some() && self.budget_us == Some(SweepBudget::Off) {
            return Err(Error::input(
                "--force-error: with --budget-us off a tick makes all its sweeps; leave one of them out",
            ));
        }
        Ok(self.force_error)
    }

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
