//! `chaincell follow`: runs the tissue of a session from its records, in another place.

use std::net::ToSocketAddrs;
use std::path::{Path, PathBuf};

use chaincell_kernel::trace::{Command, CommandRecord, Reader};

use super::model_file;
use super::shared::PrintArgs;
use super::watch::ServerWait;
use crate::bake::ImageBytes;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::error::{Error, Result};
use crate::files::recording::{self, Recording, Step, TraceFile};
use crate::files::snapshot::start_place;
use crate::files::whole::write_whole;
use crate::remote::follow::{FollowReport, Follower, Joined, Told, join};
use crate::remote::intake::Intake;
use crate::remote::way::{Input, Local, Program, Tcp, Way};
use crate::session::ipc;
use crate::session::ipc::services::Domain;
use crate::session::ipc::shown::ShowPorts;
use crate::session::timing::clock::{SECOND_NS, now_ns, span_ns};
use crate::terminal;
use crate::words::counted;

/// Begins the address of a mirror that listens.
const TCP: &str = "tcp:";
/// Ticks that --record has room for: ten minutes.
const RECORD_TICKS: usize = 600_000;

/// Run the tissue of a session in another place, from its records, and compare the state after every tick.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  chaincell follow --scene far -- ssh theatre chaincell mirror session\n  \
    chaincell follow tcp:127.0.0.1:7100 --scene far\n  \
    chaincell follow session --json\n\n\
    With --scene, `view`, `state`, `contacts` and any other viewer see the tissue as that of a server. After a cut of\n\
    any length it asks for what it missed. It runs beside the session, never ahead of it. `serve --stand-by SESSION`\n\
    follows too, and takes over from a server that is killed.\n\n\
    Exit code 0 when the recording has ended and every tick gave the recorded bits, 1 when one differs (the first\n\
    is named), 2 when the session cannot be followed."
)]
pub struct Args {
    /// Trace, folder or scene of a session on this machine, `tcp:ADDRESS:PORT` of a mirror that listens, or `-`
    /// for standard input
    #[arg(value_name = "SOURCE", required_unless_present = "program", conflicts_with = "program")]
    source: Option<String>,
    /// Program whose standard output is that of `chaincell mirror`, behind `--`; it is started again after a cut
    #[arg(last = true, value_name = "PROGRAM")]
    program: Vec<String>,
    /// Model file of the session, which the mirror then does not send
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Show the tissue to viewers on this scene
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// Largest rate at which viewers get states and contacts [Hz]
    #[arg(
        long,
        default_value_t = 60,
        value_name = "HZ",
        allow_negative_numbers = true,
        requires = "scene"
    )]
    state_hz: u32,
    /// Record the followed session in this file, for `chaincell replay` and further followers
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Overwrite an earlier trace
    #[arg(long, requires = "record")]
    force: bool,
    /// Ticks that --record has room for, 48 bytes of the disk each, and as many for each tool
    #[arg(long, value_name = "N", default_value_t = RECORD_TICKS, requires = "record")]
    record_ticks: usize,
    #[command(flatten)]
    server: ServerWait,
    #[command(flatten)]
    print: PrintArgs,
}

pub fn execute(args: &Args) -> Result<()> {
    args.server.check()?;
    // Open what is here before anything is asked for.
    let own = args.model.as_deref().map(model_file::read).transpose()?;
    let own_path = args.model.clone().unwrap_or_default();
    let own_checksum = match &own {
        Some(image) => Some(model_file::parse(image, &own_path)?.checksum()),
        None => None,
    };
    if let Some(path) = &args.record {
        recording::check_place("--record", path, args.force)?;
    }
    // Join, and build the tissue where the session begins.
    let mut intake = Intake::new(way(args)?);
    let waits_s = if comes_later(args) { args.server.wait_for_server_s } else { 0.0 };
    let end_ns = now_ns().saturating_add(span_ns("`wait_for_server_s`", waits_s)?);
    let label = PathBuf::from(args.source.clone().unwrap_or_else(|| args.program.join(" ")));
    let mut joined = join(&mut intake, own_checksum, end_ns).map_err(|why| match why {
        Error::Input(why) => Error::input(format!("cannot follow {}: {why}", label.display())),
        other => other,
    })?;
    let (image, model_path) = match (own, joined.image.take()) {
        (Some(image), _) => (image, own_path),
        (None, Some(image)) => (image, label.clone()),
        (None, None) => return Err(Error::input("the mirror sent no model: name it with --model")),
    };
    let mut tissue = tissue(&joined, &image, &label, &model_path)?;
    let trace =
        args.record.as_deref().map(|path| record(args, path, &joined, &mut tissue)).transpose()?;
    let show = args.scene.as_deref().map(|scene| {
        let scene = ipc::open(Some(scene), &Domain::default())?;
        ShowPorts::open(&scene, tissue.engine_mut(), args.state_hz)
    });
    // Follow.
    let mut tell = Teller {
        json: args.print.json,
        trace,
        with_poses: tissue.tools() > 0,
        left_out: 0,
        line_ns: 0,
        begun: false,
    };
    let mut follower = Follower::new(intake, &joined, &mut tissue, show.transpose()?)?;
    let ended = follower.run(joined, |_, told| tell.hear(told));
    let mut report = follower.report();
    let same = follower.check_same(&label);
    drop(follower);
    let finished = tell.trace.take().map_or(Ok(()), TraceFile::finish);
    // Report and judge.
    report.ticks_unrecorded = tell.left_out;
    print(args, &report)?;
    finished?;
    ended?;
    same
}

