//! The readers of mesh files, byte by byte: what they take, what they refuse and where.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod abaqus;
mod contents;
mod damaged;
mod gmsh;
mod gmsh_binary;
mod medit;
mod surface;
mod tetgen;
mod ucd;
mod vtk;
mod xml;

use std::path::{Path, PathBuf};

use chaincell_host::error::Result;
use chaincell_host::mesh::{Mesh, RawMesh, parse};

/// Every part stands in the reason why a file is refused.
#[track_caller]
fn assert_refused(read: Result<RawMesh>, parts: &[&str]) {
    let error = read.unwrap_err().to_string();
    for part in parts {
        assert!(error.contains(part), "{part} is not in: {error}");
    }
}

/// The place right behind a text that stands in the file.
fn behind(bytes: &[u8], text: &str) -> usize {
    bytes.windows(text.len()).position(|window| window == text.as_bytes()).unwrap() + text.len()
}

/// What damaged bytes may give: a body of nodes that are there and finite, or an error that names
/// the file.
fn is_sound(read: &Result<RawMesh>, name: &str) -> bool {
    match read {
        Ok(raw) => {
            let nodes = raw.nodes_m.len() as u32;
            let named = raw.tetrahedra.iter().flatten().chain(raw.groups.values().flatten());
            named.copied().all(|id| id < nodes)
                && raw.nodes_m.iter().flatten().all(|x| x.is_finite())
        }
        Err(error) => error.to_string().contains(name),
    }
}

/// A mesh file of the test data.
pub(super) fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/meshes").join(name)
}

/// The body of a mesh file of the test data.
fn load(name: &str) -> RawMesh {
    let path = data(name);
    parse(&path, &std::fs::read(&path).unwrap(), 1.0).unwrap()
}

#[test]
fn a_byte_order_mark_is_passed_over() {
    for (name, text) in [("a.msh", gmsh::NEW), ("a.vtk", vtk::TEXT)] {
        // The format is told by the first bytes too.
        for name in [name, "a"] {
            let read = |text: &str| parse(Path::new(name), text.as_bytes(), 1.0);
            assert_eq!(read(&format!("\u{feff}{text}")), read(text));
            assert!(read(text).is_ok(), "{:?}", read(text));
        }
    }
}
