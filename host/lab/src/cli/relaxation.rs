//! `chaincell relaxation`: branches from a measured curve.

use std::path::{Path, PathBuf};

use crate::experiments::relaxation::curve::Curve;
use crate::experiments::relaxation::{Found, Predicted, curve, identify, rounded, rounded_parts};
use chaincell_host::bake::tissue::KnownTissue;
use chaincell_host::error::{Error, Result};
use chaincell_host::files::whole::{check_writable, write_whole};
use chaincell_host::picture::chart::{Axis, Chart, Style};
use chaincell_host::terminal;
use serde::Serialize;

/// Poisson's ratio in a table: that of soft tissue, since a curve in one dimension has none.
const POISSON: f64 = 0.45;

/// Find the branches of tissue that relaxes from a measured curve of stress or force in time.
///
/// The law is one of a strip: an elastic response, linear with bands that stiffen it, fades as a whole by a Prony
/// series. In a baked body bands do not fade: beyond their half-widths it resists a fast press less than the strip.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell relaxation hold.csv --branches 2\n  \
    chaincell relaxation hold.csv --out own.csv --name liver_2\n  \
    chaincell relaxation hold.csv --predict slower.csv --predict deeper.csv\n\n\
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
    /// Another curve, of another rate or depth, to compare the law with; may stand several times
    #[arg(long, value_name = "CURVE")]
    predict: Vec<PathBuf>,
    /// Draw the curves and the law over the logarithm of time in this file
    #[arg(long, value_name = "FILE.svg")]
    draw: Option<PathBuf>,
    /// Write the values as a table with one tissue, for `bake --tissue FILE.csv`; it takes a curve of stress
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// Name of the tissue in the table
    #[arg(long, default_value = "found", requires = "out")]
    name: String,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A curve that is compared with the law of the first one.
#[derive(Serialize)]
struct Compared<'a> {
    curve: &'a Path,
    #[serde(flatten)]
    predicted: Predicted,
}

/// The object that `--json` prints.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    found: &'a Found,
    predicted: &'a [Compared<'a>],
}

pub fn execute(args: &Args) -> Result<()> {
    let half_widths = half_widths(&args.half_widths)?;
    let curve = curve::read(&args.curve)?;
    let others: Vec<Curve> =
        args.predict.iter().map(|path| curve::read(path)).collect::<Result<_>>()?;
    if let Some(out) = &args.out {
        check_table(args, out, &curve)?;
    }
    args.draw.as_deref().map_or(Ok(()), check_writable)?;
    let found = identify(&curve, args.branches.into(), &half_widths)?;
    // Write the table, unless no body can be baked of it.
    let table = args.out.as_ref().filter(|_| found.refusal.is_none());
    if let Some(out) = table {
        write_whole(out, tissue(args, &found).table().as_bytes())?;
    }
    let compared = args.predict.iter().zip(&others).map(|(path, other)| {
        let failed = |why: Error| Error::input(format!("--predict {}: {why}", path.display()));
        Ok(Compared { curve: path, predicted: found.predict(other).map_err(failed)? })
    });
    let compared: Vec<Compared<'_>> = compared.collect::<Result<_>>()?;
    if let Some(path) = &args.draw {
        let own = Compared { curve: &args.curve, predicted: found.predict(&curve)? };
        let all = std::iter::once((&own, &curve)).chain(compared.iter().zip(&others));
        write_whole(path, chart(found.unit, all).as_bytes())?;
    }
    match args.json {
        true => terminal::say_json(&Printed { found: &found, predicted: &compared })?,
        false => print(args, &found).and_then(|()| print_compared(&compared))?,
    }
    match (&args.out, table) {
        (Some(out), None) => Err(Error::check(format!(
            "--out {}: not written, since a bake refuses these values; take fewer --branches or --half-widths",
            out.display()
        ))),
        _ => Ok(()),
    }
}

/// Refuses a table that could not be written or named afterwards, before the fit.
fn check_table(args: &Args, out: &Path, curve: &Curve) -> Result<()> {
    let refused = |why: &str| Err(Error::input(format!("--out {}: {why}", out.display())));
    if out.extension().is_none_or(|end| end != "csv") {
        return refused(
            "bake --tissue knows a table by its end; give a file whose name ends with .csv",
        );
    }
    if curve.unit != "Pa" {
        return refused(
            "the curve is one of forces, which have no modulus in Pa; give strain or stretch, and stress_pa or \
             stress_kpa, or leave it out and bake the branches beside a --young-pa of your own",
        );
    }
    let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if args.name.is_empty() || !args.name.chars().all(is_plain) {
        return Err(Error::input(format!(
            "--name {}: give small letters, digits and _, as liver_2",
            args.name
        )));
    }
    check_writable(out)
}

