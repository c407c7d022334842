//! `chaincell cosim`: the main job, both processes side by side and the replay that checks them.

use std::path::Path;

use chaincell_kernel::Model;
use serde::Serialize;

use super::budget::BudgetArgs;
use super::cosim_body::{CosimBodyArgs, check_body_rate};
use super::cosim_replay::{Replayed, replay};
use super::cosim_view::{Shown, ViewArgs};
use super::inject::{InjectArgs, tell_injected};
use super::judgement::{Judgement, Pace};
use super::load::report::LoadReport;
use super::load::{Lengths, MemoryWatch, histogram};
use super::model_file;
use super::pins::PinArgs;
use super::session::{self, LoopArgs, tell_refused};
use super::shared::{
    DepthArgs, FolderArgs, PrintArgs, note_cut, tell_cut, tell_relaxed, tell_view,
};
use super::sides::{self, Files, Session, Sides};
use super::stage::{StageArgs, StageReport};
use super::stress::{StressArgs, tell_stress};
use super::tissue::{TissueArgs, TissueReport};
use super::verdict::{Counts, Verdict, VerdictArgs};
use crate::bake::tissue::DEVICE_HZ;
use crate::engine::convergence::ForceError;
use crate::engine::course::{ToolCourse, largest_n};
use crate::engine::cut::report::CutReport;
use crate::engine::estimates::ForceEstimate;
use crate::engine::flag_ticks::FlagTicks;
use crate::engine::motion::Pose;
use crate::engine::staged::Staged;
use crate::engine::stress_limit::StressReport;
use crate::engine::tissue::TissueEngine;
use crate::engine::untouched::Untouched;
use crate::error::{Error, Result};
use crate::files::output::Folder;
use crate::files::recording;
use crate::files::whole::write_whole;
use crate::session::ipc::services::Domain;
use crate::session::loops::floor;
use crate::session::loops::inject::Injected;
use crate::session::loops::load::Load;
use crate::session::loops::peers::PeerCost;
use crate::session::loops::record::Recorder;
use crate::session::loops::serve::{Ending, SweepBudget, SweepCounts};
use crate::session::timing::clock::PERIOD_NS;
use crate::session::timing::histogram::Summary;
use crate::terminal;
use crate::words::counted;

/// Run tissue and controller as two processes at 1 kHz, then replay what was received.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell cosim --view\n  \
    chaincell cosim liver.chaincell --contact cells:file:liver.sets.json#patch --out session\n  \
    chaincell cosim --tissue muscle --out session\n  \
    chaincell cosim --load 1 --seconds 28800 --out night\n\n\
    Exit code 0 when every tick was answered, the replay gave the same state hash and the verdict is\n  \
    held, else 1.\n\n\
    With --load a press of at most 10 s is played over and over. Before and after, for a tenth of the\n\
    time each, the same loops run under the same load without a tissue: what they miss is the\n\
    machine's own. --out gets histogram.csv too. Exit code 1 also when a process took more memory at\n\
    the end than after the warm-up. A session of more than an hour is then neither recorded nor replayed.")]
pub struct Args {
    #[command(flatten)]
    body: CosimBodyArgs,
    /// Length of the press, with --load of the session, 3 s to 31 days [s]
    #[arg(long, default_value_t = 10.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    #[command(flatten)]
    depth: DepthArgs,
    /// Threads that keep the other cores and the memory busy, 0 for none: histograms, memory growth,
    /// deadlines missed
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    load: Option<u16>,
    #[command(flatten)]
    tissue: TissueArgs,
    #[command(flatten)]
    common: LoopArgs,
    #[command(flatten)]
    pins: PinArgs,
    #[command(flatten)]
    stress: StressArgs,
    #[command(flatten)]
    budget: BudgetArgs,
    #[command(flatten)]
    verdict: VerdictArgs,
    #[command(flatten)]
    stage: StageArgs,
    #[command(flatten)]
    inject: InjectArgs,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    folder: FolderArgs,
    #[command(flatten)]
    print: PrintArgs,
}

