//! Both processes of a co-simulation under one command, with the machine's floor beside them.

use std::ffi::OsString;
use std::path::Path;

use chaincell_kernel::{Choice, Model};
use tempfile::TempDir;

use super::choice::parser;
use super::load::Lengths;
use super::press::press_on;
use super::verdict::VerdictArgs;
use crate::engine::Engine;
use crate::engine::motion::Pose;
use crate::error::{Error, Result};
use crate::files::path;
use crate::files::whole::write_whole;
use crate::session::ipc;
use crate::session::ipc::services::Domain;
use crate::session::ipc::serving::ServePorts;
use crate::session::loops::floor::{self, Floor};
use crate::session::loops::inject::{Faults, Plan};
use crate::session::loops::serve::POSE_HZ;
use crate::session::loops::wait::Wait;
use crate::session::supervise::{CosimOptions, CosimReports, Underway, cosim};
use crate::session::timing::clock::MILLISECOND_NS;
use crate::session::timing::histogram::Summary;
use crate::terminal;
use crate::words::counted;

/// Longest wait for `serve` [s].
const READY_S: u64 = 20;

/// Arguments of every command that loops at 1 kHz.
#[derive(Debug, Clone, clap::Args)]
pub struct LoopArgs {
    /// Name of the scene: services chaincell/NAME/pose and chaincell/NAME/force
    #[arg(long, value_name = "NAME")]
    pub scene: Option<String>,
    /// How to wait for the other process
    #[arg(long, value_parser = parser::<Wait>(), default_value = Wait::default().name())]
    pub wait: Wait,
    /// Do not ask for real-time scheduling, locked memory and a core of its own
    #[arg(long)]
    pub no_realtime: bool,
    /// End when the process that started this one has ended
    #[arg(long, hide = true)]
    pub ends_with_parent: bool,
    /// Put histograms into the report of --json
    #[arg(long, hide = true)]
    pub histogram: bool,
}

impl LoopArgs {
    /// Refuses a scene that cannot be served, before anything is measured or written.
    pub fn check(&self) -> Result<()> {
        let scene = ipc::open(self.scene.as_deref(), &Domain::default())?;
        ServePorts::open(&scene, false).map(|_| ())
    }

    /// How a side ends that has printed its report: where another process of this program reads
    /// the report, that one tells the user what went wrong.
    pub fn after_report(&self, outcome: Result<()>) -> Result<()> {
        outcome.map_err(|why| match self.ends_with_parent {
            true => Error::Reported(why.exit_code()),
            false => why,
        })
    }

    /// The same arguments for the two child processes, and a report from each.
    pub fn to_args(&self) -> Vec<OsString> {
        let mut args: Vec<OsString> = vec!["--json".into()];
        args.extend(self.scene.iter().map(|name| format!("--scene={name}").into()));
        args.extend(["--ends-with-parent".into(), "--wait".into(), self.wait.name().into()]);
        args.extend(self.no_realtime.then(|| "--no-realtime".into()));
        args
    }
}

/// Names the real-time privileges that were refused.
pub fn tell_refused(refused: &[String]) {
    for refused in refused {
        terminal::note(format_args!("note: {refused} (not needed, worst cases get longer)"));
    }
}

/// A folder for scratch files, gone with the value.
pub fn scratch() -> Result<TempDir> {
    tempfile::tempdir().map_err(|why| Error::file("create folder in", &std::env::temp_dir(), why))
}

/// Prints latencies, a name and a row of percentiles each.
pub fn tell_latencies(rows: &[(&str, &Summary)]) -> Result<()> {
    rows.iter().try_for_each(|(name, figures)| {
        terminal::say(format_args!("  {name:<18}{}", figures.in_us()))
    })
}

/// What a session measured.
pub struct Session {
    /// Both processes' reports.
    pub reports: CosimReports,
    /// The machine's floor, measured just before.
    pub floor: Floor,
}

