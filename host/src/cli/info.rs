//! `chaincell info`: what a model image holds.

use std::path::PathBuf;

use chaincell_kernel::stage::Device;
use serde::Serialize;

use super::admits::DeviceReport;
use super::choice::parser;
use super::model_file;
use super::probe::ProbeReport;
use super::reports::ModelReport;
use super::shared::PrintArgs;
use crate::error::{Error, Result};
use crate::terminal;

/// Show what a baked model holds: cells, links, bounds, flash and RAM.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell info liver.chaincell --json\n  \
    chaincell info liver.chaincell --probe 0.004\n  chaincell info --device omega")]
pub struct Args {
    /// Model file from `chaincell bake`
    #[arg(required_unless_present = "device")]
    model: Option<PathBuf>,
    /// Also report on a sphere of this radius [m] as the tool: a slow press is computed, for some
    /// seconds, to find the depth from which the sphere that the tissue meets stays short of the tool,
    /// so that it never goes through
    #[arg(long, value_name = "RADIUS_M", allow_negative_numbers = true)]
    probe: Option<f32>,
    /// Also say what stiffness a device can be shown, by the ticks of delay of its force
    #[arg(long, value_parser = parser::<Device>(), value_name = "DEVICE")]
    device: Option<Device>,
    /// Poses that the device sends in a second
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, default_value_t = 1000,
        value_parser = clap::value_parser!(u32).range(10..=100_000))]
    device_hz: u32,
    #[command(flatten)]
    print: PrintArgs,
}

pub fn execute(args: &Args) -> Result<()> {
    let device = args.device.map(|device| DeviceReport::new(device, args.device_hz)).transpose()?;
    let (mut model, mut probe) = (None, None);
    if let Some(path) = &args.model {
        let image = model_file::read(path)?;
        let parsed = model_file::parse(&image, path)?;
        if args.probe.is_some() && parsed.relaxes() {
            return Err(Error::input(
                "`probe`: a body that relaxes has no one force at a depth; press it with `run`, or probe one \
                 of the modulus that matters, without --branch",
            ));
        }
        probe = args.probe.map(|radius_m| ProbeReport::new(&parsed, radius_m)).transpose()?;
        model = Some(ModelReport::new(&parsed, image.as_bytes().len()));
    } else if args.probe.is_some() {
        return Err(Error::input("`probe`: it touches a model; name one"));
    }
    if args.print.json {
        return terminal::say_json(&Printed { model, probe, device });
    }
    model.map_or(Ok(()), |model| model.print(true))?;
    probe.map_or(Ok(()), |probe| probe.print())?;
    device.map_or(Ok(()), |device| device.print())
}

/// The output of `--json`.
#[derive(Serialize)]
struct Printed {
    #[serde(flatten)]
    model: Option<ModelReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    probe: Option<ProbeReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    device: Option<DeviceReport>,
}
