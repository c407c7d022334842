//! The surface of a model's nodes: what of a body is seen.

use chaincell_kernel::Model;

use crate::engine::{CutCells, Nodes, to_m};
use crate::mesh::boundary;

/// Indices into a list of nodes, and where these are at rest.
pub(super) struct Skin {
    pub rest_m: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    /// Links, where there are no triangles.
    pub links: Vec<[u32; 2]>,
}

impl Skin {
    /// Of the embedded mesh where there is one, else of the cells: the model's triangles, the boundary of its
    /// tetrahedra, or its links.
    pub fn of(model: &Model<'_>, nodes: &Nodes) -> Self {
        if model.fine_nodes() > 0 { Self::fine(model, nodes) } else { Self::cells(model, nodes) }
    }

    /// Of a body that is cut: the boundary of its tetrahedra, sides of the wound among it. The last nodes are copies
    /// of split cells.
    pub fn of_cut(model: &Model<'_>, nodes: &Nodes, cut: &CutCells) -> Self {
        let corners: Vec<u32> =
            cut.tetrahedra.as_flattened().iter().map(|&cell| cell.into()).collect();
        let body = nodes.ids.len() - cut.origins.len();
        let cells = (0..body).chain(cut.origins.iter().map(|&cell| cell.into()));
        let rest_m =
            cells.map(|cell| to_m(model, model.rest_position(cell).map(f64::from))).collect();
        Self { rest_m, triangles: boundary(&fours(&corners)), links: Vec::new() }
    }

    fn cells(model: &Model<'_>, nodes: &Nodes) -> Self {
        let wide =
            |corners: &[u16]| -> Vec<u32> { corners.iter().map(|&cell| cell.into()).collect() };
        let triangles = match (model.triangles(), model.tetrahedra()) {
            ([], []) => Vec::new(),
            ([], tetrahedra) => boundary(&fours(&wide(tetrahedra.as_flattened()))),
            (triangles, _) => threes(&wide(triangles.as_flattened())),
        };
        let all = (0..model.cells())
            .flat_map(|cell| model.row(cell).map(move |link| (cell, model.upper()[link])))
            .map(|(cell, upper)| [cell as u32, upper.into()]);
        let links = if triangles.is_empty() { all.collect() } else { Vec::new() };
        let rest = |cell| to_m(model, model.rest_position(cell).map(f64::from));
        Self { rest_m: (0..nodes.ids.len()).map(rest).collect(), triangles, links }
    }

    fn fine(model: &Model<'_>, nodes: &Nodes) -> Self {
        // Every id of an element is in the list.
        let point = |id: &u32| nodes.ids.binary_search(id).unwrap_or_default() as u32;
        let points = |ids: &[u32]| -> Vec<u32> { ids.iter().map(point).collect() };
        let triangles = match model.fine_triangles() {
            [] => boundary(&fours(&points(model.fine_tetrahedra().as_flattened()))),
            triangles => threes(&points(triangles.as_flattened())),
        };
        let rest = |id: &u32| {
            let rest = model.fine_rest(*id as usize).unwrap_or_default();
            to_m(model, rest.map(f64::from))
        };
        Self { rest_m: nodes.ids.iter().map(rest).collect(), triangles, links: Vec::new() }
    }
}

fn threes(corners: &[u32]) -> Vec<[u32; 3]> {
    corners.as_chunks().0.to_vec()
}

fn fours(corners: &[u32]) -> Vec<[u32; 4]> {
    corners.as_chunks().0.to_vec()
}
