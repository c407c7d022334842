//! Writes mesh files: text, coordinates in metres with all digits, nodes in their order.
//!
//! A new format is one function and one row in `WRITERS`.

mod abaqus;
mod carried;
mod gmsh;
mod medit;
mod surface;
mod vtk;

use std::fmt::Write as _;
use std::path::Path;

use super::{Mesh, has_extension};
use crate::error::{Error, Result};

/// Text of a file, and notes for the user, for instance on groups that have another name there.
#[derive(Debug, Default)]
pub struct Written {
    /// The file's content.
    pub text: String,
    /// One sentence each.
    pub notes: Vec<String>,
}

/// A format: its extension, the elements it needs, and its writer.
struct Writer {
    extension: &'static str,
    needs: Needs,
    write: fn(&Mesh) -> std::result::Result<Written, String>,
}

#[derive(PartialEq)]
enum Needs {
    Tetrahedra,
    Triangles,
}

const WRITERS: &[Writer] = &[
    Writer { extension: "msh", needs: Needs::Tetrahedra, write: gmsh::write },
    Writer { extension: "vtk", needs: Needs::Tetrahedra, write: vtk::legacy },
    Writer { extension: "vtu", needs: Needs::Tetrahedra, write: vtk::xml },
    Writer { extension: "inp", needs: Needs::Tetrahedra, write: abaqus::write },
    Writer { extension: "mesh", needs: Needs::Tetrahedra, write: medit::write },
    Writer { extension: "stl", needs: Needs::Triangles, write: surface::stl },
    Writer { extension: "obj", needs: Needs::Triangles, write: surface::obj },
];

/// Writes the mesh in the format of a path's extension: `.msh` (Gmsh 4.1), `.vtk`, `.vtu`, `.inp`
/// (Abaqus) or `.mesh` (Medit) with all nodes, tetrahedra and groups; `.stl` or `.obj` with the surface
/// alone.
///
/// # Errors
/// Another extension; a mesh without tetrahedra or surface; groups that the format cannot distinguish.
pub fn write(mesh: &Mesh, path: &Path) -> Result<Written> {
    let Some(writer) = WRITERS.iter().find(|writer| has_extension(path, writer.extension)) else {
        let names: Vec<String> = WRITERS.iter().map(|w| format!(".{}", w.extension)).collect();
        return Err(Error::file(
            "write",
            path,
            format!("unknown format; formats that are written: {}", names.join(", ")),
        ));
    };
    if writer.needs == Needs::Tetrahedra && mesh.tetrahedra.is_empty() {
        return Err(Error::file(
            "write",
            path,
            "the body has no tetrahedra; write it as .stl or .obj",
        ));
    }
    if writer.needs == Needs::Triangles && mesh.triangles.is_empty() {
        return Err(Error::file("write", path, "the body has no surface"));
    }
    (writer.write)(mesh).map_err(|why| Error::file("write", path, why))
}

/// Writes the numbers of a line.
fn line(text: &mut String, numbers: impl IntoIterator<Item = impl std::fmt::Display>) {
    for (at, number) in numbers.into_iter().enumerate() {
        let _ = write!(text, "{}{number}", if at == 0 { "" } else { " " });
    }
    text.push('\n');
}

/// Formats a coordinate with the fewest digits that give the same number again.
fn digits(x: f64) -> String {
    format!("{x:?}")
}
