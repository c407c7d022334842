//! `chaincell serve`: the tissue's process of a co-simulation.

use std::path::PathBuf;

use chaincell_kernel::trace::CommandRecord;
use chaincell_kernel::{Flags, ToolPose};
use serde::{Deserialize, Serialize};

use super::budget::BudgetArgs;
use super::inject::InjectArgs;
use super::judgement::{Judgement, Pace};
use super::model_file;
use super::pins::PinArgs;
use super::record::{Begun, RecordArgs, Recorded, tell_unrecorded};
use super::restore::restore;
use super::session::{LoopArgs, tell_refused, write_forces};
use super::shared::{PrintArgs, SilenceArgs, note_cut, tell_cut, tell_relaxed, tell_view};
use super::stage::{StageArgs, StageReport};
use super::stand_by::StandBy;
use super::stress::{StressArgs, tell_stress};
use super::tissue::{TissueArgs, TissueReport};
use super::verdict::{Counts, Verdict, VerdictArgs};
use crate::bake::ImageBytes;
use crate::engine::Engine;
use crate::engine::course::largest_n;
use crate::engine::motion::Pose;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::untouched::Untouched;
use crate::error::{Error, Result};
use crate::files::output::{Folder, ToolRows};
use crate::files::path;
use crate::files::recording::Recording;
use crate::session::ipc;
use crate::session::ipc::services::SceneServices;
use crate::session::loops::inject::Faults;
use crate::session::loops::record::{Recorder, Row};
use crate::session::loops::serve::{Ending, POSE_HZ, ServeOptions, ServeReport, Server};
use crate::session::timing::histogram::Summary;
use crate::terminal;
use crate::words::counted;

/// Serve a model over shared memory: each pose is one tick and one answer.
#[derive(Debug, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
#[command(after_help = "Example:\n  chaincell serve liver.chaincell --scene left\n\n\
    Prints `ready` once chaincell/left/tools and chaincell/left/forces exist; ends on Ctrl-C.\n  \
    `chaincell state` reads its states, `chaincell contacts` its contacts, `chaincell command` resets,\n  \
    pauses and sets it.")]
pub struct Args {
    /// Model file from `chaincell bake`
    pub model: PathBuf,
    #[command(flatten)]
    pub tissue: TissueArgs,
    #[command(flatten)]
    pub common: LoopArgs,
    #[command(flatten)]
    pub silence: SilenceArgs,
    /// Send the state hash with every N-th tick; 0 for the last one alone
    #[arg(long, default_value_t = 1, value_name = "N", allow_negative_numbers = true)]
    pub hash_every: u64,
    /// Largest rate at which viewers get the positions of all nodes, and the contacts of tools on a
    /// contact surface; 0 for never [Hz]
    #[arg(long, default_value_t = 60, value_name = "HZ", allow_negative_numbers = true)]
    pub state_hz: u32,
    /// Largest rate at which poses are executed, in bursts of at most 1024; further ones are counted
    /// and not executed; 0 for no limit [Hz]
    #[arg(long, default_value_t = POSE_HZ, value_name = "HZ", allow_negative_numbers = true)]
    pub max_pose_hz: u32,
    /// End after N ticks
    #[arg(long, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u64).range(1..))]
    pub ticks: Option<u64>,
    /// End after S seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub seconds: Option<f64>,
    #[command(flatten)]
    pub record: RecordArgs,
    #[command(flatten)]
    pub pins: PinArgs,
    #[command(flatten)]
    pub stress: StressArgs,
    /// Go on from a snapshot of `chaincell command snapshot`, with the options of its session but --pin; its
    /// controller needs to release no tool first
    #[arg(long, value_name = "FILE")]
    pub restore: Option<PathBuf>,
    /// Stand by for the server that records this trace, folder or scene: follow it, and go on in its place if it is
    /// killed; with the options of its session but --pin. Its controller keeps its place, and feels no force before it
    /// has released its tools
    #[arg(long, value_name = "SESSION", conflicts_with = "restore")]
    pub stand_by: Option<PathBuf>,
    #[command(flatten)]
    pub budget: BudgetArgs,
    #[command(flatten)]
    pub verdict: VerdictArgs,
    #[command(flatten)]
    pub stage: StageArgs,
    #[command(flatten)]
    pub inject: InjectArgs,
    #[command(flatten)]
    pub print: PrintArgs,
}

