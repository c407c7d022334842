//! `chaincell bake`: from a mesh to a model image.

use std::path::PathBuf;

use chaincell_kernel::{Loose, Model, TearLimit};
use clap::ValueEnum;
use serde::Serialize;

use super::filled::FilledReport;
use super::judgement::{Judgement, MeshFit, Pace};
use super::mesh_file::MeshFileArgs;
use super::model_file;
use super::reports::ModelReport;
use super::shared::{PrintArgs, tell_view};
use super::tissue_texts::{Bands, BranchOrNone, branch, stiffening};
use super::values::{Material, per_cell, toughness_with_materials, with_materials};
use crate::bake::tissue::{Branch, KnownTissue, Relaxation, STRETCH_MIN, Tissue, relaxation};
use crate::bake::{
    BakeOptions, BasisSpacing, CUT_SPARE, ContactSurface, Cuttable, Equivalent, PerCell,
    TOUGHNESS_J_PER_M2, bake,
};
use crate::engine::staged::check_tick;
use crate::error::{Error, Result};
use crate::files::whole::{keep_input, write_whole};
use crate::interrupt;
use crate::mesh::{self, Mesh, MeshOptions, Overlaps, UnlikelySize};
use crate::terminal;

/// Poisson's ratio of soft tissue, where none is given.
const POISSON: f64 = 0.45;

/// Bake a mesh into a model image that the kernel reads in place.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell bake liver.msh -o liver.chaincell \
    --fix file:liver.sets.json#fixed --alpha 0.05")]
pub struct Args {
    /// A file of first-order tetrahedra: Gmsh .msh (2.2 or 4.1), legacy VTK .vtk or VTK XML .vtu
    /// (unstructured grid), Abaqus or AVS UCD .inp, TetGen .node or .ele (both are read), Medit .mesh
    /// (ASCII);
    /// a closed surface, .stl, .obj or .ply, with --fill; plane:NXxNYxD (nodes along x and y,
    /// spacing in m), box:NXxNYxNZxD, or organ[:NODES], a generated liver-like body
    mesh: String,
    /// Model file to write
    #[arg(short, long, value_name = "MODEL")]
    output: PathBuf,
    #[command(flatten)]
    body: BodyArgs,
    /// Print what `info` prints too: valences, the coarse level, bounds, and the RAM of each scheme
    #[arg(long)]
    verbose: bool,
    #[command(flatten)]
    print: PrintArgs,
}

