//! The command line of the laboratory: one file a command.

mod identify;
mod paper;
mod report;
mod soak;
mod stress;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use chaincell_host::error::Result;

/// Experiments with chaincell: measurements, comparisons, material identification.
#[derive(Debug, Parser)]
#[command(name = "chaincell-lab", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    Report(report::Args),
    Paper(paper::Args),
    Stress(stress::Args),
    Soak(soak::Args),
    Identify(Box<identify::Args>),
}

impl Cli {
    /// Carries the command out.
    ///
    /// # Errors
    /// What went wrong, with the exit code it stands for.
    pub fn execute(self) -> Result<()> {
        match self.command {
            Work::Report(args) => report::execute(&args),
            Work::Paper(args) => paper::execute(&args),
            Work::Stress(args) => stress::execute(&args),
            Work::Soak(args) => soak::execute(&args),
            Work::Identify(args) => identify::execute(&args),
        }
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
            .map(|of| (of.get_name().to_owned(), of.get_about().unwrap().to_string()))
            .collect();
        let mut listed = COMMANDS.map(|(name, about)| (name.to_owned(), about.to_owned()));
        own.sort();
        listed.sort();
        assert_eq!(own, listed);
    }
}