/// The summary, printed and written to summary.json.
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
    tool_courses: Vec<ToolCourse>,
    /// Of a body that can be cut.
    #[serde(flatten)]
    cut: Option<CutReport>,
    /// Energy that a body with branches has relaxed since the last reset \[J\].
    #[serde(skip_serializing_if = "Option::is_none")]
    relaxed_j: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stress: Option<StressReport>,
    injected: Option<Injected>,
    state_hash: String,
    /// None for a session that was not recorded.
    replay_state_hash: Option<String>,
    interrupted: bool,
    /// Sides that did not end by themselves in time and were stopped, though nobody interrupted.
    stopped: Vec<&'static str>,
    refused: Vec<String>,
    #[serde(flatten)]
    tissue: TissueReport,
    stage: Option<StageReport>,
    /// None for a session that was not recorded, or without a force.
    force_error: Option<ForceError>,
    /// The tissue's own estimate, if it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    force_error_estimate: Option<ForceEstimate>,
    /// How near the tool came that never touched the body.
    never_touched: Option<Untouched>,
    load: Option<LoadReport>,
    judgement: Judgement,
    verdict: Verdict,
}

pub fn execute(args: &Args) -> Result<()> {
    check_rate(&args.stage)?;
    let lengths = match args.load {
        Some(_) => Lengths::under_load(args.seconds)?,
        None => Lengths::of_press(args.seconds)?,
    };
    args.inject.faults()?;
    args.common.check()?;
    // Prepare the body and its press.
    let scratch = session::scratch()?;
    let (image, model_path) = args.body.image(scratch.path())?;
    let model = model_file::parse(&image, &model_path)?;
    check_body_rate(&model, &model_path)?;
    let mut tissue = args.tissue.staged(model, args.stage.settings()?)?;
    let poses = session::press(tissue.engine(), args.depth.depth_m, lengths.press_ticks)?;
    let out = args.folder.out.clone().unwrap_or_else(|| scratch.path().join("out"));
    // Earlier results are not removed for a session that is refused or has no room.
    args.budget.of(tissue.engine())?;
    check_pins_and_limit(args, model, &mut tissue)?;
    if lengths.is_recorded {
        let ticks = poses.len() * lengths.presses as usize;
        Folder::check_room(&out, Recorder::trace_records(ticks, tissue.tools()))?;
    }
    let folder = Folder::open(&out, args.folder.force)?;
    if args.body.model.is_none() {
        write_whole(&model_path, image.as_bytes())?;
    }
    if !args.print.json {
        terminal::say(format_args!(
            "{}: {}, {} s at 1 kHz",
            args.body.name(),
            session::describe(&model),
            args.seconds
        ))?;
    }
    // Run both sides, and replay the trace.
    let recorded = lengths.is_recorded.then_some(out.as_path());
    let files = Files { model: &model_path, scratch: scratch.path(), out: recorded };
    let sides = Sides {
        histogram: args.load.is_some(),
        stage: args.stage.clone(),
        pins: args.pins.clone(),
        stress: args.stress.clone(),
        budget: args.budget,
        inject: args.inject.clone(),
        ..Sides::of(lengths, &args.tissue, &args.common)
    };
    let page = args.view.open(Shown {
        path: args.body.shown(&model_path),
        image: image.as_bytes(),
        model: &model,
        tools: args.tissue.tool_texts()?,
        scene: args.common.scene.as_deref(),
    })?;
    let (session, load) = under_load(args, &files, &poses, &sides).map_err(|why| {
        why.before_results(args.folder.out.as_deref().filter(|out| is_empty(out)))
    })?;
    let replayed = match lengths.is_recorded {
        true => replay(&mut tissue, &folder.file(recording::TRACE), lengths.ticks())?,
        false => Replayed::default(),
    };
    // Write, print and judge the summary.
    let summary = CosimSummary { load, ..summary(args, &tissue, session, replayed)? };
    folder.write_json("summary.json", &summary)?;
    if let Some(load) = &summary.load {
        folder.write("histogram.csv", histogram::csv(&load.histograms).as_bytes())?;
    }
    print(args, &summary)?;
    if let Some(page) = page {
        page.stay(&format!(
            "The session has ended, {}: this is its last state",
            answered(&summary)
        ));
    }
    judge(args, &summary)
}

/// Returns true if a folder holds nothing.
fn is_empty(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none())
}