/// Returns the tissue of a fit, with the numbers that the options of a bake have.
fn tissue(args: &Args, found: &Found) -> KnownTissue {
    // How well the curve is met, and what it leaves open.
    let mut note = match found.hold_errors {
        Some([mean, _]) => format!("the hold within {:.2} % rms", 100.0 * mean),
        None => {
            format!(
                "the curve within {:.2} % rms of the largest response",
                100.0 * found.rise_error
            )
        }
    };
    note += "; Poisson's ratio assumed";
    let open = found.values.iter().filter(|value| !value.is_identified);
    let open: Vec<&str> = open.map(|value| value.name.as_str()).collect();
    if !open.is_empty() {
        note += &format!("; not identified: {}", open.join("; "));
    }
    let (branches, stiffening) = rounded_parts(found);
    KnownTissue {
        name: args.name.clone(),
        tissue: format!("fit of {}", args.curve.display()),
        young_pa: rounded(found.modulus),
        is_instant: false,
        poisson: POISSON,
        branches,
        stiffening,
        toughness_j_per_m2: None,
        friction: None,
        status: "fitted".to_owned(),
        source: args.curve.display().to_string(),
        note,
        place: None,
    }
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
        if let Some(out) = args.out.as_deref().map(Path::display) {
            terminal::say(format_args!("  wrote {out}: bake --tissue {out}"))?;
        }
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

/// The curves as markers, and the law as lines.
fn chart<'a>(unit: &str, curves: impl Iterator<Item = (&'a Compared<'a>, &'a Curve)>) -> String {
    let response = if unit == "Pa" { "stress [Pa]" } else { "force [N]" };
    let axes = (Axis::log10("time [s]"), Axis::linear(response));
    let mut chart =
        Chart::new("Relaxation: measured, and the law of the first curve", axes.0, axes.1);
    for (of, curve) in curves {
        let points = |y: &[f64]| -> Vec<[f64; 2]> {
            // Rest is at no place of a logarithm.
            curve.points.iter().zip(y).skip(1).map(|(point, y)| [point[0], *y]).collect()
        };
        let name = of.curve.file_stem().unwrap_or_default().to_string_lossy();
        chart = chart
            .series(&format!("{name}, law"), Style::Line, &points(&of.predicted.response))
            .series(&format!("{name}, measured"), Style::Markers, &points(&curve.response));
    }
    chart.draw().in_both_lights()
}

fn print_compared(compared: &[Compared<'_>]) -> Result<()> {
    for Compared { curve, predicted } in compared {
        let (error, peak) = (100.0 * predicted.error, 100.0 * predicted.peak_error);
        let hold = predicted.hold_errors.map_or(String::new(), |[mean, worst]| {
            format!("; hold {:.2} % rms, {:.2} % at worst", 100.0 * mean, 100.0 * worst)
        });
        let curve = curve.display();
        terminal::say(format_args!(
            "  predicted {curve}: error {error:.2} % rms of the largest response, which is {peak:+.2} % off{hold}"
        ))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::relaxation::Value;
    use chaincell_host::bake::tissue::{Band, Branch};

    #[test]
    fn a_tissue_has_the_rounded_numbers_and_says_what_is_open() {
        let args = Args {
            curve: "hold.csv".into(),
            branches: 1,
            half_widths: "0.1".into(),
            predict: Vec::new(),
            draw: None,
            out: Some("own.csv".into()),
            name: "soft".into(),
            json: false,
        };
        let open = Value {
            name: "branch 1, time_s".into(),
            value: 0.4,
            interval: [0.01, 9.0],
            is_identified: false,
        };
        let modulus = Value { name: "modulus".into(), is_identified: true, ..open.clone() };
        let found = Found {
            modulus: 1234.567,
            unit: "Pa",
            stiffening: vec![[0.1, 5000.123]],
            branches: vec![[2.000_01, 0.4]],
            values: vec![modulus, open],
            hold_errors: None,
            rise_error: 0.012,
            bake: None,
            refusal: None,
        };
        let made = tissue(&args, &found);
        assert_eq!((made.young_pa, made.is_instant), (1234.6, false));
        assert_eq!(made.branches, [Branch { ratio: 2.0, time_s: 0.4 }]);
        assert_eq!(made.stiffening, [Band::new(0.1, 5000.1)]);
        let note = "the curve within 1.20 % rms of the largest response; Poisson's ratio assumed; not identified: \
                    branch 1, time_s";
        assert_eq!(made.note, note);
    }
}
