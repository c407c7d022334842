//! `chaincell control`: the controller's process of a co-simulation.

use std::path::PathBuf;

use chaincell_kernel::{Flags, ToolPose};
use serde::{Deserialize, Serialize};

use super::inject::{InjectArgs, tell_injected};
use super::judgement::Judgement;
use super::mesh_file::Units;
use super::model_file;
use super::picture;
use super::press::{Motion, PressArgs};
use super::session::{LoopArgs, tell_refused, write_forces};
use super::shared::{PrintArgs, SilenceArgs, tell_view};
use super::tissue;
use super::verdict::{Counts, Verdict, VerdictArgs};
use super::watch::ServerWait;
use crate::bake::tissue::DEVICE_HZ;
use crate::engine::course::largest_n;
use crate::engine::motion::Pose;
use crate::error::{Error, Result};
use crate::files::output::Folder;
use crate::files::path::{self, Paths, Rules};
use crate::picture::ForceCurve;
use crate::session::loops::control::{ControlOptions, ControlReport, ControlRun, control_tools};
use crate::terminal;
use crate::words::counted;

/// Send tool poses at 1 kHz to a served scene and time its answers.
#[derive(Debug, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
#[command(after_help = "Examples:\n  chaincell control --scene left --path press.csv\n  \
    chaincell control --scene left --model liver.chaincell --contact probe:0.012\n  \
    chaincell control --motion press --touch-m 0,0,0.05 --direction=0,0,-1 --depth-m 0.01\n\n\
    --out gets path.csv, force.csv with its curves in force.svg and force_depth.svg, and summary.json. The\n\
    positions of the body are the server's: its --out records what `chaincell view` and `picture` show.")]
pub struct Args {
    #[command(flatten)]
    pub common: LoopArgs,
    /// Path of tool positions (CSV), one row a millisecond; of several tools one row for each, sent as
    /// one message
    #[arg(long, value_name = "PATH.csv", conflicts_with = "motion")]
    pub path: Option<PathBuf>,
    /// Unit of the coordinates of --path
    #[arg(long, value_name = "UNITS", value_enum, default_value_t, requires = "path",
        conflicts_with_all = ["motion", "model"])]
    pub path_units: Units,
    /// Built-in motion: approach, minimum-jerk press, hold with an 8 to 12 Hz tremor, retreat
    #[arg(long, value_enum, default_value_t)]
    pub motion: Motion,
    #[command(flatten)]
    pub press: PressArgs,
    /// Model that the server runs: the press goes to its contact, as in `run` and `cosim`
    #[arg(long, value_name = "MODEL", conflicts_with = "path")]
    pub model: Option<PathBuf>,
    /// Contact that the server has: probe:RADIUS, cells:SELECTOR or auto [default: auto]
    #[arg(long, value_name = "CONTACT", requires = "model")]
    pub contact: Option<String>,
    /// Play the path or the motion N times; the ticks count on. Not with --out, which keeps the forces of one play
    #[arg(long, default_value_t = 1, value_name = "N", allow_negative_numbers = true)]
    pub repeat: u64,
    /// Folder for the poses, the forces, their curves and a summary
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite earlier results
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub server: ServerWait,
    #[command(flatten)]
    pub silence: SilenceArgs,
    #[command(flatten)]
    pub verdict: VerdictArgs,
    #[command(flatten)]
    pub inject: InjectArgs,
    #[command(flatten)]
    pub print: PrintArgs,
}

impl Args {
    fn poses(&self) -> Result<(Vec<Pose>, Vec<ToolPose>)> {
        match (&self.path, &self.contact) {
            (Some(_), Some(contact)) => Err(Error::input(format!(
                "--contact {contact}: it is for the press on a --model, and --path moves the tool itself: \
                 leave it out"
            ))),
            (Some(file), None) => {
                let paths = path::read(file, Rules::Strict)?;
                Ok(released_first(paths.in_metres(self.path_units.unit_m())))
            }
            (None, _) => Ok((self.press()?, Vec::new())),
        }
    }

