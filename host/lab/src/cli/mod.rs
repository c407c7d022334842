//! The command line of the laboratory: one file a command.

mod identify;
mod page;
mod relaxation;
mod stress;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Command, CommandFactory, Parser, Subcommand};

use chaincell_host::cli::{completions, man, version};
use chaincell_host::error::{Error, Result};

/// Experiments with chaincell: measurements, comparisons, material identification.
#[derive(Debug, Parser)]
#[command(name = "chaincell-lab", version, long_version = version::long(), max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    Report(page::Report),
    Paper(page::Paper),
    Stress(stress::Args),
    Identify(Box<identify::Args>),
    Relaxation(relaxation::Args),
    #[command(hide = true)]
    Completions(completions::Args),
    #[command(hide = true)]
    Man(man::Args),
}

impl Cli {
    /// Carries the command out.
    ///
    /// # Errors
    /// What went wrong, with the exit code it stands for.
    pub fn execute(self) -> Result<()> {
        match self.command {
            Work::Report(args) => args.execute(),
            Work::Paper(args) => args.execute(),
            Work::Stress(args) => stress::execute(&args),
            Work::Identify(args) => identify::execute(&args),
            Work::Relaxation(args) => relaxation::execute(&args),
            Work::Completions(args) => completions::execute(whole(), &args),
            Work::Man(args) => man::execute(whole(), &args),
        }
    }
}

/// The command line of `chaincell` with the commands of the laboratory in it.
fn whole() -> Command {
    let own = Cli::command();
    let shown = own.get_subcommands().filter(|command| !command.is_hide_set());
    chaincell_host::cli::Cli::command().subcommands(shown.cloned())
}

/// The folder of reference data, where one is given or named by CHAINCELL_REFERENCE.
fn reference(given: Option<&Path>) -> Result<Option<PathBuf>> {
    let of_environment = || std::env::var_os("CHAINCELL_REFERENCE").map(PathBuf::from);
    let folder = given.map(Path::to_path_buf).or_else(of_environment);
    match &folder {
        Some(missing) if !missing.is_dir() => Err(Error::input(format!(
            "--reference {}: no such folder; leave it out (and CHAINCELL_REFERENCE unset) for a \
             generated organ",
            missing.display()
        ))),
        _ => Ok(folder),
    }
}

/// How an example or a bench ends: what went wrong goes to standard error.
pub fn exit_code(ended: Result<()>) -> ExitCode {
    ended.map_or_else(
        |why| {
            eprintln!("{why}");
            ExitCode::from(why.exit_code())
        },
        |()| ExitCode::SUCCESS,
    )
}

#[cfg(test)]
mod tests {
    use chaincell_host::cli::lab::COMMANDS;
    use clap::CommandFactory;

    #[test]
    fn chaincell_lists_every_command_with_its_line() {
        let command = super::Cli::command();
        let mut own: Vec<(String, String)> = command
            .get_subcommands()
            .filter(|of| !of.is_hide_set())
            .map(|of| (of.get_name().to_owned(), of.get_about().unwrap().to_string()))
            .collect();
        let mut listed = COMMANDS.map(|(name, about)| (name.to_owned(), about.to_owned()));
        own.sort();
        listed.sort();
        assert_eq!(own, listed);
    }
}
