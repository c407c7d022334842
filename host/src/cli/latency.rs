//! `chaincell latency`: how long a step takes at worst, alone and in the loop.

use std::path::PathBuf;

use chaincell_kernel::Model;
use serde::Serialize;

use super::load::Lengths;
use super::model_file;
use super::played::play;
use super::run::progress;
use super::session::{self, LoopArgs, tell_refused};
use super::shared::{DepthArgs, PrintArgs};
use super::sides::{self, Files, Sides};
use super::tissue::TissueArgs;
use crate::engine::motion::Pose;
use crate::error::{Error, Result};
use crate::files::path::Paths;
use crate::interrupt;
use crate::session::timing::cold::{self, ColdSteps};
use crate::session::timing::histogram::Summary;
use crate::terminal;
use crate::words::counted;

/// Steps of `--worst`.
const WORST_TICKS: u64 = 200;

/// Measure the worst-case step latency of a model, alone and over shared memory.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell latency liver.chaincell --sweeps 2 --wait spin\n\n\
    The step alone runs without a pause; the loop runs at 1 kHz in two processes. The floor is the\n\
    machine's own, in the same wait mode, just before.")]
pub struct Args {
    /// Model file from `chaincell bake`
    model: PathBuf,
    /// Length of each measurement [s]
    #[arg(long, default_value_t = 5.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    #[command(flatten)]
    depth: DepthArgs,
    /// Also time steps from the worst state with cold caches: positions scaled by 1.5, so that
    /// every link is out of its band, after reading twice the last-level cache
    #[arg(long)]
    worst: bool,
    #[command(flatten)]
    tissue: TissueArgs,
    #[command(flatten)]
    common: LoopArgs,
    #[command(flatten)]
    print: PrintArgs,
}

#[derive(Debug, Serialize)]
struct LatencySummary {
    cells: usize,
    links: usize,
    sweeps_per_tick: u16,
    ticks: u64,
    step_alone_ns: Summary,
    #[serde(skip_serializing_if = "Option::is_none")]
    worst_step_ns: Option<Summary>,
    #[serde(skip_serializing_if = "Option::is_none")]
    worst_streamed_bytes: Option<usize>,
    step_ns: Summary,
    round_trip_ns: Summary,
    floor_wakeup_ns: Summary,
    floor_round_trip_ns: Summary,
    ticks_answered: u64,
    missed_deadlines: u64,
    refused: Vec<String>,
}

pub fn execute(args: &Args) -> Result<()> {
    let lengths = Lengths::of_press(args.seconds)?;
    args.common.check()?;
    let image = model_file::read(&args.model)?;
    let model = model_file::parse(&image, &args.model)?;
    // On a thread of its own: one that sweeps with others stays on its processor, and so would the
    // programs that it starts.
    let (poses, alone, cold) = std::thread::scope(|scope| {
        let measured = scope.spawn(|| alone(args, model, lengths.press_ticks)).join();
        measured.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })?;
    let scratch = session::scratch()?;
    let files = Files { model: &args.model, scratch: scratch.path(), out: None };
    let sides = Sides::of(lengths, &args.tissue, &args.common);
    let session = sides::run(&files, &poses, &sides, |_| {})?;
    let (serve, control) = (session.reports.serve, session.reports.control);
    let summary = LatencySummary {
        cells: model.body_cells(),
        links: model.links(),
        sweeps_per_tick: args.tissue.given(&model).sweeps,
        ticks: control.ticks_sent,
        step_alone_ns: alone,
        worst_step_ns: cold.as_ref().map(|cold| cold.step),
        worst_streamed_bytes: cold.as_ref().map(|cold| cold.streamed_bytes),
        step_ns: serve.step_ns,
        round_trip_ns: control.round_trip_ns,
        floor_wakeup_ns: session.floor.wakeup_ns,
        floor_round_trip_ns: session.floor.run.round_trip_ns,
        ticks_answered: control.ticks_answered,
        missed_deadlines: control.missed_deadlines,
        refused: serve.refused,
    };
    print(args, &summary)?;
    if session.reports.interrupted {
        Err(Error::Interrupted)
    } else if summary.ticks_answered != summary.ticks {
        let ticks = counted(summary.ticks, "tick");
        Err(Error::check(format!("{} of {ticks} answered", summary.ticks_answered)))
    } else {
        Ok(())
    }
}

/// The press, the steps of it without a session, and with `--worst` those from the worst state.
fn alone(
    args: &Args,
    model: Model<'_>,
    ticks: u64,
) -> Result<(Vec<Pose>, Summary, Option<ColdSteps>)> {
    let mut tissue = args.tissue.staged(model, None)?;
    let poses = session::press(tissue.engine(), args.depth.depth_m, ticks)?;
    let paths = Paths::of(vec![poses]);
    let alone = play(&mut tissue, &paths, None, progress(&paths), |_, _, _, _| Ok(()))?;
    let poses = paths.poses.concat();
    interrupt::check()?;
    let cold =
        if args.worst { Some(cold::measure(tissue.engine_mut(), WORST_TICKS)?) } else { None };
    Ok((poses, alone.step.summary(), cold))
}

fn print(args: &Args, summary: &LatencySummary) -> Result<()> {
    if args.print.json {
        return terminal::say_json(summary);
    }
    tell_refused(&summary.refused);
    terminal::say(format_args!(
        "{}, {}, {} a tick, {}, {} later than 1 ms",
        counted(summary.cells, "cell"),
        counted(summary.links, "link"),
        counted(summary.sweeps_per_tick, "sweep"),
        counted(summary.ticks, "tick"),
        counted(summary.missed_deadlines, "answer")
    ))?;
    if let Some(step) = &summary.worst_step_ns {
        session::tell_latencies(&[("worst step, cold", step)])?;
    }
    session::tell_latencies(&[
        ("step alone", &summary.step_alone_ns),
        ("step in the loop", &summary.step_ns),
        ("round trip", &summary.round_trip_ns),
        ("floor: round trip", &summary.floor_round_trip_ns),
        ("floor: wake-up", &summary.floor_wakeup_ns),
    ])
}
