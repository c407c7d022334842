//! `chaincell serve`: the tissue's process of a co-simulation.

use std::path::PathBuf;

use chaincell_kernel::trace::Record;
use chaincell_kernel::{Flags, TickOutput};
use nalgebra::Vector3;
use serde::Serialize;

use super::model_file;
use super::scene::{SceneArgs, SceneReport};
use super::session::{LoopArgs, tell_refused};
use super::stage::{StageArgs, StageReport};
use crate::cosim::payload::ToolForce;
use crate::cosim::record::Recorder;
use crate::cosim::serve::{Ending, ServeOptions, ServeReport, Server};
use crate::error::{Error, Result};
use crate::output::{Answer, Folder, force_csv};
use crate::recording::Recording;
use crate::staged::Staged;
use crate::{path, terminal};

/// Ticks that are recorded unless the run's length is known: ten minutes.
const RECORD_TICKS: usize = 600_000;

/// Serve a model over shared memory: each pose is one tick and one answer.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell serve liver.chaincell --scene left\n\n\
    Prints `ready` once chaincell/left/pose and chaincell/left/force exist; ends on Ctrl-C.\n  \
    `chaincell state` reads its states, `chaincell command` resets, pauses and sets it.")]
pub struct Args {
    /// Model file from `chaincell bake`
    model: PathBuf,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    common: LoopArgs,
    /// Silence after which the published force falls to 0, 0 for never [ms]
    #[arg(long, default_value_t = 20, value_name = "MS", allow_negative_numbers = true)]
    watchdog_ms: u32,
    /// Time in which it falls, and rises when poses come again; 0 for at once [ms]
    #[arg(long, default_value_t = 20, value_name = "MS", allow_negative_numbers = true)]
    ramp_ms: u32,
    /// Send the state hash with every so many ticks; 0 for none but the last
    #[arg(long, default_value_t = 1, value_name = "N", allow_negative_numbers = true)]
    hash_every: u64,
    /// Send the positions of all nodes to viewers so many times a second at most, 0 for never [Hz]
    #[arg(long, default_value_t = 60, value_name = "HZ", allow_negative_numbers = true)]
    state_hz: u32,
    /// End after so many ticks
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    ticks: Option<u64>,
    /// End after so many seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Folder for the model, the poses as received, the forces, a trace and a summary
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite the results of an earlier run in --out
    #[arg(long)]
    force: bool,
    /// Ticks kept for --out [default: --ticks, or ten minutes]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    record_ticks: Option<usize>,
    #[command(flatten)]
    stage: StageArgs,
    /// Print the report as one JSON object, the last line
    #[arg(long)]
    json: bool,
}

/// summary.json
#[derive(Debug, Serialize)]
struct ServeSummary<'a> {
    cells: usize,
    links: usize,
    #[serde(flatten)]
    report: &'a ServeReport,
    #[serde(flatten)]
    scene: SceneReport,
    watchdog_ms: u32,
    ramp_ms: u32,
    stage: Option<StageReport>,
}