/// What the body is made of.
#[derive(Debug, Clone, clap::Args)]
#[command(group = clap::ArgGroup::new("shapes").args(["young_pa", "material", "tissue"]).multiple(true))]
#[command(group = clap::ArgGroup::new("relaxing").args(["branches", "tissue"]).multiple(true))]
pub struct BodyArgs {
    /// Half-width of the links' band in rest lengths, in [0, 1): the slack of the tissue; a number,
    /// file:PATH with one value per node, or 0.02,group:NAME=0.1 with more groups behind commas; a
    /// link takes the mean of its two nodes
    #[arg(long, default_value = "0", value_name = "ALPHA", allow_negative_numbers = true)]
    alpha: String,
    /// Stiffness of a link [N/m]; as --alpha. With --branch it is the long-term one, unless --instant
    /// says otherwise
    #[arg(long, default_value = "20", value_name = "K", allow_negative_numbers = true)]
    stiffness_n_per_m: String,
    /// Tissue by name, of those that `chaincell tissues` lists, or FILE.csv:NAME of a table as `chaincell
    /// relaxation` writes it (FILE.csv if it has one tissue): its modulus, Poisson's ratio, branches and
    /// bands, and its toughness with --cuttable; options given beside it go before
    #[arg(long, value_name = "NAME", conflicts_with_all = ["alpha", "stiffness_n_per_m"])]
    tissue: Option<String>,
    /// Young's modulus [Pa]: the body is made of nodal shapes, its links carry no force; a value of
    /// each node, as --alpha; a tetrahedron takes the mean of its nodes. With --branch it is the
    /// long-term modulus, unless --instant says otherwise
    #[arg(
        long,
        value_name = "E",
        allow_negative_numbers = true,
        conflicts_with_all = ["alpha", "stiffness_n_per_m"]
    )]
    young_pa: Option<String>,
    /// Poisson's ratio, 0 to 0.495; as --alpha. With --branch it is the instantaneous one, and rises in
    /// time, since only shear relaxes [default: 0.45]
    #[arg(long, value_name = "NU", allow_negative_numbers = true, requires = "shapes")]
    poisson: Option<String>,
    /// What a group of the mesh is made of: group:NAME,young-pa=E,poisson=NU, and with --cuttable
    /// toughness-j-per-m2=J; once per group, a later one counts where groups share nodes
    #[arg(long, value_name = "MATERIAL", conflicts_with_all = ["alpha", "stiffness_n_per_m"])]
    material: Vec<String>,
    /// The stretch below which shapes resist five times as much, which keeps deep presses from
    /// folding them; none for no such band [default: 0.7]
    #[arg(long, value_name = "STRETCH", requires = "shapes")]
    stretch_min: Option<String>,
    /// Bands on the links of nodal shapes, up to six: HALF_WIDTH=PASCAL,HALF_WIDTH=PASCAL; what is
    /// strained beyond a half-width resists with that modulus more, as 0.1=10000,0.25=60000, and
    /// with short: or long: before it only what is shortened or lengthened, as short:0.035=22000; they
    /// stay elastic beside --branch; none leaves out those of --tissue
    #[arg(long, value_name = "BANDS", requires = "shapes", value_parser = stiffening)]
    stiffening: Option<Bands>,
    /// A branch of stress that relaxes: its shear modulus, or the stiffness of links, over the long-term
    /// one, and the time [s] in which its stress falls to 1 / e, as 2,0.1; once a branch, up to four of
    /// different times, one tick to 1,600,000 ticks. The first Lame constant, lambda, does not relax. It
    /// takes track or predict in single precision, and goes without --cuttable; none leaves out those of
    /// --tissue
    #[arg(id = "branches", long = "branch", value_name = "G,TAU",
        value_parser = branch, allow_hyphen_values = true)]
    branch: Vec<BranchOrNone>,
    /// Young's modulus, that of materials and the stiffness of links too, is the one before anything has
    /// relaxed
    #[arg(long, requires = "relaxing")]
    instant: bool,
    /// Ticks of a session in a second, for which branches are baked: run, serve and cosim refuse
    /// another rate [default: 1000]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, requires = "relaxing",
        value_parser = clap::value_parser!(u32).range(10..=100_000))]
    device_hz: Option<u32>,
    /// The paper's links, the default: no nodal shapes
    #[arg(long, conflicts_with = "shapes")]
    links: bool,
    /// Nodes held for ever: ids, nodes:0,5,7, file:PATH, file:PATH#KEY, box:x0,x1,y0,y1,z0,z1,
    /// group:NAME or group:NAME,NAME, border, or none; may be given again for more nodes [default:
    /// border of a plane, bottom of a box, back of the organ, none of a file]
    #[arg(id = "fixed", long = "fix", value_name = "SELECTOR")]
    fix: Vec<String>,
    /// Link both diagonals of each square of a plane
    #[arg(long)]
    diagonals: bool,
    /// Link nodes at most R edges apart: the neighbourhood of the paper's Eq. 1
    #[arg(long, default_value_t = 1, value_name = "R")]
    rings: u32,
    #[command(flatten)]
    file: MeshFileArgs,
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
    /// Coarse level of `track`: distance of its basis functions in mean link lengths, none,
    /// or auto (at most 400 at 2.5 or more; none where every cell is within four links of a fixed
    /// one; of nodal shapes at most 160 at 4.5 or more)
    #[arg(
        id = "coarse_basis",
        long = "coarse",
        default_value = "auto",
        value_name = "SPACING",
        allow_negative_numbers = true
    )]
    coarse: String,
    /// Leave out what firmware has no use for: groups, triangles, tetrahedra, the mesh
    /// embedded by --cells, and the links once more in slices for vector units
    #[arg(long)]
    lean: bool,
    /// The surface that tools touch, some 18 bytes a triangle: auto is yes where the mesh has
    /// triangles and the model is not --lean; without it a tool can only hold cells
    #[arg(long, value_enum, default_value = "auto", value_name = "WHETHER")]
    contact_surface: ContactSurfaceArg,
    /// The body can be cut: spare cells take the further sides of a cut. It needs tetrahedra
    #[arg(long)]
    cuttable: bool,
    /// Energy that a cut takes for each area [J/m^2]; a value of each node, as --alpha; between nodes it
    /// changes along lines [default: 160, that of liver]
    #[arg(long, value_name = "J", allow_negative_numbers = true, requires = "cuttable")]
    toughness_j_per_m2: Option<String>,
    /// Number of spare cells for each cell, eight in all at least [default: 0.1]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, requires = "cuttable")]
    cut_spare: Option<f64>,
    /// The body tears by itself where its energy reaches a fifth of the toughness for each mean edge
    #[arg(long, requires = "cuttable", conflicts_with = "tear_stretch")]
    tears: bool,
    /// The body tears by itself where it is stretched so far, 1.01 to 10 at a mean edge of 5 mm;
    /// the strain grows with one over the root of the edge
    #[arg(long, value_name = "STRETCH", allow_negative_numbers = true, requires = "cuttable")]
    tear_stretch: Option<f32>,
    /// Fate of pieces that a cut takes off: those that hang on no fixed cell and on none that the tool
    /// holds
    #[arg(long, value_enum, default_value = "leave", value_name = "WHAT", requires = "cuttable")]
    loose: LooseArg,
    /// Map the nodes to N cells, groups of neighbouring nodes whose positions follow; a mesh may
    /// then have up to 2,000,000 nodes [default: every node is a cell]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    cells: Option<usize>,
}

