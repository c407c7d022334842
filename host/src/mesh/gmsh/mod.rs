//! Gmsh meshes, formats 2.2 and 4.1, ASCII and binary.
//!
//! The reader takes nodes, first-order tetrahedra and, for the groups, triangles, lines and points,
//! with the physical groups and their names. Node ids are positions in the file; tags may be
//! sparse and in any order. Sections that the body does not need are skipped.

mod binary;
mod binary_source;
mod binary_v2;
mod binary_v4;
mod content;
mod elements;
mod lines;
mod source;
mod v2;
mod v4;

use std::collections::BTreeMap;
use std::path::Path;

use content::Content;
use lines::Lines;

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
        let mut lines = Lines::new(path, bytes, 0);
        let mut content = Content::new(unit_m);
        let mut version = None;
        while let Some(line) = lines.next()? {
            // Gmsh also skips text between sections.
            let Some(section) = line.strip_prefix('$') else { continue };
            lines.enter(section);
            match (section, version) {
                ("MeshFormat", None) => {
                    let (found, coding) = version_of(&mut lines)?;
                    // In 4.1 an element has its groups only through its entity.
                    content.physicals = matches!(found, Version::V4).then(BTreeMap::new);
                    if matches!(coding, Coding::Binary) {
                        let at = bytes.len() - lines.rest().len();
                        return binary::read(Bytes::new(path, bytes, at), path, found, content);
                    }
                    version = Some(found);
                }
                ("MeshFormat", Some(_)) => {
                    content.view(lines.rest(), &lines)?;
                    return content.finish(|why| lines.error_of_file(why));
                }
                ("PhysicalNames", Some(_)) => content.names(&mut lines)?,
                ("Entities", Some(Version::V4)) => v4::entities(&mut lines, &mut content)?,
                ("PartitionedEntities", _) => {
                    return Err(lines.error(
                        "a partitioned mesh; unpartition it in Gmsh (Mesh, Unpartition) and save it again",
                    ));
                }
                ("Nodes" | "ParametricNodes", Some(Version::V2)) => {
                    v2::nodes(&mut lines, &mut content, section == "ParametricNodes")?;
                }
                ("Nodes", Some(Version::V4)) => v4::nodes(&mut lines, &mut content)?,
                ("Elements", Some(Version::V2)) => v2::elements(&mut lines, &mut content)?,
                ("Elements", Some(Version::V4)) => v4::elements(&mut lines, &mut content)?,
                ("NOD" | "ELM", None) => {
                    return Err(lines.error(format!("Gmsh format 1; 2.2 and 4.1 are read: {SAVE}")));
                }
                ("Nodes" | "ParametricNodes" | "Elements", None) => {
                    return Err(lines.error(format!("${section} comes before $MeshFormat; {SAVE}")));
                }
                _ => {
                    lines.skip_section()?;
                    continue;
                }
            }
            lines.end()?;
        }
        if version.is_none() {
            return Err(lines.error(format!("there is no $MeshFormat section; {SAVE}")));
        }
        content.finish(|why| lines.error_of_file(why))
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

#[derive(Clone, Copy)]
enum Coding {
    Ascii,
    Binary,
}

fn version_of(lines: &mut Lines) -> Result<(Version, Coding)> {
    let mut fields = lines.record("the format")?;
    let number = fields.word("version")?;
    let kind = fields.whole("file type")?;
    let version = match number {
        "2" | "2.0" | "2.1" | "2.2" => Version::V2,
        "4.1" => Version::V4,
        _ => {
            return Err(fields.error(format!("Gmsh format {number}; 2.2 and 4.1 are read: {SAVE}")));
        }
    };
    match kind {
        0 => Ok((version, Coding::Ascii)),
        1 => match fields.whole("data size")? {
            8 => Ok((version, Coding::Binary)),
            size => {
                Err(fields.error(format!("numbers of {size} bytes; those of 8 are read: {SAVE}")))
            }
        },
        _ => {
            Err(fields
                .error(format!("file type {kind}; 0 (ASCII) and 1 (binary) are read: {SAVE}")))
        }
    }
}