pub fn execute(args: &Args) -> Result<()> {
    if args.seconds.is_some_and(|seconds| seconds.is_nan() || seconds <= 0.0) {
        return Err(Error::input("--seconds: must be above 0"));
    }
    let image = model_file::read(&args.model)?;
    let model = model_file::parse(&image, &args.model)?;
    let mut tissue = Staged::new(args.scene.engine(model)?, args.stage.settings())?;
    let known = args.ticks.and_then(|ticks| usize::try_from(ticks).ok());
    let wanted = args.record_ticks.or(known).unwrap_or(RECORD_TICKS).min(100 * RECORD_TICKS);
    let mut recorder = Recorder::with_capacity(if args.out.is_some() { wanted } else { 0 });
    let options = ServeOptions {
        scene: args.common.scene.clone(),
        wait: args.common.wait,
        realtime: !args.common.no_realtime,
        ends_with_parent: args.common.ends_with_parent,
        watchdog_ms: args.watchdog_ms,
        ramp_ms: args.ramp_ms,
        hash_every: args.hash_every,
        ticks: args.ticks,
        seconds: args.seconds,
        ..ServeOptions::default()
    };
    // A scene that is refused leaves the folder as it was.
    let nodes = tissue.engine().node_count();
    let server = Server::open(&options)?.with_state(nodes, args.state_hz)?.with_commands()?;
    let folder = args.out.as_ref().map(|out| Folder::open(out, args.force)).transpose()?;
    // Commands may set parameters: what is written is what the session began with.
    let scene = args.scene.report(tissue.engine());
    let begun = Recording::begin(tissue.engine(), args.scene.dynamics, args.scene.number)?;
    terminal::say("ready")?;
    let report = server.run(&mut tissue, &mut recorder)?;
    if let Some(folder) = &folder {
        let (cells, links) = (model.cells(), model.links());
        folder.write("model.chaincell", image.as_bytes())?;
        folder
            .write("path.csv", path::to_text(recorder.rows().iter().map(|row| row.0)).as_bytes())?;
        folder.write("session.trace", trace(begun, &recorder).bytes())?;
        let answers: Vec<Answer> = recorder.rows().iter().map(|row| answer(&row.1)).collect();
        folder.write("force.csv", force_csv(&answers).as_bytes())?;
        let summary = ServeSummary {
            cells,
            links,
            report: &report,
            scene,
            watchdog_ms: args.watchdog_ms,
            ramp_ms: args.ramp_ms,
            stage: args.stage.report(),
        };
        folder.write_json("summary.json", &summary)?;
    }
    print(args, &report)?;
    if report.ended_by == Ending::Interrupt { Err(Error::Interrupted) } else { Ok(()) }
}

/// The session as a trace, for `chaincell replay`.
fn trace(mut recording: Recording, recorder: &Recorder) -> Recording {
    let mut commands = recorder.commands().iter().peekable();
    let rows = recorder.rows();
    for at in 0..=rows.len() {
        while let Some((_, command)) = commands.next_if(|(before, _)| *before == at) {
            recording.add_command(command);
        }
        if let Some((pose, force)) = rows.get(at) {
            let state_hash = (force.state_hash != 0).then_some(force.state_hash);
            recording.add(&Record { tick: pose.tick, sample: (*pose).into(), state_hash });
        }
    }
    recording
}

/// The kernel's answer in a published message.
fn answer(force: &ToolForce) -> Answer {
    let output = TickOutput {
        force_n: Vector3::from(force.force_n),
        energy_j: force.energy_j,
        contacts: force.contacts,
        flags: Flags(force.flags),
    };
    Answer { tick: force.tick, output }
}

fn print(args: &Args, report: &ServeReport) -> Result<()> {
    if args.json {
        return terminal::say_json(report);
    }
    tell_refused(&report.refused);
    terminal::say(format_args!(
        "{} ticks answered, {} repeated, {} refused, watchdog {} times",
        report.ticks_executed, report.poses_repeated, report.poses_refused, report.watchdog_fired
    ))?;
    terminal::say(format_args!("  step        {}", report.step_ns.in_us()))?;
    terminal::say(format_args!("  force       largest step {} N", report.largest_force_step_n))?;
    terminal::say(format_args!(
        "  peers       {} joined, {} left; longest call meanwhile {:.1} us",
        report.peers.joins,
        report.peers.leaves,
        report.peers.longest_ns() as f64 * 1e-3
    ))?;
    if report.states_sent > 0 {
        terminal::say(format_args!(
            "  states      {} sent, {}",
            report.states_sent,
            report.state_ns.in_us()
        ))?;
    }
    if report.commands_done + report.commands_refused > 0 {
        terminal::say(format_args!(
            "  commands    {} done, {} refused; {} ticks while paused",
            report.commands_done, report.commands_refused, report.ticks_paused
        ))?;
    }
    if report.ticks_unrecorded > 0 {
        terminal::note(format_args!(
            "note: {} ticks were not recorded; raise --record-ticks",
            report.ticks_unrecorded
        ));
    }
    terminal::say(format_args!("  state hash  {}", report.state_hash))
}
