//! The command line: one file a command, shared arguments beside them.

mod bake;
mod command;
mod control;
mod cosim;
mod info;
mod inject;
mod latency;
pub mod model_file;
mod replay;
pub mod reports;
mod run;
pub mod scene;
mod serve;
pub mod session;
mod stage;
mod state;

pub use bake::BodyArgs;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::error::{Error, Result};
use crate::{interrupt, terminal};

/// The life of a command: logs are set up, Ctrl-C is caught, an error is printed and becomes the
/// exit code. `name` is the command that the error message begins with.
pub fn process(name: &str, execute: impl FnOnce() -> Result<()>) -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::new().filter_or("CHAINCELL_LOG", "warn"))
        .format_timestamp(None)
        .init();
    match interrupt::install().and_then(|()| execute()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            if !matches!(why, Error::Reported(_)) {
                terminal::note(format_args!("{name}: {why}"));
            }
            ExitCode::from(why.exit_code())
        }
    }
}

/// Soft tissue that a haptic device can feel: bake a mesh, run it offline, serve it at 1 kHz.
#[derive(Debug, Parser)]
#[command(name = "chaincell", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    Bake(bake::Args),
    Info(info::Args),
    Run(run::Args),
    Replay(replay::Args),
    Serve(serve::Args),
    Control(control::Args),
    State(state::Args),
    Command(command::Args),
    Cosim(cosim::Args),
    Latency(latency::Args),
}

impl Cli {
    /// Carries the command out.
    ///
    /// # Errors
    /// What went wrong, with the exit code it stands for.
    pub fn execute(self) -> Result<()> {
        match self.command {
            Work::Bake(args) => bake::execute(&args),
            Work::Info(args) => info::execute(&args),
            Work::Run(args) => run::execute(&args),
            Work::Replay(args) => replay::execute(&args),
            Work::Serve(args) => serve::execute(&args),
            Work::Control(args) => control::execute(&args),
            Work::State(args) => state::execute(&args),
            Work::Command(args) => command::execute(&args),
            Work::Cosim(args) => cosim::execute(&args),
            Work::Latency(args) => latency::execute(&args),
        }
    }
}
