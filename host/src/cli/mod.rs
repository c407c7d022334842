//! The command line: one file a command, shared arguments beside them.

mod bake;
mod control;
mod cosim;
mod info;
mod latency;
mod model_file;
mod paper;
mod replay;
mod report;
mod reports;
mod run;
mod scene;
mod serve;
mod session;

pub(crate) use scene::automatic;
pub(crate) use session::inward;

use clap::{Parser, Subcommand};

use crate::error::Result;

/// Soft tissue that a haptic device can feel: bake a mesh, run it offline, serve it at 1 kHz.
#[derive(Debug, Parser)]
#[command(name = "chaincell", version, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Bake(bake::Args),
    Info(info::Args),
    Run(run::Args),
    Replay(replay::Args),
    Serve(serve::Args),
    Control(control::Args),
    Cosim(cosim::Args),
    Latency(latency::Args),
    Report(report::Args),
    Paper(paper::Args),
}

impl Cli {
    /// Carries the command out.
    ///
    /// # Errors
    /// What went wrong, with the exit code it stands for.
    pub fn execute(self) -> Result<()> {
        match self.command {
            Command::Bake(args) => bake::execute(&args),
            Command::Info(args) => info::execute(&args),
            Command::Run(args) => run::execute(&args),
            Command::Replay(args) => replay::execute(&args),
            Command::Serve(args) => serve::execute(&args),
            Command::Control(args) => control::execute(&args),
            Command::Cosim(args) => cosim::execute(&args),
            Command::Latency(args) => latency::execute(&args),
            Command::Report(args) => report::execute(&args),
            Command::Paper(args) => paper::execute(&args),
        }
    }
}
