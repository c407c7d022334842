//! The `chaincell` command.

use std::process::ExitCode;

use chaincell_host::cli::{Cli, process};
use clap::CommandFactory;

fn main() -> ExitCode {
    process(Cli::command(), Cli::run)
}
