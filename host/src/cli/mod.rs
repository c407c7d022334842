//! The command line: one file a command, shared arguments beside them.

mod account;
mod admits;
mod bake;
mod batch;
mod browser;
mod budget;
mod check;
pub mod choice;
mod command;
pub mod completions;
mod contacts;
mod control;
mod convert;
mod cosim;
mod cosim_body;
mod cosim_replay;
mod cosim_view;
mod filled;
mod follow;
mod gathered;
mod info;
mod inject;
mod judgement;
pub mod lab;
mod latency;
mod load;
pub mod man;
mod mesh_file;
mod mirror;
pub mod model_file;
pub mod offline;
pub mod options;
mod picture;
mod pins;
mod played;
mod press;
mod probe;
mod record;
mod recorded;
mod relaxation;
mod replay;
pub mod reports;
mod restore;
mod run;
mod serve;
pub mod session;
mod settings;
mod shared;
mod sides;
mod snapshots;
mod stage;
mod stand_by;
mod state;
mod stress;
pub mod tissue;
mod tissue_texts;
mod tissues;
pub mod tool;
pub mod values;
mod verdict;
pub mod version;
mod view;
mod watch;

pub use bake::BodyArgs;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Command, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::error::{Error, Result};
use crate::input;
use crate::interrupt;
use crate::terminal;

/// The life of a command: logs are set up, Ctrl-C is caught, an error is printed and becomes the
/// exit code. `command` is the command line, whose options the error names.
pub fn process(command: Command, execute: impl FnOnce() -> Result<()>) -> ExitCode {
    env_logger::Builder::from_env(env_logger::Env::new().filter_or("CHAINCELL_LOG", "warn"))
        .format_timestamp(None)
        .init();
    input::begin();
    match interrupt::install().and_then(|()| execute()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            if !matches!(why, Error::Reported(_)) {
                let why_named = options::named(&why.to_string(), &[command, Cli::command()]);
                terminal::note(format_args!("{}: {why_named}", own_name()));
            }
            ExitCode::from(why.exit_code())
        }
    }
}

/// The name that this process was started under.
fn own_name() -> String {
    let path = std::env::args_os().next().map(PathBuf::from).unwrap_or_default();
    path.file_name().map_or_else(|| "chaincell".into(), |name| name.to_string_lossy().into_owned())
}

/// Soft tissue that a haptic device can feel: bake a mesh, run it offline, serve it at 1 kHz.
#[derive(Debug, Parser)]
#[command(name = "chaincell", version, long_version = version::long(), max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    Bake(bake::Args),
    Tissues(tissues::Args),
    Check(check::Args),
    Convert(convert::Args),
    Info(info::Args),
    Run(batch::Args),
    Picture(picture::Args),
    Replay(replay::Args),
    Serve(serve::Args),
    Control(control::Args),
    State(state::Args),
    Contacts(contacts::Args),
    Command(command::Args),
    Cosim(cosim::Args),
    Latency(latency::Args),
    Mirror(mirror::Args),
    Follow(follow::Args),
    View(view::Args),
    Completions(completions::Args),
    Man(man::Args),
}

impl Cli {
    /// Reads the command line and carries it out; a command of the laboratory is handed over.
    ///
    /// # Errors
    /// The error, with its exit code.
    pub fn run() -> Result<()> {
        let words: Vec<OsString> = std::env::args_os().skip(1).collect();
        if let Some(ended) = sides::execute(&words) {
            return ended;
        }
        lab::hand_over()?;
        let matches = options::read(lab::listed(Self::command()));
        match Self::from_arg_matches(&matches) {
            Ok(cli) => cli.execute(),
            Err(why) => why.exit(),
        }
    }

    fn execute(self) -> Result<()> {
        match self.command {
            Work::Bake(args) => bake::execute(&args),
            Work::Tissues(args) => tissues::execute(&args),
            Work::Check(args) => check::execute(&args),
            Work::Convert(args) => convert::execute(&args),
            Work::Info(args) => info::execute(&args),
            Work::Run(args) => batch::execute(&args),
            Work::Picture(args) => picture::execute(&args),
            Work::Replay(args) => replay::execute(&args),
            Work::Serve(args) => serve::execute(&args),
            Work::Control(args) => control::execute(&args),
            Work::State(args) => state::execute(&args),
            Work::Contacts(args) => contacts::execute(&args),
            Work::Command(args) => command::execute(&args),
            Work::Cosim(args) => cosim::execute(&args),
            Work::Latency(args) => latency::execute(&args),
            Work::Mirror(args) => mirror::execute(&args),
            Work::Follow(args) => follow::execute(&args),
            Work::View(args) => view::execute(&args),
            Work::Completions(args) => completions::execute(lab::listed(Self::command()), &args),
            Work::Man(args) => man::execute(lab::listed(Self::command()), &args),
        }
    }
}