    /// The built-in press: at the contact of the model, where it is known.
    fn press(&self) -> Result<Vec<Pose>> {
        let Motion::Press = self.motion;
        let Some(path) = &self.model else { return self.press.anywhere() };
        let image = model_file::read(path)?;
        let model = model_file::parse(&image, path)?;
        let contact = self.contact.as_deref().unwrap_or("auto");
        self.press.on(&model, &tissue::contact(contact, &model)?, DEVICE_HZ)
    }
}

/// A server takes poses as not engaged until the tool was released once: where the first row, or one of
/// a tool in the first tick, is engaged, one that is not goes ahead of it, numbered one below. Where
/// there is no number below, all others count one more.
fn released_first(paths: Paths) -> (Vec<Pose>, Vec<ToolPose>) {
    let count = paths.tools;
    let (mut poses, mut tools) = paths.concat();
    let ahead: Vec<ToolPose> =
        tools.iter().take(count).map(|&tool| ToolPose { engaged: 0, ..tool }).collect();
    let Some(&first) = poses.first() else { return (poses, tools) };
    if first.engaged == 0 && tools.iter().take(count).all(|tool| tool.engaged == 0) {
        return (poses, tools);
    }
    if first.tick == 0 {
        poses.iter_mut().for_each(|pose| pose.tick += 1);
    }
    poses.insert(0, Pose { tick: first.tick.saturating_sub(1), engaged: 0, ..first });
    tools.splice(0..0, ahead);
    (poses, tools)
}

pub fn execute(args: &Args) -> Result<()> {
    args.server.check()?;
    let faults = args.inject.faults()?;
    if faults.is_some_and(|(faults, _)| faults.sweep > 0.0) && !args.common.is_child {
        return Err(Error::input(
            "--inject: sweep is a fault of the tissue; give it to serve or cosim",
        ));
    }
    if args.out.is_some() && args.repeat > 1 {
        return Err(Error::input(format!(
            "--out: the forces of repeated plays are not kept; leave --repeat {} out",
            args.repeat
        )));
    }
    let (poses, tools) = args.poses()?;
    let folder = args.out.as_ref().map(|out| Folder::open(out, args.force)).transpose()?;
    // Play the poses.
    let options = ControlOptions {
        scene: args.common.scene.clone(),
        wait: args.common.wait,
        realtime: !args.common.no_realtime,
        ends_with_parent: args.common.is_child,
        wait_for_server_s: args.server.wait_for_server_s,
        says_wait: !args.common.is_child,
        repeats: args.repeat,
        histogram: args.common.histogram,
        watchdog_ms: args.silence.watchdog_ms,
        ramp_ms: args.silence.ramp_ms,
        faults,
        ..ControlOptions::default()
    };
    let run = control_tools(&poses, &tools, &options)?;
    // Judge and report.
    let report = &run.report;
    let verdict = args.verdict.judge(counts(report));
    let judgement = Judgement::default()
        .with_courses(&report.tool_courses, None)
        .with_remedy(remedy(args, report));
    if let Some(folder) = &folder {
        write(folder, (&poses, &tools), &run)?;
        folder.write_json("summary.json", &Printed::new(report, &judgement))?;
    }
    print(args, report, &judgement, &verdict)?;
    let outcome = if report.interrupted {
        Err(Error::interrupted(args.out.as_deref()))
    } else if report.ticks_unanswered > 0 {
        Err(Error::check(format!(
            "not answered: {} of {}",
            report.ticks_unanswered,
            counted(report.ticks_sent, "pose")
        )))
    } else {
        verdict.check(!args.print.json)
    };
    args.common.after_report(outcome)
}

