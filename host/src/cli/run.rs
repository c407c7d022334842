//! `chaincell run`: a path offline, deterministic, without shared memory.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use chaincell_kernel::trace::Record;
use chaincell_kernel::{Budget, Choice, TickOutput, ToolPose};
use serde::Serialize;

use super::judgement::{Judgement, Pace};
use super::mesh_file::Units;
use super::model_file;
use super::picture;
use super::press::{Motion, PressArgs};
use super::shared::{PrintArgs, note_cut, tell_cut, tell_relaxed, tell_view};
use super::snapshots::{SnapshotArgs, Snapshots};
use super::stage::{StageArgs, StageReport};
use super::tissue::{TissueArgs, TissueReport};
use crate::engine::course::{Course, ToolCourse, largest_n};
use crate::engine::cut::report::CutReport;
use crate::engine::estimates::{Estimates, ForceEstimate};
use crate::engine::far::Far;
use crate::engine::flag_ticks::FlagTicks;
use crate::engine::motion::Pose;
use crate::engine::order::{TickOrder, TickPlace};
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::tools::Poses;
use crate::engine::untouched::Untouched;
use crate::error::{Error, Result};
use crate::files::output::{Answer, ContactRows, Folder, ToolRows, cells_csv, force_csv, vtu};
use crate::files::path::{self, Paths, Rules};
use crate::files::recording;
use crate::files::recording::{Recording, TraceFile};
use crate::files::whole::{check_writable, folder_of, write_whole};
use crate::interrupt;
use crate::picture::{ForceCurve, Largest};
use crate::session::timing::histogram::{Latencies, Summary};
use crate::terminal::{self, Progress};
use crate::words::counted;

/// Run a path of tool positions offline and write forces, positions and a summary.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell run liver.chaincell --path press.csv --out press \
    --contact cells:file:liver.sets.json#patch --snapshot-ticks 100,200\n  \
    chaincell run liver.chaincell --motion press --contact probe:0.012 --seconds 2 \
    --snapshot-every 20 --out press\n\n\
    A path has the header tick,x_m,y_m,z_m,engaged and a row for each consecutive tick.\n\
    --out gets force.csv with its curves in force.svg and force_depth.svg, picture.png, cells_final.csv, final.vtu,\n\
    summary.json, the model and session.trace, which\n\
    `chaincell replay` plays; path.csv of a motion; of snapshots cells_<tick>.csv, state_<tick>.vtu\n\
    and series.pvd, which ParaView opens.")]
pub struct Args {
    /// Model file from `chaincell bake`
    model: PathBuf,
    #[command(flatten)]
    source: Source,
    /// Unit of the coordinates of --path
    #[arg(long, value_name = "UNITS", value_enum, default_value_t, conflicts_with = "motion")]
    path_units: Units,
    #[command(flatten)]
    press: PressArgs,
    /// Folder for the results
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A copy of the trace in this file
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// A picture (PNG) of the tick with the largest force: the body, coloured by displacement, and the tools;
    /// off for none [default: picture.png in --out]
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Overwrite the results of an earlier run in --out, and an earlier --trace
    #[arg(long)]
    force: bool,
    /// Sweep until the estimated error of each force is this share of it, at most --sweeps times; ticks for which
    /// the path has a number of sweeps make those. The trace has the sweeps that were made
    #[arg(long, value_name = "SHARE", value_parser = share)]
    force_error: Option<f32>,
    #[command(flatten)]
    snapshots: SnapshotArgs,
    /// Replay a recorded session, lost and bad poses included, by the rules of `serve`
    #[arg(long, conflicts_with = "motion")]
    recorded: bool,
    #[command(flatten)]
    tissue: TissueArgs,
    #[command(flatten)]
    stage: StageArgs,
    #[command(flatten)]
    print: PrintArgs,
}

/// A share of a force above the error of a body at rest.
fn share(text: &str) -> std::result::Result<f32, String> {
    let share = text.parse().ok().filter(|share| (0.001..=1.0).contains(share));
    share.ok_or_else(|| "a number from 0.001 to 1, as 0.01 for a hundredth of the force".into())
}

