//! `chaincell check`: the error of a body's force, from its mesh and from the sweeps of its ticks.

use std::fmt;
use std::time::Instant;

use chaincell_kernel::{Budget, Model, Network, ToolPart, ToolPose};
use serde::Serialize;

use super::bake::BodyArgs;
use super::press::{Vector, vector};
use super::shared::PrintArgs;
use super::tool::{self, ToolSpec};
use crate::bake::{BakeOptions, ImageBytes, bake};
use crate::engine::contact::held;
use crate::engine::convergence::{Convergence, ForceError};
use crate::engine::mesh_error::{FALL, PlaceError, Pressed, free_volumes_m3, place_error};
use crate::engine::motion::Press;
use crate::engine::place::{Place, places};
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::{Arithmetic, Contact, Engine, Scheme};
use crate::error::{Error, Result};
use crate::mesh::{Mesh, Refined, select};
use crate::terminal::{self, Progress};
use crate::words::{counted, length, three_digits};

/// Places of presses.
const PLACES: usize = 3;
/// Ticks of the press whose sweeps are judged.
const TICKS: u64 = 400;
/// Depth of a press unless given, in radii of the tool, or in mean links where cells are held.
const DEPTH: f64 = 0.5;
/// Error below which the difference of two meshes is an upper bound only.
const BOUND: f64 = 0.01;

/// Say how far a body's force is off, from its mesh and from its sweeps: press it at three places, and the same body
/// on the mesh cut once.
///
/// Takes what `bake` takes, but for bodies that relax; one that can be cut is checked uncut. The estimate is right
/// within a factor of 1.3 for a patch that is held; under a ball on a coarse mesh it is 0.35 to 1.6 times the true
/// error. Seconds for some hundred cells, minutes for some thousand.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  chaincell check organ:300 --young-pa 5000 --tool sphere:0.01\n  \
    chaincell check liver.msh --fix file:liver.sets.json#fixed --young-pa 5000 --tool sphere:0.02 --sweeps 2"
)]
pub struct Args {
    /// A mesh of tetrahedra as `bake` takes it
    mesh: String,
    #[command(flatten)]
    body: BodyArgs,
    /// The tool that presses, as `run` takes it [default: a sphere of two mean edges]
    #[arg(long, value_name = "PART[+PART...]", conflicts_with = "hold")]
    tool: Option<ToolSpec>,
    /// Press these nodes in place of a tool, all as one: a selector as of --fix
    #[arg(long, value_name = "SELECTOR")]
    hold: Option<String>,
    /// Direction of the first press [default: into the body]
    #[arg(long, value_name = "X,Y,Z", value_parser = vector, allow_hyphen_values = true)]
    direction: Option<Vector>,
    /// Depth of the presses [m] [default: half the smallest radius of the tool; half a mean edge with
    /// --hold]
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    depth_m: Option<f64>,
    /// Sweeps of a tick whose force is compared with 64
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(1..=63))]
    sweeps: u16,
    #[command(flatten)]
    print: PrintArgs,
}

/// The report, and the output of `--json`.
#[derive(Debug, Serialize)]
struct Printed {
    /// Cells of the given mesh, and of that cut once.
    cells: [usize; 2],
    /// Mean edge \[m\].
    edge_m: f64,
    /// Depth of the presses \[m\].
    depth_m: f64,
    places: Vec<PlaceError>,
    /// The largest errors of the places, from the mesh.
    field_error: f64,
    force_error: f64,
    /// Factor from these errors to those against all finer meshes.
    limit: f64,
    /// Mean edge that halves them where the surface is smooth \[m\], and cells of such a mesh.
    halving_edge_m: f64,
    halving_cells: usize,
    solver: Solver,
}

/// The error that sweeps leave, and their time.
#[derive(Debug, Serialize)]
struct Solver {
    sweeps: u16,
    /// Against many sweeps, over a press, hold and retreat; absent where no force acted.
    force_error: Option<ForceError>,
    /// Median time of a tick on this machine \[ns\].
    tick_ns: u64,
}

pub fn execute(args: &Args) -> Result<()> {
    let report = check(args)?;
    if args.print.json {
        terminal::say_json(&report)
    } else {
        terminal::say(format_args!("{report}"))
    }
}