/// Values of `--loose`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum LooseArg {
    /// They go where tools and other sides push them
    Leave,
    /// They stay where they came loose, and are felt
    Freeze,
    /// They are gone
    Drop,
}

impl From<LooseArg> for Loose {
    fn from(arg: LooseArg) -> Self {
        match arg {
            LooseArg::Leave => Self::Leave,
            LooseArg::Freeze => Self::Freeze,
            LooseArg::Drop => Self::Drop,
        }
    }
}

/// What `--json` prints.
#[derive(Serialize)]
struct Printed {
    #[serde(flatten)]
    model: ModelReport,
    #[serde(skip_serializing_if = "Option::is_none")]
    filled: Option<FilledReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    overlapping_tetrahedra: Option<usize>,
    judgement: Judgement,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ContactSurfaceArg {
    Auto,
    Yes,
    No,
}

impl From<ContactSurfaceArg> for ContactSurface {
    fn from(arg: ContactSurfaceArg) -> Self {
        match arg {
            ContactSurfaceArg::Auto => Self::Auto,
            ContactSurfaceArg::Yes => Self::Yes,
            ContactSurfaceArg::No => Self::No,
        }
    }
}

pub fn execute(args: &Args) -> Result<()> {
    keep_input(&args.mesh, &args.output)?;
    let (mesh, image, overlaps) = interrupt::at_once(|| {
        let (mesh, image) = args.body.bake(&args.mesh)?;
        let overlaps = overlaps_of(&mesh);
        Ok((mesh, image, overlaps))
    })?;
    // Write it, and read it back as a user of it does.
    write_whole(&args.output, image.as_bytes())?;
    let model = model_file::parse(&image, &args.output)?;
    let report = Printed {
        model: ModelReport::new(&model, image.as_bytes().len()),
        filled: FilledReport::of(&mesh),
        overlapping_tetrahedra: overlaps.map(|of| of.tetrahedra),
        judgement: Judgement::of_model(&model, Pace::measured(&model), MeshFit::of_surface(&model)),
    };
    // Remarks on the mesh.
    if model.fixed().is_empty() {
        terminal::note("note: no cell is fixed, the body floats; --fix holds nodes");
    } else if model.fixed().len() == model.body_cells() {
        terminal::note("note: every cell is fixed, nothing moves; --fix fewer nodes, in metres");
    }
    if let Some(unlikely) = UnlikelySize::of(&mesh.nodes_m, args.body.file.unit_m()) {
        // Only a generator holds nodes by default, and it takes no unit.
        let said = if mesh.default_fixed.is_empty() {
            unlikely.with_unit("--units")
        } else {
            unlikely.size() + ": the spacing of a generator is in metres"
        };
        terminal::note(format_args!("note: {said}"));
    }
    if report.model.has_elastic_bands() {
        terminal::note(
            "note: the bands of --stiffening do not relax; --branch is of the shapes alone",
        );
    }
    if mesh.flat_tetrahedra > 0 {
        terminal::note(format_args!("note: {} tetrahedra are flat", mesh.flat_tetrahedra));
    }
    if let Some(Overlaps { tetrahedra, place_m }) = overlaps {
        let [x, y, z] = place_m.map(|x| x / args.body.file.unit_m());
        terminal::note(format_args!(
            "note: {tetrahedra} tetrahedra overlap, the first two around ({x:.6}, {y:.6}, {z:.6}): the mesh is \
             folded, or parts of it lie in each other; mesh it again"
        ));
    }
    if let Some(remark) = too_tough(&model) {
        terminal::note(format_args!("note: {remark}"));
    }
    // The model in numbers.
    if args.print.json {
        return terminal::say_json(&report);
    }
    terminal::say(format_args!("baked {} from {}", args.output.display(), args.mesh))?;
    if let Some(wanted) = args.body.cells.filter(|&wanted| wanted != model.body_cells()) {
        terminal::say(format_args!(
            "  {:<14}{wanted} asked for; parts that stay apart make it {}",
            "cells",
            model.body_cells()
        ))?;
    }
    if let Some(filled) = &report.filled {
        filled.print()?;
    } else if !mesh.tetrahedra.is_empty() {
        terminal::say(format_args!("  {:<14}{}", "tetrahedra", mesh.tetrahedra.len()))?;
    }
    report.model.print(args.verbose)?;
    report.judgement.print(14)?;
    // The page has ticks of a millisecond.
    if check_tick(&model, None).is_err() { Ok(()) } else { tell_view(14, &[&args.output]) }
}

/// Largest toughness at which a blade parts links before they snap, over Young's modulus of the tissue to which they
/// are equivalent times the mean edge.
const TOUGHEST: f64 = 0.25;

/// A remark on a body of links that snap before a blade parts them, with the remedy.
fn too_tough(model: &Model<'_>) -> Option<String> {
    let toughness = f64::from(model.toughness_j_per_m2()?);
    let (young_pa, edge_m) = (Equivalent::of_model(model)?.body_pa, f64::from(model.unit_m()));
    let most = TOUGHEST * young_pa * edge_m;
    (toughness > most).then(|| {
        format!(
            "a toughness of {toughness:.3} J/m^2 is above a quarter of Young's modulus times the mean edge, {most:.3} \
             J/m^2 ({young_pa:.0} Pa, {:.3} mm): these links snap under a blade before it parts them, and stay \
             folded. Bake with --toughness-j-per-m2 {:.2} or less, with links {:.1} times as stiff \
             (--stiffness-n-per-m), or with --young-pa",
            1e3 * edge_m,
            (100.0 * most).floor() / 100.0,
            (10.0 * toughness / most).ceil() / 10.0,
        )
    })
}

/// Most tetrahedra that are looked at for overlaps.
const TETRAHEDRA_MAX: usize = 2_000_000;

/// The overlaps of a mesh of tetrahedra from a file; those made here have none, and nodes held by default.
fn overlaps_of(mesh: &Mesh) -> Option<Overlaps> {
    let is_own = mesh.filled.is_some() || !mesh.default_fixed.is_empty();
    if is_own || mesh.tetrahedra.len() > TETRAHEDRA_MAX { None } else { mesh::overlaps(mesh) }
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
        let mesh = self.load(spec)?;
        let (fixed, options) = self.choices(&mesh)?;
        Ok((mesh, fixed, options))
    }

