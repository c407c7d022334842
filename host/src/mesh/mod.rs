//! Bodies to bake: read from a file or generated, checked, with every id an input id.
//!
//! A body is named by a spec: `plane:NXxNYxD`, `box:NXxNYxNZxD`, `organ[:NODES]` or a file path
//! (`./organ` for a file of that name). NX, NY and NZ count the nodes along an axis, D is the
//! spacing in metres; a cube of a box has five tetrahedra. A new format is one file with a
//! `MeshReader` and one row in `READERS`.

mod abaqus;
mod bytes;
mod check;
mod cuboid;
mod filling;
mod format;
pub(crate) mod geometry;
mod gmsh;
mod groups;
mod medit;
mod number;
mod organ;
mod overlap;
mod plane;
mod refined;
mod rings;
mod rows;
mod scale;
mod selector;
mod size;
mod solid;
mod stuffing;
mod surface;
mod tetgen;
mod ucd;
mod vtk;
mod write;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use chaincell_kernel::image::MAGIC;

use crate::error::{Error, Result};
use crate::input;
use crate::text::{BYTE_ORDER_MARK, gzip};
use format::Format;

pub use filling::{Filling, Finer, Region};
pub(crate) use filling::{GROWTH, HALVINGS_MAX, halvings};
pub use overlap::{Overlaps, overlaps};
pub use refined::Refined;
pub use scale::UnlikelySize;
pub use selector::{select, select_among};
pub use solid::Filled;
pub use surface::{boundary, corner_normals, vertex_normals};
pub use write::{Written, write};

/// Most cells a body may have: a cell's number has 16 bits and one value is kept back.
pub const CELLS_MAX: usize = 65_535;

/// Most nodes of a mesh whose nodes are grouped into cells.
pub const NODES_MAX: usize = 2_000_000;
/// Why triangles alone are no body.
const A_SURFACE: &str = "a surface; `fill_m` SIZE fills it with tetrahedra of that edge in metres, as 0.005, \
     and `unit_m` mm reads it in millimetres";

/// Largest mesh file that is read, in bytes.
const FILE_BYTES_MAX: u64 = 512 << 20;

/// A checked body. Ids are input ids: positions in the file, or the generator's numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Node positions `[node][axis]` in metres, unused nodes included.
    pub nodes_m: Vec<[f64; 3]>,
    /// Links `[i, j]` with i < j, unique and sorted.
    pub links: Vec<[u32; 2]>,
    /// Faces that belong to one tetrahedron, counter-clockwise from outside; of a plane both
    /// triangles of each square, counter-clockwise from above.
    pub triangles: Vec<[u32; 3]>,
    /// Tetrahedra of positive volume (but for the flat ones), each set of four nodes once.
    pub tetrahedra: Vec<[u32; 4]>,
    /// Tetrahedra without volume, which [`Mesh::tetrahedra`] keeps.
    pub flat_tetrahedra: usize,
    /// Nodes of each physical group, sorted and unique, by name or, unnamed, by number.
    pub groups: BTreeMap<String, Vec<u32>>,
    /// Border nodes of a plane, sorted; else empty.
    pub border: Vec<u32>,
    /// Nodes held by default, sorted: the border of a plane, the bottom of a box, a patch of the
    /// organ's back. Empty for files.
    pub default_fixed: Vec<u32>,
    /// Nodes without a link, sorted.
    pub unused: Vec<u32>,
    /// Result of filling, for a body made of a closed surface.
    pub filled: Option<Filled>,
}

impl Mesh {
    /// Makes a body that is linked along the edges of its tetrahedra.
    #[must_use]
    pub fn from_tetrahedra(
        nodes_m: Vec<[f64; 3]>,
        tetrahedra: &[[u32; 4]],
        groups: BTreeMap<String, Vec<u32>>,
    ) -> Self {
        let (tetrahedra, flat_tetrahedra) =
            geometry::orient(&nodes_m, geometry::unique(tetrahedra));
        Self {
            links: geometry::edges(&tetrahedra),
            triangles: boundary(&tetrahedra),
            nodes_m,
            tetrahedra,
            flat_tetrahedra,
            groups,
            ..Self::default()
        }
    }
}

/// Returns the text for a body that is too large, with the remedy.
fn too_many(nodes: impl std::fmt::Display, nodes_max: usize, remedy: &str) -> String {
    if nodes_max == CELLS_MAX {
        format!("{nodes} than {nodes_max} cells, the limit; {remedy}, or group them with `cells` N")
    } else {
        format!("{nodes} than {nodes_max} nodes, the limit; {remedy}")
    }
}