/// The body, and its options, without what a mesh has no part in.
fn body(args: &Args) -> Result<(Mesh, Vec<u32>, BakeOptions)> {
    let (mesh, fixed, mut options) = args.body.parts(&args.mesh)?;
    if options.cells.is_some() {
        return Err(Error::input(
            "`cells`: the error of groups of nodes is not that of the mesh; leave it out, and give a mesh of as many \
             nodes",
        ));
    }
    let Some(tissue) = &options.tissue else {
        return Err(Error::input(
            "links have no finer mesh to compare with: they are the paper's, not a material's; give `young_pa`",
        ));
    };
    if tissue.relaxation.is_some() {
        return Err(Error::input(
            "`branches`: a body that relaxes has no one force at a depth; give the modulus that matters without them, \
             beside `tissue` as none",
        ));
    }
    if fixed.is_empty() {
        return Err(Error::input(
            "nothing holds the body, which a press moves as a whole; give `fixed`",
        ));
    }
    // A cut is refused as the bake does, then left aside.
    if options.cuttable.is_some() {
        bake(&mesh, &fixed, &options)?;
        options.cuttable = None;
    }
    Ok((mesh, fixed, options))
}

fn check(args: &Args) -> Result<Printed> {
    // Bake the body on both meshes.
    let (mesh, fixed, options) = body(args)?;
    let refined = Refined::of(&mesh)?;
    let image = bake(&mesh, &fixed, &options)?;
    let finer_fixed = refined.with_middles(&mesh, &fixed);
    let finer_image = bake(&refined.mesh, &finer_fixed, &options.refined(&refined))?;
    let (model, finer) = (parse(&image)?, parse(&finer_image)?);
    // The contact of both, and the places.
    let edge_m = f64::from(model.unit_m());
    let held_nodes = args
        .hold
        .as_deref()
        .map(|text| select(text, &mesh.nodes_m, &mesh.groups, &mesh.border, "--hold"));
    let held_nodes = held_nodes.transpose()?;
    let contacts = match &held_nodes {
        Some(nodes) => {
            check_patch(&mesh, nodes)?;
            let finer_nodes = refined.with_middles(&mesh, nodes);
            [
                Contact::Cells(held(&model, nodes).map_err(of_hold)?),
                Contact::Cells(held(&finer, &finer_nodes).map_err(of_hold)?),
            ]
        }
        None => {
            let contact = sphere_or(args.tool.as_ref(), &model)?;
            [contact.clone(), contact]
        }
    };
    let [contact, finer_contact] = &contacts;
    let places = places(&model, contact, args.direction.map(|of| of.0), PLACES)?;
    let depth_m = depth_m(args, contact, edge_m)?;
    // Press them.
    let bodies = [Pressed { model, contact }, Pressed { model: finer, contact: finer_contact }];
    let volumes_m3 = free_volumes_m3(&mesh, fixed.iter().chain(held_nodes.iter().flatten()));
    if volumes_m3.iter().sum::<f64>() <= 0.0 {
        return Err(Error::input(
            "every node is fixed or held, and none shows how the body deforms; give a finer mesh",
        ));
    }
    // First the solver: what it refuses is no matter of a place.
    let solver = Solver::of(&model, contact, &places[0], depth_m, args.sweeps)?;
    let errors = at_places(&places, |place| place_error(bodies, place, depth_m, &volumes_m3))?;
    let largest = |of: fn(&PlaceError) -> f64| errors.iter().map(of).fold(0.0, f64::max);
    let cells = [model, finer].map(|model| model.body_cells());
    // Half the edge makes the cells those of the cut mesh.
    let halvings = 1.0 / FALL.log2();
    let growth = (cells[1] as f64 / cells[0] as f64).powf(halvings);
    Ok(Printed {
        cells,
        edge_m,
        depth_m,
        field_error: largest(|error| error.field_error),
        force_error: largest(|error| error.force_error),
        limit: FALL / (FALL - 1.0),
        halving_edge_m: edge_m * 0.5_f64.powf(halvings),
        halving_cells: (cells[0] as f64 * growth).round() as usize,
        places: errors,
        solver,
    })
}

/// The errors of the places. A place without a force is left out, with a note.
fn at_places(
    places: &[Place],
    error_at: impl Fn(&Place) -> Result<PlaceError>,
) -> Result<Vec<PlaceError>> {
    let progress = Progress::new(places.len() as u64, "presses");
    let (mut errors, mut refused) = (Vec::new(), None);
    for place in places {
        match error_at(place) {
            Ok(error) => errors.push(error),
            Err(why @ Error::Input(_)) => {
                terminal::note(format_args!("note: a place is left out: {why}"));
                refused = Some(why);
            }
            Err(why) => return Err(why),
        }
        progress.step();
    }
    match refused {
        Some(why) if errors.is_empty() => Err(why),
        _ => Ok(errors),
    }
}

fn parse(image: &ImageBytes) -> Result<Model<'_>> {
    Model::from_bytes(image.as_bytes()).map_err(Error::check)
}

/// The tool; a sphere of two edges unless one is given.
fn sphere_or(given: Option<&ToolSpec>, model: &Model<'_>) -> Result<Contact> {
    let Some(given) = given else { return Ok(Contact::sphere(2.0 * model.unit_m(), 0.0)) };
    if given.is_blade() {
        return Err(Error::input(format!(
            "`tool` {given}: a blade cuts, and has no one force at a depth; give a tool without an edge"
        )));
    }
    tool::tools(core::slice::from_ref(given), None, model)
}