    fn load(&self, spec: &str) -> Result<Mesh> {
        let options = MeshOptions {
            diagonals: self.diagonals,
            drop_unused: self.drop_unused,
            allow_parts: self.allow_parts,
            rings: self.rings,
            nodes_max: if self.cells.is_some() { mesh::NODES_MAX } else { mesh::CELLS_MAX },
            ..self.file.options()
        };
        mesh::load(spec, &options)
    }

    /// The fixed nodes of a mesh, and what the bake may choose.
    pub fn choices(&self, mesh: &Mesh) -> Result<(Vec<u32>, BakeOptions)> {
        let fixed = self.fixed(mesh)?;
        let tissue = self.tissue(mesh)?;
        let options = BakeOptions {
            alpha: per_cell("--alpha", &self.alpha, mesh)?,
            stiffness_n_per_m: per_cell("--stiffness-n-per-m", &self.stiffness_n_per_m, mesh)?,
            link_relaxation: match tissue {
                None => self.relaxation(None)?,
                Some(_) => None,
            },
            tissue,
            saturation_m: self.k_m,
            resistance: self.r_x,
            capacitance: self.capacitance,
            energy_max_j: self.energy_max_j,
            coarse_basis: spacing(&self.coarse)?,
            lean: self.lean,
            contact_surface: self.contact_surface.into(),
            cuttable: self.cuttable(mesh)?,
            cells: self.cells,
        };
        Ok((fixed, options))
    }

