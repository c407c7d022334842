//! Abaqus input files, `.inp`: nodes, elements C3D4 and sets of one part, and of an assembly with one
//! instance of it, as Abaqus/CAE writes them.
//!
//! Groups are the sets by name, in letters of either case: the nodes of `*NSET`, and the nodes of the
//! elements of `*ELSET`. Elements that are no solids count only for their sets; nodes of the assembly are
//! reference points, which the body does not have. Keywords that the body does not need are skipped with
//! their data. Layout: Abaqus Analysis User's Guide, "Input Syntax Rules" and "Assembly definition".

mod keyword;
mod scope;
mod sets;
mod solid;

use std::collections::HashMap;
use std::path::Path;

use keyword::{Keyword, fields};
use scope::Scope;
use sets::{Numbers, Set, Sets};
use solid::{Kind, kind};

use super::bytes::{Bytes, name_line, shown};
use super::format::{begins, first_line};
use super::{MeshReader, RawMesh, has_extension};
use crate::error::Result;

/// Reader of `.inp` files.
pub(super) struct Abaqus;

/// Keywords that make or move nodes and elements in ways that are not read.
const REFUSED: [&str; 11] = [
    "INCLUDE",
    "SYSTEM",
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "IMPORT",
    "SUBMODEL",
    "SYMMETRIC MODEL GENERATION",
];
const COMMENT: &str = "**";

impl MeshReader for Abaqus {
    fn name(&self) -> &'static str {
        "Abaqus .inp"
    }

    fn is_in(&self, head: &[u8]) -> bool {
        let front = head.trim_ascii_start();
        let is_keyword = |letter: &u8| letter.is_ascii_alphabetic() || *letter == b'*';
        front.starts_with(b"*")
            && front.get(1).is_some_and(is_keyword)
            && !begins(first_line(front, COMMENT.as_bytes()), b"*KEYWORD")
    }

    fn has_name(&self, path: &Path) -> bool {
        has_extension(path, "inp")
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
        let mut bytes = Bytes::new(path, bytes, 0);
        bytes.lines = true;
        bytes.enter("the file");
        Content::new(bytes, unit_m).read()
    }
}

/// Content read so far.
struct Content<'a> {
    bytes: Bytes<'a>,
    unit_m: f64,
    nodes_m: Vec<[f64; 3]>,
    /// Position of each node number.
    places: HashMap<u64, u32>,
    tetrahedra: Vec<[u32; 4]>,
    /// Begin and end of each element's nodes in `corners`.
    elements: HashMap<u64, [usize; 2]>,
    corners: Vec<u32>,
    sets: Sets,
    scope: Scope,
    instances: usize,
}

/// Meaning of the data lines after a keyword.
enum Data {
    Nodes {
        set: Option<Set>,
    },
    Elements {
        kind: Kind,
        set: Option<Set>,
    },
    Set {
        set: Set,
        numbers: Numbers,
        generate: bool,
    },
    /// The position of an instance.
    Place,
    PassedOver,
}

impl<'a> Content<'a> {
    fn new(bytes: Bytes<'a>, unit_m: f64) -> Self {
        Self {
            bytes,
            unit_m,
            nodes_m: Vec::new(),
            places: HashMap::new(),
            tetrahedra: Vec::new(),
            elements: HashMap::new(),
            corners: Vec::new(),
            sets: Sets::default(),
            scope: Scope::new(),
            instances: 0,
        }
    }

    fn read(mut self) -> Result<RawMesh> {
        let (mut data, mut any) = (Data::PassedOver, false);
        while let Some(line) = self.bytes.raw_line(COMMENT) {
            if line.trim_ascii_start().starts_with(b"*") {
                let keyword = Keyword::read(&name_line(line), &mut self.bytes)?;
                data = self.begin(&keyword)?;
                any = true;
            } else if !any {
                return Err(self.bytes.error(format!(
                    "'{}' in front of the first keyword, which begins with *; this is no Abaqus input \
                     file: save the mesh again",
                    shown(&name_line(line))
                )));
            } else if let Data::Set { set, numbers, generate } = &data {
                let read = if *generate { Sets::range } else { Sets::line };
                read(&mut self.sets, &self.bytes, (set, *numbers), &name_line(line))?;
            } else {
                let line = self.bytes.text_of(line)?;
                self.take(&data, line)?;
            }
        }
        self.finish()
    }

