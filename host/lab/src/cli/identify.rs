//! `chaincell identify`: material parameters from measurements.

use std::path::{Path, PathBuf};

use chaincell_kernel::Model;
use serde::Serialize;

use crate::experiments::identify::slab::Slab;
use crate::experiments::identify::target::{self, Holding, Target};
use crate::experiments::identify::tool::{Tool, blade_edge, probe_radius};
use crate::experiments::identify::{
    Bench, Bounds, Identified, Wanted, check, forward, groups, identify, write,
};
use crate::reference::vectors::{minus, norm};
use chaincell_host::bake;
use chaincell_host::cli::BodyArgs;
use chaincell_host::cli::model_file;
use chaincell_host::engine::contact::{contact_cells, farthest, inward};
use chaincell_host::engine::rest_m;
use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;
use chaincell_host::files::whole::{folder_of, write_whole};
use chaincell_host::terminal;

/// Part of a target that a fit may leave over, and still is one.
const NO_FIT: f64 = 0.5;
/// Part below which the rest is that of the engine's own arithmetic.
const EXACT: f64 = 2e-3;

/// Find the material of a body, links or nodal shapes, from measured curves and fields.
///
/// Every group of nodes has a stiffness and an alpha, the body one time constant, which only
/// curves in time show. With --young-pa the body is made of nodal shapes: every group has a Young's
/// modulus, --fit names what else is looked for, and Poisson's ratio stays as it is given.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell identify liver.msh --target press.csv --group \
    tumour=group:tumour --group rest=group:rest \\\n    --contact cells:nodes:17,18 -o \
    liver.chaincell --out fit\n  \
    chaincell identify slab:0.06x0.02x0.001 --young-pa 3000 --stiffening 0.1=5000 \\\n    \
    --fit stiffening,half-width,thickness --contact probe:0.004 \\\n    \
    --target probed.csv -o liver.chaincell --out fit\n\n\
    A target is a CSV file whose first line says what it holds:\n  \
    displacement_m,force_n                equilibrium forces of a growing press, along its direction\n  \
    displacement_m,force_n,q25_n,q75_n    the same with quartiles, which are the error of each row\n  \
    time_s,force_n                        relaxation after a step of --displacement-m at time 0\n  \
    time_s,displacement_m,force_n         the force along a path of the tool in time\n  \
    node,ux_m,uy_m,uz_m                   displacements of nodes at --displacement-m, in equilibrium\n\
    Forces are those that the tool exerts along its direction. From a field alone only the ratios \
    of stiffnesses follow.\n\
    --out gets identified.json, residuals.csv and charts; -o the model with the values found. The \
    time constant is no part of a model: give it to `run --time-constant-s`.")]
pub struct Args {
    /// The body: a mesh as `bake` takes it, or slab:WIDTHxTHICKNESSxD [m], a slab on a held ground
    /// with elements of D in the middle of its top, growing outwards
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
    /// Cells that the tool holds: cells:SELECTOR, input ids, or auto, as in `run`; or probe:RADIUS
    /// [m], a sphere whose displacement counts from where it meets the surface; or
    /// blade:LENGTH/X,Y,Z,W, an edge with its turn, as in `run --tool`
    #[arg(long, default_value = "auto", value_name = "CONTACT")]
    contact: String,
    /// The point of the surface that a probe or blade meets first, x,y,z [m], or auto: the node
    /// farthest from the fixed ones, of a slab the middle of its top
    #[arg(long, default_value = "auto", value_name = "X,Y,Z", allow_hyphen_values = true)]
    probe_at: String,
    /// Direction of the displacement, x,y,z, or auto: into the body at the contact; once for all
    /// targets, or once for each
    #[arg(long, default_value = "auto", value_name = "X,Y,Z", allow_hyphen_values = true)]
    direction: Vec<String>,
    /// What else is looked for with --young-pa: stiffening (the moduli of --stiffening, which says
    /// where to begin), half-width (its half-widths), thickness (of a slab), offset (how far a probe
    /// or blade had gone on from where it met the surface when its displacement was 0), toughness
    /// (what a blade feels, with --cuttable)
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    fit: Vec<Fitted>,
    /// Displacement of the tool with relaxation curves and fields [m]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    displacement_m: Option<f64>,
    /// Force of the tool with a field [N]
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    force_n: Option<f64>,
    /// Part of the rows of every target that only judges the result
    #[arg(long, default_value_t = 0.2, value_name = "PART", allow_negative_numbers = true)]
    hold_out: f64,
    /// Where a parameter is looked for; repeat it for several. Unless given: stiffness_n_per_m=0.01,1e5,
    /// alpha=0,0.5, time_constant_s=1e-4,1e4, young_pa=100,1e6, stiffening_pa=10,1e7,
    /// half_width=0.01,0.5, thickness_m=0.002,0.1, offset_m=1e-5,1e-3, toughness_j_per_m2=0.1,1e4
    #[arg(long, value_name = "NAME=LOW,HIGH")]
    bounds: Vec<String>,
    #[command(flatten)]
    body: BodyArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What `--fit` names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Fitted {
    Stiffening,
    HalfWidth,
    Thickness,
    Offset,
    Toughness,
}

/// identified.json
#[derive(Debug, Serialize)]
struct IdentifiedFile<'a> {
    mesh: &'a str,
    model: String,
    cells: usize,
    contact_nodes: Vec<u32>,
    probe_radius_m: Option<f64>,
    blade_length_m: Option<f64>,
    direction: [f64; 3],
    hold_out: f64,
    #[serde(flatten)]
    found: &'a Identified,
    volume_term: &'static str,
}

