//! `chaincell replay`: a trace once more, to the same bits.

use std::fs;
use std::path::{Path, PathBuf};

use chaincell_kernel::trace::{End, ReplayError};
use serde::Serialize;

use super::pins::{add_pins, tell_pins};
use super::recorded::{Begun, RecordedArgs};
use super::shared::PrintArgs;
use crate::choice;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::{Arithmetic, Scheme};
use crate::error::{Error, Result};
use crate::files::output::{PinCourse, PinRows};
use crate::files::recording::{self, Played, Step, Stop};
use crate::files::whole::{check_writable, keep_input, write_whole};
use crate::interrupt;
use crate::terminal;
use crate::words::counted;

/// Play a recorded trace again and compare the state after every tick, bit for bit.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell cosim liver.chaincell --out session\n  \
    chaincell replay session\n  \
    chaincell replay dump.trace --model liver.chaincell\n\n\
    Exit code 0 when every tick gave the recorded bits, 1 when one differs (the first is named), \
    2 when the trace cannot be played.")]
pub struct Args {
    #[command(flatten)]
    session: RecordedArgs,
    /// Begin behind the snapshot after this tick, from TRACE.TICK.snapshot
    #[arg(long, value_name = "TICK", allow_negative_numbers = true)]
    from: Option<u64>,
    /// Write the force on each pin in every tick to this file, with the columns of `pins.csv`
    #[arg(long, value_name = "FILE")]
    pin_forces: Option<PathBuf>,
    #[command(flatten)]
    print: PrintArgs,
}

/// The printed report.
#[derive(Debug, Serialize)]
struct ReplayReport {
    cells: usize,
    links: usize,
    #[serde(serialize_with = "choice::serialize")]
    scheme: Scheme,
    #[serde(serialize_with = "choice::serialize")]
    precision: Arithmetic,
    model_checksum: String,
    ticks: u32,
    commands: u32,
    hashes_compared: u32,
    state_hash: String,
    end: String,
    /// The course of each pin, with `--pin-forces`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pins: Vec<PinCourse>,
    first_difference: Option<Difference>,
}

/// The first tick that came out otherwise.
#[derive(Debug, Serialize)]
struct Difference {
    record: u32,
    tick: u64,
    recorded_state_hash: String,
    replayed_state_hash: String,
}

pub fn execute(args: &Args) -> Result<()> {
    // Nothing is written before the end, and a single tick may take long.
    interrupt::end_at_once()?;
    // Open the trace and its model.
    let session = args.session.read()?;
    if let Some(file) = &args.pin_forces {
        keep_input(&session.path.to_string_lossy(), file)?;
        check_pins_file(file)?;
    }
    let Begun { trace, model, mut tissue, scheme, precision, start } = session.begin(args.from)?;
    let path = &session.path;
    // Play the records.
    let (mut played, mut pins) = (Played::default(), PinRows::default());
    let after = |tissue: &mut Staged<'_>, step: Step<'_>| {
        if let Step::Tick { record, .. } = step
            && args.pin_forces.is_some()
        {
            add_pins(&mut pins, record.tick, tissue.engine_mut());
        }
        true
    };
    let (end, differs) = match recording::play(&trace, &mut tissue, start, &mut played, after) {
        Ok(end) => (Some(end), None),
        Err(Stop::Differs(why)) => (None, Some(why)),
        Err(Stop::Command(record)) => return Err(session.bad_command(record)),
        Err(Stop::Enough) => (None, None),
    };
    // Report and judge.
    let Played { ticks, commands, compared, .. } = played;
    let report = ReplayReport {
        cells: model.body_cells(),
        links: model.links(),
        scheme,
        precision,
        model_checksum: format!("{:08x}", model.checksum()),
        ticks,
        commands,
        hashes_compared: compared,
        state_hash: format!("{:016x}", tissue.state_hash()),
        end: end.map_or("not reached".into(), |end| end.to_string()),
        pins: pins.courses().to_vec(),
        first_difference: differs.map(|why| Difference {
            record: why.record,
            tick: why.tick,
            recorded_state_hash: format!("{:016x}", why.recorded),
            replayed_state_hash: format!("{:016x}", why.here),
        }),
    };
    if args.print.json {
        terminal::say_json(&report)?;
    }
    judge(path, &report, end, differs, args.from.is_some())?;
    if let Some(file) = &args.pin_forces {
        write_pins(file, &pins)?;
    }
    if args.print.json {
        return Ok(());
    }
    terminal::say(format_args!(
        "{} replayed to the same bits, {} compared",
        counted(ticks, "tick"),
        if compared == 1 { "1 state hash".into() } else { format!("{compared} state hashes") }
    ))?;
    if commands > 0 {
        terminal::say(format_args!("  {:<14}{commands}", "commands"))?;
    }
    tell_pins(14, &report.pins)?;
    terminal::say(format_args!("  {:<14}{}", "state hash", report.state_hash))
}

/// Writes the table of the pins, with its heading alone where there were none.
fn write_pins(file: &Path, pins: &PinRows) -> Result<()> {
    write_whole(file, pins.table().as_bytes())?;
    if pins.courses().is_empty() {
        terminal::note(
            "note: no tick that was played has a pin: the table of --pin-forces is empty",
        );
    }
    Ok(())
}

/// Refuses to replace a file that is not an earlier table of pins.
fn check_pins_file(file: &Path) -> Result<()> {
    if file.is_file() {
        let text = fs::read(file).map_err(|why| Error::file("read", file, why))?;
        if !text.starts_with(PinRows::default().table().as_bytes()) {
            let why = "it is there, and no table of pins: name another file";
            return Err(Error::file("write", file, why));
        }
    }
    check_writable(file)
}

/// Judges the outcome; `is_named`: a snapshot was named to begin from.
fn judge(
    trace: &Path,
    report: &ReplayReport,
    end: Option<End>,
    differs: Option<ReplayError>,
    is_named: bool,
) -> Result<()> {
    // Refuse a difference, and a damaged trace.
    let path = trace.display();
    if let Some(why) = differs {
        return Err(Error::check(format!("{path}: {why}")));
    }
    if let Some(end @ (End::Damaged(_) | End::Kind(..))) = end {
        let why = format_args!(
            "{end}; {} before it replayed to the same bits",
            counted(report.ticks, "tick")
        );
        return Err(Error::file("replay", trace, why));
    }
    // A cut trace counts up to its last whole record.
    if let Some(end @ End::Cut(_)) = end {
        terminal::note(format_args!("note: {path}: {end}; the whole records before it count"));
    }
    // Refuse a trace that compares nothing.
    match (report.ticks, report.hashes_compared) {
        (0, _) if is_named => {
            let why =
                "no tick stands behind the snapshot: begin at an earlier one, or without --from";
            Err(Error::file("replay", trace, why))
        }
        (0, _) => Err(Error::file("replay", trace, "it holds no tick: record again")),
        (_, 0) => Err(Error::file(
            "replay",
            trace,
            "it holds no state hash to compare with: record with `serve --hash-every 1`",
        )),
        _ => Ok(()),
    }
}
