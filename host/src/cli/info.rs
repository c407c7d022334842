//! `chaincell info`: what a model image holds.

use std::path::PathBuf;

use super::model_file;
use super::reports::ModelReport;
use crate::error::Result;
use crate::terminal;

/// Show what a baked model holds: cells, links, bounds, flash and RAM.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell info liver.chaincell --json")]
pub struct Args {
    /// Model file from `chaincell bake`
    model: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn execute(args: &Args) -> Result<()> {
    let image = model_file::read(&args.model)?;
    let model = model_file::parse(&image, &args.model)?;
    let report = ModelReport::new(&model, image.as_bytes().len());
    if args.json { terminal::say_json(&report) } else { report.print() }
}
