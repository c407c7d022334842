//! `chaincell identify`: material parameters from measurements.

use std::path::{Path, PathBuf};

use chaincell_kernel::Model;
use serde::Serialize;

use crate::experiments::identify::target::{self, Holding, Target};
use crate::experiments::identify::{
    Bench, Bounds, Identified, check, forward, groups, identify, write,
};
use crate::reference::vectors::norm;
use chaincell_host::bake;
use chaincell_host::cli::BodyArgs;
use chaincell_host::cli::model_file;
use chaincell_host::engine::contact::{contact_cells, inward};
use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_host::files::whole::{folder_of, write_whole};
use chaincell_host::terminal;

/// Part of a target that a fit may leave over, and still is one.
const NO_FIT: f64 = 0.5;
/// Part below which the rest is that of the engine's own arithmetic.
const EXACT: f64 = 2e-3;

/// Find stiffness, slack and time constant of a body from measured curves and fields.
///
/// Every group of nodes has a stiffness and an alpha, the body one time constant, which only
/// relaxation curves show. There is no volume term in the model, so none is looked for.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell identify liver.msh --target press.csv --group \
    tumour=group:tumour --group rest=group:rest \\\n    --contact cells:nodes:17,18 -o \
    liver.chaincell --out fit\n\n\
    A target is a CSV file whose first line says what it holds:\n  \
    displacement_m,force_n    equilibrium forces of a growing press, along its direction\n  \
    time_s,force_n            relaxation after a step of --displacement-m at time 0\n  \
    node,ux_m,uy_m,uz_m       displacements of nodes at --displacement-m, in equilibrium\n\
    Forces are those that the tool exerts along its direction. From a field alone only the ratios \
    of stiffnesses follow.\n\
    --out gets identified.json, residuals.csv and charts; -o the model with the values found. The \
    time constant is no part of a model: give it to `run --time-constant-s`.")]
pub struct Args {
    /// The body: a mesh as `bake` takes it
    mesh: String,
    /// Measurement (CSV); repeat it for several that one body must meet
    #[arg(long, value_name = "FILE", required = true)]
    target: Vec<PathBuf>,
    /// Model file to write
    #[arg(short, long, value_name = "MODEL")]
    output: PathBuf,
    /// Folder for the results
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Overwrite the results of an earlier run in --out
    #[arg(long)]
    force: bool,
    /// Nodes of one material: NAME=SELECTOR, see `bake --fix`; repeat it for several. Nodes of no
    /// group keep --stiffness-n-per-m and --alpha [default: all nodes]
    #[arg(long, value_name = "NAME=SELECTOR")]
    group: Vec<String>,
    /// Cells that the tool holds: cells:SELECTOR, input ids, or auto, as in `run`
    #[arg(long, default_value = "auto", value_name = "CONTACT")]
    contact: String,
    /// Direction of the displacement, x,y,z, or auto: into the body at the contact
    #[arg(long, default_value = "auto", value_name = "X,Y,Z", allow_hyphen_values = true)]
    direction: String,
    /// Displacement of the tool with relaxation curves and fields [m]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    displacement_m: Option<f64>,
    /// Force of the tool with a field [N]
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    force_n: Option<f64>,
    /// Part of the rows of every target that only judges the result
    #[arg(long, default_value_t = 0.2, value_name = "PART", allow_negative_numbers = true)]
    hold_out: f64,
    /// Where stiffnesses are looked for [N/m]
    #[arg(long, default_value = "0.01,1e5", value_name = "LOW,HIGH", allow_hyphen_values = true)]
    stiffness_bounds_n_per_m: String,
    /// Largest alpha
    #[arg(long, default_value_t = 0.5, value_name = "ALPHA", allow_negative_numbers = true)]
    alpha_max: f64,
    /// Where the time constant is looked for [s]
    #[arg(long, default_value = "1e-4,1e4", value_name = "LOW,HIGH", allow_hyphen_values = true)]
    time_constant_bounds_s: String,
    #[command(flatten)]
    body: BodyArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// identified.json
#[derive(Debug, Serialize)]
struct IdentifiedFile<'a> {
    mesh: &'a str,
    model: String,
    cells: usize,
    contact_nodes: Vec<u32>,
    direction: [f64; 3],
    hold_out: f64,
    #[serde(flatten)]
    found: &'a Identified,
    volume_term: &'static str,
}

pub fn execute(args: &Args) -> Result<()> {
    refuse_model(&args.mesh)?;
    let (mesh, fixed, options) = args.body.parts(&args.mesh)?;
    let groups = groups(&args.group, &mesh)?;
    let targets = targets(args)?;
    let image = bake::bake(&mesh, &fixed, &options)?;
    let model = model_file::parse(&image, &args.output)?;
    let contacts = contact_cells(&args.contact, &model)?;
    if let Some(&cell) = contacts.iter().find(|&&cell| model.is_fixed(cell)) {
        return Err(Error::input(format!(
            "--contact: node {} is fixed and cannot be held by the tool",
            model.input_id()[usize::from(cell)]
        )));
    }
    let bench = Bench {
        mesh: &mesh,
        fixed: &fixed,
        options: &options,
        groups: &groups,
        contacts: &contacts,
        direction: direction(&args.direction, &model, &contacts)?,
        targets: &targets,
    };
    let bounds = Bounds {
        stiffness_n_per_m: pair("--stiffness-bounds-n-per-m", &args.stiffness_bounds_n_per_m)?,
        alpha_max: args.alpha_max,
        time_constant_s: pair("--time-constant-bounds-s", &args.time_constant_bounds_s)?,
    };
    check(&bench, &bounds, args.hold_out)?;
    check_place(&args.output)?;
    let folder = Folder::open(&args.out, args.force)?;
    let found = identify(&bench, &bounds, args.hold_out)?;
    let image = forward::image(&bench, &found.parameters)?;
    folder.write("residuals.csv", write::residuals_csv(&targets, &found).as_bytes())?;
    for figure in write::charts(&targets, &found)? {
        figure.picture.write(&folder, &figure.name)?;
    }
    let contact_nodes = contacts.iter().map(|&cell| model.input_id()[usize::from(cell)]);
    let report = IdentifiedFile {
        mesh: &args.mesh,
        model: args.output.display().to_string(),
        cells: model.cells(),
        contact_nodes: contact_nodes.collect(),
        direction: bench.direction,
        hold_out: args.hold_out,
        found: &found,
        volume_term: "not part of the model",
    };
    folder.write_json("identified.json", &report)?;
    check_fit(&found, bench.direction)?;
    write_whole(&args.output, image.as_bytes())?;
    if args.json { terminal::say_json(&report) } else { print(args, &found, bench.direction) }
}