/// summary.json
#[derive(Debug, Serialize)]
struct ServeSummary<'a> {
    cells: usize,
    links: usize,
    #[serde(flatten)]
    report: &'a ServeReport,
    #[serde(flatten)]
    tissue: TissueReport,
    watchdog_ms: u32,
    ramp_ms: u32,
    hash_every: u64,
    max_pose_hz: u32,
    state_hz: u32,
    stage: Option<StageReport>,
    never_touched: Option<Untouched>,
    judgement: &'a Judgement,
    verdict: Verdict,
}

/// The object that `--json` prints.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    report: &'a ServeReport,
    judgement: &'a Judgement,
}

pub fn execute(args: &Args) -> Result<()> {
    if args.seconds.is_some_and(|seconds| seconds.is_nan() || seconds <= 0.0) {
        return Err(Error::input("--seconds: must be above 0"));
    }
    check_rate(args)?;
    let image = model_file::read(&args.model)?;
    let model = model_file::parse(&image, &args.model)?;
    let mut tissue = args.tissue.staged(model, args.stage.settings()?)?;
    let faults = faults(args)?;
    let options = ServeOptions {
        force_error: args.budget.force_error(tissue.engine_mut())?,
        ..options(args, &tissue, &faults)?
    };
    check_stress(args, tissue.engine_mut())?;
    let begins_anew = args.restore.is_none() && args.stand_by.is_none();
    if !begins_anew && !args.pins.is_empty() {
        return Err(Error::input(
            "--pin: a session that goes on has its pins: leave the option out",
        ));
    }
    let pins = args.pins.set(tissue.engine_mut())?;
    let (scheme, precision) = (tissue.engine().scheme(), args.tissue.precision);
    let begun = Recording::begin(tissue.engine(), scheme, precision, tissue.settings())?;
    // Commands may set parameters: what is written is what the session began with.
    let settings = args.tissue.report(tissue.engine());
    let begins = begin(args, &options, begun, &image, &mut tissue)?;
    let Some(Begins { server, folder, mut recorder }) = begins else {
        return terminal::say("the other server has ended by itself: nothing to take over");
    };
    for (command, hash) in pins {
        recorder.command(CommandRecord { tick: 0, command, state_hash: Some(hash) });
    }
    server.say_ready()?;
    let report = server.run(&mut tissue, &mut recorder)?;
    let verdict = args.verdict.judge(counts(&report, tissue.engine()));
    // Told last, so that it costs no other result.
    let finished = recorder.finish_trace();
    let never_touched = folder.as_ref().and_then(|_| untouched(&tissue, recorder.rows(), &report));
    let judgement = judgement(args, &report, never_touched, tissue.engine());
    if let Some(folder) = &folder {
        let (cells, links) = (model.body_cells(), model.links());
        write_poses(folder, &recorder, tissue.tools())?;
        write_forces(folder, recorder.rows().iter().map(|row| &row.force))?;
        let summary = ServeSummary {
            cells,
            links,
            report: &report,
            tissue: settings,
            watchdog_ms: args.silence.watchdog_ms,
            ramp_ms: args.silence.ramp_ms,
            hash_every: args.hash_every,
            max_pose_hz: args.max_pose_hz,
            state_hz: args.state_hz,
            stage: args.stage.report()?,
            never_touched,
            judgement: &judgement,
            verdict,
        };
        folder.write_json("summary.json", &summary)?;
    }
    if args.record.is_given() {
        tell_unrecorded(&report);
    }
    print(args, &report, &judgement, &verdict)?;
    finished?;
    let interrupted = report.ended_by == Ending::Interrupt;
    args.common.after_report(if interrupted {
        Err(Error::interrupted(args.record.folder.out.as_deref()))
    } else {
        verdict.check(!args.print.json)
    })
}