/// Where the poses come from.
#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = false)]
struct Source {
    /// Path of tool positions (CSV)
    #[arg(long, value_name = "PATH.csv")]
    path: Option<PathBuf>,
    /// Built-in motion in place of a path: a press on the contact, with a tool from where it first
    /// touches the body
    #[arg(long, value_enum)]
    motion: Option<Motion>,
}

/// summary.json
#[derive(Debug, Serialize)]
struct RunSummary {
    cells: usize,
    nodes: usize,
    links: usize,
    ticks: u64,
    state_hash: String,
    step_ns: Summary,
    ram_bytes: usize,
    poses_repeated: u64,
    recorded: bool,
    snapshot_ticks: BTreeSet<u64>,
    /// How near the tool came that never touched the body.
    never_touched: Option<Untouched>,
    /// What each tool did; of held cells one entry.
    tool_courses: Vec<ToolCourse>,
    judgement: Judgement,
    /// Largest torque of the tissue on the handles of scissors, above 0 where it resists closing \[N m\].
    #[serde(skip_serializing_if = "Option::is_none")]
    opening_torque_n_m: Option<f32>,
    /// Errors of the forces as the kernel estimates them; `None` where it knows none.
    #[serde(skip_serializing_if = "Option::is_none")]
    force_error_estimate: Option<ForceEstimate>,
    /// Sweeps a tick, with `--force-error`.
    #[serde(skip_serializing_if = "Option::is_none")]
    sweeps_mean: Option<f64>,
    /// Flags seen, each with the number of ticks it was set on.
    flag_ticks: FlagTicks,
    interrupted: bool,
    /// Of a body that can be cut.
    #[serde(flatten)]
    cut: Option<CutReport>,
    /// Energy that a body with branches has relaxed since the last reset \[J\].
    #[serde(skip_serializing_if = "Option::is_none")]
    relaxed_j: Option<f32>,
    #[serde(flatten)]
    tissue: TissueReport,
    stage: Option<StageReport>,
}

pub fn execute(args: &Args) -> Result<()> {
    let image = model_file::read(&args.model)?;
    let model = model_file::parse(&image, &args.model)?;
    let mut tissue = args.tissue.staged(model, args.stage.timeless()?)?;
    let paths = paths(args, &tissue)?;
    let poses = &paths.poses;
    let snapshot_ticks = args.snapshots.of(poses)?;
    check_sweeps(args, &mut tissue, poses)?;
    let records = poses.iter().map(Vec::len).sum::<usize>() * (1 + tissue.tools());
    check_places(args, records)?;
    let folder = Folder::open(&args.out, args.force)?;
    let (scheme, precision) = (tissue.engine().scheme(), args.tissue.precision);
    let begun = Recording::begin(tissue.engine(), scheme, precision, tissue.settings())?;
    let front = begun.bytes().to_vec();
    let place = folder.file(recording::TRACE);
    let mut trace = TraceFile::create("--out", &place, args.force, begun, records)?;
    let copy = args.trace.as_ref().filter(|copy| !is_same(copy, &place));
    if let Some(path) = copy {
        // A place that cannot be written is told before the run, not after it.
        write_whole(path, &front)?;
    }
    folder.write(recording::MODEL, image.as_bytes())?;
    write_motion(args, &folder, poses)?;
    let hz = args.stage.hz();
    let (mut snapshots, mut executed) = (Snapshots::new(&snapshot_ticks, &folder, hz), Vec::new());
    let mut rows = Rows { draws: args.picture().is_some(), ..Rows::default() };
    let played = play(&mut tissue, &paths, args.force_error, |pose, of_tools, output, tissue| {
        trace.add_tools(&record(args, pose, output, tissue), of_tools.each());
        executed.push(*pose);
        rows.after(pose, of_tools, output, tissue);
        snapshots.after(pose.tick, tissue.engine_mut())
    })?;
    trace.finish()?;
    if let Some(path) = copy {
        write_whole(path, &recording::read(&place)?)?;
    }
    snapshots.finish()?;
    let nodes = write_nodes(&folder, &mut tissue)?;
    folder.write("force.csv", force_csv(&played.answers).as_bytes())?;
    rows.write(&folder, &tissue, hz)?;
    let tool_courses: Vec<ToolCourse> = rows.courses.iter().map(Course::result).collect();
    let never_touched = Untouched::of(tissue.engine(), &executed, played.has_touched());
    let judgement = judgement(args, &tissue, &played, poses);
    let judgement = judgement.with_tools(tissue.engine(), &tool_courses, never_touched);
    let summary = RunSummary {
        cells: model.body_cells(),
        nodes,
        links: model.links(),
        ticks: played.answers.len() as u64,
        state_hash: format!("{:016x}", tissue.state_hash()),
        step_ns: played.step.summary(),
        ram_bytes: tissue.engine().ram_bytes(),
        poses_repeated: played.poses_repeated,
        recorded: args.recorded,
        snapshot_ticks,
        never_touched,
        judgement,
        tool_courses,
        opening_torque_n_m: rows.opening_torque_n_m,
        force_error_estimate: rows.estimates.result(),
        sweeps_mean: args.force_error.map(|_| played.sweeps_mean()),
        flag_ticks: played.flag_ticks,
        interrupted: interrupt::asked(),
        cut: tissue.engine_mut().cut(),
        relaxed_j: tissue.engine_mut().relaxed_j(),
        tissue: args.tissue.report(tissue.engine()),
        stage: args.stage.report()?,
    };
    folder.write_json("summary.json", &summary)?;
    let drawn = rows.picture(args.picture().as_deref(), &tissue)?;
    report(args, &summary, far(args, &tissue, &executed), drawn.as_deref())?;
    if summary.interrupted { Err(Error::interrupted(Some(&args.out))) } else { Ok(()) }
}

