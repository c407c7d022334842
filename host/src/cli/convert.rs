//! `chaincell convert`: from any mesh that `bake` reads to a mesh file.

use std::path::PathBuf;

use serde::Serialize;

use super::filled::FilledReport;
use super::mesh_file::MeshFileArgs;
use super::shared::PrintArgs;
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
    #[command(flatten)]
    file: MeshFileArgs,
    #[command(flatten)]
    print: PrintArgs,
}

/// The output of `--json`.
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
        drop_unused: true,
        allow_parts: true,
        nodes_max: mesh::NODES_MAX,
        ..args.file.options()
    };
    // Read, fill and write the mesh.
    keep_input(&args.mesh, &args.output)?;
    let (mesh, written) = interrupt::at_once(|| {
        let mesh = mesh::load(&args.mesh, &options)?;
        let written = mesh::write(&mesh, &args.output)?;
        Ok((mesh, written))
    })?;
    write_whole(&args.output, written.text.as_bytes())?;
    // Report it.
    let printed = Printed {
        nodes: mesh.nodes_m.len(),
        tetrahedra: mesh.tetrahedra.len(),
        triangles: mesh.triangles.len(),
        groups: mesh.groups.keys().cloned().collect(),
        notes: written.notes,
        filled: FilledReport::of(&mesh),
    };
    if args.print.json {
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