/// Options of reading a body, and the defects that are tolerated.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshOptions {
    /// Metres in one unit of a file's coordinates. Generators always use metres.
    pub unit_m: f64,
    /// Link both diagonals of each square of a plane.
    pub diagonals: bool,
    /// List nodes without a link in [`Mesh::unused`] instead of refusing them.
    pub drop_unused: bool,
    /// Accept a body of several unconnected parts.
    pub allow_parts: bool,
    /// Nodes that are at most this many edges apart are linked, 1 or more.
    pub rings: u32,
    /// Most nodes: [`CELLS_MAX`], or [`NODES_MAX`] if groups of them become cells.
    pub nodes_max: usize,
    /// Fill a closed surface with tetrahedra of these sizes.
    pub filling: Option<Filling>,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            unit_m: 1.0,
            diagonals: false,
            drop_unused: false,
            allow_parts: false,
            rings: 1,
            nodes_max: CELLS_MAX,
            filling: None,
        }
    }
}

/// Content of a file as a reader returns it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawMesh {
    /// `[node][axis]` in metres, in file order.
    pub nodes_m: Vec<[f64; 3]>,
    /// Positions of four different nodes each.
    pub tetrahedra: Vec<[u32; 4]>,
    /// Sorted unique nodes by group.
    pub groups: BTreeMap<String, Vec<u32>>,
}

impl From<RawMesh> for Mesh {
    fn from(raw: RawMesh) -> Self {
        Self::from_tetrahedra(raw.nodes_m, &raw.tetrahedra, raw.groups)
    }
}

/// One file format.
trait MeshReader: Sync {
    /// The format in words, for error texts.
    fn name(&self) -> &'static str;
    /// Returns true if the file's first bytes, `head`, show that it is of the format.
    fn is_in(&self, head: &[u8]) -> bool;
    /// Returns true if the path has a name of this format.
    fn has_name(&self, path: &Path) -> bool;
    /// Reads the whole file; `unit_m` is metres per unit of its coordinates.
    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh>;
}

/// The formats, tried in this order.
const READERS: &[&dyn MeshReader] = &[
    &gmsh::Gmsh,
    &vtk::Vtk,
    &vtk::Vtu,
    &abaqus::Abaqus,
    &tetgen::TetGen,
    &medit::Medit,
    &ucd::Ucd,
];

/// Reads or generates the body of `spec` and checks it.
pub fn load(spec: &str, options: &MeshOptions) -> Result<Mesh> {
    check_unit(options)?;
    // The options must suit the kind of body.
    let (kind, size) = spec.split_once(':').map_or((spec, None), |(k, s)| (k, Some(s)));
    if options.diagonals && kind != "plane" {
        return Err(Error::input(format!(
            "`diagonals` links the squares of a plane; {spec} is none: leave it out"
        )));
    }
    // Generate or read the body.
    let mesh = match (kind, size) {
        ("plane" | "box" | "organ", _) if options.filling.is_some() => {
            return Err(Error::input(format!(
                "`fill_m` fills the closed surface of a file; {spec} has tetrahedra or squares of its \
                 own: leave it out"
            )));
        }
        ("plane", size) => plane::generate(size.unwrap_or(""), options)?,
        ("box", size) => cuboid::generate(size.unwrap_or(""), options.nodes_max)?,
        ("organ", size) => organ::generate(size)?,
        _ => {
            let path = Path::new(spec);
            let what = "a mesh is a file, plane:NXxNYxD, box:NXxNYxNZxD or organ[:NODES]";
            body(path, &content(path, what)?, options)?
        }
    };
    finish(spec, mesh, options)
}

/// Returns the body of a mesh file's bytes, checked; they and `name` determine the format. Errors
/// contain `name`.
///
/// # Errors
/// Place and remedy of the first thing that is not a sound body.
pub fn from_bytes(name: &str, bytes: &[u8], options: &MeshOptions) -> Result<Mesh> {
    check_unit(options)?;
    finish(name, body(Path::new(name), bytes, options)?, options)
}

/// Returns the body of nodes and tetrahedra given as numbers, checked; errors call it `name`. The unit
/// of the options is not applied.
///
/// # Errors
/// A coordinate that is not finite, a tetrahedron or a group with a node that does not exist, a
/// tetrahedron with a node twice; then as [`from_bytes`].
pub fn from_raw(name: &str, raw: RawMesh, options: &MeshOptions) -> Result<Mesh> {
    if options.filling.is_some() {
        return Err(Error::input(format!(
            "`fill_m` fills the closed surface of a file; {name} has tetrahedra of its own: leave it out"
        )));
    }
    check::numbers(name, &raw)?;
    finish(name, raw.into(), options)
}

