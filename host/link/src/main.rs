//! `chaincell-link`: options of both sides.

use std::io::{self, BufWriter, IsTerminal};
use std::path::PathBuf;
use std::process::ExitCode;

use chaincell_host::cli::process;
use chaincell_host::error::{Error, Result};
use chaincell_host::remote::frame::Ask;
use chaincell_host::remote::place::Place;
use chaincell_link::message::Keys;
use chaincell_link::receive::receive;
use chaincell_link::send::send;
use chaincell_link::settings::Settings;
use clap::{CommandFactory, Parser, Subcommand};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

/// Carry a session to many followers over zenoh.
#[derive(Debug, Parser)]
#[command(
    name = "chaincell-link",
    version,
    max_term_width = 100,
    after_help = "Examples:\n  \
    chaincell-link send session --name left\n  \
    chaincell follow --scene far -- chaincell-link receive left\n\n\
    A receiver writes the stream of `chaincell mirror` to standard output. Of what was lost on the way it asks the\n\
    sender, which reads the trace; the session does not wait for it. Nothing but this machine is reached unless --listen,\n\
    --connect or --config says so: discovery is off, and nothing is encrypted. --config has both, in zenoh's format."
)]
struct Cli {
    #[command(subcommand)]
    work: Work,
}

#[derive(Debug, Subcommand)]
enum Work {
    Send(SendArgs),
    Receive(ReceiveArgs),
}

/// Publish a session while it is recorded, and answer receivers until Ctrl-C
#[derive(Debug, clap::Args)]
struct SendArgs {
    /// Trace of `serve`, `cosim` or `run`, which may still be written, the folder of such a run, or the scene of a
    /// server that records
    #[arg(value_name = "SESSION")]
    session: PathBuf,
    /// Name by which receivers ask for the session
    #[arg(long, value_name = "NAME")]
    name: String,
    /// Model file of the session, for receivers that have none [default: model.chaincell beside the trace]
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Listen here; may stand several times [default: tcp/127.0.0.1:7447, or nowhere with --connect]
    #[arg(long, value_name = "ENDPOINT")]
    listen: Vec<String>,
    /// Let it be another address than this machine's own: anyone who reaches it may read the session
    #[arg(long, requires = "listen")]
    open_to_network: bool,
    /// Connect to this router; may stand several times
    #[arg(long, value_name = "ENDPOINT")]
    connect: Vec<String>,
    /// Configuration of zenoh (JSON5): certificates, access control, discovery
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
}

/// Write a session to standard output, as `chaincell mirror` does
#[derive(Debug, clap::Args)]
struct ReceiveArgs {
    /// Name of the session
    #[arg(value_name = "NAME")]
    name: String,
    /// Connect to this sender or router; of several the first that is there [default: tcp/127.0.0.1:7447]
    #[arg(long, value_name = "ENDPOINT")]
    connect: Vec<String>,
    /// Configuration of zenoh (JSON5): certificates, access control, discovery
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// The place where a follower goes on after a cut; `chaincell follow` adds it
    #[arg(long, value_name = "SEAL:RECORD", value_parser = Ask::goes_on_of)]
    goes_on: Option<(u32, u32)>,
    /// Checksum of the model that a follower has; `chaincell follow` adds it
    #[arg(long, value_name = "CHECKSUM", value_parser = Ask::model_of)]
    has_model: Option<u32>,
    /// Write records packed; `chaincell follow` adds it
    #[arg(long)]
    packed: bool,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    process(Cli::command(), || match &cli.work {
        Work::Send(args) => execute_send(args),
        Work::Receive(args) => execute_receive(args),
    })
}

fn execute_send(args: &SendArgs) -> Result<()> {
    let place = Place::find(&args.session, args.model.clone())?;
    let settings = Settings {
        listen: args.listen.clone(),
        connect: args.connect.clone(),
        config: args.config.clone(),
        is_open: args.open_to_network,
    };
    send(&place, &Keys::new(&args.name)?, &settings.sender()?)
}

fn execute_receive(args: &ReceiveArgs) -> Result<()> {
    let (connect, config) = (args.connect.clone(), args.config.clone());
    let settings = Settings { connect, config, ..Settings::default() };
    let out = io::stdout();
    if out.is_terminal() {
        return Err(Error::input(
            "standard output is a terminal, and a receiver writes bytes: give it to chaincell follow as a program, \
             behind --",
        ));
    }
    let ask = Ask { goes_on: args.goes_on, model: args.has_model, packed: args.packed };
    let mut buffered = BufWriter::new(out.lock());
    receive(&Keys::new(&args.name)?, &settings.receiver()?, &ask, &mut buffered, is_gone)
}

/// Returns true if nobody reads standard output any more.
fn is_gone() -> bool {
    let out = io::stdout();
    let mut outs = [PollFd::new(&out, PollFlags::empty())];
    let now = Timespec { tv_sec: 0, tv_nsec: 0 };
    poll(&mut outs, Some(&now)).is_ok()
        && outs[0].revents().intersects(PollFlags::ERR | PollFlags::HUP)
}
