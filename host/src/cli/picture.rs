//! `chaincell picture`: a tick of a recorded session as a PNG file.

use std::path::{Path, PathBuf};

use chaincell_kernel::trace::{End, Reader};
use serde::Serialize;

use super::recorded::{Begun, Recorded, RecordedArgs};
use super::shared::PrintArgs;
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::files::output::Folder;
use crate::files::recording::{self, Played, Step, Stop};
use crate::files::whole::{check_writable, write_whole};
use crate::interrupt;
use crate::picture::chart::Chart;
use crate::picture::{ForceCurve, Largest, Moment, encode};
use crate::terminal;

/// Draw a tick of a recorded session: the body, coloured by displacement, and the tools.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell picture session --tick 300\n  \
    chaincell picture session --out deepest.png\n\n\
    The session is played through the tissue up to the tick, so any tick can be drawn. A screen is not needed.")]
pub struct Args {
    #[command(flatten)]
    session: RecordedArgs,
    /// Number of the tick [default: that of the largest force]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    tick: Option<u64>,
    /// The PNG file [default: picture_N.png beside the trace]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    print: PrintArgs,
}

/// The printed report.
#[derive(Debug, Serialize)]
struct Report {
    picture: PathBuf,
    tick: u64,
    force_n: [f32; 3],
    displacement_max_m: f64,
}

pub fn execute(args: &Args) -> Result<()> {
    interrupt::end_at_once()?;
    let session = args.session.read()?;
    if let Some(out) = &args.out {
        check_writable(out)?;
    }
    let mut begun = session.begin(None)?;
    let moment = play(args, &session, &mut begun)?;
    let out = args
        .out
        .clone()
        .unwrap_or_else(|| session.path.with_file_name(format!("picture_{}.png", moment.tick)));
    let report = draw(&moment, begun.tissue.engine(), &out)?;
    if args.print.json {
        return terminal::say_json(&report);
    }
    say(&report)
}

/// Writes a picture of a moment.
///
/// # Errors
/// A file that cannot be written, with its path.
fn draw(moment: &Moment, engine: &Engine<'_>, out: &Path) -> Result<Report> {
    write_whole(out, &encode(&moment.draw(engine)))?;
    let Moment { tick, force_n, .. } = *moment;
    let displacement_max_m = moment.displacement_m(engine);
    Ok(Report { picture: out.to_owned(), tick, force_n, displacement_max_m })
}

/// Writes the picture of a run's largest force, and says so; nothing without a tick.
///
/// # Errors
/// A file that cannot be written, with its path.
pub fn of_run(largest: &Largest, engine: &Engine<'_>, out: &Path) -> Result<Option<String>> {
    let Some(moment) = largest.moment() else { return Ok(None) };
    let report = draw(moment, engine, out)?;
    Ok(Some(words(&report)))
}

/// Writes the curves of a force beside its table: over time, of ticks at a rate \[Hz\], and over the depth.
///
/// # Errors
/// As [`Folder::write`].
pub fn write_curves(curve: &ForceCurve, folder: &Folder, hz: u32) -> Result<()> {
    let svg = |chart: Chart| chart.draw().in_both_lights();
    folder.write("force.svg", svg(curve.over_time(hz)).as_bytes())?;
    folder.write("force_depth.svg", svg(curve.over_depth()).as_bytes())
}

fn words(report: &Report) -> String {
    format!(
        "{}: tick {}, displacement up to {:.2} mm",
        report.picture.display(),
        report.tick,
        1e3 * report.displacement_max_m
    )
}

fn say(report: &Report) -> Result<()> {
    terminal::say(words(report))
}

/// Plays the session up to the tick that was named, or all of it for the one of the largest force.
fn play(args: &Args, session: &Recorded, begun: &mut Begun<'_>) -> Result<Moment> {
    let Begun { trace, tissue, start, .. } = begun;
    let (mut played, mut largest, mut named) = (Played::default(), Largest::default(), None);
    // Play; keep the tick that is asked for.
    let ended = recording::play(trace, tissue, *start, &mut played, |tissue, step| {
        let Step::Tick { record, poses, output } = step else { return true };
        // In a pause no cell moves.
        let force_n = output.map_or([0.0; 3], |output| output.force_n.into());
        match args.tick {
            None => largest.after(tissue.engine_mut(), record.tick, poses, force_n),
            Some(tick) if tick == record.tick => {
                named = Some(Moment::of(tissue.engine_mut(), tick, poses, force_n));
            }
            Some(_) => {}
        }
        named.is_none()
    });
    // Refuse a session that cannot be played; a cut one counts as far as it goes.
    match ended {
        Err(Stop::Enough) => {}
        Err(Stop::Differs(why)) => {
            return Err(Error::check(format!("{}: {why}", session.path.display())));
        }
        Err(Stop::Command(record)) => return Err(session.bad_command(record)),
        Ok(End::Complete) => {}
        Ok(end) => terminal::note(format_args!("note: {}: {end}", session.path.display())),
    }
    // Take the moment that was found.
    let found = named.or_else(|| largest.moment().cloned());
    found.ok_or_else(|| no_tick(args.tick, trace, &session.path))
}

/// The error of a tick that the session has not, with those that it has.
fn no_tick(tick: Option<u64>, trace: &Reader<'_>, path: &Path) -> Error {
    let mut ends: Option<(u64, u64)> = None;
    let _ = trace.entries(|_, entry| {
        if let chaincell_kernel::trace::Entry::Tick(record) = entry {
            let first = ends.map_or(record.tick, |ends| ends.0);
            ends = Some((first, record.tick));
        }
        Ok::<(), std::convert::Infallible>(())
    });
    match (tick, ends) {
        (Some(tick), Some((first, last))) => Error::input(format!(
            "--tick {tick}: {} has no such tick; its ticks go from {first} to {last}",
            path.display()
        )),
        _ => Error::file("draw", path, "it holds no tick: record again"),
    }
}