/// How the scene is served.
fn options(args: &Args, tissue: &Staged<'_>, faults: &Faults) -> Result<ServeOptions> {
    Ok(ServeOptions {
        scene: args.common.scene.clone(),
        wait: args.common.wait,
        realtime: !args.common.no_realtime,
        ends_with_parent: args.common.is_child,
        watchdog_ms: args.silence.watchdog_ms,
        ramp_ms: args.silence.ramp_ms,
        max_slew_n_per_s: tissue.settings().map_or(f32::INFINITY, |stage| stage.max_slew_n_per_s),
        hash_every: args.hash_every,
        max_pose_hz: args.max_pose_hz,
        // A stage judges the speed of its device itself.
        max_speed_m_per_s: tissue
            .settings()
            .map_or(args.stage.max_speed_m_per_s(), |_| f32::INFINITY),
        budget: args.budget.of(tissue.engine())?,
        delay_period_ns: args.stage.delay_period_ns(),
        sweep_ns: faults.sweep_ns(),
        sweep_after: faults.sweep_after.into(),
        histogram: args.common.histogram,
        ticks: args.ticks,
        seconds: args.seconds,
        ..ServeOptions::default()
    })
}

/// A server that is ready, and where it records.
struct Begins {
    server: Server,
    folder: Option<Folder>,
    recorder: Recorder,
}

/// Begins at rest, from a snapshot, or in the place of a killed server; `None` where that has ended by itself.
fn begin(
    args: &Args,
    options: &ServeOptions,
    begun: Recording,
    image: &ImageBytes,
    tissue: &mut Staged<'_>,
) -> Result<Option<Begins>> {
    let scene = ipc::open(args.common.scene.as_deref(), &options.domain)?;
    let header = begun.bytes().to_vec();
    let begun = Begun {
        recording: begun,
        image,
        tools: tissue.tools(),
        ticks: known_ticks(args),
        stands_by: args.stand_by.is_some(),
    };
    let (server, from, mut recorded) = match &args.stand_by {
        None => {
            // A scene that is refused leaves the folder as it was.
            let server = open(args, scene, options, tissue.engine_mut())?;
            let from = args.restore.as_ref().map(|path| restore(path, &header, tissue));
            let from = from.transpose()?;
            (server, from, args.record.begin(begun)?)
        }
        Some(session) => {
            // Join, and make room for the trace, before there is something to take over.
            let stand_by = StandBy::join(session, &header, &scene, tissue)?;
            let recorded = args.record.begin(begun)?;
            let from = match stand_by.wait(&scene, tissue) {
                Ok(Some(from)) => from,
                other => {
                    recorded.forget();
                    return other.map(|_| None);
                }
            };
            match open(args, scene, options, tissue.engine_mut()) {
                Ok(server) => (server, Some(from), recorded),
                // Another one that stood by was faster.
                Err(why) => {
                    recorded.forget();
                    return Err(why);
                }
            }
        }
    };
    match recorded.go_on(server, from, &header, tissue) {
        Ok(server) => {
            let Recorded { folder, recorder, .. } = recorded;
            Ok(Some(Begins { server, folder, recorder }))
        }
        Err(why) => {
            recorded.forget();
            Err(why)
        }
    }
}

/// Refuses a limit of the stress that cannot be watched, before another server is waited for.
fn check_stress(args: &Args, engine: &mut Engine<'_>) -> Result<()> {
    match args.stress.limit(engine)? {
        Some(_) if args.state_hz == 0 => Err(Error::input(
            "--stress-limit-pa: needs a --state-hz above 0, at which stress is computed",
        )),
        _ => Ok(()),
    }
}

