//! `Surface`: the surface of a body as it is cut.

use chaincell_client::surface::{SurfaceHeader, SurfaceRow};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::model::{column, rows};

/// The surface of a body as it is cut after a tick, from `Tissue.surface`: the nodes, the copies of those that cuts
/// have split, and triangles between them. Arrays are copies.
///
/// >>> options = dict(young_pa=5000, poisson=0.4, cuttable=True, cut_spare=0.3, toughness_j_per_m2=10)
/// >>> slab = chaincell.Model.bake_mesh("box:5x5x4x0.01", **options)
/// >>> cutter = chaincell.Tissue(slab, tools=["blade:0.032"])
/// >>> for z_m in np.linspace(0.0305, 0.0155, 150):
/// ...     output = cutter.tick([0.0, 0.0, z_m])
/// >>> surface = cutter.surface()
/// >>> len(surface.triangles) > len(slab.triangles)
/// True
/// >>> corners_m = surface.positions_m[surface.triangles]  # to draw
/// >>> height_m = slab.rest_m[surface.origins, 2]  # at rest, for colours
/// >>> height_m.shape == (slab.nodes + cutter.cuts["copied_cells"],) == surface.positions_m.shape[:1]
/// True
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Surface {
    vertices: Vec<SurfaceRow>,
    triangles: Vec<[u32; 3]>,
    nodes: usize,
    /// Number of the tick.
    #[pyo3(get)]
    tick: u64,
}

impl Surface {
    /// The lists of a surface after a tick.
    pub(crate) fn new(header: SurfaceHeader, rows: &[SurfaceRow], tick: u64) -> Self {
        let [nodes, copies, triangles] =
            [header.nodes, header.copies, header.triangles].map(|count| count as usize);
        Self {
            vertices: rows.iter().take(nodes + copies).copied().collect(),
            triangles: rows.iter().take(triangles).map(|of| of.corners).collect(),
            nodes,
            tick,
        }
    }
}

#[pymethods]
impl Surface {
    /// Positions of the nodes [m] in the order of `Model.node_ids`, and of the copies after them, float32
    /// (nodes + copies, 3).
    #[getter]
    fn positions_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        rows(self.vertices.iter().map(|of| of.position_m).collect()).into_pyarray(py)
    }

    /// The node that each node is and each copy was made from: its place in `Model.node_ids`, uint32
    /// (nodes + copies,).
    #[getter]
    fn origins<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let nodes = self.vertices.get(..self.nodes).unwrap_or(&[]);
        column(py, &self.vertices, |of| {
            let place = nodes.binary_search_by_key(&of.node, |node| node.node);
            place.unwrap_or_default() as u32
        })
    }

    /// Corners of the triangles, counter-clockwise from outside: rows of `positions_m`, uint32 (triangles, 3). They
    /// begin with those of `Model.triangles`, in its order. One of a piece that is gone (`loose="drop"`) has three
    /// times the same corner.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(self.triangles.clone()).into_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let (triangles, copies) = (self.triangles.len(), self.vertices.len() - self.nodes);
        format!(
            "<chaincell.Surface: {triangles} triangles, {copies} copies after tick {}>",
            self.tick
        )
    }
}