/// True for a mirror that listens and for a file, which may come later.
fn comes_later(args: &Args) -> bool {
    args.source.as_ref().is_some_and(|source| source != "-")
}

/// How the bytes come.
fn way(args: &Args) -> Result<Box<dyn Way>> {
    let Some(source) = &args.source else {
        return Ok(Box::new(Program::new(args.program.clone())));
    };
    if source == "-" {
        return Ok(Box::new(Input));
    }
    let Some(address) = source.strip_prefix(TCP) else {
        return Ok(Box::new(Local::Named(source.into())));
    };
    let addresses = address.to_socket_addrs();
    let first = addresses.map_err(|why| Error::input(format!("{source}: {why}")))?.next();
    first
        .map(|address| Box::new(Tcp::new(address)) as Box<dyn Way>)
        .ok_or_else(|| Error::input(format!("{source}: no such address")))
}

/// The tissue of a session, in the state of its start.
fn tissue<'m>(
    joined: &Joined,
    image: &'m ImageBytes,
    label: &Path,
    model_path: &Path,
) -> Result<Staged<'m>> {
    let trace = Reader::open(&joined.begun).map_err(|why| Error::file("follow", label, why))?;
    let model = model_file::parse(image, model_path)?;
    let (mut tissue, _, _) = recording::tissue(&trace, label, model)?;
    if let Some(begin) = &joined.start {
        if begin.snapshot.begun != joined.begun {
            let why = "its snapshot is of another session: take a new one";
            return Err(Error::file("follow", label, why));
        }
        tissue.restore(&begin.snapshot.saved)?;
    }
    Ok(tissue)
}

/// Begins the trace of what is followed.
fn record(args: &Args, path: &Path, joined: &Joined, tissue: &mut Staged<'_>) -> Result<TraceFile> {
    let refused = || Error::file("record", path, "the session's header does not fit this release");
    let begun = Reader::open(&joined.begun).ok().and_then(|trace| Recording::again(&trace));
    let records = args.record_ticks.saturating_mul(tissue.tools() + 1).saturating_add(1);
    let mut trace =
        TraceFile::create("--record", path, args.force, begun.ok_or_else(refused)?, records)?;
    if let Some(begin) = &joined.start {
        write_whole(&start_place(path), &begin.snapshot.to_bytes().0)?;
        let (command, state_hash) =
            (Command::Snapshot { checksum: begin.checksum }, Some(tissue.state_hash()));
        trace.add_command(&CommandRecord { tick: begin.snapshot.tick, command, state_hash });
    }
    Ok(trace)
}

/// Records the steps of the follower, and prints a line a second.
struct Teller {
    json: bool,
    trace: Option<TraceFile>,
    /// True if its ticks have poses of tools.
    with_poses: bool,
    left_out: u64,
    line_ns: u64,
    begun: bool,
}

impl Teller {
    fn hear(&mut self, told: Told<'_>) -> Result<()> {
        match told {
            Told::Step(step) => self.add(step),
            Told::Cut(why) => {
                terminal::note(format_args!("note: cut off from the session: {why}; trying again"));
            }
            Told::Again => terminal::note("note: connected again"),
            Told::Look { tick, lag_ticks, hashes_compared } => {
                if !self.begun {
                    self.begun = true;
                    terminal::say("ready")?;
                }
                if !self.json && now_ns() >= self.line_ns {
                    self.line_ns = now_ns() + SECOND_NS;
                    terminal::say(format_args!(
                        "tick {tick}, {} behind, {hashes_compared} state hashes equal",
                        counted(lag_ticks, "tick"),
                    ))?;
                }
            }
        }
        Ok(())
    }

    fn add(&mut self, step: Step<'_>) {
        let Some(trace) = self.trace.as_mut().filter(|_| self.left_out == 0) else {
            self.left_out += u64::from(self.trace.is_some());
            return;
        };
        let is_added = match step {
            Step::Tick { record, poses, .. } => {
                let poses = if self.with_poses { poses } else { &[] };
                trace.add_tools(record, poses)
            }
            Step::Command(record) => trace.add_command(record),
        };
        self.left_out += u64::from(!is_added);
    }
}

fn print(args: &Args, report: &FollowReport) -> Result<()> {
    let left_out = report.ticks_unrecorded;
    if left_out > 0 {
        terminal::note(format_args!(
            "note: {left_out} ticks and commands did not fit into the trace; pass a larger --record-ticks"
        ));
    }
    if args.print.json {
        return terminal::say_json(report);
    }
    if report.was_killed {
        terminal::note(
            "note: the session has no end: its server was killed, or the trace is a part of it",
        );
    }
    let cuts = counted(report.cuts, "cut");
    terminal::say(format_args!(
        "{} followed, {} state hashes equal, {cuts}, at most {} behind",
        counted(report.ticks, "tick"),
        report.hashes_compared,
        counted(report.largest_lag_ticks, "tick"),
    ))?;
    terminal::say(format_args!("  {:<14}{}", "state hash", report.state_hash))
}