/// Ticks of the run, if they are known.
fn known_ticks(args: &Args) -> Option<usize> {
    let of_seconds = |seconds: f64| (seconds * f64::from(args.stage.hz())).ceil() as usize;
    let ticks = args.ticks.map(|ticks| usize::try_from(ticks).unwrap_or(usize::MAX));
    ticks.or(args.seconds.map(of_seconds))
}

/// The server with all that it sends and takes.
fn open(
    args: &Args,
    scene: SceneServices,
    options: &ServeOptions,
    engine: &mut Engine<'_>,
) -> Result<Server> {
    let (nodes, tools, hz) = (engine.node_count(), engine.contact().tools(), args.state_hz);
    let limit = args.stress.limit(engine)?;
    let mut server = Server::on(scene, options)?.with_state(nodes, hz)?;
    if let Some(cells) = engine.stressed_cells() {
        server = server.with_stress((nodes, cells), hz)?;
    }
    if let Some(limit) = limit {
        server = server.with_stress_limit(limit);
    }
    if let Some(rows) = engine.surface_rows() {
        server = server.with_surface(rows, hz)?;
    }
    server.with_contacts(tools, hz)?.with_commands()
}

/// The poses as executed; of several tools also what each felt.
fn write_poses(folder: &Folder, recorder: &Recorder, tools: usize) -> Result<()> {
    let rows = recorder.rows();
    let poses: Vec<ToolPose> = recorder.tool_rows().iter().map(|row| row.pose).collect();
    let path = path::session_to_text(rows.iter().map(|row| row.pose), &poses, tools);
    folder.write("path.csv", path.as_bytes())?;
    if tools == 0 {
        return Ok(());
    }
    let mut felt = ToolRows::default();
    for (row, of_tick) in rows.iter().zip(recorder.tool_rows().chunks_exact(tools)) {
        for (tool, of) in of_tick.iter().enumerate() {
            felt.add(row.pose.tick, tool, &of.felt, row.force.flags);
        }
    }
    felt.write(folder, tools)
}

/// Faults in the tissue, where they are asked for.
fn faults(args: &Args) -> Result<Faults> {
    match args.inject.faults()? {
        Some((faults, _)) if faults.in_poses() => Err(Error::input(
            "--inject: serve sends no poses; it takes sweep:PERIODS alone, give the others to \
             control",
        )),
        Some((faults, _)) => Ok(faults),
        None => Ok(Faults::default()),
    }
}

/// Late answers that this process knows of: those to poses that newer ones had overtaken.
fn counts(report: &ServeReport, engine: &Engine<'_>) -> Counts {
    Counts {
        answers: report.ticks_executed,
        late: report.flag_ticks.of(Flags::LATE),
        // Poses that came at once behind a silence: somebody stood still, not the tissue.
        floor_share: report.ticks_late_behind_gaps as f64 / report.ticks_executed.max(1) as f64,
        ..Counts::of_tissue(report, engine)
    }
}

/// The judgement of this session; nothing where no pose came.
fn judgement(
    args: &Args,
    report: &ServeReport,
    never_touched: Option<Untouched>,
    engine: &Engine<'_>,
) -> Judgement {
    if report.ticks_executed == 0 {
        return Judgement::default();
    }
    let model = engine.network().model();
    let (sweeps, cells) = (args.tissue.given(model).sweeps, model.body_cells());
    let sweeps = args.budget.all_sweeps(sweeps);
    let pace = Pace::of_served(report, sweeps, cells, args.stage.hz());
    Judgement::of_body(engine, args.tissue.holds_default(), pace).with_tools(
        engine,
        &report.tool_courses,
        never_touched,
    )
}