/// Refuses a device of another rate than that of the controller.
fn check_rate(stage: &StageArgs) -> Result<()> {
    let hz = stage.hz();
    if hz == DEVICE_HZ {
        return Ok(());
    }
    Err(Error::input(format!(
        "`device_hz` {hz}: the controller of cosim sends {DEVICE_HZ} poses a second; take `run`, or `serve` with a device \
         of that rate"
    )))
}

/// Refuses pins and a limit of the stress that the body does not take. It pins a tissue apart: the replay pins
/// `tissue`.
fn check_pins_and_limit(args: &Args, model: Model<'_>, tissue: &mut Staged<'_>) -> Result<()> {
    args.stress.limit(tissue.engine_mut())?;
    if args.pins.is_empty() {
        return Ok(());
    }
    let mut apart = args.tissue.staged(model, args.stage.settings()?)?;
    args.pins.set(apart.engine_mut()).map(drop)
}

/// Number of answered ticks in words.
fn answered(summary: &CosimSummary) -> String {
    let sent = counted(summary.ticks_sent, "tick");
    format!("{} of {sent} answered", summary.ticks_answered)
}

/// Runs the session, under the load if there is one, and reports on the load.
fn under_load(
    args: &Args,
    files: &Files<'_>,
    poses: &[Pose],
    sides: &Sides<'_>,
) -> Result<(Session, Option<LoadReport>)> {
    let lengths = sides.lengths;
    let Some(threads) = args.load else {
        return Ok((sides::run(files, poses, sides, |_| {})?, None));
    };
    // Run the session under the load.
    let load = Load::start(threads.into())?;
    let mut watch = MemoryWatch::new(&lengths);
    let mut session = sides::run(files, poses, sides, |underway| watch.look(underway))?;
    // Measure the floor once more; a user who asks to stop gets the report without it.
    let realtime = !args.common.no_realtime;
    let after = (!session.reports.interrupted)
        .then(|| {
            let domain = Domain::default();
            floor::without_tissue(args.common.wait, realtime, lengths.floor_ticks, &domain)
        })
        .transpose();
    let after = match after {
        Err(Error::Interrupted) => None,
        after => after?,
    };
    session.reports.interrupted |= after.is_none();
    // Report both.
    let (serve, control) = (&session.reports.serve, &session.reports.control);
    let mut report = LoadReport::of(control, &session.floor.run, after.as_ref());
    report.load = load.end();
    report.press_s = lengths.press_ticks as f64 / f64::from(DEVICE_HZ);
    report.histograms.step = serve.step_histogram.clone().unwrap_or_default();
    [report.memory_serve, report.memory_control] = watch.growth();
    Ok((session, Some(report)))
}

fn summary(
    args: &Args,
    tissue: &Staged<'_>,
    session: Session,
    replayed: Replayed,
) -> Result<CosimSummary> {
    let model = tissue.engine().network().model();
    let Session { reports, floor } = session;
    // Judge the answers.
    let verdict = args.verdict.judge(Counts {
        answers: reports.control.ticks_answered,
        late: reports.control.missed_deadlines,
        unanswered: reports.control.ticks_unanswered,
        floor_share: floor.late_share(),
        ..Counts::of_tissue(&reports.serve, tissue.engine())
    });
    // Judge the figures.
    let sweeps_max = args.tissue.given(model).sweeps;
    let all = args.budget.all_sweeps(sweeps_max);
    let pace = Pace::of_served(&reports.serve, all, model.body_cells(), DEVICE_HZ);
    let body = Judgement::of_body(tissue.engine(), args.tissue.is_place_default(), pace);
    let judgement =
        body.with_tools(tissue.engine(), &reports.serve.tool_courses, replayed.never_touched);
    // Sides that ended before their time.
    let (serve, control) = (reports.serve, reports.control);
    let ended_early =
        [("serve", serve.ended_by == Ending::Interrupt), ("control", control.interrupted)];
    let stopped = ended_early.into_iter().filter(|(_, early)| *early && !reports.interrupted);
    let stopped = stopped.map(|(side, _)| side);
    // Privileges that either side lacked.
    let mut refused = serve.refused;
    refused.extend(control.refused);
    refused.sort();
    refused.dedup();
    Ok(CosimSummary {
        cells: model.body_cells(),
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
        floor_wakeup_ns: floor.wakeup_ns,
        floor_round_trip_ns: floor.run.round_trip_ns,
        send_late_ns: control.send_late_ns,
        peers: serve.peers,
        poses_throttled: serve.poses_throttled,
        largest_force_step_n: control.largest_force_step_n,
        tool_courses: serve.tool_courses,
        cut: serve.cut,
        relaxed_j: serve.relaxed_j,
        stress: serve.stress,
        injected: control.injected,
        state_hash: serve.state_hash,
        replay_state_hash: replayed.state_hash,
        interrupted: reports.interrupted,
        stopped: stopped.collect(),
        refused,
        tissue: args.tissue.report(tissue.engine()),
        stage: args.stage.report()?,
        force_error: replayed.force_error,
        force_error_estimate: serve.force_error_estimate,
        never_touched: replayed.never_touched,
        load: None,
        judgement,
        verdict,
    })
}