    /// Returns the data that a keyword begins.
    fn begin(&mut self, keyword: &Keyword) -> Result<Data> {
        if REFUSED.contains(&keyword.name.as_str()) || keyword.has("INPUT") {
            return Err(self.bytes.error(format!(
                "*{} makes or moves nodes and elements in a way that is not read; write the mesh out in \
                 full: *NODE, *ELEMENT and sets in this file",
                shown(&keyword.name)
            )));
        }
        // The keyword may change the block that the following lines belong to.
        self.scope.keyword(&keyword.name);
        let outside = self.scope.is_outside();
        let set = |name: &str| keyword.value(name).map(|name| Set { name, outside });
        Ok(match keyword.name.as_str() {
            "NODE" => {
                if keyword.has("SYSTEM") || keyword.has("NBLOCK") {
                    return Err(self.bytes.error(
                        "*NODE in a system of its own; save the mesh with rectangular coordinates",
                    ));
                }
                Data::Nodes { set: set("NSET") }
            }
            "ELEMENT" => {
                let name = keyword.needed("TYPE", &self.bytes)?;
                Data::Elements { kind: kind(&name, &self.bytes)?, set: set("ELSET") }
            }
            "NSET" | "ELSET" => self.set(keyword)?,
            "PART" => {
                if !self.nodes_m.is_empty() {
                    return Err(self.bytes.error(
                        "a second part with nodes; one is read: delete the others with their instances, \
                         or merge the instances into one part, and save the mesh",
                    ));
                }
                self.scope.part(keyword.value("NAME"));
                Data::PassedOver
            }
            "INSTANCE" => {
                self.instances += 1;
                if self.instances > 1 {
                    return Err(self.bytes.error(
                        "a second instance of a part; one is read: merge the instances into one part",
                    ));
                }
                self.scope.instance(keyword.value("NAME"));
                Data::Place
            }
            _ => Data::PassedOver,
        })
    }

    /// Begins a set.
    fn set(&mut self, keyword: &Keyword) -> Result<Data> {
        let of_elements = keyword.name == "ELSET";
        let name = keyword.needed(&keyword.name, &self.bytes)?;
        let set = Set { name, outside: self.scope.is_outside() };
        // With an instance, the numbers are those of its part.
        let outside = set.outside && !keyword.has("INSTANCE");
        if let Some(elements) = keyword.value("ELSET").filter(|_| !of_elements) {
            let numbers = Numbers { of_elements: true, outside };
            self.sets.copy(&self.bytes, (&set, numbers), &elements);
        }
        self.sets.begin(&set);
        let numbers = Numbers { of_elements, outside };
        Ok(Data::Set { set, numbers, generate: keyword.has("GENERATE") })
    }

    /// Reads a line of data.
    fn take(&mut self, data: &Data, line: &'a str) -> Result<()> {
        match data {
            _ if line.is_empty() => Ok(()),
            Data::PassedOver | Data::Set { .. } => Ok(()),
            Data::Place => Err(self.bytes.error(
                "the instance moves its part; one in its place is read: move the nodes and save the mesh",
            )),
            Data::Nodes { set } => self.node(line, set.as_ref()),
            Data::Elements { kind, set } => self.element(line, kind, set.as_ref()),
        }
    }

    /// `number, x, y, z`; missing coordinates are 0.
    fn node(&mut self, line: &str, set: Option<&Set>) -> Result<()> {
        let mut words = fields(line);
        let number = self.bytes.whole_of(words.next().unwrap_or(""), "the node number")?;
        let mut position = [0.0; 3];
        for (value, name) in position.iter_mut().zip(["x", "y", "z"]) {
            if let Some(word) = words.next().filter(|word| !word.is_empty()) {
                *value = self.bytes.metres_of(word, self.unit_m, name)?;
            }
        }
        if let Some(set) = set {
            self.sets.add(set, false, number, &self.bytes);
        }
        if self.scope.is_outside() {
            self.scope.add(false, number);
            return Ok(());
        }
        let place = self.nodes_m.len() as u32;
        if self.places.insert(number, place).is_some() {
            return Err(self.bytes.error(format!(
                "node number {number} is given twice; give each node a number of its own and save the \
                 mesh again"
            )));
        }
        self.nodes_m.push(position);
        Ok(())
    }