    /// What a body that can be cut has besides its tetrahedra.
    fn cuttable(&self, mesh: &Mesh) -> Result<Option<Cuttable>> {
        let materials = self.materials()?;
        if !self.cuttable {
            let tough = materials.iter().find(|material| material.toughness_j_per_m2.is_some());
            let Some(Material { name, .. }) = tough else { return Ok(None) };
            return Err(Error::input(format!(
                "--material group:{name}: toughness-j-per-m2 is of a body that can be cut; add --cuttable, or leave \
                 it out"
            )));
        }
        // What is given goes before what the table has.
        let toughness = match self.toughness_j_per_m2.as_deref() {
            Some(text) => per_cell("--toughness-j-per-m2", text, mesh)?,
            None => {
                let known = self.known()?.and_then(|tissue| tissue.toughness_j_per_m2);
                PerCell::Uniform(known.unwrap_or(TOUGHNESS_J_PER_M2))
            }
        };
        Ok(Some(Cuttable {
            toughness_j_per_m2: toughness_with_materials(toughness, &materials, mesh)?,
            spare_share: self.cut_spare.unwrap_or(CUT_SPARE),
            tear_limit: match self.tear_stretch {
                Some(stretch) => Some(TearLimit::Stretch(stretch)),
                None => self.tears.then_some(TearLimit::Toughness),
            },
            loose: self.loose.into(),
        }))
    }

    /// The materials of groups.
    fn materials(&self) -> Result<Vec<Material<'_>>> {
        self.material.iter().map(|text| Material::parse(text)).collect()
    }
}

