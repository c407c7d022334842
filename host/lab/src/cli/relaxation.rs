//! `chaincell relaxation`: branches from a measured curve.

use std::path::PathBuf;

use crate::experiments::relaxation::{Found, curve, identify};
use chaincell_host::error::{Error, Result};
use chaincell_host::terminal;

/// Find the branches of tissue that relaxes from a measured curve of stress or force in time.
///
/// The law is one of a strip: an elastic response, linear with bands that stiffen it, fades as a whole by a Prony
/// series. In a baked body bands do not fade: beyond their half-widths it resists a fast press less than the strip.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell relaxation hold.csv --branches 2\n\n\
    A curve is a CSV file with a line of names: time_s, from rest at 0; strain, stretch or displacement_m;\n\
    and force_n, stress_pa or stress_kpa, also with a word before it, as cauchy_stress_kpa. Further columns are left\n\
    alone. A value that the curve does not determine within a factor of two is said not to be identified; where \
    errors\nfollow one another, intervals are too narrow.")]
pub struct Args {
    /// The measured curve (CSV)
    curve: PathBuf,
    /// Number of branches; one a decade of time follows most tissue
    #[arg(long, default_value_t = 2, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u8).range(1..=4))]
    branches: u8,
    /// Half-widths of up to three bands, with commas, whose moduli are looked for too, in the unit of the strain;
    /// or none
    #[arg(long, default_value = "none", value_name = "W,W")]
    half_widths: String,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub fn execute(args: &Args) -> Result<()> {
    let half_widths = half_widths(&args.half_widths)?;
    let curve = curve::read(&args.curve)?;
    let found = identify(&curve, args.branches.into(), &half_widths)?;
    if args.json { terminal::say_json(&found) } else { print(args, &found) }
}

/// The half-widths of an option, in ascending order.
fn half_widths(text: &str) -> Result<Vec<f64>> {
    if text == "none" {
        return Ok(Vec::new());
    }
    let widths: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let mut widths = widths.unwrap_or_default();
    widths.sort_by(f64::total_cmp);
    let is_good = (1..=3).contains(&widths.len())
        && widths.iter().all(|width| width.is_finite() && *width > 0.0)
        && widths.windows(2).all(|pair| pair[0] < pair[1]);
    if is_good {
        return Ok(widths);
    }
    Err(Error::input(format!(
        "--half-widths {text}: give one to three different numbers above 0, as 0.15,0.24, or none"
    )))
}

fn print(args: &Args, found: &Found) -> Result<()> {
    let Found { unit, .. } = found;
    terminal::say(format_args!("relaxation of {}", args.curve.display()))?;
    terminal::say(format_args!("  {:<22}{:>12}  {:<26}identified", "value", "", "95 % interval"))?;
    for of in &found.values {
        let [low, high] = of.interval;
        let interval = format!("{low:.4e} to {high:.4e}");
        let is_modulus = of.name == "modulus" || of.name.starts_with("band");
        let name = if is_modulus { format!("{} [{unit}]", of.name) } else { of.name.clone() };
        let identified = if of.is_identified { "yes" } else { "no" };
        terminal::say(format_args!("  {name:<22}{:>12.4e}  {interval:<26}{identified}", of.value))?;
    }
    // How well the curve is met.
    if let Some([mean, worst]) = found.hold_errors {
        let [mean, worst] = [100.0 * mean, 100.0 * worst];
        terminal::say(format_args!("  hold: error {mean:.2} % rms, {worst:.2} % at worst"))?;
    }
    let rise = 100.0 * found.rise_error;
    terminal::say(format_args!("  before it: error {rise:.2} % rms of the largest response"))?;
    if let Some(options) = &found.bake {
        terminal::say(format_args!("  bake {options}"))?;
    }
    if let Some(why) = &found.refusal {
        terminal::say(format_args!("  a bake refuses these values: {why}"))?;
        terminal::note(
            "note: take fewer branches or bands, or a curve that has points within the time of each branch",
        );
    }
    if found.values.iter().any(|value| !value.is_identified) {
        terminal::note(
            "note: values that are not identified are left open by the curve: take fewer branches or bands, or a \
             longer and finer curve",
        );
    }
    Ok(())
}
