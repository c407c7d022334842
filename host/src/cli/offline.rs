//! A tissue from the options of `run`, for programs that have no command line.

use chaincell_kernel::{Budget, Model};
use clap::{CommandFactory, FromArgMatches, Parser};

use super::budget::{check_force_error, share, timeless};
use super::options::in_a_line;
use super::stage::StageArgs;
use super::tissue::TissueArgs;
use crate::engine::Arithmetic;
use crate::engine::staged::Staged;
use crate::error::{Error, Result};

/// Contact, dynamics, limits and output stage, as `run` has them.
#[derive(Debug, Clone, Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
pub struct Offline {
    #[command(flatten)]
    tissue: TissueArgs,
    #[command(flatten)]
    stage: StageArgs,
    #[arg(long, value_name = "SHARE", value_parser = share)]
    force_error: Option<f32>,
}

impl Offline {
    /// Reads options, each as `--name=value`.
    ///
    /// # Errors
    /// An option that there is not, a value that is none of it, two that exclude each other.
    pub fn parse(options: impl IntoIterator<Item = String>) -> Result<Self> {
        let matches = Self::command().try_get_matches_from(options);
        matches
            .and_then(|found| Self::from_arg_matches(&found))
            .map_err(|why| Error::input(in_a_line(&why)))
    }

    /// The tissue of a model, at rest.
    ///
    /// # Errors
    /// What does not go with the model, a value out of its range, a delay that is to be measured, a share of the force
    /// for its error where no error is known.
    pub fn staged<'m>(&self, model: Model<'m>) -> Result<Staged<'m>> {
        let mut tissue = self.tissue.staged(model, self.stage.timeless()?)?;
        check_force_error(self.force_error, tissue.engine_mut())?;
        Ok(tissue)
    }

    /// Budget of a tick, with the sweeps that it shall make if they are known.
    #[must_use]
    pub fn budget(&self, sweeps: Option<u16>) -> Budget<'static> {
        timeless(sweeps, self.force_error)
    }

    /// What cells and links are computed in.
    #[must_use]
    pub fn numbers(&self) -> Arithmetic {
        self.tissue.precision
    }

    /// Names of all options, without the dashes.
    pub fn names() -> Vec<String> {
        let command = Self::command();
        let longs = command.get_arguments().filter_map(clap::Arg::get_long);
        longs.map(str::to_owned).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(option: &str) -> String {
        Offline::parse([option.to_owned()]).unwrap_err().to_string()
    }

    #[test]
    fn a_refusal_is_one_line_that_names_the_option() {
        for (option, part) in [
            ("--sweeps=x", "--sweeps"),
            ("--scheme=none", "--scheme"),
            ("--device=hammer", "--device"),
            ("--colour=1", "--colour"),
            ("--force-error=2", "--force-error"),
            ("--help", "--help"),
        ] {
            let text = refusal(option);
            assert!(text.contains(part) && !text.contains(['\n']), "{text}");
            assert!(!text.contains("For more information"), "{text}");
        }
    }

    #[test]
    fn every_option_is_named() {
        let names = Offline::names();
        assert!(
            ["contact", "tool", "sweeps", "device"].iter().all(|of| names.contains(&(*of).into()))
        );
    }
}
