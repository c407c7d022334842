//! The `chaincell` command.

use std::process::ExitCode;

use chaincell_host::cli::{Cli, process};

fn main() -> ExitCode {
    process(Cli::run)
}