/// The poses of the path or of the built-in motion.
fn paths(args: &Args, tissue: &Staged<'_>) -> Result<Paths> {
    let engine = tissue.engine();
    let has_scissors = (0..tissue.tools()).any(|tool| engine.has_scissors(tool));
    let Some(file) = &args.source.path else {
        if has_scissors {
            terminal::note("note: the built-in motion leaves scissors closed; --path opens them");
        }
        let (model, hz) = (engine.network().model(), args.stage.hz());
        return Ok(Paths::of(vec![args.press.on(model, engine.contact(), hz)?]));
    };
    let rules = if args.recorded { Rules::Recorded } else { Rules::Strict };
    let paths = path::read(file, rules)?.in_metres(args.path_units.unit_m());
    if paths.tools > 0 && paths.tools != tissue.tools() {
        return Err(Error::input(format!(
            "{}: it moves {}, and --tool chooses {}: give --tool once for each tool of the path",
            file.display(),
            counted(paths.tools, "tool"),
            tissue.tools()
        )));
    }
    if has_scissors && !paths.opens() {
        terminal::note(format_args!(
            "note: {}: the scissors stay closed, as no row opens them: give the opening in a column \
             `opening_rad` behind `engaged`, 0 to 3.14159",
            file.display()
        ));
    }
    Ok(paths)
}

/// Writes the path of a built-in motion, which can be played again.
fn write_motion(args: &Args, folder: &Folder, poses: &[Vec<Pose>]) -> Result<()> {
    if args.source.motion.is_none() {
        return Ok(());
    }
    folder.write("path.csv", path::to_text(poses.concat()).as_bytes())
}

/// Writes the positions after the last tick; returns the number of nodes.
fn write_nodes(folder: &Folder, tissue: &mut Staged<'_>) -> Result<usize> {
    let nodes = tissue.engine_mut().nodes();
    folder.write("cells_final.csv", cells_csv(&nodes).as_bytes())?;
    folder.write("final.vtu", vtu(tissue.engine_mut(), &nodes).as_bytes())?;
    Ok(nodes.ids.len())
}