impl BodyArgs {
    /// The nodes that are held for ever.
    fn fixed(&self, mesh: &Mesh) -> Result<Vec<u32>> {
        let mut fixed = match &self.fix[..] {
            [] => mesh.default_fixed.clone(),
            [none] if none == "none" => Vec::new(),
            all => {
                let mut fixed = Vec::new();
                for text in all {
                    let (nodes_m, groups) = (&mesh.nodes_m, &mesh.groups);
                    fixed.extend(mesh::select(text, nodes_m, groups, &mesh.border, "--fix")?);
                }
                fixed
            }
        };
        fixed.sort_unstable();
        fixed.dedup();
        Ok(fixed)
    }

    /// What the tissue is made of, where it is not made of links.
    fn tissue(&self, mesh: &Mesh) -> Result<Option<Tissue>> {
        if self.young_pa.is_none() && self.material.is_empty() && self.tissue.is_none() {
            return Ok(None);
        }
        // What is given goes before what the table has.
        let known = self.known()?;
        let of_known = |value: fn(&KnownTissue) -> f64| known.as_ref().map(value);
        let young = self.young_pa.as_deref().map(|young| per_cell("--young-pa", young, mesh));
        let young = young.transpose()?.or(of_known(|of| of.young_pa).map(PerCell::Uniform));
        let poisson = match self.poisson.as_deref() {
            Some(poisson) => per_cell("--poisson", poisson, mesh)?,
            None => PerCell::Uniform(of_known(|of| of.poisson).unwrap_or(POISSON)),
        };
        let (young_pa, poisson) = match young {
            Some(young) if self.material.is_empty() => (young, poisson),
            young => with_materials(young, poisson, &self.materials()?, mesh)?,
        };
        let stretch_min = match self.stretch_min.as_deref() {
            None => Some(STRETCH_MIN),
            Some("none") => None,
            Some(text) => Some(text.parse().map_err(|_| {
                Error::input(format!("--stretch-min {text}: give a stretch, as 0.7, or none"))
            })?),
        };
        let of_known = known.as_ref().map(|tissue| tissue.stiffening.clone());
        let stiffening = self.stiffening.clone().map(|bands| bands.0).or(of_known);
        let (stiffening, relaxation) =
            (stiffening.unwrap_or_default(), self.relaxation(known.as_ref())?);
        let row = known.as_ref().and_then(|tissue| tissue.row(|option| self.gives(option)));
        Ok(Some(Tissue { young_pa, poisson, stretch_min, stiffening, relaxation, row }))
    }

    /// True if the value of an option is given, which a table of tissues has too.
    fn gives(&self, option: &str) -> bool {
        let has_material = !self.material.is_empty();
        match option {
            "young_pa" => self.young_pa.is_some() || has_material,
            "poisson" => self.poisson.is_some() || has_material,
            "stiffening" => self.stiffening.is_some(),
            "branches" => !self.branch.is_empty(),
            "toughness_j_per_m2" => self.toughness_j_per_m2.is_some() || has_material,
            _ => false,
        }
    }

    /// The tissue of the table that is asked for.
    fn known(&self) -> Result<Option<KnownTissue>> {
        self.tissue.as_deref().map(KnownTissue::find).transpose()
    }

    /// The branches, where the tissue relaxes.
    fn relaxation(&self, known: Option<&KnownTissue>) -> Result<Option<Relaxation>> {
        let branches: Vec<Branch> = self.branch.iter().filter_map(|branch| branch.0).collect();
        if branches.len() < self.branch.len() && self.branch.len() > 1 {
            return Err(Error::input("`branches` none: it goes alone; leave the others out"));
        }
        let branches = (!self.branch.is_empty()).then_some(branches);
        relaxation(known, branches, self.young_pa.is_some(), self.instant, self.device_hz)
    }
}

fn spacing(text: &str) -> Result<BasisSpacing> {
    match text {
        "auto" => Ok(BasisSpacing::BySize),
        "none" => Ok(BasisSpacing::None),
        number => number.parse().map(BasisSpacing::Links).map_err(|_| {
            Error::input(format!(
                "--coarse {number}: give a distance in mean link lengths, none or auto"
            ))
        }),
    }
}
