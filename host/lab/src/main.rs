//! The `chaincell-lab` command.

use std::process::ExitCode;

use chaincell_host::cli::{options, process};
use chaincell_lab::cli::Cli;
use clap::{CommandFactory, FromArgMatches};

fn main() -> ExitCode {
    process(Cli::command(), || match Cli::from_arg_matches(&options::read(Cli::command())) {
        Ok(cli) => cli.execute(),
        Err(why) => why.exit(),
    })
}
