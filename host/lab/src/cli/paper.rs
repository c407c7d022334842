//! `chaincell paper`: the paper's results beside those of the method it improves on.

use std::path::PathBuf;

use crate::experiments::paper::section::Context;
use crate::experiments::paper::write::{PaperReport, collect, pieces};
use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_host::session::timing::machine::Machine;
use chaincell_host::terminal;

/// Folder of the report unless given.
const FOLDER: &str = "paper";

/// Compute the results of the paper anew, beside traditional ChainMail, and write one HTML page with
/// pictures, tables and numbers.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell paper --out paper\n  \
    chaincell paper --quick --json\n\n\
    --out gets paper.html, which shows everything and fetches nothing, paper.json with the figures,\n\
    every picture as SVG and PNG, and the numbers behind them as CSV.\n\
    With --json alone nothing is written.")]
pub struct Args {
    /// Folder for the report [default: paper]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Fewer ticks, sizes and repetitions; the page says how long it took
    #[arg(long)]
    quick: bool,
    /// Folder of reference data with the real liver
    /// [default: CHAINCELL_REFERENCE; without it the generated organ]
    #[arg(long, value_name = "DIR")]
    reference: Option<PathBuf>,
    /// Overwrite an earlier report in --out
    #[arg(long)]
    force: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn execute(args: &Args) -> Result<()> {
    let reference = super::reference(args.reference.as_deref())?;
    let out = args.out.clone().or_else(|| (!args.json).then(|| FOLDER.into()));
    let folder = out.as_deref().map(|out| Folder::open(out, args.force)).transpose()?;
    let mut report = PaperReport {
        command: format!(
            "chaincell paper{}{}",
            if args.quick { " --quick" } else { "" },
            if reference.is_some() { " --reference DIR" } else { "" }
        ),
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::read(),
        quick: args.quick,
        reference: reference.is_some(),
        ..PaperReport::default()
    };
    let context = Context { reference, quick: args.quick };
    let bar = terminal::progress(pieces(), "computing");
    let ended = collect(&context, &mut report, &bar);
    bar.finish_and_clear();
    // Whatever ended it, the sections that are done are kept.
    if report.sections.is_empty() && !matches!(ended, Err(Error::Interrupted)) {
        return ended;
    }
    if let Some(folder) = &folder {
        report.write(folder)?;
    }
    if args.json {
        terminal::say_json(&report.json())?;
    } else if let Some(out) = &out {
        terminal::say(format_args!("{}", out.join("paper.html").display()))?;
    }
    ended
}