pub fn execute(args: &Args) -> Result<()> {
    // Read the mesh, its groups and the targets.
    refuse_model(&args.mesh)?;
    let slab = Slab::parse(&args.mesh)?;
    let (mesh, fixed, options) = match slab {
        None => args.body.parts(&args.mesh)?,
        Some(slab) => {
            let mesh = slab.mesh()?;
            let (fixed, options) = args.body.choices(&mesh)?;
            (mesh, fixed, options)
        }
    };
    let groups = groups(&args.group, &mesh)?;
    let mut targets = targets(args)?;
    // Bake the body with start values, and place the tool.
    let image = bake::bake(&mesh, &fixed, &options)?;
    let model = model_file::parse(&image, &args.output)?;
    let contacts;
    let at_m = || first_met(&args.probe_at, slab.is_some(), &model);
    let tool = match (probe_radius(&args.contact)?, blade_edge(&args.contact)?) {
        (Some(radius_m), _) => Tool::Probe { radius_m, at_m: at_m()? },
        (None, Some(edge)) => {
            refuse_blade(&args.contact, &model)?;
            Tool::Blade(edge, at_m()?)
        }
        (None, None) => {
            contacts = held(args, &model)?;
            Tool::Held(&contacts)
        }
    };
    // Set up the bench.
    let direction = directions(args, &model, &tool, &mut targets)?;
    let wanted = Wanted {
        stiffening: args.fit.contains(&Fitted::Stiffening),
        half_width: args.fit.contains(&Fitted::HalfWidth),
        thickness: args.fit.contains(&Fitted::Thickness),
        offset: args.fit.contains(&Fitted::Offset),
        toughness: args.fit.contains(&Fitted::Toughness),
    };
    let bench = Bench {
        mesh: &mesh,
        fixed: &fixed,
        options: &options,
        groups: &groups,
        tool,
        direction,
        targets: &targets,
        slab,
        wanted,
    };
    // Check everything before the long fit, and open the folder.
    let bounds = bounds(&args.bounds)?;
    check(&bench, &bounds, args.hold_out)?;
    check_place(&args.output)?;
    let folder = Folder::open(&args.out, args.force)?;
    // Fit, and write the results.
    let found = identify(&bench, &bounds, args.hold_out)?;
    write_results(args, &bench, &model, &found, &folder)
}

