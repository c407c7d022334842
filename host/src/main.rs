//! The `chaincell` command.

use std::process::ExitCode;

use chaincell_host::cli::Cli;
use chaincell_host::{interrupt, terminal};
use clap::Parser;

fn main() -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::new().filter_or("CHAINCELL_LOG", "warn"))
        .format_timestamp(None)
        .init();
    let cli = Cli::parse();
    match interrupt::install().and_then(|()| cli.execute()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            terminal::note(format_args!("chaincell: {why}"));
            ExitCode::from(why.exit_code())
        }
    }
}
