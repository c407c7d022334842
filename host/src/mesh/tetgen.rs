//! TetGen meshes: the points in `NAME.node`, the tetrahedra in `NAME.ele`; either name is given.
//!
//! Points are numbered from the number of the first one, 0 or 1. Groups are whole numbers: `N` of the
//! first attribute of the tetrahedra (the region), `points:N` of the points' boundary markers, 0 being
//! none.
//! Layout: Si, TetGen, A Quality Tetrahedral Mesh Generator, manual 1.6, chapter 5.

use std::path::Path;

use super::groups::Groups;
use super::rows::Rows;
use super::{MeshReader, RawMesh, has_extension};
use crate::error::Result;

/// Reader of `.node` and `.ele` files.
pub(super) struct TetGen;

impl MeshReader for TetGen {
    fn name(&self) -> &'static str {
        "TetGen .node and .ele"
    }

    fn is_in(&self, _: &[u8]) -> bool {
        false
    }

    fn has_name(&self, path: &Path) -> bool {
        has_extension(path, "node") || has_extension(path, "ele")
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
        let (other, part) = if has_extension(path, "node") {
            (path.with_extension("ele"), "tetrahedra")
        } else {
            (path.with_extension("node"), "points")
        };
        let missing = format!(
            "{} needs it, which has the {part} of the mesh: put both into one folder",
            path.display()
        );
        let content = super::content(&other, &missing)?;
        let rest = super::without_mark(&other, &content)?;
        if has_extension(path, "node") {
            join((path, bytes), (&other, rest), unit_m)
        } else {
            join((&other, rest), (path, bytes), unit_m)
        }
    }
}

/// Returns the mesh of both files' bytes, each with its path.
pub(super) fn join(node: (&Path, &[u8]), ele: (&Path, &[u8]), unit_m: f64) -> Result<RawMesh> {
    let mut groups = Groups::default();
    let (nodes_m, first) = points(Rows::new(node.0, node.1), unit_m, &mut groups)?;
    let tetrahedra = tetrahedra(Rows::new(ele.0, ele.1), first, nodes_m.len(), &mut groups)?;
    Ok(RawMesh { nodes_m, tetrahedra, groups: groups.finish() })
}

/// Reads `points dimension attributes markers`, then `number x y z attributes.. marker` a line; returns
/// the positions and the number of the first point.
fn points(mut rows: Rows, unit_m: f64, groups: &mut Groups) -> Result<(Vec<[f64; 3]>, u64)> {
    rows.bytes.enter("the points");
    rows.next("the number of points")?;
    let count = rows.whole("the number of points")?;
    let dimension = rows.whole("the dimension")?;
    if dimension != 3 {
        return Err(rows.bytes.error(format!(
            "points of dimension {dimension}; a volume mesh is needed, of dimension 3"
        )));
    }
    let attributes = rows.optional("the number of attributes")?;
    let markers = rows.optional("the number of boundary markers")?;
    rows.end()?;
    // A row has at least a digit for the number and each coordinate, and their separators.
    rows.bytes.fits(count, 7, "points")?;
    // Each row: number, position, attributes, marker.
    let (mut nodes_m, mut first) = (Vec::new(), 0);
    for place in 0..count {
        rows.next("a point")?;
        let number = rows.whole("the number of a point")?;
        match place {
            0 if number <= 1 => first = number,
            _ if number == first + place => {}
            _ => {
                return Err(rows.bytes.error(format!(
                    "point number {number} in place {place}; points are numbered one by one from 0 or \
                     1: save the mesh again"
                )));
            }
        }
        let position = rows.position_m(unit_m)?;
        nodes_m.push(position);
        rows.skip(attributes, "an attribute of the point")?;
        if markers > 0 {
            groups.of_point(rows.reference("the boundary marker")?, place as u32);
        }
        rows.end()?;
    }
    if nodes_m.is_empty() {
        return Err(rows
            .bytes
            .error_of_file("it has no points; mesh the volume and save it again"));
    }
    rows.end_of_file("points")?;
    Ok((nodes_m, first))
}

/// Reads `tetrahedra nodes attributes`, then `number nodes.. attributes..` a line.
fn tetrahedra(
    mut rows: Rows,
    first: u64,
    points: usize,
    groups: &mut Groups,
) -> Result<Vec<[u32; 4]>> {
    rows.bytes.enter("the tetrahedra");
    rows.next("the number of tetrahedra")?;
    let count = rows.whole("the number of tetrahedra")?;
    match rows.whole("the number of nodes of a tetrahedron")? {
        4 => {}
        nodes => {
            return Err(rows.bytes.error(format!(
                "elements of {nodes} nodes; tetrahedra of 4 are read: mesh it without -o2"
            )));
        }
    }
    let attributes = rows.optional("the number of attributes")?;
    rows.end()?;
    rows.bytes.fits(count, 9, "tetrahedra")?;
    // Each row: number, points, attributes.
    let mut tetrahedra = Vec::new();
    for _ in 0..count {
        rows.next("a tetrahedron")?;
        rows.whole("the number of a tetrahedron")?;
        let mut ids = [0; 4];
        for at in 0..4 {
            let number = rows.whole("a point of a tetrahedron")?;
            ids[at] = match number.checked_sub(first) {
                Some(place) if place < points as u64 => place as u32,
                _ => {
                    return Err(rows.bytes.error(format!(
                        "point {number}; the points are {first} to {}: save both files again",
                        first + points as u64 - 1
                    )));
                }
            };
            if ids[..at].contains(&ids[at]) {
                return Err(rows
                    .bytes
                    .error("a tetrahedron that has a point twice; delete it or mesh again"));
            }
        }
        tetrahedra.push(ids);
        if attributes > 0 {
            groups.of_element(rows.reference("the attribute")?, ids);
            rows.skip(attributes - 1, "an attribute of the tetrahedron")?;
        }
        rows.end()?;
    }
    if tetrahedra.is_empty() {
        return Err(rows.bytes.error_of_file(
            "it has no tetrahedra; a volume mesh is needed: mesh the volume inside and save it again",
        ));
    }
    rows.end_of_file("tetrahedra")?;
    Ok(tetrahedra)
}
