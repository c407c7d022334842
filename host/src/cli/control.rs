//! `chaincell control`: the controller's process of a co-simulation.

use std::path::PathBuf;

use clap::ValueEnum;

use super::inject::{InjectArgs, tell_injected};
use super::session::{LoopArgs, tell_refused};
use super::verdict::{Counts, Verdict, VerdictArgs};
use crate::engine::motion::{Pose, Press};
use crate::error::{Error, Result};
use crate::files::path::{self, Rules};
use crate::session::ipc::payload::ToolPose;
use crate::session::loops::control::{ControlOptions, ControlReport, control};
use crate::terminal;
use crate::words::counted;

/// Send tool poses at 1 kHz to a served scene and time its answers.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell control --scene left --path press.csv\n  \
    chaincell control --motion press --touch-m 0,0,0.05 --direction=0,0,-1 --depth-m 0.01")]
pub struct Args {
    #[command(flatten)]
    common: LoopArgs,
    /// Path of tool positions (CSV), one row a millisecond
    #[arg(long, value_name = "PATH.csv", conflicts_with = "motion")]
    path: Option<PathBuf>,
    /// Built-in motion: approach, minimum-jerk press, hold with an 8 to 12 Hz tremor, retreat
    #[arg(long, value_enum, default_value_t)]
    motion: Motion,
    /// Point where the press touches, x,y,z [m]; with a probe its centre then: a radius outside
    #[arg(long, default_value = "0,0,0", value_name = "X,Y,Z", value_parser = vector,
        allow_hyphen_values = true)]
    touch_m: Vector,
    /// Direction of the press
    #[arg(long, default_value = "0,0,-1", value_name = "X,Y,Z", value_parser = vector,
        allow_hyphen_values = true)]
    direction: Vector,
    /// Depth of the press [m]
    #[arg(long, default_value_t = 0.01, value_name = "D", allow_negative_numbers = true)]
    depth_m: f64,
    /// Length of the press [s]
    #[arg(long, default_value_t = 10.0, value_name = "S", allow_negative_numbers = true)]
    seconds: f64,
    /// Play the path or the motion so many times, its ticks counting on
    #[arg(long, default_value_t = 1, value_name = "N", allow_negative_numbers = true)]
    repeat: u64,
    /// Longest wait for a server [s]
    #[arg(long, default_value_t = 10.0, value_name = "S", allow_negative_numbers = true)]
    wait_for_server_s: f64,
    /// Silence of the server after which the force at the device falls to 0, 0 for never [ms]
    #[arg(long, default_value_t = 20, value_name = "MS", allow_negative_numbers = true)]
    watchdog_ms: u32,
    /// Time in which it falls, and rises when answers come again; 0 for at once [ms]
    #[arg(long, default_value_t = 20, value_name = "MS", allow_negative_numbers = true)]
    ramp_ms: u32,
    #[command(flatten)]
    verdict: VerdictArgs,
    #[command(flatten)]
    inject: InjectArgs,
    /// Print the report as one JSON object, the last line
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
enum Motion {
    /// Approach, press, hold, retreat
    #[default]
    Press,
}

/// Three coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Vector([f64; 3]);

fn vector(text: &str) -> std::result::Result<Vector, String> {
    let numbers: Option<Vec<f64>> =
        text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
    let three = numbers.and_then(|numbers| numbers.try_into().ok());
    three.map(Vector).ok_or_else(|| "give three finite numbers, x,y,z".to_owned())
}

/// Ticks in a number of seconds.
///
/// # Errors
/// Less than the built-in press has room for, more than a day, or no number.
pub fn ticks(seconds: f64) -> Result<u64> {
    if seconds.is_finite() && (0.02..=86_400.0).contains(&seconds) {
        Ok((seconds * 1000.0).round() as u64)
    } else {
        Err(Error::input(format!("--seconds {seconds}: must be from 0.02 to 86400")))
    }
}

impl Args {
    fn poses(&self) -> Result<Vec<Pose>> {
        match &self.path {
            Some(file) => {
                let sequences = path::read(file, Rules::Strict)?;
                Ok(released_first(sequences.concat()))
            }
            None => {
                let ticks = ticks(self.seconds)?;
                Press::new(self.touch_m.0, self.direction.0, self.depth_m, ticks)
                    .map(|press| press.poses())
            }
        }
    }
}

/// A server takes poses as not engaged until the tool was released once: where the first row is
/// engaged, one that is not goes ahead of it, numbered one below. Where there is no number below,
/// all others count one more.
fn released_first(mut poses: Vec<Pose>) -> Vec<Pose> {
    let Some(&first) = poses.first().filter(|first| first.engaged != 0) else { return poses };
    if first.tick == 0 {
        poses.iter_mut().for_each(|pose| pose.tick += 1);
    }
    poses.insert(0, Pose { tick: first.tick.saturating_sub(1), engaged: 0, ..first });
    poses
}

pub fn execute(args: &Args) -> Result<()> {
    if !(args.wait_for_server_s.is_finite() && args.wait_for_server_s >= 0.0) {
        return Err(Error::input(format!(
            "--wait-for-server-s {}: must be 0 or more",
            args.wait_for_server_s
        )));
    }
    let faults = args.inject.faults()?;
    if faults.is_some_and(|(faults, _)| faults.sweep > 0.0) && !args.common.ends_with_parent {
        return Err(Error::input(
            "--inject: sweep is a fault of the tissue; give it to serve or cosim",
        ));
    }
    let poses: Vec<ToolPose> = args.poses()?.into_iter().map(ToolPose::from).collect();
    let options = ControlOptions {
        scene: args.common.scene.clone(),
        wait: args.common.wait,
        realtime: !args.common.no_realtime,
        ends_with_parent: args.common.ends_with_parent,
        wait_for_server_s: args.wait_for_server_s,
        repeats: args.repeat,
        histogram: args.common.histogram,
        watchdog_ms: args.watchdog_ms,
        ramp_ms: args.ramp_ms,
        faults,
        ..ControlOptions::default()
    };
    let report = control(&poses, &options)?.report;
    let verdict = args.verdict.judge(counts(&report));
    print(args, &report, &verdict)?;
    let outcome = if report.interrupted {
        Err(Error::Interrupted)
    } else if report.ticks_unanswered > 0 {
        Err(Error::check(format!(
            "not answered: {} of {}",
            report.ticks_unanswered,
            counted(report.ticks_sent, "pose")
        )))
    } else {
        verdict.check(!args.json)
    };
    args.common.after_report(outcome)
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

fn print(args: &Args, report: &ControlReport, verdict: &Verdict) -> Result<()> {
    if args.json {
        return terminal::say_json(report);
    }
    tell_refused(&report.refused);
    terminal::say(format_args!(
        "{} sent, {} answered, {} later than 1 ms",
        counted(report.ticks_sent, "pose"),
        report.ticks_answered,
        report.missed_deadlines
    ))?;
    terminal::say(format_args!(
        "  flags       {}; watchdog of the tissue in {}",
        report.flag_ticks,
        counted(report.stale_answers, "message")
    ))?;
    terminal::say(format_args!("  round trip  {}", report.round_trip_ns.in_us()))?;
    terminal::say(format_args!("  sent late   {}", report.send_late_ns.in_us()))?;
    terminal::say(format_args!(
        "  force       largest step {} N, {}",
        report.largest_force_step_n,
        counted(report.silences, "silence")
    ))?;
    tell_injected(report.injected.as_ref())?;
    terminal::say(format_args!("  state hash  {}", report.state_hash))?;
    terminal::say(format_args!("  verdict     {verdict}"))
}
