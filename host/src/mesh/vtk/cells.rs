//! Cells of an unstructured grid: lists of nodes, and the kind of each.

use super::values::{Values, number_type};
use crate::error::Result;
use crate::mesh::bytes::{Bytes, shown};
use crate::mesh::number::Number;
use crate::words::counted;

/// Cells read so far.
#[derive(Default)]
pub(super) struct Cells {
    /// Begin of each cell's nodes in `nodes`, then the end of the last.
    pub(super) starts: Vec<usize>,
    pub(super) nodes: Vec<u64>,
    pub(super) types: Vec<u64>,
}

/// Smallest number of bytes of a value in either coding.
const VALUE: Number = Number::I32;

/// Use of a cell.
enum Kind {
    Tetrahedron,
    /// Without volume: skipped; has its number of nodes if the type fixes it.
    Flat(Option<usize>),
    Refused(&'static str, &'static str),
}

const RECOMBINED: &str =
    "only tetrahedra are read: mesh it without recombination, or split it into tetrahedra";
const SECOND_ORDER: &str = "only first-order meshes are read: save it with linear elements";

fn kind(number: u64) -> Kind {
    match number {
        10 => Kind::Tetrahedron,
        0 => Kind::Flat(Some(0)),
        1 => Kind::Flat(Some(1)),
        3 => Kind::Flat(Some(2)),
        5 => Kind::Flat(Some(3)),
        8 | 9 => Kind::Flat(Some(4)),
        2 | 4 | 6 | 7 => Kind::Flat(None),
        11 => Kind::Refused("voxel", RECOMBINED),
        12 => Kind::Refused("hexahedron", RECOMBINED),
        13 => Kind::Refused("wedge", RECOMBINED),
        14 => Kind::Refused("pyramid", RECOMBINED),
        15 | 16 => Kind::Refused("prism", RECOMBINED),
        24 => Kind::Refused("10-node tetrahedron", SECOND_ORDER),
        42 => Kind::Refused("polyhedron", RECOMBINED),
        21..=37 => Kind::Refused("second-order cell", SECOND_ORDER),
        60..=81 => Kind::Refused("higher-order cell", SECOND_ORDER),
        _ => Kind::Refused("cell of another kind", RECOMBINED),
    }
}

impl Cells {
    /// `CELLS n size`, then for each cell the number of its nodes and the nodes.
    pub(super) fn read_lists(&mut self, values: &mut Values) -> Result<()> {
        let count = values.count("the number of cells")?;
        let size = values.count("the size of the cells")?;
        values.begin_data(size, 1, VALUE, "numbers")?;
        let mut left = size;
        self.starts.push(0);
        for cell in 0..count {
            let nodes = if left == 0 { 0 } else { values.whole(VALUE, "a number of nodes")? };
            // The count itself is one of the numbers.
            if left == 0 || nodes > left - 1 {
                return Err(values.bytes.error(format!(
                    "the cells' size is {size}, too little for cell {cell} of {count}; save or \
                     copy the mesh again"
                )));
            }
            for _ in 0..nodes {
                self.nodes.push(values.whole(VALUE, "a node of a cell")?);
            }
            self.starts.push(self.nodes.len());
            left -= 1 + nodes;
        }
        if left == 0 {
            return Ok(());
        }
        Err(values.bytes.error(format!(
            "the cells' size is {size}, {left} more than the {count} cells have; save or copy the \
             mesh again"
        )))
    }

    /// `CELLS n size`, `OFFSETS type` and n numbers, `CONNECTIVITY type` and size nodes.
    pub(super) fn read_offsets(&mut self, values: &mut Values) -> Result<()> {
        let count = values.count("the number of offsets")?;
        let size = values.count("the size of the connectivity")?;
        let number = array(values, "OFFSETS", count)?;
        for _ in 0..count {
            let start = values.whole(number, "an offset")?;
            let last = self.starts.last().copied().unwrap_or(0);
            match usize::try_from(start) {
                Ok(start) if start >= last && start as u64 <= size => self.starts.push(start),
                _ => {
                    return Err(values.bytes.error(format!(
                        "the offset {start} behind {last}; offsets ascend to the size {size}: save \
                         or copy the mesh again"
                    )));
                }
            }
        }
        if self.starts.first().is_some_and(|start| *start != 0)
            || self.starts.last().is_some_and(|end| *end as u64 != size)
        {
            return Err(values.bytes.error(format!(
                "the offsets do not run from 0 to {size}, the size of the connectivity; save or \
                 copy the mesh again"
            )));
        }
        let number = array(values, "CONNECTIVITY", size)?;
        for _ in 0..size {
            self.nodes.push(values.whole(number, "a node of a cell")?);
        }
        Ok(())
    }

