//! VTK XML files of unstructured grids, `.vtu`: ASCII, base64 or appended data, plain or compressed by
//! zlib, either byte order. Several pieces are joined in their order.
//!
//! The reader takes the same data as from a legacy file. Layout: Kitware, The VTK User's Guide, "XML File
//! Formats".

mod array;
mod coding;

use std::collections::BTreeMap;
use std::path::Path;

use roxmltree::{Document, Node, ParsingOptions};

use super::cells::{Cells, check_tetrahedra};
use super::groups::{is_known, named};
use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};
use crate::mesh::groups::Groups;
use crate::mesh::{MeshReader, RawMesh, has_extension};
use array::Array;
use coding::Coding;

/// Reader of `.vtu` files.
pub(in crate::mesh) struct Vtu;

/// Most elements and texts of a file: a grid has some dozens.
const XML_NODES_MAX: u32 = 100_000;
/// Deepest nesting of elements: a grid has six.
const XML_DEPTH_MAX: usize = 32;
/// Begin of the data after the XML.
const APPENDED: &[u8] = b"<AppendedData";

impl MeshReader for Vtu {
    fn name(&self) -> &'static str {
        "VTK XML .vtu unstructured grid"
    }

    fn is_in(&self, head: &[u8]) -> bool {
        head.trim_ascii_start().starts_with(b"<")
    }

    fn has_name(&self, path: &Path) -> bool {
        has_extension(path, "vtu")
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
        let mut place = Bytes::new(path, bytes, 0);
        place.lines = true;
        let (text, appended) = split(bytes, &mut place)?;
        check_depth(&text, &mut place)?;
        let options = ParsingOptions { nodes_limit: XML_NODES_MAX, ..ParsingOptions::default() };
        let document = Document::parse_with_options(&text, options).map_err(|why| {
            place.error_of_file(if text.contains("<VTKFile") {
                format!(
                    "it is no sound XML ({why}); it is cut off or damaged: save or copy it again"
                )
            } else {
                format!("it is no sound XML of VTK ({why}); save the tetrahedra as .vtu or .vtk")
            })
        })?;
        let root = document.root_element();
        let kind = root.attribute("type").unwrap_or("");
        if root.tag_name().name() != "VTKFile" || kind != "UnstructuredGrid" {
            return Err(place.error_of_file(format!(
                "it is <{} type=\"{}\">; a volume mesh is needed: save the tetrahedra as one file of \
                 type UnstructuredGrid",
                shown(root.tag_name().name()),
                shown(kind)
            )));
        }
        let coding = Coding::of(root, appended, bytes.len() as u64, &mut place)?;
        grid(root, &coding, &mut place, unit_m)
    }
}

/// Returns the XML, which ends before appended data, and the bytes after the tag of that data.
fn split<'a>(bytes: &'a [u8], place: &mut Bytes) -> Result<(String, Option<&'a [u8]>)> {
    let at = bytes.windows(APPENDED.len()).position(|window| window == APPENDED);
    let (head, tag, data) = match at {
        None => (bytes, None, None),
        Some(at) => {
            let (head, rest) = bytes.split_at(at);
            let Some(end) = rest.iter().position(|byte| *byte == b'>') else {
                place.enter("the tag AppendedData");
                return Err(place.truncated("its end"));
            };
            (head, rest.get(..end), rest.get(end + 1..))
        }
    };
    let mut text = String::new();
    for part in [Some(head), tag].into_iter().flatten() {
        let part = std::str::from_utf8(part).map_err(|why| {
            place.return_to(why.valid_up_to());
            place.error("no UTF-8 text; the file is damaged: save or copy it again")
        })?;
        text.push_str(part);
    }
    if tag.is_some() {
        text.truncate(text.trim_end_matches('/').len());
        text.push_str("/></VTKFile>");
    }
    Ok((text, data))
}

/// Refuses elements that are nested deeper than any grid's, since the XML parser is recursive.
fn check_depth(text: &str, place: &mut Bytes) -> Result<()> {
    let (mut depth, mut behind) = (0usize, 0);
    for (at, _) in text.match_indices('<') {
        // Signs inside a comment or plain text belong to no element.
        if at < behind {
            continue;
        }
        let rest = &text[at + 1..];
        let skipped = [("!--", "-->"), ("![CDATA[", "]]>")];
        if let Some((_, end)) = skipped.iter().find(|(begin, _)| rest.starts_with(begin)) {
            behind = rest.find(end).map_or(text.len(), |end| at + 1 + end);
            continue;
        }
        match rest.as_bytes().first() {
            Some(b'/') => depth = depth.saturating_sub(1),
            Some(b'?' | b'!') => {}
            _ => {
                let end = rest.find(['<', '>']).unwrap_or(0);
                let is_empty = rest[..end].ends_with('/') && rest[end..].starts_with('>');
                depth += usize::from(!is_empty);
            }
        }
        if depth > XML_DEPTH_MAX {
            place.return_to(at);
            return Err(place.error(format!(
                "elements nested {depth} deep; a grid has 6: save the mesh again"
            )));
        }
    }
    Ok(())
}

fn child<'a, 'input>(of: Node<'a, 'input>, name: &str) -> Option<Node<'a, 'input>> {
    of.children().find(|node| node.has_tag_name(name))
}

