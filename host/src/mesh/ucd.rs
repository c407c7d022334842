//! AVS UCD files, ASCII, `.inp` or `.avs`: nodes and tetrahedra; elements without volume give only their
//! material.
//!
//! Groups are the material numbers, 0 being none. Data after the elements is ignored.
//! Layout: Advanced Visual Systems, AVS Developer's Guide, "UCD data files".

use std::collections::HashMap;
use std::path::Path;

use super::bytes::shown;
use super::format::first_line;
use super::groups::Groups;
use super::rows::Rows;
use super::{MeshReader, RawMesh, has_extension};
use crate::error::Result;

/// Reader of UCD files.
pub(super) struct Ucd;

/// Numbers of the first line: of nodes, of elements, and of values of nodes, elements and the model.
const HEADER: usize = 5;

impl MeshReader for Ucd {
    fn name(&self) -> &'static str {
        "AVS UCD .inp (ASCII)"
    }

    fn is_in(&self, head: &[u8]) -> bool {
        let words = first_line(head, b"#").split(u8::is_ascii_whitespace);
        let mut words = words.filter(|word| !word.is_empty());
        let is_whole = |word: &[u8]| word.iter().all(u8::is_ascii_digit);
        words.by_ref().take(HEADER).filter(|word| is_whole(word)).count() == HEADER
            && words.next().is_none()
    }

    fn has_name(&self, path: &Path) -> bool {
        has_extension(path, "avs") || has_extension(path, "ucd")
    }

    fn read(&self, path: &Path, bytes: &[u8], unit_m: f64) -> Result<RawMesh> {
        let mut rows = Rows::new(path, bytes);
        rows.bytes.enter("its header");
        rows.next("the numbers of nodes and elements")?;
        let nodes = rows.whole("the number of nodes")?;
        let elements = rows.whole("the number of elements")?;
        // A row has at least a digit for the number and each coordinate, and their separators.
        rows.bytes.fits(nodes, 7, "nodes")?;
        let mut content = Content::default();
        rows.bytes.enter("the nodes");
        for _ in 0..nodes {
            content.node(&mut rows, unit_m)?;
        }
        // A row has at least a number, a material, a type and a node.
        rows.bytes.fits(elements, 8, "elements")?;
        rows.bytes.enter("the elements");
        for _ in 0..elements {
            content.element(&mut rows)?;
        }
        content.finish(&rows, elements)
    }
}

/// Content read so far.
#[derive(Default)]
struct Content {
    nodes_m: Vec<[f64; 3]>,
    /// Position of each node number.
    places: HashMap<u64, u32>,
    tetrahedra: Vec<[u32; 4]>,
    groups: Groups,
}

impl Content {
    /// `number x y z`
    fn node(&mut self, rows: &mut Rows, unit_m: f64) -> Result<()> {
        rows.next("a node")?;
        let number = rows.whole("the number of a node")?;
        let position = rows.position_m(unit_m)?;
        rows.end()?;
        if self.places.insert(number, self.nodes_m.len() as u32).is_some() {
            return Err(rows.bytes.error(format!(
                "node number {number} is given twice; give each node a number of its own and save the \
                 mesh again"
            )));
        }
        self.nodes_m.push(position);
        Ok(())
    }

    /// `number material type nodes..`
    fn element(&mut self, rows: &mut Rows) -> Result<()> {
        rows.next("an element")?;
        let number = rows.whole("the number of an element")?;
        let material = rows.word("the material")?;
        let material = rows.bytes.signed_of(material, "the material")?;
        let kind = rows.word("the type of the element")?;
        let count = match kind.to_ascii_lowercase().as_str() {
            "pt" => 1,
            "line" => 2,
            "tri" => 3,
            "quad" | "tet" => 4,
            _ => {
                return Err(rows.bytes.error(format!(
                    "element {number} is of type '{}'; only tetrahedra (tet) are read: mesh it with \
                     tetrahedra, or split it into them",
                    shown(kind)
                )));
            }
        };
        // The positions of its nodes.
        let mut ids = Vec::with_capacity(count);
        for _ in 0..count {
            let node = rows.whole("a node of the element")?;
            let place = self.places.get(&node).ok_or_else(|| {
                rows.bytes.error(format!(
                    "element {number} refers to node {node}, which the nodes in front do not have; save \
                     the mesh again"
                ))
            })?;
            ids.push(*place);
        }
        rows.end()?;
        // All elements count for their group; only tetrahedra are kept.
        self.groups.of_element(material, ids.iter().copied());
        if let (true, &[a, b, c, d]) = (kind.eq_ignore_ascii_case("tet"), ids.as_slice()) {
            if (1..4).any(|at| ids[..at].contains(&ids[at])) {
                return Err(rows.bytes.error(format!(
                    "element {number} is a tetrahedron that has a node twice; delete it or mesh again"
                )));
            }
            self.tetrahedra.push([a, b, c, d]);
        }
        Ok(())
    }

    fn finish(self, rows: &Rows, elements: u64) -> Result<RawMesh> {
        if self.tetrahedra.is_empty() {
            return Err(rows.bytes.error_of_file(format!(
                "it has {} nodes and {elements} elements but no tetrahedra; a volume mesh is needed: mesh \
                 the volume inside and save all elements",
                self.nodes_m.len()
            )));
        }
        let groups = self.groups.finish();
        Ok(RawMesh { nodes_m: self.nodes_m, tetrahedra: self.tetrahedra, groups })
    }
}