/// Returns the body that fills a closed surface, given as points in the unit of the options and
/// triangles of them; errors call it `name`.
///
/// # Errors
/// A coordinate that is not finite, a triangle with a point that does not exist, no size to fill it with,
/// a surface that is not closed or intersects itself; then as [`from_bytes`].
pub fn from_surface(
    name: &str,
    points: &[[f64; 3]],
    triangles: Vec<[u32; 3]>,
    options: &MeshOptions,
) -> Result<Mesh> {
    check_unit(options)?;
    let Some(filling) = &options.filling else {
        return Err(Error::input(format!("{name}: {A_SURFACE}")));
    };
    let faces = solid::Faces::new(name, points, triangles, options.unit_m)?;
    let mesh = solid::fill_faces(name, faces, options.unit_m, filling, options.nodes_max)?;
    finish(name, mesh, options)
}

fn check_unit(options: &MeshOptions) -> Result<()> {
    if options.unit_m.is_finite() && options.unit_m > 0.0 {
        return Ok(());
    }
    Err(Error::input(format!(
        "`unit_m`: {} metres a unit; it must be finite and above 0",
        options.unit_m
    )))
}

/// Adds the links of wider rings, then checks the body.
fn finish(spec: &str, mut mesh: Mesh, options: &MeshOptions) -> Result<Mesh> {
    rings::widen(&mut mesh, options.rings)?;
    mesh.unused = check::check(spec, &mesh, options)?;
    Ok(mesh)
}

/// Returns the body of a mesh file, or the body that fills a closed surface.
fn body(path: &Path, bytes: &[u8], options: &MeshOptions) -> Result<Mesh> {
    let Some(filling) = &options.filling else {
        return Ok(parse(path, bytes, options.unit_m)?.into());
    };
    let bytes = without_mark(path, bytes)?;
    if let Some(Format::Surface(reader)) = format::of(path, bytes)? {
        let faces = solid::read(reader, path, bytes, options.unit_m)?;
        let name = path.display().to_string();
        return solid::fill_faces(&name, faces, options.unit_m, filling, options.nodes_max);
    }
    let names: Vec<_> = solid::names().collect();
    Err(Error::file(
        "fill",
        path,
        format!(
            "`fill_m` fills closed surfaces ({}); leave it out where a file has tetrahedra",
            names.join(", ")
        ),
    ))
}

/// Returns the bytes of a file that belongs to a mesh; `what` describes it in errors.
fn content(path: &Path, what: &str) -> Result<Vec<u8>> {
    let refuse = |why: std::io::Error| Error::file("open mesh", path, format!("{why}; {what}"));
    let file = input::open(path).map_err(refuse)?;
    let mut bytes = Vec::new();
    let taken = file.take(FILE_BYTES_MAX + 1).read_to_end(&mut bytes);
    let length = taken.map_err(|why| Error::file("read mesh", path, why))?;
    if length as u64 > FILE_BYTES_MAX {
        return Err(Error::file(
            "read mesh",
            path,
            format!("it has more than {} MiB, the limit", FILE_BYTES_MAX >> 20),
        ));
    }
    Ok(bytes)
}

/// Returns a file's bytes without a byte order mark; empty and compressed files are refused.
fn without_mark<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8]> {
    if let Some(why) = gzip(bytes) {
        return Err(Error::file("read mesh", path, why));
    }
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK.as_bytes()).unwrap_or(bytes);
    if bytes.is_empty() {
        return Err(Error::file("read mesh", path, "the file is empty; save the mesh again"));
    }
    Ok(bytes)
}

/// Returns true if a file's name has this extension, in letters of either case.
fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension))
}

/// Returns the nodes and tetrahedra of a mesh file's bytes, not yet checked as a body; `unit_m` is
/// metres per unit of its coordinates. The content determines the format, else the path's extension.
///
/// # Errors
/// Place and remedy of the first thing that cannot be read.
pub fn parse(path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
    let bytes = without_mark(path, bytes)?;
    match format::of(path, bytes)? {
        Some(Format::Volume(reader)) => reader.read(path, bytes, unit_m),
        Some(Format::Surface(_)) => Err(Error::file("read mesh", path, A_SURFACE)),
        None if bytes.starts_with(&MAGIC) => Err(Error::file(
            "read mesh",
            path,
            "this is a baked body, not a mesh; give the mesh it was baked from",
        )),
        None => {
            let names: Vec<_> =
                READERS.iter().map(|reader| reader.name()).chain(solid::names()).collect();
            Err(Error::file(
                "read mesh",
                path,
                format!("unknown format; formats that are read: {}", names.join(", ")),
            ))
        }
    }
}
