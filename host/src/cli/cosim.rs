//! `chaincell cosim`: the main job, both processes side by side and the replay that checks them.

use std::path::{Path, PathBuf};

use chaincell_kernel::trace::Reader;
use serde::Serialize;

use super::budget::BudgetArgs;
use super::inject::{InjectArgs, tell_injected};
use super::model_file;
use super::press::ticks;
use super::run::play;
use super::session::{self, Files, LoopArgs, Session, Sides, tell_refused};
use super::stage::{StageArgs, StageReport};
use super::tissue::{TissueArgs, TissueReport};
use super::verdict::{Counts, Verdict, VerdictArgs};
use crate::bake::organ;
use crate::engine::flag_ticks::FlagTicks;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::untouched::Untouched;
use crate::error::{Error, Result};
use crate::files::output::Folder;
use crate::files::path::{self, Rules};
use crate::files::recording::{self, Played, Start, Stop};
use crate::files::tools_path::Paths;
use crate::files::whole::write_whole;
use crate::interrupt;
use crate::session::loops::inject::Injected;
use crate::session::loops::peers::PeerCost;
use crate::session::loops::record::Recorder;
use crate::session::loops::serve::{Ending, SweepBudget, SweepCounts};
use crate::session::timing::clock::PERIOD_NS;
use crate::session::timing::histogram::Summary;
use crate::terminal;
use crate::words::counted;

/// Run tissue and controller as two processes at 1 kHz, then replay what was received.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell cosim\n  \
    chaincell cosim liver.chaincell --contact cells:file:liver.sets.json#patch --out session\n\n\
    Exit code 0 when every tick was answered and the replay gave the same state hash, else 1.")]