fn write_results(
    args: &Args,
    bench: &Bench<'_>,
    model: &Model<'_>,
    found: &Identified,
    folder: &Folder,
) -> Result<()> {
    // Write residuals and charts.
    let image = forward::image(bench, &found.parameters)?;
    folder.write("residuals.csv", write::residuals_csv(bench.targets, found).as_bytes())?;
    for figure in write::charts(bench.targets, found)? {
        figure.picture.write(folder, &figure.name)?;
    }
    // Write the report.
    let (contacts, probe_radius_m, blade_length_m) = match bench.tool {
        Tool::Held(cells) => (cells, None, None),
        Tool::Probe { radius_m, .. } => (&[][..], Some(radius_m), None),
        Tool::Blade(edge, _) => (&[][..], None, Some(2.0 * f64::from(edge.half_m[0]))),
    };
    let contact_nodes = contacts.iter().map(|&cell| model.input_id()[usize::from(cell)]);
    let is_nodal = bench.options.tissue.is_some();
    let report = IdentifiedFile {
        mesh: &args.mesh,
        model: args.output.display().to_string(),
        cells: model.cells(),
        contact_nodes: contact_nodes.collect(),
        probe_radius_m,
        blade_length_m,
        direction: bench.direction,
        hold_out: args.hold_out,
        found,
        volume_term: if is_nodal { "held as given" } else { "not part of the model" },
    };
    folder.write_json("identified.json", &report)?;
    // Write the model, if the fit holds, and print.
    check_fit(found, bench.direction)?;
    write_whole(&args.output, image.as_bytes())?;
    if args.json { terminal::say_json(&report) } else { print(args, found, bench.direction) }
}

/// The cells that the tool holds.
fn held(args: &Args, model: &Model<'_>) -> Result<Vec<u16>> {
    if args.probe_at != "auto" {
        return Err(Error::input(format!(
            "--probe-at {}: there is no probe; give --contact probe:RADIUS, or leave it out",
            args.probe_at
        )));
    }
    let contacts = contact_cells(&args.contact, model)?;
    match contacts.iter().find(|&&cell| model.is_fixed(cell)) {
        None => Ok(contacts),
        Some(&cell) => Err(Error::input(format!(
            "--contact: node {} is fixed and cannot be held by the tool",
            model.input_id()[usize::from(cell)]
        ))),
    }
}

/// The point that a probe or blade meets first \[m\].
fn first_met(at: &str, is_slab: bool, model: &Model<'_>) -> Result<[f64; 3]> {
    match at {
        // The middle of a slab's top.
        "auto" if is_slab => Ok([0.0; 3]),
        "auto" => Ok(rest_m(model, farthest(model)?.into())),
        text => numbers(text).filter(|at: &[f64; 3]| at.iter().all(|x| x.is_finite())).ok_or_else(
            || Error::input(format!("--probe-at {text}: give three numbers, x,y,z [m], or auto")),
        ),
    }
}

/// Refuses a blade on a body that cannot be cut.
fn refuse_blade(contact: &str, model: &Model<'_>) -> Result<()> {
    if model.tetrahedra_to_cut() > 0 {
        return Ok(());
    }
    Err(Error::input(format!("--contact {contact}: a blade cuts: add --cuttable")))
}

fn bounds(texts: &[String]) -> Result<Bounds> {
    texts.iter().try_fold(Bounds::default(), |bounds, text| {
        let parts = text.split_once('=').and_then(|(name, pair)| Some((name, numbers(pair)?)));
        let (name, pair) =
            parts.ok_or_else(|| Error::input(format!("--bounds {text}: give NAME=LOW,HIGH")))?;
        bounds.with(name, pair)
    })
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

/// The direction of the bench; that of each target where there are several.
fn directions(
    args: &Args,
    model: &Model<'_>,
    tool: &Tool<'_>,
    targets: &mut [Target],
) -> Result<[f64; 3]> {
    let cells = match *tool {
        Tool::Held(cells) => cells.to_vec(),
        Tool::Probe { at_m, .. } | Tool::Blade(_, at_m) => vec![nearest(model, at_m)],
    };
    let all: Result<Vec<_>> =
        args.direction.iter().map(|text| direction(text, model, &cells)).collect();
    let (all, count) = (all?, args.target.len());
    if all.len() > 1 && (all.len() != count || targets.len() != count) {
        return Err(Error::input(format!(
            "--direction: {} of them for {count} targets; give one for all, or one for each",
            all.len()
        )));
    }
    if all.len() > 1 {
        for (target, direction) in targets.iter_mut().zip(&all) {
            target.direction = Some(*direction);
        }
    }
    all.first().copied().ok_or_else(|| Error::check("no direction"))
}

/// The surface cell nearest to a point.
fn nearest(model: &Model<'_>, at_m: [f64; 3]) -> u16 {
    let away = |cell: &u16| norm(minus(rest_m(model, usize::from(*cell)), at_m));
    let surface = model.surface().iter().copied();
    surface.min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or_default()
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

fn print(args: &Args, found: &Identified, direction: [f64; 3]) -> Result<()> {
    // Print the parameters.
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
    // Print how well each target is met.
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
    // Print what is not determined, and the cost.
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
