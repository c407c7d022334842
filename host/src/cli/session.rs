//! Arguments that every command which loops at 1 kHz shares, and lines that several of them print.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;

use chaincell_kernel::{Choice, Flags, Model, TickOutput};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use tempfile::TempDir;

use super::choice::parser;
use super::press::press_on;
use crate::choice;
use crate::engine::Engine;
use crate::engine::motion::Pose;
use crate::error::{Error, Result};
use crate::files::output::{Answer, Folder, force_csv};
use crate::session::ipc;
use crate::session::ipc::services::Domain;
use crate::session::ipc::serving::ServePorts;
use crate::session::ipc::tools::TickForce;
use crate::session::loops::wait::Wait;
use crate::session::timing::histogram::Summary;
use crate::terminal;
use crate::words::counted;

/// Arguments of every command that loops at 1 kHz.
#[derive(Debug, Clone, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct LoopArgs {
    /// Name of the scene: services chaincell/NAME/tools and chaincell/NAME/forces
    #[arg(long, value_name = "NAME")]
    pub scene: Option<String>,
    /// How to wait for the other process
    #[serde(with = "choice")]
    #[arg(long, value_parser = parser::<Wait>(), default_value = Wait::default().name())]
    pub wait: Wait,
    /// Do not ask for real-time scheduling, locked memory and a core of its own
    #[arg(long)]
    pub no_realtime: bool,
    /// True for a process that ends with its parent, which reads its report.
    #[arg(skip)]
    pub is_child: bool,
    /// True for a report with histograms.
    #[arg(skip)]
    pub histogram: bool,
}

impl LoopArgs {
    /// Refuses a scene that cannot be served, before anything is measured or written.
    pub fn check(&self) -> Result<()> {
        let scene = ipc::open(self.scene.as_deref(), &Domain::default())?;
        ServePorts::open(&scene, false).map(|_| ())
    }

    /// How a side ends that has printed its report: where another process of this program reads
    /// the report, that one names the error.
    pub fn after_report(&self, outcome: Result<()>) -> Result<()> {
        outcome.map_err(|why| match self.is_child {
            true => Error::Reported(why.exit_code()),
            false => why,
        })
    }
}

/// Writes the forces of a session's messages into force.csv.
///
/// # Errors
/// As [`Folder::write`].
pub fn write_forces<'a>(
    folder: &Folder,
    forces: impl IntoIterator<Item = &'a TickForce>,
) -> Result<()> {
    let answers: Vec<Answer> = forces.into_iter().map(answer).collect();
    folder.write("force.csv", force_csv(&answers).as_bytes())
}

/// The kernel's answer in a published message.
fn answer(force: &TickForce) -> Answer {
    let output = TickOutput {
        force_n: Vector3::from(force.force_n),
        energy_j: force.energy_j,
        contacts: force.contacts,
        flags: Flags(force.flags),
        ..TickOutput::NONE
    };
    let force_error_n = force.force_error_n;
    Answer { tick: force.tick, output, cut_area_m2: None, force_error_n }
}

/// Names the real-time privileges that were refused.
pub fn tell_refused(refused: &[String]) {
    for refused in refused {
        terminal::note(format_args!("note: {refused} (not needed, worst cases get longer)"));
    }
}

/// A folder for scratch files that this user alone may enter, gone with the value.
pub fn scratch() -> Result<TempDir> {
    let folder = tempfile::Builder::new().permissions(Permissions::from_mode(0o700)).tempdir();
    folder.map_err(|why| Error::file("create folder in", &std::env::temp_dir(), why))
}

/// Prints latencies, a name and a row of percentiles each.
pub fn tell_latencies(rows: &[(&str, &Summary)]) -> Result<()> {
    rows.iter().try_for_each(|(name, figures)| {
        terminal::say(format_args!("  {name:<18}{}", figures.in_us()))
    })
}

/// The built-in press on the body of an engine, at its contact.
pub fn press(engine: &Engine<'_>, depth_m: Option<f64>, ticks: u64) -> Result<Vec<Pose>> {
    press_on(engine.network().model(), engine.contact(), depth_m, ticks)
}

/// Size in a line, for headings.
pub fn describe(model: &Model<'_>) -> String {
    format!("{}, {}", counted(model.body_cells(), "cell"), counted(model.links(), "link"))
}
