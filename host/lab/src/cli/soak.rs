//! `chaincell soak`: both processes for hours, with load beside them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::experiments::report::machine::Machine;
use crate::experiments::soak::load::{self, Load};
use crate::experiments::soak::memory::{Growth, Memory, Watch};
use crate::experiments::soak::report::{Missed, SoakFloor, SoakReport};
use crate::experiments::soak::write;
use chaincell_host::bake::organ;
use chaincell_host::cli::model_file;
use chaincell_host::cli::session::{self, LoopArgs, tell_refused};
use chaincell_host::cli::tissue::TissueArgs;
use chaincell_host::engine::Engine;
use chaincell_host::engine::motion::Pose;
use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_host::files::path;
use chaincell_host::files::whole::write_whole;
use chaincell_host::interrupt;
use chaincell_host::session::ipc::services::Domain;
use chaincell_host::session::loops::control::ControlReport;
use chaincell_host::session::loops::floor;
use chaincell_host::session::supervise::{self, CosimOptions, CosimReports, Underway, program};
use chaincell_host::terminal;
use chaincell_host::words::counted;

/// Length unless given: ten minutes [s].
const SECONDS: f64 = 600.0;
/// Shortest and longest run [s].
const SECONDS_RANGE: std::ops::RangeInclusive<f64> = 3.0..=31.0 * 86_400.0;
/// Longest press; shorter where fewer than four would fit [s].
const PRESS_S: f64 = 10.0;
/// Fewest presses.
const PRESSES_MIN: f64 = 4.0;
/// Memory counts from a press and this on, but from the middle of the run at the latest [s].
const WARM_UP_S: f64 = 10.0;
/// Length of each measurement of the machine's floor: a tenth of the run, within [s].
const FLOOR_S: [f64; 2] = [1.0, 600.0];
/// Span between progress lines.
const PROGRESS: Duration = Duration::from_secs(10);
/// Longest wait for `serve` [s].
const READY_S: u64 = 20;

/// Run both processes for hours under load: histograms, memory growth, deadlines missed.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell soak --hours 8 --out soak\n  \
    chaincell soak liver.chaincell --seconds 600 --no-load --json\n\n\
    A press is played over and over. Before and after, for a tenth of the time each, the same loops\n\
    run under the same load without a tissue: what they miss is the machine's own. Exit code 1 when\n\
    a tick was not answered or a process took more memory at the end than after the warm-up.")]
pub struct Args {
    /// Model file from `chaincell bake` [default: organ:1000, 5 kPa, Poisson's ratio 0.45]
    model: Option<PathBuf>,
    /// Length of the run [h]
    #[arg(long, value_name = "H", allow_negative_numbers = true, conflicts_with = "seconds")]
    hours: Option<f64>,
    /// Length of the run [s] [default: 600]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Depth of the press [m] [default: 3 mean link lengths]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    depth_m: Option<f64>,
    /// Threads that keep the other cores and the memory busy [default: all cores but one]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    load: Option<u16>,
    /// No load
    #[arg(long, conflicts_with = "load")]
    no_load: bool,
    #[command(flatten)]
    tissue: TissueArgs,
    #[command(flatten)]
    common: LoopArgs,
    /// Folder for soak.json, histogram.csv and a chart
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite the results of an earlier run in --out
    #[arg(long)]
    force: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// How long everything takes.
#[derive(Debug, Clone, Copy)]
struct Plan {
    press_ticks: u64,
    presses: u64,
    floor_ticks: u64,
    warm_up: Duration,
}

impl Plan {
    fn new(args: &Args) -> Result<Self> {
        let hours_s = args.hours.map(|hours| 3600.0 * hours);
        let seconds = hours_s.or(args.seconds).unwrap_or(SECONDS);
        if !SECONDS_RANGE.contains(&seconds) {
            let given = match args.hours {
                Some(hours) => format!("--hours {hours}"),
                None => format!("--seconds {seconds}"),
            };
            return Err(Error::input(format!(
                "{given}: must be from {} s to {} s (31 days)",
                SECONDS_RANGE.start(),
                SECONDS_RANGE.end()
            )));
        }
        let presses = (seconds / PRESS_S).ceil().max(PRESSES_MIN);
        let press_s = seconds / presses;
        let ticks = |seconds: f64| (1000.0 * seconds).round() as u64;
        Ok(Self {
            press_ticks: ticks(press_s),
            presses: presses as u64,
            floor_ticks: ticks((0.1 * seconds).clamp(FLOOR_S[0], FLOOR_S[1])),
            warm_up: Duration::from_secs_f64((press_s + WARM_UP_S).min(0.5 * seconds)),
        })
    }

