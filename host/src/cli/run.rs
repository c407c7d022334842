//! `chaincell run`: a path offline, deterministic, without shared memory.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use chaincell_kernel::trace::CommandRecord;
use chaincell_kernel::{Choice, Model, TickOutput};
use serde::Serialize;

use super::account::{AccountReport, tell_account};
use super::budget::{check_force_error, share};
use super::gathered::{Gathered, Tables};
use super::judgement::{Judgement, Pace};
use super::mesh_file::Units;
use super::model_file;
use super::pins::{PinArgs, Pinned, tell_pins};
use super::played::{Played, play};
use super::press::{Motion, PressArgs};
use super::shared::{PrintArgs, note_cut, tell_cut, tell_relaxed, tell_view};
use super::snapshots::{SnapshotArgs, Snapshots};
use super::stage::{StageArgs, StageReport};
use super::stress::{StressArgs, StressWatch, tell_stress};
use super::tissue::{TissueArgs, TissueReport};
use crate::bake::ImageBytes;
use crate::engine::course::{ToolCourse, largest_n};
use crate::engine::cut::report::CutReport;
use crate::engine::estimates::ForceEstimate;
use crate::engine::far::Far;
use crate::engine::flag_ticks::FlagTicks;
use crate::engine::motion::Pose;
use crate::engine::staged::Staged;
use crate::engine::stress_limit::StressReport;
use crate::engine::tissue::TissueEngine;
use crate::engine::tools::Poses;
use crate::engine::untouched::Untouched;
use crate::error::{Error, Result};
use crate::files::output::{Folder, JOB, Job, PinCourse};
use crate::files::path::{self, Paths, Rules};
use crate::files::recording;
use crate::files::recording::Recording;
use crate::files::whole::{check_writable, folder_of};
use crate::interrupt;
use crate::session::timing::histogram::Summary;
use crate::terminal::{self, Progress};
use crate::words::counted;

/// Run a path of tool positions offline and write forces, positions and a summary.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell run liver.chaincell --path press.csv --out press \
    --contact cells:file:liver.sets.json#patch --snapshot-ticks 100,200\n  \
    chaincell run liver.chaincell --motion press --contact probe:0.012 --seconds 2 \
    --snapshot-every 20 --out press\n  \
    chaincell run --batch jobs.jsonl --results results.jsonl\n\n\
    A path has the header tick,x_m,y_m,z_m,engaged and a row for each consecutive tick.\n\
    --out gets force.csv with its curves in force.svg and force_depth.svg, picture.png, cells_final.csv, final.vtu,\n\
    summary.json, the model and session.trace, which\n\
    `chaincell replay` plays; path.csv of a motion; of snapshots cells_<tick>.csv, state_<tick>.vtu\n\
    and series.pvd, which ParaView opens.\n\
    A job of a batch is a line such as {\"model\":\"liver.chaincell\",\"path\":\"press.csv\",\"sweeps\":2}; its result is\n\
    a line with the keys of summary.json, or with `error`.")]
pub struct Args {
    /// Model file from `chaincell bake`
    pub model: PathBuf,
    #[command(flatten)]
    source: Source,
    /// Unit of the coordinates of --path
    #[arg(long, value_name = "UNITS", value_enum, default_value_t, conflicts_with = "motion")]
    path_units: Units,
    #[command(flatten)]
    press: PressArgs,
    /// Folder for the results
    // A job of a batch may do without.
    #[arg(long, value_name = "DIR", required = true)]
    pub out: Option<PathBuf>,
    /// A copy of the trace in this file
    #[arg(long, value_name = "FILE", requires = "out")]
    trace: Option<PathBuf>,
    /// A picture (PNG) of the tick with the largest force: the body, coloured by displacement, and the tools;
    /// off for none [default: picture.png in --out]
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Overwrite the results of an earlier run in --out, and an earlier --trace
    #[arg(long)]
    pub force: bool,
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
    pins: PinArgs,
    #[command(flatten)]
    stress: StressArgs,
    #[command(flatten)]
    tissue: TissueArgs,
    #[command(flatten)]
    stage: StageArgs,
    #[command(flatten)]
    print: PrintArgs,
    /// Of a job of a batch, the hash of its inputs: the folder keeps it.
    #[arg(skip)]
    pub inputs_hash: Option<String>,
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
pub struct RunSummary {
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
    /// The course of each pin.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pins: Vec<PinCourse>,
    /// The limit of the stress, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    stress: Option<StressReport>,
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
    pub interrupted: bool,
    /// Of a body that can be cut.
    #[serde(flatten)]
    cut: Option<CutReport>,
    /// Energy that a body with branches has relaxed since the last reset \[J\].
    #[serde(skip_serializing_if = "Option::is_none")]
    relaxed_j: Option<f32>,
    /// Where the energy of tools went; of a body that can be cut or that relaxes.
    #[serde(flatten)]
    account: Option<AccountReport>,
    #[serde(flatten)]
    tissue: TissueReport,
    stage: Option<StageReport>,
}

/// What a run came to.
#[derive(Debug)]
pub struct Ended {
    pub summary: RunSummary,
    /// The picture that was drawn, in words.
    drawn: Option<String>,
}

/// Who follows a run.
#[derive(Debug)]
pub enum Follower<'a> {
    /// The terminal, which sees its progress too.
    Terminal,
    /// A batch, which keeps its notes.
    Batch(&'a mut Vec<String>),
}

impl Follower<'_> {
    fn note(&mut self, text: impl ToString) {
        match self {
            Self::Terminal => terminal::note(format_args!("note: {}", text.to_string())),
            Self::Batch(notes) => notes.push(text.to_string()),
        }
    }