/// Writes the poses, of several tools those of each, and the answers; of an interrupted session the poses up to
/// the last answer.
fn write(
    folder: &Folder,
    (poses, tools): (&[Pose], &[ToolPose]),
    ControlRun { report, forces }: &ControlRun,
) -> Result<()> {
    let per_tick = tools.len().checked_div(poses.len()).unwrap_or_default();
    let last = forces.last().map(|force| force.tick);
    let played = poses.iter().copied();
    let played = played.take_while(|pose| !report.interrupted || Some(pose.tick) <= last);
    let path = path::session_to_text(played, tools, per_tick);
    folder.write("path.csv", path.as_bytes())?;
    write_forces(folder, forces)?;
    let mut curve = ForceCurve::default();
    for force in forces {
        if let Ok(at) = poses.binary_search_by_key(&force.tick, |pose| pose.tick) {
            curve.add(force.tick, poses[at].position_m, force.force_n, force.contacts > 0);
        }
    }
    picture::write_curves(&curve, folder, DEVICE_HZ)
}

/// Late answers as this process sees them; those whose pose it sent late itself are the machine's.
fn counts(report: &ControlReport) -> Counts {
    let answers = report.ticks_answered;
    Counts {
        answers,
        late: report.missed_deadlines,
        unanswered: report.ticks_unanswered,
        floor_share: report.missed_sent_late as f64 / answers.max(1) as f64,
        ..Counts::default()
    }
}

/// The output of `--json`, and summary.json.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    report: &'a ControlReport,
    /// True if an answer had a contact; unknown where nothing was answered.
    has_touched: Option<bool>,
    judgement: &'a Judgement,
}

impl<'a> Printed<'a> {
    fn new(report: &'a ControlReport, judgement: &'a Judgement) -> Self {
        let courses = &report.tool_courses;
        let touched = courses.iter().any(|course| course.has_touched);
        let has_touched = (!courses.is_empty()).then_some(touched);
        Self { report, has_touched, judgement }
    }
}

fn print(
    args: &Args,
    report: &ControlReport,
    judgement: &Judgement,
    verdict: &Verdict,
) -> Result<()> {
    if args.print.json {
        return terminal::say_json(&Printed::new(report, judgement));
    }
    // Print privileges that were refused, and counts of poses and answers.
    tell_refused(&report.refused);
    terminal::say(format_args!(
        "{} sent, {} answered, {} later than 1 ms",
        counted(report.ticks_sent, "pose"),
        report.ticks_answered,
        report.missed_deadlines
    ))?;
    // Print flags, times and forces.
    terminal::say(format_args!(
        "  flags       {}; the server's watchdog acted on {}",
        report.flag_ticks,
        counted(report.stale_answers, "answer")
    ))?;
    terminal::say(format_args!("  round trip  {}", report.round_trip_ns.in_us()))?;
    terminal::say(format_args!("  sent late   {}", report.send_late_ns.in_us()))?;
    terminal::say(format_args!(
        "  force       largest {:.4} N, largest step {} N, {}",
        largest_n(&report.tool_courses),
        report.largest_force_step_n,
        counted(report.silences, "silence")
    ))?;
    // Print the judgement of the run, and injected faults.
    judgement.print(12)?;
    tell_injected(report.injected.as_ref())?;
    // Print the state, where the results are, and the verdict.
    terminal::say(format_args!("  state hash  {}", report.state_hash))?;
    if let Some(out) = &args.out {
        terminal::say(format_args!("  results     {}", out.display()))?;
    }
    match &args.model {
        Some(model) => tell_view(12, &[model])?,
        None => terminal::say(
            "  view        chaincell view DIR, of `serve --out DIR`: a controller knows forces, and no body",
        )?,
    }
    terminal::say(format_args!("  verdict     {verdict}"))
}

/// The remedy where nothing was touched.
fn remedy(args: &Args, report: &ControlReport) -> Option<&'static str> {
    if report.flag_ticks.of(Flags::STARTS_INSIDE) > 0 {
        return Some(
            "it began inside the body, where a tool waits until all of it has been outside: begin outside, \
             with --model MODEL --contact probe:RADIUS for a press, or with another --touch-m or --path",
        );
    }
    (args.path.is_none() && args.model.is_none())
        .then_some("--model MODEL --contact probe:RADIUS puts the press where the probe meets it")
}
