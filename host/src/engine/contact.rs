//! The cells that the tool holds, from nodes given by the user.

use std::collections::BTreeMap;

use chaincell_kernel::Model;

use super::to_m;
use crate::bake::Notes;
use crate::error::{Error, Result};
use crate::mesh;

/// Cells for a patch of nodes (input ids), ascending.
///
/// If every node is a cell, those of the patch. If cells are groups of nodes, a cell is held if the patch has
/// half of its group or more: the held cells then cover about the same part of the body as the patch. A
/// smaller patch, or each of several separate ones, holds the one cell that has most of its nodes; of equals
/// the one with the lowest input id.
///
/// # Errors
/// A node that is no cell, or one that is fixed.
pub fn held(model: &Model<'_>, nodes: &[u32]) -> Result<Vec<u16>> {
    let mut named: BTreeMap<u16, usize> = BTreeMap::new();
    // Count the named nodes of each cell.
    let cell_of = cells(model);
    for &node in nodes {
        let cell = cell_of.get(&node).copied().ok_or_else(|| {
            Error::input(format!("`contact`: node {node} is no cell of the model"))
        })?;
        if model.is_fixed(cell) {
            return Err(Error::input(format!(
                "`contact`: node {node} is fixed and cannot be held by the tool"
            )));
        }
        *named.entry(cell).or_default() += 1;
    }
    if model.fine_nodes() == 0 {
        return Ok(named.into_keys().collect());
    }
    // Size of each cell's group.
    let mut size = vec![0_usize; model.cells()];
    for cell in cell_of.into_values() {
        size[usize::from(cell)] += 1;
    }
    let id = |cell: u16| model.input_id()[usize::from(cell)];
    // Choose the cells patch by patch.
    let mut held = Vec::new();
    for patch in patches(model, named.keys().copied().collect()) {
        let covered = |cell: &u16| 2 * named[cell] >= size[usize::from(*cell)];
        let before = held.len();
        held.extend(patch.iter().copied().filter(covered));
        if held.len() == before {
            held.extend(patch.into_iter().max_by_key(|&cell| (named[&cell], !id(cell))));
        }
    }
    held.sort_unstable();
    Ok(held)
}

/// The cell of every input id that has one. A map, since input ids may be far larger than the model.
fn cells(model: &Model<'_>) -> BTreeMap<u32, u16> {
    if model.fine_nodes() > 0 {
        let own = |node| Some((node, model.cell_of_input(node)?));
        return (0..model.fine_nodes() as u32).filter_map(own).collect();
    }
    model.input_id().iter().copied().zip(0..).collect()
}

/// Splits cells into sets that are connected by links.
fn patches(model: &Model<'_>, cells: Vec<u16>) -> Vec<Vec<u16>> {
    let mut left = cells;
    let mut patches = Vec::new();
    while let Some(first) = left.pop() {
        let mut patch = vec![first];
        let mut at = 0;
        while let Some(&cell) = patch.get(at) {
            at += 1;
            for (_, other) in model.neighbours(cell.into()) {
                if let Some(found) = left.iter().position(|&cell| usize::from(cell) == other) {
                    patch.push(left.swap_remove(found));
                }
            }
        }
        patches.push(patch);
    }
    patches
}

/// The contact cells of `--contact`, ascending.
pub fn contact_cells(contact: &str, model: &Model<'_>) -> Result<Vec<u16>> {
    if contact == "auto" {
        return automatic(model);
    }
    if ["sphere:", "capsule:", "half-space"].iter().any(|kind| contact.starts_with(kind)) {
        return Err(Error::input(format!(
            "`contact` {contact}: give probe:RADIUS, cells:SELECTOR or auto; a tool by its parts is given with \
             `tool`"
        )));
    }
    let selector = contact.strip_prefix("cells:").unwrap_or(contact);
    let notes = Notes::read(model);
    let nodes = (model.input_nodes() as usize, places_m(model));
    let given = format!("`contact` {contact}");
    let nodes = mesh::select_among(selector, nodes, &notes.groups, &notes.border, &given)?;
    held(model, &nodes)
}

/// Input ids with their rest positions \[m\]: those of the cells, or of the nodes of the embedded mesh.
fn places_m<'m>(model: &Model<'m>) -> impl Iterator<Item = (u32, [f64; 3])> + use<'m> {
    let model = *model;
    let fine = (0..model.fine_nodes() as u32)
        .filter_map(move |node| Some((node, model.fine_rest(node as usize)?)));
    let cells = model.input_id().iter().zip(0..);
    let coarse = cells.map(move |(&id, cell)| (id, model.rest_position(cell)));
    let coarse = coarse.take(if model.fine_nodes() > 0 { 0 } else { model.body_cells() });
    fine.chain(coarse).map(move |(id, rest)| (id, to_m(&model, rest.map(f64::from))))
}

/// The free surface cell farthest from the fixed cells (from the centre if none is fixed), with its free
/// surface neighbours; any free cell if the model has no surface.
pub fn automatic(model: &Model<'_>) -> Result<Vec<u16>> {
    let surface = surface(model);
    let farthest = farthest(model)?;
    let neighbours = model.neighbours(farthest.into()).map(|(_, other)| other as u16);
    let on_surface = |cell: &u16| surface.binary_search(cell).is_ok();
    let mut cells: Vec<u16> =
        neighbours.filter(|cell| on_surface(cell) && is_free(model, *cell)).collect();
    cells.push(farthest);
    cells.sort_unstable();
    Ok(cells)
}

/// The surface cells, or all cells if the model has no surface; ascending.
fn surface(model: &Model<'_>) -> Vec<u16> {
    if model.surface().is_empty() {
        (0..model.body_cells() as u16).collect()
    } else {
        model.surface().to_vec()
    }
}

fn is_free(model: &Model<'_>, cell: u16) -> bool {
    !model.is_fixed(cell) && model.neighbours(cell.into()).count() > 0
}

/// The middle cell of [`automatic`].
pub fn farthest(model: &Model<'_>) -> Result<u16> {
    let at = |cell: u16| model.rest_position(cell.into());
    let squared = |a: [f32; 3], b: [f32; 3]| -> f32 {
        (0..3).map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis])).sum()
    };
    let clearance = |cell: u16| {
        let nearest = model.fixed().iter().map(|&fixed| squared(at(cell), at(fixed)));
        nearest.reduce(f32::min).unwrap_or_else(|| squared(at(cell), [0.0; 3]))
    };
    surface(model)
        .into_iter()
        .filter(|&cell| is_free(model, cell))
        .max_by(|&a, &b| clearance(a).total_cmp(&clearance(b)).then(b.cmp(&a)))
        .ok_or_else(|| {
            Error::input("`contact` auto: every cell is fixed; bake with fewer fixed cells")
        })
}

/// Direction into the body at some of its cells: opposite to the sum of their normals, straight down if they
/// have none.
pub fn inward(model: &Model<'_>, cells: &[u16]) -> [f64; 3] {
    let normals = cells.iter().filter_map(|cell| {
        model.surface().binary_search(cell).ok().and_then(|at| model.normals().get(at))
    });
    let inward = normals.fold([0.0; 3], |sum: [f64; 3], normal| {
        std::array::from_fn(|axis| sum[axis] - f64::from(normal[axis]))
    });
    if inward.iter().any(|&x| x != 0.0) { inward } else { [0.0, 0.0, -1.0] }
}
