//! Both processes of a co-simulation under one command: their options in one settings file.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::{Args, Command};
use serde::{Deserialize, Serialize};

use super::budget::BudgetArgs;
use super::inject::InjectArgs;
use super::load::Lengths;
use super::pins::PinArgs;
use super::record::RecordArgs;
use super::session::LoopArgs;
use super::shared::{FolderArgs, PrintArgs};
use super::stage::StageArgs;
use super::stress::StressArgs;
use super::tissue::TissueArgs;
use super::verdict::VerdictArgs;
use super::{control, serve};
use crate::engine::motion::Pose;
use crate::error::{Error, Result};
use crate::files::path;
use crate::files::whole::write_whole;
use crate::session::ipc::services::Domain;
use crate::session::loops::floor::{self, Floor};
use crate::session::loops::inject::Plan;
use crate::session::loops::serve::POSE_HZ;
use crate::session::supervise::{CosimOptions, CosimReports, Underway, cosim};
use crate::session::timing::clock::MILLISECOND_NS;
use crate::terminal::Progress;
use crate::text;

/// Longest wait for `serve` \[s\].
const READY_S: u64 = 20;
/// Option of both sides that stands alone.
const OPTION: &str = "--settings";
/// Name of the settings file.
const SETTINGS: &str = "settings.json";
/// Size limit of a settings file \[bytes\].
const SETTINGS_BYTES_MAX: u64 = 1 << 20;

/// The settings file: options of both sides.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Options of the tissue's side.
    pub serve: serve::Args,
    /// Options of the controller's side.
    pub control: control::Args,
}

impl Settings {
    fn read(path: &Path) -> Result<Self> {
        let refused = |why: String| Error::file("read settings", path, why);
        let text = text::read(path, SETTINGS_BYTES_MAX).map_err(|why| refused(why.to_string()))?;
        serde_json::from_str(&text).map_err(|why| {
            // A line of the file is a field.
            let line = text.lines().nth(why.line().saturating_sub(1)).unwrap_or_default();
            refused(format!("{why}: {}", line.trim()))
        })
    }
}

/// Carries out `serve --settings FILE` or `control --settings FILE`, which [`run`] starts; `None` for other
/// words.
pub fn execute(words: &[OsString]) -> Option<Result<()>> {
    let [side, option, path] = words else { return None };
    let settings = || Settings::read(Path::new(path));
    match (side.to_str(), option.to_str()) {
        (Some("serve"), Some(OPTION)) => Some(settings().and_then(|of| serve::execute(&of.serve))),
        (Some("control"), Some(OPTION)) => {
            Some(settings().and_then(|of| control::execute(&of.control)))
        }
        _ => None,
    }
}

/// Returns the options of a command line that has the words alone.
fn defaults<A: Args>(words: &[&str]) -> Result<A> {
    let command = A::augment_args(Command::new("chaincell").no_binary_name(true));
    let matches = command.try_get_matches_from(words);
    matches.and_then(|matches| A::from_arg_matches(&matches)).map_err(Error::check)
}

/// Files of a session.
pub struct Files<'a> {
    /// Model image.
    pub model: &'a Path,
    /// Folder for scratch files.
    pub scratch: &'a Path,
    /// Folder for the results of `serve`.
    pub out: Option<&'a Path>,
}

/// Options of both sides.
pub struct Sides<'a> {
    /// Lengths of the session.
    pub lengths: Lengths,
    /// True for a report with histograms from each.
    pub histogram: bool,
    /// Options of the tissue.
    pub tissue: &'a TissueArgs,
    /// Options of the loops.
    pub common: &'a LoopArgs,
    /// Options of the output stage.
    pub stage: StageArgs,
    /// Pins of the first tick.
    pub pins: PinArgs,
    /// Limit of the stress.
    pub stress: StressArgs,
    /// Time of a tick.
    pub budget: BudgetArgs,
    /// Deliberate faults.
    pub inject: InjectArgs,
}

impl<'a> Sides<'a> {
    /// The options of these, without an output stage, pins, a limit of the stress, a budget and faults.
    pub fn of(lengths: Lengths, tissue: &'a TissueArgs, common: &'a LoopArgs) -> Self {
        let (stage, budget, inject) =
            (StageArgs::default(), BudgetArgs::default(), InjectArgs::default());
        let (pins, stress) = (PinArgs::default(), StressArgs::default());
        Self { lengths, histogram: false, tissue, common, stage, pins, stress, budget, inject }
    }

    fn common(&self) -> LoopArgs {
        LoopArgs { is_child: true, histogram: self.histogram, ..self.common.clone() }
    }

    /// Options of `serve`, for a session with this number of answers.
    fn serve(&self, files: &Files<'_>, answers: u64) -> Result<serve::Args> {
        let faults = self.inject.faults()?;
        Ok(serve::Args {
            model: files.model.to_owned(),
            tissue: self.tissue.clone(),
            common: self.common(),
            // Poses that are sent faster on purpose have to be executed.
            max_pose_hz: faults.map_or(POSE_HZ, |(faults, _)| faults.rate_hz.max(POSE_HZ)),
            ticks: Some(answers),
            record: RecordArgs {
                folder: FolderArgs { out: files.out.map(Path::to_owned), force: true },
                record_ticks: files.out.and(usize::try_from(answers).ok()),
                record: None,
            },
            pins: self.pins.clone(),
            stress: self.stress.clone(),
            budget: self.budget,
            verdict: VerdictArgs::off(),
            stage: self.stage.clone(),
            inject: self.inject.of_tissue()?,
            print: PrintArgs { json: true },
            ..defaults(&["MODEL"])?
        })
    }

