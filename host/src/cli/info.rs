//! `chaincell info`: what a model image holds.

use std::path::PathBuf;

use serde::Serialize;

use super::model_file;
use super::probe::ProbeReport;
use super::reports::ModelReport;
use crate::error::Result;
use crate::terminal;

/// Show what a baked model holds: cells, links, bounds, flash and RAM.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell info liver.chaincell --json\n  \
    chaincell info liver.chaincell --probe 0.004")]
pub struct Args {
    /// Model file from `chaincell bake`
    model: PathBuf,
    /// Also say what a probe of this radius [m] meets. Where it meets triangles a slow press is
    /// computed, for some seconds: from which depth on the sphere that the tissue meets stays behind
    /// the tool, so that it never goes through
    #[arg(long, value_name = "RADIUS_M", allow_negative_numbers = true)]
    probe: Option<f32>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn execute(args: &Args) -> Result<()> {
    let image = model_file::read(&args.model)?;
    let model = model_file::parse(&image, &args.model)?;
    let of_probe = |radius_m| ProbeReport::new(&model, radius_m);
    let probe = args.probe.map(of_probe).transpose()?;
    let model = ModelReport::new(&model, image.as_bytes().len());
    if args.json {
        return terminal::say_json(&Printed { model, probe });
    }
    model.print()?;
    probe.map_or(Ok(()), |probe| probe.print())
}

/// What `--json` prints.
#[derive(Serialize)]
struct Printed {
    #[serde(flatten)]
    model: ModelReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    probe: Option<ProbeReport>,
}