/// The built-in press on the body of an engine, at its contact.
pub fn press(engine: &Engine<'_>, depth_m: Option<f64>, ticks: u64) -> Result<Vec<Pose>> {
    press_on(engine.network().model(), engine.contact(), depth_m, ticks)
}

/// The model's bytes and the poses as files that the two processes read.
pub struct Files<'a> {
    /// Model image.
    pub model: &'a Path,
    /// Folder for scratch files.
    pub scratch: &'a Path,
    /// Folder for the results of `serve`.
    pub out: Option<&'a Path>,
}

/// Options of the two processes, besides the files.
#[derive(Debug)]
pub struct Sides {
    /// Lengths of the session, in which the poses are those of a press.
    pub lengths: Lengths,
    /// True for a report with histograms from each.
    pub histogram: bool,
    /// Further arguments of `serve`.
    pub serve_args: Vec<OsString>,
    /// Further arguments of `control`.
    pub control_args: Vec<OsString>,
    /// The faults that `control` is told to make, with their seed.
    pub faults: Option<(Faults, u64)>,
}

impl Sides {
    /// No further options, for a session of these lengths.
    pub fn of(lengths: Lengths) -> Self {
        let (serve_args, control_args) = (Vec::new(), Vec::new());
        Self { lengths, histogram: false, serve_args, control_args, faults: None }
    }
}

/// Measures the floor, then runs both processes over `poses`, as often as planned; calls `watch`
/// meanwhile.
pub fn run(
    files: &Files<'_>,
    poses: &[Pose],
    sides: Sides,
    common: &LoopArgs,
    watch: impl FnMut(Underway),
) -> Result<Session> {
    let Lengths { presses, floor_ticks, .. } = sides.lengths;
    let sent = files.scratch.join("sent.csv");
    write_whole(&sent, path::to_text(poses.iter().copied()).as_bytes())?;
    let spinner = terminal::progress(1, "measuring the machine's floor");
    let floor = floor::measure(common.wait, !common.no_realtime, floor_ticks, &Domain::default())?;
    spinner.finish_and_clear();
    let mut both = common.to_args();
    both.extend(sides.histogram.then(|| "--histogram".into()));
    let mut serve_args: Vec<OsString> = vec!["serve".into(), files.model.into()];
    serve_args.extend(both.iter().cloned());
    serve_args.extend(VerdictArgs::off());
    let totals = Plan::new(poses.len() as u64 * presses, sides.faults).totals();
    if totals.answers == 0 {
        return Err(Error::input("--inject: no pose would be left to answer; lose fewer of them"));
    }
    if let Some((faults, _)) = sides.faults {
        // What is sent faster on purpose is to be executed.
        let pose_hz = faults.rate_hz.max(POSE_HZ);
        serve_args.extend(["--max-pose-hz".into(), pose_hz.to_string().into()]);
        if faults.sweep > 0.0 {
            serve_args.push(format!("--inject={}", faults.of_sweeps()).into());
        }
    }
    serve_args.extend(sides.serve_args);
    serve_args.extend(["--ticks".into(), totals.answers.to_string().into()]);
    if let Some(out) = files.out {
        serve_args.extend(["--force".into(), "--out".into(), out.into()]);
        serve_args.extend(["--record-ticks".into(), totals.answers.to_string().into()]);
    }
    let mut control_args: Vec<OsString> = vec!["control".into(), "--path".into(), sent.into()];
    control_args.extend(both);
    control_args.extend(["--repeat".into(), presses.to_string().into()]);
    control_args.extend(VerdictArgs::off());
    control_args.extend(sides.control_args);
    let motion_ms = totals.end_ns / MILLISECOND_NS;
    let program = std::env::current_exe()
        .map_err(|why| Error::check(format!("cannot find this executable: {why}")))?;
    let options = CosimOptions { program, serve_args, control_args, motion_ms, ready_s: READY_S };
    Ok(Session { reports: cosim(&options, watch)?, floor })
}

/// Size in a line, for headings.
pub fn describe(model: &Model<'_>) -> String {
    format!("{}, {}", counted(model.cells(), "cell"), counted(model.links(), "link"))
}
