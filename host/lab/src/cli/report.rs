//! `chaincell report`: speed against error on this machine.

use std::path::PathBuf;
use std::time::Instant;

use crate::experiments::report::collect::{Options, Report, collect, pieces};
use crate::experiments::report::write::write;
use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_host::terminal;

/// Folder of a report unless given.
const FOLDER: &str = "report";

/// Measure speed against error on this machine and write REPORT.md, CSV files and pictures.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell report --out report\n  \
    chaincell report --quick --json\n\n\
    Held cells against exact energy minima of the same links, computed in double precision, and\n\
    tools on a surface against many more sweeps a tick, for several schemes and numbers of sweeps.\n\
    Single thread; leave the machine alone meanwhile.\n\
    With --json alone nothing is written.")]
pub struct Args {
    /// Fewer bodies, sizes and repetitions; REPORT.md says how long it took
    #[arg(long)]
    quick: bool,
    /// Folder of reference data with the real liver
    /// [default: CHAINCELL_REFERENCE; without it, and with --quick, a generated organ]
    #[arg(long, value_name = "DIR")]
    reference: Option<PathBuf>,
    /// Folder for the report [default: report]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite an earlier report in --out
    #[arg(long)]
    force: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn execute(args: &Args) -> Result<()> {
    let reference = super::reference(args.reference.as_deref())?.filter(|_| !args.quick);
    let options = Options { quick: args.quick, reference };
    let out = args.out.clone().or_else(|| (!args.json).then(|| FOLDER.into()));
    let folder = out.as_deref().map(|out| Folder::open(out, args.force)).transpose()?;
    let bar = terminal::progress(pieces(&options), "measuring");
    let mut report = Report::default();
    let start = Instant::now();
    let ended = collect(&options, &mut report, &bar);
    report.seconds = start.elapsed().as_secs_f64();
    report.interrupted = ended == Err(Error::Interrupted);
    bar.finish_and_clear();
    if !matches!(ended, Ok(()) | Err(Error::Interrupted)) {
        return ended;
    }
    if let Some(folder) = &folder {
        let quick = if args.quick { " --quick" } else { "" };
        write(&report, folder, &format!("chaincell report{quick}"))?;
    }
    if args.json {
        terminal::say_json(&report)?;
    } else if let Some(out) = &out {
        terminal::say(format_args!("{}", out.join("REPORT.md").display()))?;
    }
    ended
}