    fn progress(&self, paths: &Paths) -> Progress {
        match self {
            Self::Terminal => progress(paths),
            Self::Batch(_) => Progress::unseen(),
        }
    }
}

/// The progress of playing paths.
pub fn progress(paths: &Paths) -> Progress {
    Progress::new(paths.poses.iter().map(Vec::len).sum::<usize>() as u64, "run")
}

pub fn execute(args: &Args) -> Result<()> {
    let image = model_file::read(&args.model)?;
    let model = model_file::parse(&image, &args.model)?;
    let ended = args.carry_out(&image, model, Follower::Terminal)?;
    report(args, &ended)?;
    if ended.summary.interrupted { Err(Error::interrupted(args.out.as_deref())) } else { Ok(()) }
}

impl Args {
    /// Runs a model, which these are the bytes of, and writes the results.
    ///
    /// # Errors
    /// Arguments that do not go with the model or with each other; a path that is none; a place that cannot be
    /// written. A run that the user stopped is none: its summary says so.
    pub fn carry_out(
        &self,
        image: &ImageBytes,
        model: Model<'_>,
        mut follower: Follower<'_>,
    ) -> Result<Ended> {
        // Refuse what cannot be done before anything is written.
        let mut tissue = self.tissue.staged(model, self.stage.timeless()?)?;
        let paths = paths(self, &tissue, &mut follower)?;
        let pinned = self.pins.set(tissue.engine_mut())?;
        let poses = &paths.poses;
        let snapshot_ticks = self.snapshots.of(poses)?;
        check_sweeps(self, &tissue, poses)?;
        check_force_error(self.force_error, tissue.engine_mut())?;
        let limit = self.stress.limit(tissue.engine_mut())?;
        let mut watch = limit.map(|limit| StressWatch::new(limit, tissue.engine()));
        let records = poses.iter().map(Vec::len).sum::<usize>() * (1 + tissue.tools());
        check_places(self, records)?;
        // Play the path; keep what is asked for.
        let folder = self.out.as_deref().map(|out| Folder::open(out, self.force)).transpose()?;
        let of_folder =
            |folder| self.tables(folder, image, &tissue, &snapshot_ticks, poses, &pinned);
        let tables = folder.as_ref().map(of_folder).transpose()?;
        let picture = self.picture();
        let is_adaptive = self.force_error.is_some();
        let mut gathered = Gathered::new(tables, picture.is_some(), is_adaptive)?;
        let mut executed = Vec::new();
        let progress = follower.progress(&paths);
        let mut after =
            |pose: &Pose, of_tools: &Poses, output: &TickOutput, tissue: &mut Staged<'_>| {
                executed.push(*pose);
                let over = watch.as_mut().and_then(|of| of.after(pose.tick, tissue));
                if let Some(warning) = over {
                    follower.note(warning);
                }
                gathered.after(pose, of_tools, output, tissue)
            };
        let played = play(&mut tissue, &paths, self.force_error, progress, &mut after)?;
        gathered.finish(&mut tissue, &played.answers, self.stage.hz())?;
        // Judge it, and sum it up.
        let tool_courses = gathered.courses();
        let never_touched = Untouched::of(tissue.engine(), &executed, played.has_touched());
        let judgement = judgement(self, &tissue, &played, poses);
        let judgement = judgement.with_tools(tissue.engine(), &tool_courses, never_touched);
        let far = self.source.path.as_ref().and_then(|_| Far::of(tissue.engine(), &executed));
        self.note_far(far, largest_n(&tool_courses), &mut follower);
        let stored_j = played.answers.last().map_or(0.0, |answer| answer.output.energy_j);
        let summary = RunSummary {
            cells: model.body_cells(),
            nodes: tissue.engine().node_count(),
            links: model.links(),
            ticks: played.answers.len() as u64,
            state_hash: format!("{:016x}", tissue.state_hash()),
            step_ns: played.step.summary(),
            ram_bytes: tissue.engine().ram_bytes(),
            poses_repeated: played.poses_repeated,
            recorded: self.recorded,
            snapshot_ticks: snapshot_ticks.clone(),
            never_touched,
            judgement,
            tool_courses,
            pins: gathered.pin_courses(),
            stress: watch.as_ref().map(StressWatch::report),
            opening_torque_n_m: gathered.opening_torque_n_m,
            force_error_estimate: gathered.estimates.result(),
            sweeps_mean: self.force_error.map(|_| played.sweeps_mean()),
            flag_ticks: played.flag_ticks,
            interrupted: interrupt::asked(),
            cut: tissue.engine_mut().cut(),
            relaxed_j: tissue.engine_mut().relaxed_j(),
            account: AccountReport::of([gathered.given_j, stored_j.into()], &mut tissue),
            tissue: self.tissue.report(tissue.engine()),
            stage: self.stage.report()?,
        };
        if let Some(folder) = &folder {
            folder.write_json("summary.json", &summary)?;
        }
        let drawn = gathered.picture(picture.as_deref(), &tissue)?;
        Ok(Ended { summary, drawn })
    }

    /// The folder with model, trace and path, to which the ticks are added.
    fn tables<'a>(
        &'a self,
        folder: &'a Folder,
        image: &ImageBytes,
        tissue: &Staged<'_>,
        snapshot_ticks: &'a BTreeSet<u64>,
        poses: &[Vec<Pose>],
        pinned: &[Pinned],
    ) -> Result<Tables<'a>> {
        if let Some(hash) = &self.inputs_hash {
            folder.write_json(JOB, &Job { inputs_hash: hash.into() })?;
        }
        let (scheme, precision) = (tissue.engine().scheme(), self.tissue.precision);
        let mut begun = Recording::begin(tissue.engine(), scheme, precision, tissue.settings())?;
        for &(command, hash) in pinned {
            begun.add_command(&CommandRecord { tick: 0, command, state_hash: Some(hash) });
        }
        let records = poses.iter().map(Vec::len).sum::<usize>() * (1 + tissue.tools());
        let snapshots = Snapshots::new(snapshot_ticks, folder, self.stage.hz());
        let copy = self.trace.as_deref();
        let tables = Tables::begin(folder, begun, records, snapshots, copy, self.force)?;
        folder.write(recording::MODEL, image.as_bytes())?;
        // The path of a built-in motion can be played again.
        if self.source.motion.is_some() {
            folder.write("path.csv", path::to_text(poses.concat()).as_bytes())?;
        }
        Ok(tables)
    }

    /// Notes that a path leads far beyond the body.
    fn note_far(&self, far: Option<Far>, peak_n: f32, follower: &mut Follower<'_>) {
        let Some(far) = far else { return };
        let remedy = match self.path_units {
            Units::M => "where the path is in millimetres, pass --path-units mm",
            Units::Mm => "where the path is in metres, leave --path-units out",
        };
        follower.note(format_args!("{far}: the largest force is {peak_n:.3} N; {remedy}"));
    }
}