/// What a run says of its body and its pace.
fn judgement(args: &Args, tissue: &Staged<'_>, played: &Played, poses: &[Vec<Pose>]) -> Judgement {
    let network = tissue.engine().network();
    let (sweeps, cells) = (network.settings().sweeps, network.model().body_cells());
    let are_fixed = poses.iter().flatten().all(|pose| pose.sweeps.is_none());
    let makes_all = are_fixed && args.force_error.is_none();
    let (step, hz) = (played.step.summary(), args.stage.hz());
    let pace = Pace::of_all_sweeps(&step, sweeps, cells, hz).filter(|_| makes_all);
    let is_default = args.press_is_default();
    Judgement::of_body(tissue.engine(), is_default, pace)
}

impl Args {
    /// The file of the picture, if one is wanted.
    fn picture(&self) -> Option<PathBuf> {
        match &self.picture {
            Some(off) if off == Path::new("off") => None,
            Some(file) => Some(file.clone()),
            None => Some(self.out.join("picture.png")),
        }
    }

    /// Returns true if no option chose where the tool touches.
    fn press_is_default(&self) -> bool {
        match self.source.motion {
            Some(_) => self.tissue.is_place_default() && !self.press.is_placed(),
            None => self.tissue.holds_default(),
        }
    }
}

/// How far a path leads beyond the body.
fn far(args: &Args, tissue: &Staged<'_>, executed: &[Pose]) -> Option<Far> {
    args.source.path.as_ref().and_then(|_| Far::of(tissue.engine(), executed))
}

/// The record of a tick that has been made, with its sweeps where the path or the force's error chose them.
fn record(args: &Args, pose: &Pose, output: &TickOutput, tissue: &mut Staged<'_>) -> Record {
    let state_hash = Some(tissue.state_hash());
    let sweeps = pose.sweeps.or(args.force_error.map(|_| output.sweeps));
    Record { sweeps, state_hash, ..Record::of(pose.tick, ToolPose::from(*pose)) }
}

/// What is collected tick by tick for the results.
#[derive(Default)]
struct Rows {
    contacts: ContactRows,
    tools: ToolRows,
    curve: ForceCurve,
    /// One for each tool; of held cells one.
    courses: Vec<Course>,
    /// True if a picture is wanted.
    draws: bool,
    largest: Largest,
    /// Of scissors, the largest so far.
    opening_torque_n_m: Option<f32>,
    estimates: Estimates,
}

impl Rows {
    /// Adds a tick that has been made.
    fn after(
        &mut self,
        pose: &Pose,
        of_tools: &Poses,
        output: &TickOutput,
        tissue: &mut Staged<'_>,
    ) {
        let force_n = output.force_n.into();
        self.courses.resize(tissue.tools().max(1), Course::default());
        if let ([only], 0) = (&mut self.courses[..], tissue.tools()) {
            only.add(force_n, output.contacts, None);
            self.estimates.add(force_n, output.contacts, tissue.engine_mut().force_error_n(0));
        }
        for tool in 0..tissue.tools() {
            let felt = tissue.felt(tool);
            self.courses[tool].add(felt.force_n, felt.contacts, tissue.places_m(tool));
            self.tools.add(pose.tick, tool, &felt, output.flags.0);
            let error_n = tissue.engine_mut().force_error_n(tool);
            self.estimates.add(felt.force_n, felt.contacts, error_n);
            let torque_n_m = tissue.engine_mut().opening_torque_n_m(tool).map(|x| x + 0.0);
            self.opening_torque_n_m = larger(self.opening_torque_n_m, torque_n_m);
        }
        self.contacts.after(pose.tick, tissue.engine_mut());
        self.curve.add(pose.tick, pose.position_m, force_n, output.contacts > 0);
        if self.draws {
            self.largest.after(tissue.engine_mut(), pose.tick, of_tools.each(), force_n);
        }
    }

    /// Writes tables and curves.
    fn write(&self, folder: &Folder, tissue: &Staged<'_>, hz: u32) -> Result<()> {
        picture::write_curves(&self.curve, folder, hz)?;
        self.contacts.write(folder, tissue.engine())?;
        self.tools.write(folder, tissue.tools())
    }