fn print(args: &Args, summary: &CosimSummary) -> Result<()> {
    let cut = summary.cut.as_ref();
    note_cut(cut);
    if args.print.json {
        return terminal::say_json(summary);
    }
    // Print privileges that were refused, and counts of answers.
    tell_refused(&summary.refused);
    terminal::say(format_args!(
        "{}, {} later than 1 ms after the scheduled send",
        answered(summary),
        summary.missed_deadlines
    ))?;
    // Print flags.
    terminal::say(format_args!("  {:<18}{}", "flags", summary.flag_ticks))?;
    // Print times of steps, answers and calls.
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
    // Print forces, their error, the largest stress and injected faults.
    terminal::say(format_args!(
        "  {:<18}largest {:.4} N, largest step {} N",
        "force",
        largest_n(&summary.tool_courses),
        summary.largest_force_step_n
    ))?;
    if let Some(error) = &summary.force_error {
        terminal::say(format_args!("  {:<18}{error}", "force error"))?;
    }
    tell_stress(18, summary.stress.as_ref())?;
    tell_injected(summary.injected.as_ref())?;
    // Print the cut, and compare the state hash with that of the replay.
    tell_cut(18, cut)?;
    tell_relaxed(18, summary.relaxed_j)?;
    let replayed = match &summary.replay_state_hash {
        None => "not replayed: longer than an hour".to_owned(),
        Some(hash) if *hash == summary.state_hash => format!("replayed {hash} (the same)"),
        Some(hash) => format!("replayed {hash} (OTHER)"),
    };
    terminal::say(format_args!("  {:<18}{}, {replayed}", "state hash", summary.state_hash))?;
    // Print the load, the folder and the verdict.
    if let Some(load) = &summary.load {
        load.print()?;
    }
    let body = &args.body;
    match (&args.folder.out, &body.model) {
        (Some(out), _) => {
            terminal::say(format_args!("  {:<18}{}", "results", out.display()))?;
            tell_view(18, &[out])?;
        }
        // `view` makes no organ of another tissue.
        (None, _) if args.view.is_wanted() || body.tissue.is_some() || !args.pins.is_empty() => {}
        (None, Some(model)) => tell_view(18, &[model])?,
        // Without a model it shows the same organ.
        (None, None) => tell_view(18, &[])?,
    }
    summary.judgement.print(18)?;
    summary.verdict.tell()
}

fn judge(args: &Args, summary: &CosimSummary) -> Result<()> {
    let replayed = summary.replay_state_hash.as_ref();
    if let Some(hash) = replayed.filter(|hash| **hash != summary.state_hash) {
        Err(Error::check(format!(
            "the replay gave state hash {hash}, the session {}",
            summary.state_hash
        )))
    } else if summary.interrupted {
        Err(Error::interrupted(args.folder.out.as_deref()))
    } else if summary.ticks_unanswered > 0 {
        Err(Error::check(unanswered(summary)))
    } else if let Some(stopped) = summary.stopped.first() {
        Err(Error::check(format!(
            "{stopped} was stopped before its end, after {} of the press",
            counted(summary.ticks_sent, "tick")
        )))
    } else {
        summary.load.as_ref().map_or(Ok(()), LoadReport::judge)?;
        summary.verdict.check(!args.print.json)
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