    /// `number, node, node, ..`; a line that ends in a comma continues in the next.
    fn element(&mut self, line: &'a str, kind: &Kind, set: Option<&Set>) -> Result<()> {
        let mut words = fields(line);
        let number = self.bytes.whole_of(words.next().unwrap_or(""), "the element number")?;
        let start = self.corners.len();
        let item = self.bytes.item();
        let outside = self.scope.is_outside();
        let mut line = line;
        loop {
            // Elements of the assembly do not belong to the body.
            for word in words.by_ref().filter(|word| !(outside || word.is_empty())) {
                let node = self.bytes.whole_of(word, "a node of the element")?;
                let place = self.places.get(&node).ok_or_else(|| {
                    self.bytes.error(format!(
                        "element {number} refers to node {node}, which no *NODE in front has; save the \
                         mesh again"
                    ))
                })?;
                self.corners.push(*place);
            }
            if !line.ends_with(',') {
                break;
            }
            line = match self.bytes.text_line(COMMENT)? {
                Some(next) if !next.starts_with('*') => next,
                _ => return Err(self.bytes.truncated("the rest of an element")),
            };
            words = fields(line);
        }
        self.bytes.return_to(item);
        // Add it to its set, and to the elements of the part or the assembly.
        if let Some(set) = set {
            self.sets.add(set, true, number, &self.bytes);
        }
        if matches!(kind, Kind::Tetrahedron) {
            self.tetrahedron(number, start, outside)?;
        }
        if outside {
            self.scope.add(true, number);
            return Ok(());
        }
        if self.elements.insert(number, [start, self.corners.len()]).is_some() {
            return Err(self.bytes.error(format!(
                "element number {number} is given twice; give each element a number of its own and save \
                 the mesh again"
            )));
        }
        Ok(())
    }

    /// Adds a tetrahedron, whose nodes begin at `start` and are the last ones.
    fn tetrahedron(&mut self, number: u64, start: usize, outside: bool) -> Result<()> {
        if outside {
            return Err(self.bytes.error(format!(
                "element {number} is a tetrahedron outside of the part; one part is read: put all \
                 tetrahedra into it and save the mesh"
            )));
        }
        let ids = self.corners.get(start..).unwrap_or_default();
        let corners = <[u32; 4]>::try_from(ids).map_err(|_| {
            self.bytes.error(format!(
                "element {number} has {} nodes, a tetrahedron has 4; the line is cut off: save the mesh \
                 again",
                ids.len()
            ))
        })?;
        if (1..4).any(|corner| corners[..corner].contains(&corners[corner])) {
            return Err(self.bytes.error(format!(
                "element {number} is a tetrahedron that has a node twice; delete it or mesh again"
            )));
        }
        self.tetrahedra.push(corners);
        Ok(())
    }

    fn finish(mut self) -> Result<RawMesh> {
        if self.nodes_m.is_empty() {
            return Err(self.bytes.error_of_file("it has no *NODE; save the mesh with its nodes"));
        }
        if self.tetrahedra.is_empty() {
            return Err(self.bytes.error_of_file(format!(
                "it has {} elements but none of type C3D4; a volume mesh is needed: mesh the volume \
                 inside with linear tetrahedra",
                self.elements.len()
            )));
        }
        let nodes = |number: u64| self.places.get(&number).map(std::slice::from_ref);
        let elements = |number: u64| {
            self.elements.get(&number).and_then(|&[start, end]| self.corners.get(start..end))
        };
        let groups = self.sets.groups(&mut self.bytes, &self.scope, nodes, elements)?;
        Ok(RawMesh { nodes_m: self.nodes_m, tetrahedra: self.tetrahedra, groups })
    }
}
