//! The `chaincell-lab` command.

use std::process::ExitCode;

use chaincell_host::cli::process;
use chaincell_lab::cli::Cli;
use clap::{CommandFactory, Parser};

fn main() -> ExitCode {
    process(Cli::command(), || Cli::parse().execute())
}