/// Refuses a device whose given rate is above that of the poses that are executed.
fn check_rate(args: &Args) -> Result<()> {
    let most_hz = args.max_pose_hz;
    let Some(hz) = args.stage.given_hz().filter(|&hz| most_hz > 0 && hz > most_hz) else {
        return Ok(());
    };
    Err(Error::input(format!(
        "`device_hz` {hz}: of its poses `max_pose_hz` {most_hz} would leave some out; pass `max_pose_hz` {}",
        hz.saturating_mul(2)
    )))
}

/// How near the tool came that never touched, where all of the session is recorded.
fn untouched(tissue: &Staged<'_>, rows: &[Row], report: &ServeReport) -> Option<Untouched> {
    let poses: Vec<Pose> = rows.iter().map(|row| row.pose).collect();
    let has_touched = rows.iter().any(|row| row.force.contacts > 0);
    let untouched = Untouched::of(tissue.engine(), &poses, has_touched);
    untouched.filter(|_| report.ticks_unrecorded == 0)
}

/// Says how many messages of a kind viewers got, and how long each took.
fn tell_sent(name: &str, sent: u64, took: &Summary) -> Result<()> {
    if sent == 0 {
        return Ok(());
    }
    terminal::say(format_args!("  {name}{sent} sent, {}", took.in_us()))
}

fn print(
    args: &Args,
    report: &ServeReport,
    judgement: &Judgement,
    verdict: &Verdict,
) -> Result<()> {
    let cut = report.cut.as_ref();
    // The parent of a child prints the same note.
    note_cut(cut.filter(|_| !args.common.is_child));
    if args.print.json {
        return terminal::say_json(&Printed { report, judgement });
    }
    // Print privileges that were refused, and counts of ticks and poses.
    tell_refused(&report.refused);
    terminal::say(format_args!(
        "{} answered, {} without a sweep, {} repeated, {} refused, {} too fast, {} missing, watchdog fired {}",
        counted(report.ticks_executed, "tick"),
        report.ticks_late,
        report.poses_repeated,
        report.poses_refused,
        report.poses_throttled,
        report.poses_missing,
        counted(report.watchdog_fired, "time")
    ))?;
    // Print flags.
    terminal::say(format_args!("  flags       {}", report.flag_ticks))?;
    // Print times, forces and programs that joined.
    terminal::say(format_args!("  step        {}", report.step_ns.in_us()))?;
    terminal::say(format_args!(
        "  force       largest {:.4} N, largest step {} N",
        largest_n(&report.tool_courses),
        report.largest_force_step_n
    ))?;
    terminal::say(format_args!(
        "  peers       {} joined, {} left; longest call meanwhile {:.1} us",
        report.peers.joins,
        report.peers.leaves,
        report.peers.longest_ns() as f64 * 1e-3
    ))?;
    // Print states, contacts and commands, where there were any.
    tell_sent("states      ", report.states_sent, &report.state_ns)?;
    tell_sent("stresses    ", report.stresses_sent, &report.stress_ns)?;
    tell_sent("surfaces    ", report.surfaces_sent, &report.surface_ns)?;
    tell_stress(12, report.stress.as_ref())?;
    tell_sent("contacts    ", report.contacts_sent, &report.contacts_ns)?;
    if report.commands_done + report.commands_refused > 0 {
        terminal::say(format_args!(
            "  commands    {} done, {} refused; {} while paused",
            report.commands_done,
            report.commands_refused,
            counted(report.ticks_paused, "tick")
        ))?;
    }
    // Print the cut, the state and the verdict.
    tell_cut(12, cut)?;
    tell_relaxed(12, report.relaxed_j)?;
    terminal::say(format_args!("  state hash  {}", report.state_hash))?;
    match (&args.record.folder.out, &args.record.record) {
        (Some(session), _) => tell_view(12, &[session])?,
        (None, Some(trace)) => tell_view(12, &[trace, "--model".as_ref(), &args.model])?,
        (None, None) => tell_view(12, &[&args.model])?,
    }
    judgement.print(12)?;
    terminal::say(format_args!("  verdict     {verdict}"))
}