    /// Draws the tick of the largest force where a picture is wanted, and says so.
    fn picture(&self, out: Option<&Path>, tissue: &Staged<'_>) -> Result<Option<String>> {
        let Some(out) = out else { return Ok(None) };
        picture::of_run(&self.largest, tissue.engine(), out)
    }
}

/// The larger of two numbers, of which there may be none.
fn larger(one: Option<f32>, other: Option<f32>) -> Option<f32> {
    let both = one.zip(other).map(|(one, other)| one.max(other));
    both.or(one).or(other)
}

/// Refuses places that cannot be written, before anything is removed or made.
fn check_places(args: &Args, records: usize) -> Result<()> {
    if let Some(trace) = &args.trace
        && (args.out.exists() || folder_of(trace).exists())
    {
        recording::check_place(trace, args.force)?;
    }
    // A picture may go into the folder that the run makes.
    if let Some(picture) = args.picture()
        && picture.parent() != Some(&args.out)
    {
        check_writable(&picture)?;
    }
    Folder::check_room(&args.out, records)
}

/// Whether both are the same file.
fn is_same(one: &Path, other: &Path) -> bool {
    one.canonicalize().ok().zip(other.canonicalize().ok()).is_some_and(|(one, other)| one == other)
}

/// Ticks may end by an error where one is known. A path may ask for the sweeps of a tick where a tick may end after any,
/// up to `--sweeps`.
fn check_sweeps(args: &Args, tissue: &mut Staged<'_>, poses: &[Vec<Pose>]) -> Result<()> {
    if args.force_error.is_some() && !tissue.engine_mut().tells_force_error() {
        return Err(Error::input(
            "--force-error: an error of the force is known under --scheme predict, of bodies of \
             --young-pa with a coarse level and without --branch and --cuttable; leave it out",
        ));
    }
    let most = poses.iter().flatten().filter_map(|pose| pose.sweeps).max();
    let path = args.source.path.as_deref().unwrap_or(Path::new("path")).display();
    let sweeps = tissue.engine().network().settings().sweeps;
    match most {
        Some(_) if !tissue.is_anytime() => Err(Error::input(format!(
            "{path}: it has the column sweeps, but under --scheme {} the sweeps are the tissue's \
             time, and their number is fixed; leave the column out, or take --scheme track",
            tissue.engine().scheme().name()
        ))),
        Some(most) if most > sweeps => Err(Error::input(format!(
            "{path}: a tick of {most} sweeps, --sweeps {sweeps} is the most that a tick makes; pass \
             --sweeps {most}"
        ))),
        _ => Ok(()),
    }
}

/// What a path played through an engine gave.
pub struct Played {
    /// One answer a tick that was executed.
    pub answers: Vec<Answer>,
    /// On how many ticks each flag was set.
    pub flag_ticks: FlagTicks,
    /// Time of each tick.
    pub step: Latencies,
    /// Poses whose tick was not above the last one, or was bad: not executed.
    pub poses_repeated: u64,
}

/// Plays sequences of poses, each from another controller, through a tissue as `serve` would,
/// `after` being called behind each tick, with the poses of all tools. A path of one tool moves the
/// first alone. A tick ends early where the estimated errors of the forces are within `share` of them, if one is
/// given. Ends early, with what it has, when the user asks to stop.
pub fn play(
    tissue: &mut Staged<'_>,
    paths: &Paths,
    share: Option<f32>,
    mut after: impl FnMut(&Pose, &Poses, &TickOutput, &mut Staged<'_>) -> Result<()>,
) -> Result<Played> {
    let poses: usize = paths.poses.iter().map(Vec::len).sum();
    let mut played = Played {
        answers: Vec::with_capacity(poses),
        flag_ticks: FlagTicks::default(),
        step: Latencies::new()?,
        poses_repeated: 0,
    };
    let progress = Progress::new(poses as u64, "run");
    'session: for (sequence, poses) in paths.poses.iter().enumerate() {
        let mut order = TickOrder::default();
        for (at, pose) in poses.iter().enumerate() {
            if interrupt::asked() {
                break 'session;
            }
            progress.step();
            if order.take(pose.tick) != TickPlace::Next {
                played.poses_repeated += 1;
                continue;
            }
            let first = [ToolPose::from(*pose)];
            let poses = match paths.each(sequence, at) {
                [] => &first,
                each => each,
            };
            let budget = match (pose.sweeps, share) {
                (None, Some(share)) => Budget::Within(share),
                (sweeps, _) => Budget::again(sweeps),
            };
            let output = played.tick(tissue, pose.tick, poses, budget);
            after(pose, &Poses::of_tools(tissue.tools(), poses), &output, tissue)?;
        }
    }
    drop(progress);
    Ok(played)
}