/// Reads the points, cells and groups of all pieces.
fn grid(root: Node, coding: &Coding, place: &mut Bytes, unit_m: f64) -> Result<RawMesh> {
    let grid = child(root, "UnstructuredGrid");
    let pieces =
        grid.iter().flat_map(|grid| grid.children()).filter(|node| node.has_tag_name("Piece"));
    let (mut raw, mut cell_count, mut groups) = (RawMesh::default(), 0, Groups::default());
    for piece in pieces {
        let points = count(piece, "NumberOfPoints", place)?;
        let own_count = count(piece, "NumberOfCells", place)?;
        // Parallel programs write empty pieces.
        if points == 0 && own_count == 0 {
            continue;
        }
        let first = raw.nodes_m.len() as u32;
        let nodes_m = points_m(piece, points, coding, place, unit_m)?;
        let cells = cells(piece, own_count, coding, place)?;
        let tetrahedra = cells.tetrahedra(place, nodes_m.len())?;
        for (name, ids) in of_cells(piece, &cells, coding, place)? {
            groups.add(name, ids.into_iter().map(|id| first + id));
        }
        raw.nodes_m.extend(nodes_m);
        raw.tetrahedra.extend(tetrahedra.into_iter().map(|ids| ids.map(|id| first + id)));
        cell_count += own_count;
    }
    if raw.nodes_m.is_empty() {
        return Err(place.error_of_file("it has no Piece with points; save the mesh again"));
    }
    check_tetrahedra(&raw.tetrahedra, cell_count, place)?;
    raw.groups = groups.finish();
    Ok(raw)
}

/// Reads the cells of a piece.
fn cells(piece: Node, cell_count: u64, coding: &Coding, place: &mut Bytes) -> Result<Cells> {
    let mut cells = Cells { starts: vec![0], ..Cells::default() };
    for end in array(piece, "Cells", "offsets", place)?.whole(cell_count, coding, place)? {
        let last = cells.starts.last().copied().unwrap_or(0);
        match usize::try_from(end) {
            Ok(end) if end >= last => cells.starts.push(end),
            _ => {
                return Err(place.error(format!(
                    "the offset {end} behind {last}; offsets ascend: save or copy the mesh again"
                )));
            }
        }
    }
    let size = cells.starts.last().copied().unwrap_or(0) as u64;
    cells.nodes = array(piece, "Cells", "connectivity", place)?.whole(size, coding, place)?;
    cells.types = array(piece, "Cells", "types", place)?.whole(cell_count, coding, place)?;
    Ok(cells)
}

fn points_m(
    piece: Node,
    count: u64,
    coding: &Coding,
    place: &mut Bytes,
    unit_m: f64,
) -> Result<Vec<[f64; 3]>> {
    let node = child(piece, "Points").and_then(|points| child(points, "DataArray"));
    let Some(node) = node.filter(|_| count > 0) else {
        return Err(place.error_of_file("it has no points; save the mesh with its nodes"));
    };
    let array = Array::of(node, place)?;
    let components = array.components();
    if components != "3" {
        return Err(place.error(format!(
            "points of {} components; they have 3: save the mesh again",
            shown(components)
        )));
    }
    let values = array.real(count.saturating_mul(3), coding, place)?;
    let mut nodes_m = Vec::with_capacity(values.len() / 3);
    for xyz in values.chunks_exact(3) {
        let mut position = [0.0; 3];
        for ((metres, value), name) in position.iter_mut().zip(xyz).zip(["x", "y", "z"]) {
            *metres = place.metres(*value, unit_m, name)?;
        }
        nodes_m.push(position);
    }
    Ok(nodes_m)
}

fn count(piece: Node, name: &str, place: &mut Bytes) -> Result<u64> {
    place.return_to(piece.range().start);
    place.whole_of(piece.attribute(name).unwrap_or("").trim(), name)
}

/// Returns an array that a grid must have.
fn array<'a>(piece: Node<'a, 'a>, of: &str, name: &str, place: &mut Bytes) -> Result<Array<'a>> {
    let mut arrays = child(piece, of).into_iter().flat_map(|of| of.children());
    match arrays.find(|node| node.attribute("Name").is_some_and(|own| own == name)) {
        Some(node) => Array::of(node, place),
        None => {
            Err(place.error_of_file(format!("it has no array '{name}' in {of}; save it again")))
        }
    }
}

/// Returns the groups of the first array of a known name with one whole number a cell.
fn of_cells(
    piece: Node,
    cells: &Cells,
    coding: &Coding,
    place: &mut Bytes,
) -> Result<BTreeMap<String, Vec<u32>>> {
    let arrays = child(piece, "CellData").into_iter().flat_map(|data| data.children());
    let known = arrays.filter(|node| node.attribute("Name").is_some_and(is_known));
    for node in known {
        // An array of another type, such as text, holds no groups.
        let Ok(array) = Array::of(node, place) else { continue };
        if array.components() != "1" {
            continue;
        }
        if let Some(numbers) = array.references(cells.count(), coding, place)? {
            return Ok(named(cells, array.name(), &numbers));
        }
    }
    Ok(BTreeMap::new())
}