    fn ticks(&self) -> u64 {
        self.press_ticks * self.presses
    }
}

pub fn execute(args: &Args) -> Result<()> {
    let plan = Plan::new(args)?;
    args.common.check()?;
    let scratch = session::scratch()?;
    let (image, model_path) = match &args.model {
        Some(path) => (model_file::read(path)?, path.clone()),
        None => (organ()?, scratch.path().join("organ.chaincell")),
    };
    let model = model_file::parse(&image, &model_path)?;
    let engine = args.tissue.engine(model)?;
    let poses = session::press(&engine, args.depth_m, plan.press_ticks)?;
    let folder = args.out.as_ref().map(|out| Folder::open(out, args.force)).transpose()?;
    if args.model.is_none() {
        write_whole(&model_path, image.as_bytes())?;
    }
    let load = Load::start(match args.load {
        Some(threads) => threads.into(),
        None if args.no_load => 0,
        None => load::default_threads(),
    })?;
    terminal::note(format_args!(
        "soak: {}, {} s; {} s before and after without a tissue",
        session::describe(&model),
        plan.ticks() as f64 / 1000.0,
        plan.floor_ticks as f64 / 1000.0
    ));
    let before = floor_run(args, &plan)?;
    let both = both(args, &plan, &poses, &model_path, scratch.path())?;
    let after = match both.reports.interrupted {
        true => Err(Error::Interrupted),
        false => floor_run(args, &plan),
    };
    let after = match after {
        Err(Error::Interrupted) => None,
        run => Some(run?),
    };
    let report = SoakReport { load: load.end(), ..report(&plan, &engine, both, &before, after) };
    if let Some(folder) = &folder {
        interrupt::ignoring(|| write::files(&report, folder))?;
    }
    print(args, &report)?;
    report.judge()
}

/// The same loops under the same load, without a tissue.
fn floor_run(args: &Args, plan: &Plan) -> Result<ControlReport> {
    let realtime = !args.common.no_realtime;
    floor::without_tissue(args.common.wait, realtime, plan.floor_ticks, &Domain::default())
}

/// What both processes said, and their memory.
struct Both {
    reports: CosimReports,
    memory: [Growth; 2],
}

fn both(args: &Args, plan: &Plan, poses: &[Pose], model: &Path, scratch: &Path) -> Result<Both> {
    let sent = scratch.join("press.csv");
    write_whole(&sent, path::to_text(poses.iter().copied()).as_bytes())?;
    let mut common = args.common.to_args();
    common.push("--histogram".into());
    let mut serve_args: Vec<OsString> = vec!["serve".into(), model.into()];
    serve_args.extend(common.iter().cloned());
    serve_args.extend(args.tissue.to_args());
    serve_args.extend(["--ticks".into(), plan.ticks().to_string().into()]);
    let mut control_args: Vec<OsString> = vec!["control".into(), "--path".into(), sent.into()];
    control_args.extend(["--repeat".into(), plan.presses.to_string().into()]);
    control_args.extend(common);
    let program = program::find("chaincell").ok_or_else(|| {
        Error::input(
            "no chaincell beside this program or in PATH: build it with cargo build --release",
        )
    })?;
    let options = CosimOptions {
        program,
        serve_args,
        control_args,
        motion_ms: plan.ticks(),
        ready_s: READY_S,
    };
    let mut looks = Looks::new(plan);
    let reports = supervise::cosim_watched(&options, |underway| looks.look(underway))?;
    Ok(Both { reports, memory: [looks.serve.growth(), looks.control.growth()] })
}

/// Looks at the memory of both sides, and tells of the progress.
struct Looks {
    length: Duration,
    next_look: Duration,
    next_line: Duration,
    serve: Watch,
    control: Watch,
}

impl Looks {
    fn new(plan: &Plan) -> Self {
        let length = Duration::from_millis(plan.ticks());
        let (serve, control) = (Watch::default(), Watch::default());
        Self { length, next_look: plan.warm_up, next_line: PROGRESS, serve, control }
    }

    fn look(&mut self, underway: Underway) {
        let now = underway.elapsed;
        // The controller began to play later than it was started: it is playing still.
        if now >= self.next_look && now < self.length {
            self.next_look = now + (self.length / 100).min(Duration::from_secs(1));
            for (pid, watch) in
                [(underway.serve_pid, &mut self.serve), (underway.control_pid, &mut self.control)]
            {
                if let Some(memory) = Memory::of(pid) {
                    watch.look(memory);
                }
            }
        }
        if now >= self.next_line {
            self.next_line += PROGRESS;
            terminal::note(format_args!(
                "soak: {:.0} of {:.0} s; {}, {}",
                now.as_secs_f64(),
                self.length.as_secs_f64(),
                taken("serve", self.serve.growth()),
                taken("control", self.control.growth())
            ));
        }
    }