/// A fit that leaves most of a target over is none.
fn check_fit(found: &Identified, direction: [f64; 3]) -> Result<()> {
    let poor = found.targets.iter().find(|of| of.rms_residual > NO_FIT * of.rms_measured);
    poor.map_or(Ok(()), |of| {
        Err(Error::check(format!(
            "{}: the best fit leaves {:.0} % of it over, so no model is written; forces and \
             displacements count along the push, here ({:.3}, {:.3}, {:.3}): compare their signs, \
             --direction, --contact and the bounds",
            of.name,
            100.0 * of.rms_residual / of.rms_measured,
            direction[0],
            direction[1],
            direction[2]
        )))
    })
}

/// A model holds no mesh to bake again.
fn refuse_model(spec: &str) -> Result<()> {
    let image = std::fs::File::open(spec).is_ok_and(|mut file| {
        let mut head = [0; 8];
        std::io::Read::read_exact(&mut file, &mut head).is_ok()
            && head == chaincell_kernel::image::MAGIC
    });
    if image {
        return Err(Error::input(format!(
            "{spec}: a baked model; give the mesh that it was baked from, with the same --fix"
        )));
    }
    Ok(())
}

/// A place that cannot be written is told before the fit, not after it.
fn check_place(path: &Path) -> Result<()> {
    let failed = |why: std::io::Error| Error::file("write", path, why);
    tempfile::tempfile_in(folder_of(path)).map_err(failed)?;
    if path.is_dir() {
        return Err(Error::file("write", path, "it is a folder; name a file"));
    }
    Ok(())
}

fn targets(args: &Args) -> Result<Vec<Target>> {
    let holding = Holding { displacement_m: args.displacement_m, force_n: args.force_n };
    let mut all = Vec::new();
    for file in &args.target {
        all.extend(target::read(file, &holding)?);
    }
    Ok(all)
}

/// The direction as a unit vector.
fn direction(text: &str, model: &Model<'_>, contacts: &[u16]) -> Result<[f64; 3]> {
    let refuse = |why: &str| Error::input(format!("--direction {text}: {why}"));
    let vector = if text == "auto" {
        inward(model, contacts)
    } else {
        numbers(text).ok_or_else(|| refuse("give three numbers, x,y,z, or auto"))?
    };
    let length = norm(vector);
    if length.is_finite() && length > 0.0 {
        Ok(vector.map(|x| x / length))
    } else {
        Err(refuse("its length must be finite and above 0"))
    }
}

/// So many numbers with commas between them.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|x| x.trim().parse().ok()).collect();
    numbers?.try_into().ok()
}

/// Two numbers.
fn pair(option: &str, text: &str) -> Result<[f64; 2]> {
    numbers(text)
        .ok_or_else(|| Error::input(format!("{option} {text}: give two numbers, LOW,HIGH")))
}

fn print(args: &Args, found: &Identified, direction: [f64; 3]) -> Result<()> {
    let [x, y, z] = direction;
    terminal::say(format_args!(
        "identified {} of {}, pushed along ({x:.3}, {y:.3}, {z:.3})",
        args.output.display(),
        args.mesh
    ))?;
    terminal::say(format_args!(
        "  {:<30}{:>12}  {:<26}determined",
        "parameter", "value", "95 % interval"
    ))?;
    for estimate in &found.estimates {
        let [low, high] = estimate.interval;
        let interval = format!("{} to {}", short(low), short(high));
        let determined = if estimate.determined { "yes" } else { "no" };
        let (name, value) = (estimate.name(), short(estimate.value));
        terminal::say(format_args!("  {name:<30}{value:>12}  {interval:<26}{determined}"))?;
    }
    for target in &found.targets {
        let part = |rms: f64| format!("{:.2} %", 100.0 * rms / target.rms_measured);
        let held = target.rms_residual_held_out.map_or("none".to_owned(), part);
        terminal::say(format_args!(
            "  {} ({}): residual {} of {} rows fitted, {held} of {} held out",
            target.name,
            target.kind,
            part(target.rms_residual),
            target.rows,
            target.rows_held_out
        ))?;
        let follows = target.rms_residual <= EXACT * target.rms_measured;
        if !follows && target.correlation.is_some_and(|correlation| correlation > 0.6) {
            terminal::note(format_args!(
                "note: {}: the residuals follow one another; the model does not follow the curve, \
                 and the intervals are too narrow",
                target.name
            ));
        }
    }
    for sentence in &found.undetermined {
        terminal::note(format_args!("note: {sentence}"));
    }
    terminal::say(format_args!("  {} evaluations, {:.1} s", found.evaluations, found.seconds))
}

/// Four significant digits.
fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.3e}");
    }
    let before = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let digits = (3 - before).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}