    /// Options of `control`, for the poses of a file.
    fn control(&self, poses: PathBuf) -> Result<control::Args> {
        Ok(control::Args {
            common: self.common(),
            path: Some(poses),
            repeat: self.lengths.presses,
            verdict: VerdictArgs::off(),
            inject: self.inject.clone(),
            print: PrintArgs { json: true },
            ..defaults(&[])?
        })
    }
}

/// Measurements of a session.
pub struct Session {
    /// Reports of both processes.
    pub reports: CosimReports,
    /// The floor of the machine, measured directly before.
    pub floor: Floor,
}

/// Measures the floor, then runs both processes over `poses`, as often as the lengths say; calls `watch`
/// meanwhile.
pub fn run(
    files: &Files<'_>,
    poses: &[Pose],
    sides: &Sides<'_>,
    watch: impl FnMut(Underway),
) -> Result<Session> {
    let Lengths { presses, floor_ticks, .. } = sides.lengths;
    // Plan the poses.
    let totals = Plan::new(poses.len() as u64 * presses, sides.inject.faults()?).totals();
    if totals.answers == 0 {
        return Err(Error::input("--inject: no pose would be left to answer; lose fewer of them"));
    }
    // Measure the floor.
    let spinner = Progress::new(1, "measuring the machine's floor");
    let realtime = !sides.common.no_realtime;
    let floor = floor::measure(sides.common.wait, realtime, floor_ticks, &Domain::default())?;
    drop(spinner);
    // Write the poses and the settings.
    let sent = files.scratch.join("sent.csv");
    write_whole(&sent, path::to_text(poses.iter().copied()).as_bytes())?;
    let (serve, control) = (sides.serve(files, totals.answers)?, sides.control(sent)?);
    let settings = files.scratch.join(SETTINGS);
    let text = serde_json::to_string_pretty(&Settings { serve, control })
        .map_err(|why| Error::input(format!("the model or --out: {why}; give it a plain name")))?;
    write_whole(&settings, text.as_bytes())?;
    // Run both processes.
    let program = std::env::current_exe()
        .map_err(|why| Error::check(format!("cannot find this executable: {why}")))?;
    let side = |name: &str| vec![OsString::from(name), OPTION.into(), settings.clone().into()];
    let options = CosimOptions {
        program,
        serve_args: side("serve"),
        control_args: side("control"),
        motion_ms: totals.end_ns / MILLISECOND_NS,
        ready_s: READY_S,
    };
    Ok(Session { reports: cosim(&options, watch)?, floor })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Options of a session with everything that an option can say.
    fn settings() -> Settings {
        let words = [
            "m",
            "--tool",
            "sphere:0.01@0,0,0.1+box:1,2,3,0.1",
            "--scheme",
            "predict",
            "--threads",
            "auto",
            "--drive",
            "current",
            "--max-force-n",
            "0.1",
            "--friction",
            "1e-7",
            "--wait",
            "spin",
            "--budget-us",
            "750",
            "--late-share",
            "2.5%",
            "--device",
            "falcon",
            "--coupling",
            "700.5:0.25",
            "--passivity",
            "none",
            "--max-speed-m-per-s",
            "off",
            "--delay-ticks",
            "auto",
            "--pin",
            "-0.01,0.02,0.04,0.006",
            "--pin",
            "0.01,0.02,0.04,0.006,2.7",
            "--stress-limit-pa",
            "0.1",
            "--inject",
            "sweep:0.8@9",
            "--inject-seed",
            "7",
        ];
        Settings { serve: defaults(&words).unwrap(), control: defaults(&[]).unwrap() }
    }

    #[test]
    fn a_settings_file_keeps_every_option() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(SETTINGS);
        let text = serde_json::to_string_pretty(&settings()).unwrap();
        std::fs::write(&path, &text).unwrap();
        let read = Settings::read(&path).unwrap();
        assert_eq!(format!("{read:?}"), format!("{:?}", settings()));
    }

    #[test]
    fn a_bad_settings_file_is_refused_with_file_and_field() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(SETTINGS);
        let text = serde_json::to_string_pretty(&settings()).unwrap();
        for (good, bad, parts) in [
            ("\"threads\": \"auto\"", "\"threads\": \"few\"", ["\"threads\": \"few\"", "or auto"]),
            (
                "\"wait\": \"spin\"",
                "\"wait\": \"turn\"",
                ["\"wait\": \"turn\"", "hybrid, spin or event"],
            ),
            ("\"watchdog_ms\": 20,", "", ["missing field", "watchdog_ms"]),
            ("\"ramp_ms\": 20", "\"ramp_ms\": 20, \"ramps\": 1", ["unknown field", "ramps"]),
        ] {
            assert!(text.contains(good), "{good}: {text}");
            std::fs::write(&path, text.replacen(good, bad, 1)).unwrap();
            let why = Settings::read(&path).unwrap_err();
            assert_eq!(why.exit_code(), 2);
            let why = why.to_string();
            assert!(why.contains(path.to_str().unwrap()), "{why}");
            assert!(parts.iter().all(|part| why.contains(part)), "{why}");
        }
    }
}