/// Refuses nodes without a triangle of the surface between them: the force at a point has no limit as meshes get finer.
fn check_patch(mesh: &Mesh, nodes: &[u32]) -> Result<()> {
    let has = |node: &u32| nodes.binary_search(node).is_ok();
    if mesh.triangles.iter().any(|corners| corners.iter().all(has)) {
        return Ok(());
    }
    Err(Error::input(
        "`hold`: no triangle of the surface lies between these nodes, and the force at a point depends on the mesh alone; \
         hold a patch",
    ))
}

/// Names `hold` in a refusal of its cells.
fn of_hold(why: Error) -> Error {
    match why {
        Error::Input(text) => Error::Input(text.replace("`contact`", "`hold`")),
        other => other,
    }
}

/// The depth of the presses.
fn depth_m(args: &Args, contact: &Contact, edge_m: f64) -> Result<f64> {
    let radius_m = contact.first_tool().map(|parts| {
        parts.iter().map(|part: &ToolPart| f64::from(part.radius_m)).fold(f64::INFINITY, f64::min)
    });
    let depth_m = args.depth_m.unwrap_or(DEPTH * radius_m.unwrap_or(edge_m));
    if depth_m.is_finite() && depth_m > 0.0 {
        return Ok(depth_m);
    }
    Err(Error::input(format!("`depth_m` {depth_m}: must be above 0 and finite; give it in metres")))
}

impl Solver {
    /// Presses a body by its ticks, once to compare them with many sweeps and once to time them.
    fn of(
        model: &Model<'_>,
        contact: &Contact,
        place: &Place,
        depth_m: f64,
        sweeps: u16,
    ) -> Result<Self> {
        let press = Press::new(place.touch_m, place.direction, depth_m, TICKS)?;
        let poses: Vec<ToolPose> = press.poses().into_iter().map(ToolPose::from).collect();
        let staged = || {
            let settings = Scheme::Predict.settings(model, sweeps);
            let network = Network::new(*model, settings).map_err(Error::check)?;
            let engine =
                Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact.clone());
            Staged::new(engine?, None)
        };
        let mut convergence = Convergence::new(TICKS, model.body_cells());
        let mut tissue = staged()?;
        for pose in &poses {
            convergence.tick(&mut tissue, core::slice::from_ref(pose), Budget::All);
        }
        let mut tissue = staged()?;
        let mut steps: Vec<u64> = poses
            .iter()
            .map(|pose| {
                let start = Instant::now();
                tissue.tick(pose);
                u64::try_from(start.elapsed().as_nanos()).unwrap_or(u64::MAX)
            })
            .collect();
        steps.sort_unstable();
        let tick_ns = steps.get(steps.len() / 2).copied().unwrap_or_default();
        Ok(Self { sweeps, force_error: convergence.error(), tick_ns })
    }
}

impl fmt::Display for Printed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let [cells, finer] = self.cells;
        writeln!(
            f,
            "{cells} cells with edges of {}, beside {finer} of the mesh cut once; pressed {} deep",
            length(self.edge_m),
            length(self.depth_m)
        )?;
        for place in &self.places {
            let [x, y, z] = place.touch_m.map(|x| 1e3 * x);
            writeln!(
                f,
                "  at ({x:.1}, {y:.1}, {z:.1}) mm: {} N, cut once {} N: force {}, field {} off",
                three_digits(place.force_n),
                three_digits(place.finer_force_n),
                percent(place.force_error),
                percent(place.field_error)
            )?;
        }
        let (field, force) = (self.field_error, self.force_error);
        writeln!(
            f,
            "  from the mesh    field {}, force {} at most; against all finer meshes {}, {}",
            percent(field),
            percent(force),
            percent(self.limit * field),
            percent(self.limit * force)
        )?;
        if field.min(force) < BOUND {
            writeln!(f, "  {:17}below 1 % an error is an upper bound, no estimate", "")?;
        }
        writeln!(
            f,
            "  {:17}edges of {}, some {} cells, halve it where the surface is smooth",
            "",
            length(self.halving_edge_m),
            self.halving_cells
        )?;
        let Solver { sweeps, force_error, tick_ns } = &self.solver;
        let time = format!("{} and {} us a tick", counted(sweeps, "sweep"), tick_ns / 1000);
        match force_error {
            Some(error) => write!(
                f,
                "  from the solver  {} (median {}) at {time}, in 99 of 100 ticks of a press",
                percent(error.p99),
                percent(error.median)
            ),
            None => write!(f, "  from the solver  no force acted in a press at {time}"),
        }
    }
}
