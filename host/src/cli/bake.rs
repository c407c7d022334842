//! `chaincell bake`: from a mesh to a model image.

use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::model_file;
use super::reports::ModelReport;
use crate::bake::tissue::Tissue;
use crate::bake::{BakeOptions, BasisSpacing, PerCell, bake};
use crate::error::{Error, Result};
use crate::files::whole::write_whole;
use crate::interrupt;
use crate::mesh::{self, Mesh, MeshOptions};
use crate::terminal;
use crate::text;

/// Poisson's ratio of soft tissue, where none is given.
const POISSON: &str = "0.45";
/// Largest file of values, one a node \[B\].
const VALUES_BYTES_MAX: u64 = 64 << 20;

/// Bake a mesh into a model image that the kernel reads in place.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell bake liver.msh -o liver.chaincell \
    --fix file:liver.sets.json#fixed --alpha 0.05")]
pub struct Args {
    /// A Gmsh .msh file (2.2 or 4.1) or a legacy VTK .vtk file (unstructured grid), ASCII or
    /// binary, first-order tetrahedra; plane:NXxNYxD (nodes along x and y, spacing in m),
    /// box:NXxNYxNZxD, or organ[:NODES], a generated liver-like body
    mesh: String,
    /// Model file to write
    #[arg(short, long, value_name = "MODEL")]
    output: PathBuf,
    #[command(flatten)]
    body: BodyArgs,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What the body is made of.
#[derive(Debug, Clone, clap::Args)]
pub struct BodyArgs {
    /// Half-width of the links' band in rest lengths, in [0, 1): the slack of the tissue; a number,
    /// or file:PATH with one value per node
    #[arg(long, default_value = "0", value_name = "ALPHA", allow_negative_numbers = true)]
    alpha: String,
    /// Stiffness of a link [N/m]; a number, or file:PATH with one value per node
    #[arg(long, default_value = "20", value_name = "K", allow_negative_numbers = true)]
    stiffness_n_per_m: String,
    /// Young's modulus [Pa]: the body is made of nodal shapes, its links carry no force; a number,
    /// or file:PATH with one value per node
    #[arg(
        long,
        value_name = "E",
        allow_negative_numbers = true,
        conflicts_with_all = ["alpha", "stiffness_n_per_m"]
    )]
    young_pa: Option<String>,
    /// Poisson's ratio, 0 to 0.495; a number, or file:PATH with one value per node
    /// [default: 0.45]
    #[arg(long, value_name = "NU", allow_negative_numbers = true, requires = "young_pa")]
    poisson: Option<String>,
    /// Nodes held for ever: ids, nodes:0,5,7, file:PATH, file:PATH#KEY, box:x0,x1,y0,y1,z0,z1,
    /// group:NAME, border, or none [default: border of a plane, bottom of a box, back of the
    /// organ, none of a file]
    #[arg(id = "fixed", long = "fix", value_name = "SELECTOR")]
    fix: Option<String>,
    /// Link both diagonals of each square of a plane
    #[arg(long)]
    diagonals: bool,
    /// Link nodes at most R edges apart: the neighbourhood of the paper's Eq. 1
    #[arg(long, default_value_t = 1, value_name = "R")]
    rings: u32,
    /// Unit of a mesh file's coordinates
    #[arg(id = "unit_m", long = "units", value_name = "UNITS", value_enum, default_value_t = Units::M)]
    units: Units,
    /// Leave nodes without a link out; the others keep their numbers
    #[arg(long)]
    drop_unused: bool,
    /// Accept a body of several unconnected parts
    #[arg(long)]
    allow_parts: bool,
    /// Saturation K: largest coordinate of a cell from the body's centre [m]
    /// [default: 4 times the largest at rest]
    #[arg(id = "saturation_m", long = "k-m", value_name = "K", allow_negative_numbers = true)]
    k_m: Option<f64>,
    /// Cell resistance R_x
    #[arg(
        id = "resistance",
        long = "r-x",
        default_value_t = 1.0,
        value_name = "R",
        allow_negative_numbers = true
    )]
    r_x: f64,
    /// Cell capacitance C
    #[arg(long, default_value_t = 1.0, value_name = "C", allow_negative_numbers = true)]
    capacitance: f64,
    /// Largest energy a tool may load into the body [J] [default: that of eight
    /// cells of the largest valence, each displaced by the width of the body]
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    energy_max_j: Option<f64>,
    /// Coarse level of `track`: distance of its basis functions (hats) in mean link lengths, none,
    /// or auto (at most 400 at 2.5 or more; none where every cell is within four links of a fixed
    /// one)
    #[arg(
        id = "coarse_basis",
        long = "hats",
        default_value = "auto",
        value_name = "SPACING",
        allow_negative_numbers = true
    )]
    hats: String,
    /// Add the colours of the cells, which gauss-seidel needs: two bytes a cell
    #[arg(long)]
    colours: bool,
    /// Leave out what firmware has no use for: groups, triangles, tetrahedra, the mesh
    /// embedded by --cells, and the links once more in slices for vector units
    #[arg(long)]
    lean: bool,
    /// Map the nodes to N cells, groups of neighbouring nodes whose positions follow; a mesh may
    /// then have up to 2,000,000 nodes [default: every node is a cell]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    cells: Option<usize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Units {
    M,
    Mm,
}

