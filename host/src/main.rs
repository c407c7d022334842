//! The `chaincell` command.

use std::process::ExitCode;

use chaincell_host::cli::{Cli, process};
use clap::Parser;

fn main() -> ExitCode {
    process("chaincell", || Cli::parse().execute())
}
