//! The cells of a body: their order, their frame, links and fixed cells by cell.

use super::order::by_place;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// Cells of a link, lower first, and the index of the mesh's link.
pub(super) type Link = ([u16; 2], usize);

/// Cells in the model's order, with the data of the sections.
pub(super) struct OrderedCells {
    /// Each cell's node in the network's mesh.
    pub node: Vec<u32>,
    /// Cell of each node of that mesh; `u16::MAX` for a node that is no cell.
    pub cell_of: Vec<u16>,
    pub centre_m: [f32; 3],
    pub unit_m: f32,
    pub rest: Vec<[f32; 3]>,
    /// Links of cells, `i < j`, sorted, with the index of the mesh's link.
    pub links: Vec<Link>,
    pub fixed: Vec<u16>,
    /// Number of spare cells after these.
    pub spare: usize,
}

impl OrderedCells {
    /// Returns the number of cells, including the spare ones.
    pub fn all_cells(&self) -> usize {
        self.rest.len() + self.spare
    }
}

/// Chooses the frame and the order of the cells, and renumbers links and fixed nodes.
pub(super) fn lay_out(mesh: &Mesh, fixed: &[u32]) -> Result<OrderedCells> {
    let mut used = vec![true; mesh.nodes_m.len()];
    for &node in &mesh.unused {
        used[node as usize] = false;
    }
    let nodes: Vec<u32> = (0..mesh.nodes_m.len() as u32).filter(|&id| used[id as usize]).collect();
    let mut valence = vec![0_u32; mesh.nodes_m.len()];
    for &node in mesh.links.as_flattened() {
        valence[node as usize] += 1;
    }
    // Number the cells.
    let order = by_place(&mesh.nodes_m, &valence, nodes);
    let mut cell_of = vec![u16::MAX; mesh.nodes_m.len()];
    for (cell, &node) in order.iter().enumerate() {
        cell_of[node as usize] = cell as u16;
    }
    let mut links: Vec<Link> = (mesh.links.iter().enumerate())
        .map(|(at, &[i, j])| {
            let (a, b) = (cell_of[i as usize], cell_of[j as usize]);
            ([a.min(b), a.max(b)], at)
        })
        .collect();
    links.sort_unstable();
    // Renumber the fixed nodes.
    let mut fixed_cells = Vec::with_capacity(fixed.len());
    for &node in fixed {
        match cell_of.get(node as usize) {
            Some(&cell) if cell != u16::MAX => fixed_cells.push(cell),
            _ => return Err(Error::input(format!("`fixed`: node {node} is no cell of the body"))),
        }
    }
    fixed_cells.sort_unstable();
    fixed_cells.dedup();
    // Rest positions in the frame.
    let (centre_m, unit_m) = frame(mesh, &order);
    let rest = order.iter().map(|&node| internal(mesh.nodes_m[node as usize], centre_m, unit_m));
    Ok(OrderedCells {
        rest: rest.collect(),
        node: order,
        cell_of,
        centre_m,
        unit_m,
        links,
        fixed: fixed_cells,
        spare: 0,
    })
}

/// Converts a position to mean link lengths from the centre.
pub(super) fn internal(position_m: [f64; 3], centre_m: [f32; 3], unit_m: f32) -> [f32; 3] {
    // Adding +0.0 turns -0.0 into +0.0.
    std::array::from_fn(|axis| {
        ((position_m[axis] - f64::from(centre_m[axis])) / f64::from(unit_m)) as f32 + 0.0
    })
}

/// Returns the centre of the bounding box and the mean link length, in single precision, as all later
/// conversions use them.
fn frame(mesh: &Mesh, nodes: &[u32]) -> ([f32; 3], f32) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &node in nodes {
        for (axis, &x) in mesh.nodes_m[node as usize].iter().enumerate() {
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
    }
    let centre = [0, 1, 2].map(|axis| (0.5 * (low[axis] + high[axis])) as f32 + 0.0);
    let lengths = mesh.links.iter().map(|&[i, j]| {
        let (a, b) = (mesh.nodes_m[i as usize], mesh.nodes_m[j as usize]);
        (0..3).map(|axis| (b[axis] - a[axis]).powi(2)).sum::<f64>().sqrt()
    });
    let mean = lengths.sum::<f64>() / mesh.links.len() as f64;
    (centre, mean as f32)
}

/// Returns true if forces and energies of a body of this mean link length and stiffness stay in the range
/// of single precision.
pub(super) fn holds_units(unit_m: f32, stiffness_n_per_m: f32) -> bool {
    let unit_m = f64::from(unit_m);
    let force_unit_n = 2.0 * f64::from(stiffness_n_per_m) * unit_m;
    [force_unit_n, force_unit_n * unit_m].iter().all(|unit| (1e-17..=1e17).contains(unit))
}