    /// `CELL_TYPES n`, then a number a cell.
    pub(super) fn read_types(&mut self, values: &mut Values) -> Result<()> {
        let count = values.count("the number of cell types")?;
        values.begin_data(count, 1, VALUE, "cell types")?;
        for _ in 0..count {
            self.types.push(values.whole(VALUE, "a cell type")?);
        }
        Ok(())
    }

    /// Number of cells.
    pub(super) fn count(&self) -> u64 {
        self.starts.len().saturating_sub(1) as u64
    }

    /// Nodes of a cell, of cells that [were checked](Self::tetrahedra).
    pub(super) fn nodes_of(&self, cell: usize) -> impl Iterator<Item = u32> {
        let ends = self.starts.get(cell).zip(self.starts.get(cell + 1));
        let nodes = ends.and_then(|(&start, &end)| self.nodes.get(start..end)).unwrap_or_default();
        nodes.iter().filter_map(|&node| u32::try_from(node).ok())
    }

    /// Returns the tetrahedra; `bytes` makes errors of the file.
    pub(super) fn tetrahedra(&self, bytes: &Bytes, points: usize) -> Result<Vec<[u32; 4]>> {
        let count = self.starts.len().saturating_sub(1);
        if self.types.len() != count {
            return Err(bytes.error_of_file(format!(
                "it has {count} CELLS and {} CELL_TYPES; save or copy the mesh again",
                self.types.len()
            )));
        }
        // Check the nodes and the type of each cell; keep the tetrahedra.
        let mut tetrahedra = Vec::new();
        for (cell, (ends, number)) in self.starts.windows(2).zip(&self.types).enumerate() {
            let nodes = self.nodes.get(ends[0]..ends[1]).unwrap_or_default();
            let refused = |why: String| bytes.error_of_file(format!("cell {cell} {why}"));
            if let Some(node) = nodes.iter().find(|node| **node >= points as u64) {
                return Err(refused(format!(
                    "refers to point {node}, the file has {points}; save the mesh again"
                )));
            }
            let wanted = match kind(*number) {
                Kind::Tetrahedron => Some(4),
                Kind::Flat(wanted) => wanted,
                Kind::Refused(name, remedy) => {
                    return Err(refused(format!("is a {name} (type {number}); {remedy}")));
                }
            };
            if wanted.is_some_and(|wanted| wanted != nodes.len()) {
                return Err(refused(format!(
                    "of type {number} has {}; save or copy the mesh again",
                    counted(nodes.len(), "node")
                )));
            }
            if *number == TETRAHEDRON {
                tetrahedra.push(corners(nodes).ok_or_else(|| {
                    refused(
                        "is a tetrahedron that has a node twice; delete it or mesh again".into(),
                    )
                })?);
            }
        }
        Ok(tetrahedra)
    }
}

/// Refuses a file without tetrahedra, which has `cells` cells; `bytes` makes errors of the file.
pub(super) fn check_tetrahedra(tetrahedra: &[[u32; 4]], cells: u64, bytes: &Bytes) -> Result<()> {
    if !tetrahedra.is_empty() {
        return Ok(());
    }
    let cells = counted(cells, "cell");
    Err(bytes.error_of_file(format!(
        "it has {cells} but no tetrahedra; a volume mesh is needed: mesh the volume inside and save all \
         cells"
    )))
}

/// Type number of a first-order tetrahedron.
const TETRAHEDRON: u64 = 10;

/// Returns the nodes if they are four different ones.
fn corners(nodes: &[u64]) -> Option<[u32; 4]> {
    let mut ids = [0; 4];
    for (at, (id, node)) in ids.iter_mut().zip(nodes).enumerate() {
        if nodes.get(..at)?.contains(node) {
            return None;
        }
        *id = u32::try_from(*node).ok()?;
    }
    Some(ids)
}

/// Reads the head of an array of whole numbers.
fn array(values: &mut Values, keyword: &str, count: u64) -> Result<Number> {
    values.keyword(keyword)?;
    let name = values.text("the type of the array")?;
    let number = match number_type(name) {
        Some(number @ (Number::I32 | Number::I64)) => number,
        _ => {
            return Err(values.bytes.error(format!(
                "{keyword} of type '{}'; vtktypeint64 and int are read: save the mesh with one of \
                 these",
                shown(name)
            )));
        }
    };
    values.begin_data(count, 1, number, "numbers")?;
    Ok(number)
}
