//! Arguments of faults on purpose: `serve`, `control`, `cosim`.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::session::loops::inject::{Faults, Injected};
use crate::terminal;
use crate::words::counted;

/// Faults between the schedule of poses and shared memory.
#[derive(Debug, Clone, Default, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
#[command(next_help_heading = "Faults on purpose")]
pub struct InjectArgs {
    /// Faults in the poses sent, drawn by the seed: late:5%@MS (up to MS late, those behind wait),
    /// lost:1%, dup:1%, reorder:1%, nan:1%, burst:2%@N (N at once), rate:HZ, stop:MS@N (after N
    /// poses nothing for MS, then all that were due); in the tissue, for serve and cosim:
    /// sweep:PERIODS@N (after N poses a sweep takes at least that many pose periods)
    #[arg(long, value_name = "KIND:VALUE,..", allow_hyphen_values = true)]
    inject: Option<String>,
    /// Seed of the faults
    #[arg(
        long,
        default_value_t = 1,
        value_name = "N",
        requires = "inject",
        allow_negative_numbers = true
    )]
    inject_seed: u64,
}

impl InjectArgs {
    /// The faults and their seed, `None` where none were asked for.
    ///
    /// # Errors
    /// A fault that there is not, a share or a number out of range.
    pub fn faults(&self) -> Result<Option<(Faults, u64)>> {
        let Some(text) = &self.inject else { return Ok(None) };
        match text.parse() {
            Ok(faults) => Ok(Some((faults, self.inject_seed))),
            Err(why) => Err(Error::input(format!("--inject {text}: {why}"))),
        }
    }

    /// The faults in the tissue alone.
    ///
    /// # Errors
    /// As [`Self::faults`].
    pub fn of_tissue(&self) -> Result<Self> {
        let faults = self.faults()?.filter(|(faults, _)| faults.sweep > 0.0);
        Ok(Self { inject: faults.map(|(faults, _)| faults.of_sweeps()), ..*self })
    }
}

/// Prints what was done on purpose.
pub fn tell_injected(injected: Option<&Injected>) -> Result<()> {
    let Some(done) = injected else { return Ok(()) };
    terminal::say(format_args!(
        "  injected    {} late, {} lost, {} twice, {} overtaken, {} not a number, {}, {} \
         (seed {})",
        done.late,
        done.lost,
        done.duplicated,
        done.overtaken,
        done.nan,
        counted(done.bursts, "burst"),
        counted(done.stops, "stop"),
        done.seed
    ))
}
