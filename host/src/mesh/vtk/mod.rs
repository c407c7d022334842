//! Legacy VTK files: unstructured grids of versions 1 to 5, ASCII and binary (big-endian).
//!
//! The reader takes points and tetrahedra. Vertices, lines and faces are skipped, since the surface
//! follows from the tetrahedra; other elements are refused. Groups are whole numbers of the cells, see
//! [`groups`]; all other data is ignored. Layout: Kitware, The VTK User's Guide, "VTK File Formats",
//! and for version 5.1 its addendum on OFFSETS and CONNECTIVITY.

mod cells;
mod groups;
mod values;
mod xml;

use std::collections::BTreeMap;
use std::path::Path;

use cells::{Cells, check_tetrahedra};
use values::{Values, number_type};

use super::bytes::{Bytes, shown};
use super::format::begins;
use super::number::Number;
use super::{MeshReader, RawMesh, has_extension};
use crate::error::Result;

pub(super) use xml::Vtu;

/// Reader of `.vtk` files.
pub(super) struct Vtk;

/// First bytes of every file.
const MAGIC: &[u8] = b"# vtk DataFile Version ";
/// First version whose cells are stored as offsets and connectivity.
const OFFSETS_VERSION: u32 = 5;

impl MeshReader for Vtk {
    fn name(&self) -> &'static str {
        "legacy VTK .vtk unstructured grid (ASCII and binary)"
    }

    fn is_in(&self, head: &[u8]) -> bool {
        begins(head, b"# vtk ")
    }

    fn has_name(&self, path: &Path) -> bool {
        has_extension(path, "vtk")
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
        let mut bytes = Bytes::new(path, bytes, 0);
        bytes.lines = true;
        bytes.little = false;
        bytes.enter("its header");
        let version = version(&mut bytes)?;
        if bytes.line().is_none() {
            return Err(bytes.truncated("the title"));
        }
        let coding = bytes.word();
        let binary = match coding.map(str::to_ascii_uppercase).as_deref() {
            Some("ASCII") => false,
            Some("BINARY") => true,
            None => return Err(bytes.truncated("ASCII or BINARY")),
            Some(other) => {
                return Err(bytes.error(format!(
                    "'{}' where ASCII or BINARY should be; save the mesh again",
                    shown(other)
                )));
            }
        };
        let mut values = Values::new(bytes, binary);
        values.keyword("DATASET")?;
        let dataset = values.text("the kind of the data set")?;
        if !dataset.eq_ignore_ascii_case("UNSTRUCTURED_GRID") {
            return Err(values.bytes.error(format!(
                "a data set {}; a volume mesh is needed: save the tetrahedra as an \
                 UNSTRUCTURED_GRID",
                shown(dataset)
            )));
        }
        sections(&mut values, version, unit_m)
    }
}

/// Returns the version's first number, from the first line.
fn version(bytes: &mut Bytes) -> Result<u32> {
    let line = bytes.line().unwrap_or_default();
    let number = line.strip_prefix(MAGIC).and_then(|text| std::str::from_utf8(text).ok());
    let Some(number) = number else {
        return Err(bytes.error(
            "no legacy VTK file: its first line is not '# vtk DataFile Version'; save the mesh again",
        ));
    };
    let first = number.trim().split('.').next().and_then(|number| number.parse().ok());
    match first {
        Some(version @ 1..=OFFSETS_VERSION) => Ok(version),
        _ => Err(bytes.error(format!(
            "version '{}'; 1.0 to 5.1 are read: save the mesh in one of these",
            shown(number.trim())
        ))),
    }
}

/// Reads the sections, including the data of points and cells.
fn sections(values: &mut Values, version: u32, unit_m: f64) -> Result<RawMesh> {
    let mut points = None;
    let (mut cells, mut attached) = (Cells::default(), None);
    while let Some(word) = values.bytes.word() {
        match word.to_ascii_uppercase().as_str() {
            "POINTS" if points.is_none() => {
                values.bytes.enter("section POINTS");
                points = Some(read_points(values, unit_m)?);
            }
            "CELLS" if cells.starts.is_empty() => {
                values.bytes.enter("section CELLS");
                if version < OFFSETS_VERSION {
                    cells.read_lists(values)?;
                } else {
                    cells.read_offsets(values)?;
                }
            }
            "CELL_TYPES" if cells.types.is_empty() => {
                values.bytes.enter("section CELL_TYPES");
                cells.read_types(values)?;
            }
            "FIELD" => {
                values.bytes.enter("section FIELD");
                values.skip_field()?;
            }
            "METADATA" => values.skip_metadata(),
            "POINT_DATA" | "CELL_DATA" => {
                attached = Some(word);
                break;
            }
            _ => {
                return Err(values.bytes.error(format!(
                    "'{}' where a section should begin (POINTS, CELLS and CELL_TYPES, once each): \
                     the one before has another length than it says; save or copy the mesh again",
                    shown(word)
                )));
            }
        }
    }
    // Check the content, then read the groups from the data after the mesh.
    let nodes_m = points.unwrap_or_default();
    if nodes_m.is_empty() {
        return Err(values.bytes.error_of_file("it has no POINTS; save the mesh with its nodes"));
    }
    let tetrahedra = cells.tetrahedra(&values.bytes, nodes_m.len())?;
    check_tetrahedra(&tetrahedra, cells.count(), &values.bytes)?;
    let groups = match attached {
        Some(begun) => groups::read(values, &cells, begun)?,
        None => BTreeMap::new(),
    };
    Ok(RawMesh { nodes_m, tetrahedra, groups })
}

/// `POINTS n type`, then three numbers a point.
fn read_points(values: &mut Values, unit_m: f64) -> Result<Vec<[f64; 3]>> {
    let count = values.count("the number of points")?;
    let kind = values.text("the type of the points")?;
    let number = match number_type(kind) {
        Some(number @ (Number::F32 | Number::F64)) => number,
        _ => {
            return Err(values.bytes.error(format!(
                "points of type '{}'; float and double are read: save the mesh with one of these",
                shown(kind)
            )));
        }
    };
    values.begin_data(count, 3, number, "points")?;
    let mut nodes_m = Vec::new();
    for _ in 0..count {
        let mut position = [0.0; 3];
        for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
            let coordinate = values.real(number, name)?;
            *value = values.bytes.metres(coordinate, unit_m, name)?;
        }
        nodes_m.push(position);
    }
    Ok(nodes_m)
}
