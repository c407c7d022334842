//! `chaincell convert`: from any mesh that `bake` reads to a mesh file.

use std::path::PathBuf;

use serde::Serialize;

use super::bake::Units;
use super::filled::FilledReport;
use crate::error::Result;
use crate::files::whole::{keep_input, write_whole};
use crate::interrupt;
use crate::mesh::{self, MeshOptions};
use crate::terminal;

/// Write a mesh in another format: .msh (Gmsh 4.1), .vtk, .vtu, .inp (Abaqus) or .mesh (Medit), with its
/// groups; .stl or .obj of its surface. Text, in metres; nodes keep their numbers.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell convert scan.stl liver.msh --units mm --fill 0.004")]
pub struct Args {
    /// A mesh, a surface with --fill, or a generator, as bake takes them
    mesh: String,
    /// File to write; its extension says the format
    output: PathBuf,
    /// Unit of the coordinates that are read; metres are written
    #[arg(id = "unit_m", long = "units", value_name = "UNITS", value_enum, default_value_t = Units::M)]
    units: Units,
    /// Fill a closed surface (.stl, .obj, .ply) with tetrahedra of this mean edge [m]
    #[arg(id = "fill_m", long = "fill", value_name = "SIZE", allow_negative_numbers = true)]
    fill_m: Option<f64>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Printed {
    nodes: usize,
    tetrahedra: usize,
    triangles: usize,
    groups: Vec<String>,
    notes: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    filled: Option<FilledReport>,
}

pub fn execute(args: &Args) -> Result<()> {
    let options = MeshOptions {
        unit_m: args.units.metres(),
        drop_unused: true,
        allow_parts: true,
        nodes_max: mesh::NODES_MAX,
        fill_m: args.fill_m,
        ..MeshOptions::default()
    };
    keep_input(&args.mesh, &args.output)?;
    let mesh = mesh::load(&args.mesh, &options)?;
    let written = mesh::write(&mesh, &args.output)?;
    interrupt::check()?;
    write_whole(&args.output, written.text.as_bytes())?;
    let printed = Printed {
        nodes: mesh.nodes_m.len(),
        tetrahedra: mesh.tetrahedra.len(),
        triangles: mesh.triangles.len(),
        groups: mesh.groups.keys().cloned().collect(),
        notes: written.notes,
        filled: FilledReport::of(&mesh),
    };
    if args.json {
        return terminal::say_json(&printed);
    }
    printed.notes.iter().for_each(|note| terminal::note(format_args!("note: {note}")));
    terminal::say(format_args!("wrote {} from {}", args.output.display(), args.mesh))?;
    terminal::say(format_args!(
        "  {} nodes, {} tetrahedra, {} triangles of the surface, {} groups",
        printed.nodes,
        printed.tetrahedra,
        printed.triangles,
        printed.groups.len()
    ))?;
    printed.filled.map_or(Ok(()), |filled| filled.print())
}