impl Played {
    /// Mean number of sweeps in a tick.
    fn sweeps_mean(&self) -> f64 {
        let sweeps: u64 = self.answers.iter().map(|answer| u64::from(answer.output.sweeps)).sum();
        sweeps as f64 / self.answers.len().max(1) as f64
    }

    /// Whether the tool had a contact in some tick.
    pub fn has_touched(&self) -> bool {
        self.answers.iter().any(|answer| answer.output.contacts > 0)
    }

    /// One timed tick.
    fn tick(
        &mut self,
        tissue: &mut Staged<'_>,
        tick: u64,
        poses: &[ToolPose],
        budget: Budget<'_>,
    ) -> TickOutput {
        let start = Instant::now();
        let output = tissue.tick_by(poses, budget);
        let span = start.elapsed();
        self.step.record(u64::try_from(span.as_nanos()).unwrap_or(u64::MAX));
        self.flag_ticks.add(output.flags);
        let cut_area_m2 = tissue.engine_mut().cut_area_m2();
        let force_error_n = tissue.engine_mut().force_error_n(0);
        self.answers.push(Answer { tick, output, cut_area_m2, force_error_n });
        output
    }
}

fn report(args: &Args, summary: &RunSummary, far: Option<Far>, drawn: Option<&str>) -> Result<()> {
    let peak = largest_n(&summary.tool_courses);
    if let Some(far) = far {
        let remedy = match args.path_units {
            Units::M => "where the path is in millimetres, pass --path-units mm",
            Units::Mm => "where the path is in metres, leave --path-units out",
        };
        terminal::note(format_args!("note: {far}: the largest force is {peak:.3} N; {remedy}"));
    }
    let cut = summary.cut.as_ref();
    note_cut(cut);
    if args.print.json {
        return terminal::say_json(summary);
    }
    let step = &summary.step_ns;
    terminal::say(format_args!(
        "{}, {}, {}",
        counted(summary.ticks, "tick"),
        counted(summary.cells, "cell"),
        counted(summary.links, "link")
    ))?;
    terminal::say(format_args!("  {:<14}{peak:.4} N", "largest force"))?;
    if let Some(estimate) = &summary.force_error_estimate {
        terminal::say(format_args!("  {:<14}{estimate}", "force error"))?;
    }
    if let Some(mean) = summary.sweeps_mean {
        terminal::say(format_args!("  {:<14}{mean:.2} a tick", "sweeps"))?;
    }
    if let Some(torque_n_m) = summary.opening_torque_n_m {
        terminal::say(format_args!("  {:<14}{torque_n_m:.5} N m, largest", "handles"))?;
    }
    terminal::say(format_args!(
        "  {:<14}p50 {:.1} us, p99 {:.1} us, max {:.1} us",
        "step",
        step.p50 as f64 * 1e-3,
        step.p99 as f64 * 1e-3,
        step.max as f64 * 1e-3
    ))?;
    terminal::say(format_args!("  {:<14}{}", "state hash", summary.state_hash))?;
    terminal::say(format_args!("  {:<14}{}", "flags", summary.flag_ticks))?;
    tell_cut(14, cut)?;
    tell_relaxed(14, summary.relaxed_j)?;
    summary.judgement.print(14)?;
    if let Some(drawn) = drawn {
        terminal::say(format_args!("  {:<14}{drawn}", "picture"))?;
    }
    terminal::say(format_args!("  {:<14}{}", "results", args.out.display()))?;
    if args.tissue.is_shown(cut) { tell_view(14, &[&args.out]) } else { Ok(()) }
}
