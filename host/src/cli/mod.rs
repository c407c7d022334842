//! The command line: one file a command, shared arguments beside them.

mod bake;
mod command;
mod control;
mod cosim;
mod identify;
mod info;
mod inject;
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
mod soak;
mod stage;
mod state;
mod stress;

pub(crate) use scene::{automatic, contact_cells};
pub(crate) use session::inward;

use clap::{Parser, Subcommand};

use crate::error::Result;

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
    Soak(soak::Args),
    Report(report::Args),
    Paper(paper::Args),
    Stress(stress::Args),
    Identify(Box<identify::Args>),
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
            Work::Soak(args) => soak::execute(&args),
            Work::Report(args) => report::execute(&args),
            Work::Paper(args) => paper::execute(&args),
            Work::Stress(args) => stress::execute(&args),
            Work::Identify(args) => identify::execute(&args),
        }
    }
}
