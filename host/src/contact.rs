//! The cells that the tool holds, from the nodes that the user names.

use std::collections::BTreeMap;

use chaincell_kernel::Model;

use crate::error::{Error, Result};

/// Cells for a patch of nodes (input ids), ascending.
///
/// Where every node is a cell, those of the patch. Where cells are groups of nodes, a cell is held
/// if the patch has half of its group or more: the cells held then cover about what the patch
/// covers, neither more nor less of the body. A patch smaller than that, or each of several such
/// patches apart, holds the one cell that has most of its nodes, of equals the one with the lowest
/// input id.
///
/// # Errors
/// A node that is no cell, or one that is fixed.
pub fn held(model: &Model<'_>, nodes: &[u32]) -> Result<Vec<u16>> {
    let mut named: BTreeMap<u16, usize> = BTreeMap::new();
    let cell_of = cells(model);
    for &node in nodes {
        let cell = cell_of.get(&node).copied().ok_or_else(|| {
            Error::input(format!("--contact: node {node} is no cell of the model"))
        })?;
        if model.is_fixed(cell) {
            return Err(Error::input(format!(
                "--contact: node {node} is fixed and cannot be held by the tool"
            )));
        }
        *named.entry(cell).or_default() += 1;
    }
    if model.fine_nodes() == 0 {
        return Ok(named.into_keys().collect());
    }
    let mut size = vec![0_usize; model.cells()];
    for cell in cell_of.into_values() {
        size[usize::from(cell)] += 1;
    }
    let id = |cell: u16| model.input_id()[usize::from(cell)];
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

/// The cell of every input id that has one: a numbering may be far longer than the model.
fn cells(model: &Model<'_>) -> BTreeMap<u32, u16> {
    if model.fine_nodes() > 0 {
        let own = |node| Some((node, model.cell_of_input(node)?));
        return (0..model.fine_nodes() as u32).filter_map(own).collect();
    }
    model.input_id().iter().copied().zip(0..).collect()
}

/// Cells in sets that links join.
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