pub fn execute(args: &Args) -> Result<()> {
    let (mesh, image) = args.body.bake(&args.mesh)?;
    write_whole(&args.output, image.as_bytes())?;
    let model = model_file::parse(&image, &args.output)?;
    let report = ModelReport::new(&model, image.as_bytes().len());
    if args.json {
        return terminal::say_json(&report);
    }
    if model.fixed().is_empty() {
        terminal::note("note: no cell is fixed, the body floats; --fix holds nodes");
    }
    if mesh.flat_tetrahedra > 0 {
        terminal::note(format_args!("note: {} tetrahedra are flat", mesh.flat_tetrahedra));
    }
    terminal::say(format_args!("baked {} from {}", args.output.display(), args.mesh))?;
    if let Some(wanted) = args.body.cells.filter(|&wanted| wanted != model.cells()) {
        terminal::say(format_args!(
            "  {:<14}{wanted} asked for; parts that stay apart make it {}",
            "cells",
            model.cells()
        ))?;
    }
    if !mesh.tetrahedra.is_empty() {
        terminal::say(format_args!("  {:<14}{}", "tetrahedra", mesh.tetrahedra.len()))?;
    }
    report.print()
}

impl BodyArgs {
    /// Reads or generates the mesh and bakes it.
    pub fn bake(&self, spec: &str) -> Result<(Mesh, crate::bake::ImageBytes)> {
        let (mesh, fixed, options) = self.parts(spec)?;
        let image = bake(&mesh, &fixed, &options)?;
        interrupt::check()?;
        Ok((mesh, image))
    }

    /// Reads or generates the mesh; with its fixed nodes and what the bake may choose.
    pub fn parts(&self, spec: &str) -> Result<(Mesh, Vec<u32>, BakeOptions)> {
        let options = MeshOptions {
            unit_m: if self.units == Units::Mm { 0.001 } else { 1.0 },
            diagonals: self.diagonals,
            drop_unused: self.drop_unused,
            allow_parts: self.allow_parts,
            rings: self.rings,
            nodes_max: if self.cells.is_some() { mesh::NODES_MAX } else { mesh::CELLS_MAX },
        };
        let mesh = mesh::load(spec, &options)?;
        let fixed = match self.fix.as_deref() {
            None => mesh.default_fixed.clone(),
            Some("none") => Vec::new(),
            Some(text) => mesh::select(text, &mesh.nodes_m, &mesh.groups, &mesh.border, "--fix")?,
        };
        let options = BakeOptions {
            alpha: per_cell("--alpha", &self.alpha)?,
            stiffness_n_per_m: per_cell("--stiffness-n-per-m", &self.stiffness_n_per_m)?,
            tissue: self.tissue()?,
            saturation_m: self.k_m,
            resistance: self.r_x,
            capacitance: self.capacitance,
            energy_max_j: self.energy_max_j,
            coarse_basis: spacing(&self.hats)?,
            colours: self.colours,
            lean: self.lean,
            cells: self.cells,
        };
        Ok((mesh, fixed, options))
    }
}

impl BodyArgs {
    /// What the tissue is made of, where it is not made of links.
    fn tissue(&self) -> Result<Option<Tissue>> {
        let Some(young) = &self.young_pa else { return Ok(None) };
        let poisson = self.poisson.as_deref().unwrap_or(POISSON);
        Ok(Some(Tissue {
            young_pa: per_cell("--young-pa", young)?,
            poisson: per_cell("--poisson", poisson)?,
        }))
    }
}

fn spacing(text: &str) -> Result<BasisSpacing> {
    match text {
        "auto" => Ok(BasisSpacing::BySize),
        "none" => Ok(BasisSpacing::None),
        number => number.parse().map(BasisSpacing::Links).map_err(|_| {
            Error::input(format!(
                "--hats {number}: give a distance in mean link lengths, none or auto"
            ))
        }),
    }
}

/// A number, or one a node from a file (JSON array, or separated by white space or commas).
fn per_cell(option: &str, text: &str) -> Result<PerCell> {
    let number = |token: &str, place: &str| {
        token.parse::<f64>().map_err(|_| {
            Error::input(format!("{option}{place}: `{token}` is no number; give one, or file:PATH"))
        })
    };
    let Some(path) = text.strip_prefix("file:").map(Path::new) else {
        return number(text, "").map(PerCell::Uniform);
    };
    let content = text::read(path, VALUES_BYTES_MAX)
        .map_err(|why| Error::file(&format!("read {option}"), path, why))?;
    let tokens = content
        .split(|c: char| c.is_whitespace() || matches!(c, ',' | '[' | ']'))
        .filter(|token| !token.is_empty());
    let values: Result<Vec<f64>> = (tokens.enumerate())
        .map(|(at, token)| number(token, &format!(" {}, value {at}", path.display())))
        .collect();
    values.map(PerCell::Each)
}