pub struct Args {
    /// Model file from `chaincell bake` [default: organ:1000, 5 kPa, Poisson's ratio 0.45]
    model: Option<PathBuf>,
    /// Length of the press [s]
    #[arg(long, default_value_t = 10.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    /// Depth of the press [m] [default: 3 mean link lengths]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    depth_m: Option<f64>,
    #[command(flatten)]
    tissue: TissueArgs,
    #[command(flatten)]
    common: LoopArgs,
    #[command(flatten)]
    budget: BudgetArgs,
    #[command(flatten)]
    verdict: VerdictArgs,
    #[command(flatten)]
    stage: StageArgs,
    #[command(flatten)]
    inject: InjectArgs,
    /// Folder for the model, the poses as received, the forces, a trace and a summary
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite the results of an earlier run in --out
    #[arg(long)]
    force: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What is printed and written to summary.json.
#[derive(Debug, Serialize)]
struct CosimSummary {
    cells: usize,
    links: usize,
    ticks_sent: u64,
    ticks_answered: u64,
    ticks_unanswered: u64,
    missed_deadlines: u64,
    ticks_late: u64,
    poses_missing: u64,
    overloads: u64,
    sweeps: SweepCounts,
    budget_us: SweepBudget,
    flag_ticks: FlagTicks,
    step_ns: Summary,
    round_trip_ns: Summary,
    floor_wakeup_ns: Summary,
    floor_round_trip_ns: Summary,
    send_late_ns: Summary,
    peers: PeerCost,
    poses_throttled: u64,
    largest_force_step_n: f32,
    injected: Option<Injected>,
    state_hash: String,
    replay_state_hash: String,
    interrupted: bool,
    /// Sides that did not end by themselves in time and were stopped, though nobody interrupted.
    stopped: Vec<&'static str>,
    refused: Vec<String>,
    #[serde(flatten)]
    tissue: TissueReport,
    stage: Option<StageReport>,
    /// How near the tool came that never touched the body.
    never_touched: Option<Untouched>,
    verdict: Verdict,
}

pub fn execute(args: &Args) -> Result<()> {
    let ticks = ticks(args.seconds)?;
    let faults = args.inject.faults()?;
    args.common.check()?;
    let scratch = session::scratch()?;
    let (image, model_path) = match &args.model {
        Some(path) => (model_file::read(path)?, path.clone()),
        None => (organ()?, scratch.path().join("organ.chaincell")),
    };
    let model = model_file::parse(&image, &model_path)?;
    let mut tissue = args.tissue.staged(model, args.stage.settings()?)?;
    let poses = session::press(tissue.engine(), args.depth_m, ticks)?;
    let out = args.out.clone().unwrap_or_else(|| scratch.path().join("out"));
    // Earlier results are not removed for a session that is refused or has no room.
    args.budget.of(tissue.engine())?;
    Folder::check_room(&out, Recorder::trace_records_of(poses.len(), tissue.tools()))?;
    let folder = Folder::open(&out, args.force)?;
    if args.model.is_none() {
        write_whole(&model_path, image.as_bytes())?;
    }
    if !args.json {
        terminal::say(format_args!(
            "{}: {}, {} s at 1 kHz",
            args.model.as_ref().map_or("organ".into(), |path| path.display().to_string()),
            session::describe(&model),
            args.seconds
        ))?;
    }
    let files = Files { model: &model_path, scratch: scratch.path(), out: Some(&out) };
    let mut serve_args = args.tissue.to_args();
    serve_args.extend(args.stage.to_args());
    serve_args.extend(args.budget.to_args());
    let sides = Sides { serve_args, control_args: args.inject.to_args(), faults };
    let session = session::run(&files, &poses, sides, &args.common)?;
    // Of several tools the trace alone has all bits.
    let by_path = session.reports.serve.commands_done == 0 && tissue.tools() == 0;
    let replayed = if by_path {
        replay(&mut tissue, &folder.file("path.csv"))?
    } else {
        let (hash, has_touched) = replay_trace(&mut tissue, &folder.file(recording::TRACE))?;
        let poses = path::read(&folder.file("path.csv"), Rules::Recorded)?.concat();
        (hash, Untouched::of(tissue.engine(), &poses, has_touched))
    };
    let summary = summary(args, &tissue, session, replayed)?;
    folder.write_json("summary.json", &summary)?;
    print(args, &summary)?;
    judge(args, &summary)
}

/// State hash after the poses as received, played once more without shared memory, and how near a
/// tool came that never touched.
fn replay(tissue: &mut Staged<'_>, received: &Path) -> Result<(String, Option<Untouched>)> {
    let nothing_received =
        std::fs::metadata(received).is_ok_and(|file| file.len() == path::HEADER.len() as u64 + 1);
    let mut never_touched = None;
    if !nothing_received {
        let poses = Paths::of(path::read(received, Rules::Recorded)?);
        let mut executed = Vec::new();
        // An interrupted session is short and checked like any other.
        let played = interrupt::ignoring(|| {
            play(tissue, &poses, |pose, _, _, _| {
                executed.push(*pose);
                Ok(())
            })
        })?;
        never_touched = Untouched::of(tissue.engine(), &executed, played.has_touched());
    }
    Ok((format!("{:016x}", tissue.state_hash()), never_touched))
}

/// As [`replay`], of a session with tools or commands, which only the trace has in full. Also returns whether the
/// first tool had a contact.
fn replay_trace(tissue: &mut Staged<'_>, path: &Path) -> Result<(String, bool)> {
    let bytes = recording::read(path)?;
    let trace = Reader::open(&bytes).map_err(|why| Error::file("replay", path, why))?;
    let mut played = Played::default();
    match recording::play(&trace, tissue, Start::default(), &mut played) {
        Ok(_) => Ok((format!("{:016x}", tissue.state_hash()), played.has_touched)),
        Err(Stop::Differs(why)) => Err(Error::check(format!("{}: {why}", path.display()))),
        Err(why @ Stop::Command(_)) => Err(Error::check(format!("{}: {why:?}", path.display()))),
    }
}

fn summary(
    args: &Args,
    tissue: &Staged<'_>,
    session: Session,
    (replay_state_hash, never_touched): (String, Option<Untouched>),
) -> Result<CosimSummary> {
    let model = tissue.engine().network().model();
    let Session { reports, floor } = session;
    let verdict = args.verdict.judge(Counts {
        answers: reports.control.ticks_answered,
        late: reports.control.missed_deadlines,
        unanswered: reports.control.ticks_unanswered,
        floor_share: floor.floor_late_share,
        ..Counts::of_tissue(&reports.serve, args.tissue.sweeps, tissue.engine())
    });
    let (serve, control) = (reports.serve, reports.control);
    let ended_early =
        [("serve", serve.ended_by == Ending::Interrupt), ("control", control.interrupted)];
    let stopped = ended_early.into_iter().filter(|(_, early)| *early && !reports.interrupted);
    let stopped = stopped.map(|(side, _)| side);
    let mut refused = serve.refused;
    refused.extend(control.refused);
    refused.sort();
    refused.dedup();
    Ok(CosimSummary {
        cells: model.cells(),
        links: model.links(),
        ticks_sent: control.ticks_sent,
        ticks_answered: control.ticks_answered,
        ticks_unanswered: control.ticks_unanswered,
        missed_deadlines: control.missed_deadlines,
        ticks_late: serve.ticks_late,
        poses_missing: serve.poses_missing,
        overloads: serve.overloads,
        sweeps: serve.sweeps,
        budget_us: serve.budget_us,
        flag_ticks: serve.flag_ticks,
        step_ns: serve.step_ns,
        round_trip_ns: control.round_trip_ns,
        floor_wakeup_ns: floor.floor_wakeup_ns,
        floor_round_trip_ns: floor.floor_round_trip_ns,
        send_late_ns: control.send_late_ns,
        peers: serve.peers,
        poses_throttled: serve.poses_throttled,
        largest_force_step_n: control.largest_force_step_n,
        injected: control.injected,
        state_hash: serve.state_hash,
        replay_state_hash,
        interrupted: reports.interrupted,
        stopped: stopped.collect(),
        refused,
        tissue: args.tissue.report(tissue.engine()),
        stage: args.stage.report()?,
        never_touched,
        verdict,
    })
}

fn print(args: &Args, summary: &CosimSummary) -> Result<()> {
    if args.json {
        return terminal::say_json(summary);
    }
    tell_refused(&summary.refused);
    terminal::say(format_args!(
        "{} of {} answered, {} later than 1 ms after the scheduled send",
        summary.ticks_answered,
        counted(summary.ticks_sent, "tick"),
        summary.missed_deadlines
    ))?;
    terminal::say(format_args!("  {:<18}{}", "flags", summary.flag_ticks))?;
    if let Some(untouched) = &summary.never_touched {
        terminal::say(format_args!("  {:<18}{untouched}", "contact"))?;
    }
    session::tell_latencies(&[
        ("kernel step", &summary.step_ns),
        ("round trip", &summary.round_trip_ns),
        ("floor: round trip", &summary.floor_round_trip_ns),
        ("floor: wake-up", &summary.floor_wakeup_ns),
    ])?;
    terminal::say(format_args!(
        "  {:<18}{} joined, {} left; longest call meanwhile {:.1} us",
        "peers",
        summary.peers.joins,
        summary.peers.leaves,
        summary.peers.longest_ns() as f64 * 1e-3
    ))?;
    terminal::say(format_args!(
        "  {:<18}largest step {} N",
        "force", summary.largest_force_step_n
    ))?;
    tell_injected(summary.injected.as_ref())?;
    let verdict =
        if summary.state_hash == summary.replay_state_hash { "the same" } else { "OTHER" };
    terminal::say(format_args!(
        "  {:<18}{}, replayed {} ({verdict})",
        "state hash", summary.state_hash, summary.replay_state_hash
    ))?;
    if let Some(out) = &args.out {
        terminal::say(format_args!("  {:<18}{}", "results", out.display()))?;
    }
    summary.verdict.tell()
}

fn judge(args: &Args, summary: &CosimSummary) -> Result<()> {
    if summary.state_hash != summary.replay_state_hash {
        Err(Error::check(format!(
            "the replay gave state hash {}, the session {}",
            summary.replay_state_hash, summary.state_hash
        )))
    } else if summary.interrupted {
        Err(Error::Interrupted)
    } else if summary.ticks_unanswered > 0 {
        Err(Error::check(unanswered(summary)))
    } else if let Some(stopped) = summary.stopped.first() {
        Err(Error::check(format!(
            "{stopped} was stopped before its end, after {} of the press",
            counted(summary.ticks_sent, "tick")
        )))
    } else {
        summary.verdict.check(!args.json)
    }
}

/// Which ticks have no answer, and what is known of the cause.
fn unanswered(summary: &CosimSummary) -> String {
    let mut text = format!(
        "not answered: {} of {}",
        summary.ticks_unanswered,
        counted(summary.ticks_sent, "tick")
    );
    let step = &summary.step_ns;
    if step.p99 > PERIOD_NS {
        let ms = |ns: u64| ns as f64 * 1e-6;
        text += &format!(
            "; the tissue is overloaded: poses come every millisecond, a tick took {:.1} ms in the \
             median and {:.1} ms at most; take fewer --sweeps or a smaller model",
            ms(step.p50),
            ms(step.max)
        );
    }
    if summary.stopped.contains(&"serve") {
        text += "; serve still waited for poses that were lost, and was stopped";
    }
    text
}