/// The poses of the path or of the built-in motion.
fn paths(args: &Args, tissue: &Staged<'_>, follower: &mut Follower<'_>) -> Result<Paths> {
    let engine = tissue.engine();
    let has_scissors = (0..tissue.tools()).any(|tool| engine.has_scissors(tool));
    let Some(file) = &args.source.path else {
        if has_scissors {
            follower.note("the built-in motion leaves scissors closed; --path opens them");
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
        follower.note(format_args!(
            "{}: the scissors stay closed, as no row opens them: give the opening in a column \
             `opening_rad` behind `engaged`, 0 to 3.14159",
            file.display()
        ));
    }
    Ok(paths)
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
            None => self.out.as_ref().map(|out| out.join("picture.png")),
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

/// Refuses places that cannot be written, before anything is removed or made.
fn check_places(args: &Args, records: usize) -> Result<()> {
    let Some(out) = &args.out else {
        return args.picture().map_or(Ok(()), |picture| check_writable(&picture));
    };
    if let Some(trace) = &args.trace
        && (out.exists() || folder_of(trace).exists())
    {
        recording::check_place("`trace`", trace, args.force)?;
    }
    // A picture may go into the folder that the run makes.
    if let Some(picture) = args.picture()
        && picture.parent() != Some(out)
    {
        check_writable(&picture)?;
    }
    Folder::check_room(out, records)
}

/// A path may ask for the sweeps of a tick where a tick may end after any, up to `--sweeps`.
fn check_sweeps(args: &Args, tissue: &Staged<'_>, poses: &[Vec<Pose>]) -> Result<()> {
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

fn report(args: &Args, ended: &Ended) -> Result<()> {
    let summary = &ended.summary;
    let peak = largest_n(&summary.tool_courses);
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
    tell_pins(14, &summary.pins)?;
    tell_stress(14, summary.stress.as_ref())?;
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
    tell_account(14, summary.account.as_ref())?;
    summary.judgement.print(14)?;
    if let Some(drawn) = &ended.drawn {
        terminal::say(format_args!("  {:<14}{drawn}", "picture"))?;
    }
    let Some(out) = &args.out else { return Ok(()) };
    terminal::say(format_args!("  {:<14}{}", "results", out.display()))?;
    tell_view(14, &[out])
}
