//! `chaincell report` and `chaincell paper`: experiments as one page with pictures.

use std::path::PathBuf;

use crate::experiments::page::{Context, Findings, Page, collect, write};
use crate::experiments::{paper, report};
use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_host::terminal::{self, Progress};

/// Measure speed against error on this machine and write one HTML page with pictures, tables and
/// numbers.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell report --out report\n  \
    chaincell report --quick --json\n\n\
    Held cells against exact energy minima of the same links, computed in double precision, and\n\
    tools on a surface against many more sweeps a tick, for several schemes and numbers of sweeps.\n\
    Single thread; leave the machine alone meanwhile: some minutes for what a sweep buys on 1000 cells,\n\
    longer for held cells. After an interruption the sections that are done are written.\n\
    --quick takes no reference data.\n\n\
    --out gets report.html, which shows everything and fetches nothing, report.json with the figures,\n\
    report.md with the tables, every picture as SVG and PNG, and the numbers behind them as CSV.\n\
    With --json alone nothing is written.")]
pub struct Report {
    /// Cells of the generated organ that shows what a sweep buys [default: 1000]
    #[arg(long, value_name = "N")]
    cells: Option<usize>,
    #[command(flatten)]
    options: Options,
}

/// Compute the results of the paper anew, beside traditional ChainMail, and write one HTML page with
/// pictures, tables and numbers.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell paper --out paper\n  \
    chaincell paper --quick --json\n\n\
    --out gets paper.html, which shows everything and fetches nothing, paper.json with the figures,\n\
    paper.md with the tables, every picture as SVG and PNG, and the numbers behind them as CSV.\n\
    With --json alone nothing is written.")]
pub struct Paper {
    #[command(flatten)]
    options: Options,
}

#[derive(Debug, clap::Args)]
struct Options {
    /// Folder for the page [default: the name of the command]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Fewer bodies, ticks, sizes and repetitions; the page says how long it took
    #[arg(long)]
    quick: bool,
    /// Folder of reference data with the real liver
    /// [default: CHAINCELL_REFERENCE; without it the generated organ]
    #[arg(long, value_name = "DIR")]
    reference: Option<PathBuf>,
    /// Overwrite an earlier page in --out
    #[arg(long)]
    force: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Report {
    /// Measures and writes the page.
    pub fn execute(&self) -> Result<()> {
        let options = &self.options;
        let reference = super::reference(options.reference.as_deref())?;
        let reference = reference.filter(|_| !options.quick);
        let context = Context { reference, quick: options.quick, cells: self.cells };
        make(options, &report::PAGE, context)
    }
}

impl Paper {
    /// Computes and writes the page.
    pub fn execute(&self) -> Result<()> {
        let reference = super::reference(self.options.reference.as_deref())?;
        let context = Context { reference, quick: self.options.quick, ..Context::default() };
        make(&self.options, &paper::PAGE, context)
    }
}

/// Makes a page; whatever ends it, the sections that are done are kept.
fn make(options: &Options, page: &'static Page, context: Context) -> Result<()> {
    let out = options.out.clone().or_else(|| (!options.json).then(|| page.name.into()));
    let folder = out.as_deref().map(|out| Folder::open(out, options.force)).transpose()?;
    let mut findings = Findings::new(page, context);
    let bar = Progress::new(page.experiments.len() as u64, page.name);
    let ended = collect(&mut findings, &bar);
    drop(bar);
    if findings.sections.is_empty() && !matches!(ended, Err(Error::Interrupted)) {
        return ended;
    }
    if let Some(folder) = &folder {
        write(&findings, folder)?;
    }
    if options.json {
        terminal::say_json(&findings.json())?;
    } else if let Some(out) = &out {
        terminal::say(format_args!("{}", out.join(page.name).with_extension("html").display()))?;
    }
    ended
}