    #[cfg(test)]
    fn counts(&self) -> [u64; 2] {
        [self.serve.growth().looks, self.control.growth().looks]
    }
}

fn taken(side: &str, memory: Growth) -> String {
    match (memory.looks, memory.growth_kb) {
        (0, _) => format!("{side} warms up"),
        (_, 0) => format!("{side} {} kB", memory.first_kb),
        (_, growth_kb) => format!("{side} {} kB {growth_kb:+} kB", memory.first_kb),
    }
}

fn report(
    plan: &Plan,
    engine: &Engine<'_>,
    both: Both,
    before: &ControlReport,
    after: Option<ControlReport>,
) -> SoakReport {
    let (serve, control) = (both.reports.serve, both.reports.control);
    let mut refused = [serve.refused, control.refused.clone()].concat();
    refused.sort();
    refused.dedup();
    let missed = Missed::of(&control);
    let (wakeup, round_trip) =
        control.histogram.map(|spans| (spans.send_late, spans.round_trip)).unwrap_or_default();
    let kernel = std::fs::read_to_string("/proc/sys/kernel/osrelease").unwrap_or_default();
    let model = engine.network().model();
    let [memory_serve, memory_control] = both.memory;
    SoakReport {
        command: std::env::args().collect::<Vec<_>>().join(" "),
        machine: Machine::read(),
        kernel: kernel.trim().to_owned(),
        load: load::LoadFigures::default(),
        cells: model.cells(),
        links: model.links(),
        press_s: plan.press_ticks as f64 / 1000.0,
        ticks_sent: control.ticks_sent,
        ticks_answered: control.ticks_answered,
        missed,
        floor: SoakFloor::of(before, after.as_ref()),
        wakeup,
        step: serve.step_histogram.unwrap_or_default(),
        round_trip,
        memory_serve,
        memory_control,
        state_hash: serve.state_hash,
        interrupted: both.reports.interrupted || after.is_none(),
        refused,
    }
}

fn print(args: &Args, report: &SoakReport) -> Result<()> {
    if args.json {
        return terminal::say_json(report);
    }
    tell_refused(&report.refused);
    let machine = &report.machine;
    terminal::say(format_args!(
        "{}, {}, Linux {}; load: {}, {:.1} GB/s{}",
        machine.processor,
        counted(machine.cores, "core"),
        report.kernel,
        counted(report.load.threads, "thread"),
        report.load.gb_per_s,
        if machine.optimised { "" } else { "; a debug build" }
    ))?;
    terminal::say(format_args!("{}", report.command))?;
    terminal::say(write::maxima(report).trim_end())?;
    terminal::say(format_args!(
        "{} of {} ticks answered",
        report.ticks_answered, report.ticks_sent
    ))?;
    let (missed, floor) = (&report.missed, &report.floor.both);
    for (name, missed) in [("later than 1 ms", missed), ("machine alone", floor)] {
        terminal::say(format_args!(
            "  {name:<16}{} of {} ({:.1} in a million): {} sent late, {} in the step, {} on the way",
            missed.total,
            missed.ticks,
            missed.in_a_million,
            missed.sent_late,
            missed.in_step,
            missed.on_the_way
        ))?;
    }
    for (side, memory) in [("serve", &report.memory_serve), ("control", &report.memory_control)] {
        terminal::say(format_args!(
            "  {:<16}{} kB after the warm-up, growth {} kB, {} page faults, {} looks",
            format!("memory {side}"),
            memory.first_kb,
            memory.growth_kb,
            memory.minor_faults + memory.major_faults,
            memory.looks
        ))?;
    }
    terminal::say(write::text(report).trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn plan(options: &[&str]) -> Result<Plan> {
        Plan::new(&Line::parse_from([&["soak"], options].concat()).args)
    }

    #[test]
    fn presses_fill_the_time() {
        let ten_minutes = plan(&[]).unwrap();
        assert_eq!((ten_minutes.presses, ten_minutes.press_ticks), (60, 10_000));
        assert_eq!((ten_minutes.floor_ticks, ten_minutes.warm_up.as_secs()), (60_000, 20));
        let short = plan(&["--seconds", "4"]).unwrap();
        assert_eq!((short.presses, short.press_ticks, short.floor_ticks), (4, 1000, 1000));
        assert_eq!(short.warm_up, Duration::from_secs(2));
        let long = plan(&["--hours", "8"]).unwrap();
        assert_eq!((long.ticks(), long.floor_ticks), (28_800_000, 600_000));
        for bad in ["2", "-1", "NaN", "inf", "1e9"] {
            let error = plan(&["--seconds", bad]).unwrap_err();
            assert!(error.to_string().contains("--seconds"), "{error}");
        }
    }

    // REQ-COS-08
    #[test]
    fn memory_is_looked_at_after_the_warm_up_and_before_the_end() {
        let mut looks = Looks::new(&plan(&["--seconds", "4"]).unwrap());
        let pid = std::process::id();
        let mut at = |ms| {
            let elapsed = Duration::from_millis(ms);
            looks.look(Underway { elapsed, serve_pid: pid, control_pid: pid });
            looks.counts()
        };
        assert_eq!(at(1999), [0, 0]);
        assert_eq!(at(2000), [1, 1]);
        assert_eq!(at(2030), [1, 1], "a look every hundredth of the run");
        assert_eq!(at(2040), [2, 2]);
        assert_eq!(at(4000), [2, 2]);
    }
}
