//! Gmsh meshes, formats 2.2 and 4.1, ASCII and binary.
//!
//! The reader takes nodes, first-order tetrahedra and, for the groups, triangles, lines and points,
//! with the physical groups and their names. Node ids are positions in the file; tags may be
//! sparse and in any order. Sections that the body does not need are skipped.

mod content;
mod elements;
mod file;
mod sections;

use std::collections::BTreeMap;
use std::path::Path;

use content::Content;
use file::File;

use super::bytes::Bytes;
use super::format::{self, begins};
use super::{MeshReader, RawMesh, has_extension};
use crate::error::Result;

/// Sections with which a file may begin.
const SECTIONS: [&str; 6] =
    ["$MeshFormat", "$Comments", "$PhysicalNames", "$NOD", "$Nodes", "$Elements"];

/// Reader of `.msh` files.
pub(super) struct Gmsh;

impl MeshReader for Gmsh {
    fn name(&self) -> &'static str {
        "Gmsh .msh 2.2 and 4.1 (ASCII and binary)"
    }

    fn is_in(&self, head: &[u8]) -> bool {
        let mut lines = head.split(|byte| matches!(byte, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
        let first = format::first_line(head, b"#");
        let is_section = |section: &&str| begins(first, section.as_bytes());
        SECTIONS.iter().any(is_section) || lines.any(|line| line == b"$MeshFormat")
    }

    fn has_name(&self, path: &Path) -> bool {
        has_extension(path, "msh")
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
        let mut file = File::new(Bytes::new(path, bytes, 0));
        let mut content = Content::new(unit_m);
        let mut version = None;
        while let Some(section) = file.next_section()? {
            match (section, version) {
                ("MeshFormat", None) => {
                    let found = version_of(&mut file)?;
                    // In 4.1 an element has its groups only through its entity.
                    content.physicals = matches!(found, Version::V4).then(BTreeMap::new);
                    version = Some(found);
                }
                ("MeshFormat", Some(_)) => {
                    content.view(&file)?;
                    break;
                }
                ("PhysicalNames", Some(_)) => content.names(&mut file)?,
                ("Entities", Some(Version::V4)) => sections::entities(&mut file, &mut content)?,
                ("PartitionedEntities", _) => {
                    return Err(file.refuse(
                        "a partitioned mesh; unpartition it in Gmsh (Mesh, Unpartition) and save it again",
                    ));
                }
                ("Nodes" | "ParametricNodes", Some(Version::V2)) => {
                    sections::nodes_v2(&mut file, &mut content, section == "ParametricNodes")?;
                }
                ("Nodes", Some(Version::V4)) => sections::nodes_v4(&mut file, &mut content)?,
                ("Elements", Some(Version::V2)) => sections::elements_v2(&mut file, &mut content)?,
                ("Elements", Some(Version::V4)) => sections::elements_v4(&mut file, &mut content)?,
                ("NOD" | "ELM", None) => {
                    return Err(
                        file.refuse(&format!("Gmsh format 1; 2.2 and 4.1 are read: {SAVE}"))
                    );
                }
                ("Nodes" | "ParametricNodes" | "Elements", None) => {
                    return Err(
                        file.refuse(&format!("${section} comes before $MeshFormat; {SAVE}"))
                    );
                }
                _ => {
                    file.skip_section()?;
                    continue;
                }
            }
            file.end()?;
        }
        if version.is_none() {
            return Err(file.refuse(&format!("there is no $MeshFormat section; {SAVE}")));
        }
        content.finish(|why| file.bytes.error_of_file(why))
    }
}

/// Remedy for a file in a format that is not read.
const SAVE: &str =
    "save it with gmsh -save -format msh41 -setnumber Mesh.Binary 0 -o OUT.msh IN.msh";

#[derive(Clone, Copy)]
enum Version {
    V2,
    V4,
}

/// Reads the version; a binary file is read as such from here on.
fn version_of(file: &mut File) -> Result<Version> {
    file.text_record("the format")?;
    let number = file.word("the version")?;
    let kind = file.text_whole("the file type")?;
    let version = match number {
        "2" | "2.0" | "2.1" | "2.2" => Version::V2,
        "4.1" => Version::V4,
        _ => {
            let why = format!("Gmsh format {number}; 2.2 and 4.1 are read: {SAVE}");
            return Err(file.refuse(&why));
        }
    };
    let why = match kind {
        0 => return Ok(version),
        1 => match file.text_whole("the data size")? {
            8 => {
                file.begin_binary()?;
                return Ok(version);
            }
            size => format!("numbers of {size} bytes; those of 8 are read: {SAVE}"),
        },
        _ => format!("file type {kind}; 0 (ASCII) and 1 (binary) are read: {SAVE}"),
    };
    Err(file.refuse(&why))
}
