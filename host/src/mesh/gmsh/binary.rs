//! Binary files: sections between lines of text, with numbers of either byte order.
//!
//! The names of physical groups and, in 2.2, the counts are text in binary files too. Counts are
//! compared with the bytes that are left before anything is read.

use std::path::Path;

use super::binary_source::Binary;
use super::content::Content;
use super::lines::Lines;
use super::{SAVE, Version, binary_v2, binary_v4};
use crate::error::Result;
use crate::mesh::RawMesh;
use crate::mesh::bytes::Bytes;

/// Reads the file after the line that names its format.
pub(super) fn read<'a>(
    bytes: Bytes<'a>,
    path: &'a Path,
    version: Version,
    mut content: Content,
) -> Result<RawMesh> {
    let mut file = Binary { bytes, version };
    // The rest of the section that names the format.
    file.bytes.enter("section $MeshFormat");
    file.probe()?;
    file.end("MeshFormat")?;
    // The other sections; text between them is skipped.
    while let Some(line) = file.bytes.line() {
        let Some(header) = line.trim_ascii().strip_prefix(b"$") else { continue };
        let Ok(section) = std::str::from_utf8(header) else {
            return Err(file.bytes.error(format!("a section without a readable name; {SAVE}")));
        };
        file.bytes.enter(section);
        match (section, version) {
            ("MeshFormat", _) => {
                content.view(file.bytes.rest(), &file)?;
                break;
            }
            ("PhysicalNames", _) => {
                let before = file.bytes.line_number() - 1;
                let mut lines = Lines::new(path, file.bytes.rest(), before);
                lines.enter(section);
                content.names(&mut lines)?;
                file.bytes.skip(file.bytes.rest().len() - lines.rest().len());
            }
            ("Entities", Version::V4) => binary_v4::entities(&mut file, &mut content)?,
            ("PartitionedEntities", _) => {
                return Err(file.bytes.error(
                    "a partitioned mesh; unpartition it in Gmsh (Mesh, Unpartition) and save it \
                     again",
                ));
            }
            ("Nodes", Version::V2) => binary_v2::nodes(&mut file, &mut content, false)?,
            ("ParametricNodes", Version::V2) => binary_v2::nodes(&mut file, &mut content, true)?,
            ("Nodes", Version::V4) => binary_v4::nodes(&mut file, &mut content)?,
            ("Elements", Version::V2) => binary_v2::elements(&mut file, &mut content)?,
            ("Elements", Version::V4) => binary_v4::elements(&mut file, &mut content)?,
            _ => {
                file.skip_section(section)?;
                continue;
            }
        }
        file.end(section)?;
    }
    content.finish(|why| file.bytes.error_of_file(why))
}
