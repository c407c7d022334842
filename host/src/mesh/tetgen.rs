//! TetGen meshes: the points in `NAME.node`, the tetrahedra in `NAME.ele`; either name is given.
//!
//! Points are numbered from 0 or from 1, as the first one is. Groups are whole numbers: `N` of the first
//! attribute of the tetrahedra (the region), `points:N` of the points' boundary markers, 0 being none.
//! Layout: Si, TetGen, A Quality Tetrahedral Mesh Generator, manual 1.6, chapter 5.

use std::path::Path;

use super::bytes::{Bytes, shown};
use super::groups::Groups;
use super::{MeshReader, RawMesh, has_extension};
use crate::error::Result;

/// Reader of `.node` and `.ele` files.
pub(super) struct TetGen;

impl MeshReader for TetGen {
    fn name(&self) -> &'static str {
        "TetGen .node and .ele"
    }

    fn recognises(&self, path: &Path, _: &[u8]) -> bool {
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

/// The mesh of both files' bytes, each with its path.
pub(super) fn join(node: (&Path, &[u8]), ele: (&Path, &[u8]), unit_m: f64) -> Result<RawMesh> {
    let mut groups = Groups::default();
    let (nodes_m, first) = points(Rows::new(node.0, node.1), unit_m, &mut groups)?;
    let tetrahedra = tetrahedra(Rows::new(ele.0, ele.1), first, nodes_m.len(), &mut groups)?;
    Ok(RawMesh { nodes_m, tetrahedra, groups: groups.finish() })
}

/// Lines of numbers without comments.
struct Rows<'a> {
    bytes: Bytes<'a>,
    words: Vec<&'a str>,
    at: usize,
}

impl<'a> Rows<'a> {
    fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let mut bytes = Bytes::new(path, bytes, 0);
        bytes.lines = true;
        Self { bytes, words: Vec::new(), at: 0 }
    }

    /// Goes to the next line that is not blank.
    fn next(&mut self, what: &str) -> Result<()> {
        loop {
            let Some(line) = self.bytes.text_line("#")? else {
                return Err(self.bytes.truncated(what));
            };
            let numbers = line.split('#').next().unwrap_or_default();
            (self.words, self.at) = (numbers.split_ascii_whitespace().collect(), 0);
            if !self.words.is_empty() {
                return Ok(());
            }
        }
    }

    fn word(&mut self, what: &str) -> Result<&'a str> {
        let word = self.words.get(self.at).copied();
        self.at += 1;
        word.ok_or_else(|| {
            self.bytes.error(format!(
                "the line ends before {what}; it is cut off or a number in the first line is wrong: \
                 save or copy the mesh again"
            ))
        })
    }

    fn whole(&mut self, what: &str) -> Result<u64> {
        let word = self.word(what)?;
        self.bytes.whole_of(word, what)
    }

    /// A whole number that may be left out of the first line.
    fn optional(&mut self, what: &str) -> Result<u64> {
        if self.at < self.words.len() { self.whole(what) } else { Ok(0) }
    }

    /// Refuses a line that goes on.
    fn end(&self) -> Result<()> {
        match self.words.get(self.at) {
            None => Ok(()),
            Some(word) => Err(self.bytes.error(format!(
                "the line goes on with '{}' after its last number; a number in the first line is \
                 wrong: save the mesh again",
                shown(word)
            ))),
        }
    }

    /// Refuses lines behind the last one that was promised.
    fn end_of_file(mut self, what: &str) -> Result<()> {
        match self.bytes.text_line("#")? {
            None => Ok(()),
            Some(_) => Err(self.bytes.error(format!(
                "a line more than the number of {what} in the first line; save or copy the mesh again"
            ))),
        }
    }

    /// Passes over so many numbers.
    fn skip(&mut self, count: u64, what: &str) -> Result<()> {
        for _ in 0..count {
            self.word(what)?;
        }
        Ok(())
    }

    /// An attribute or a marker as a reference number; 0 where it is no whole number.
    fn reference(&mut self, what: &str) -> Result<i64> {
        let word = self.word(what)?;
        let value: f64 = word.parse().map_err(|_| self.bytes.no_number(what, word, "a number"))?;
        let is_whole = value.fract() == 0.0 && value.abs() < 1e15;
        Ok(if is_whole { value as i64 } else { 0 })
    }
}

/// `points dimension attributes markers`, then `number x y z attributes.. marker` a line; returns the
/// places and the number of the first.
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
    // A digit each for the number and the coordinates, and what separates them.
    rows.bytes.fits(count, 7, "points")?;
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
        let mut position = [0.0; 3];
        for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
            let word = rows.word(name)?;
            *value = rows.bytes.metres_of(word, unit_m, name)?;
        }
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

/// `tetrahedra nodes attributes`, then `number nodes.. attributes..` a line.
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
