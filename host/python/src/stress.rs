//! `Stress`, `SessionStress`: strain and stress of tissue, a row for each node.

use chaincell_client::stress::NodeStress;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::model::{column, rows};

/// Strain and stress of tissue at its nodes after a tick, in the order of `Model.node_ids`. Arrays are copies.
///
/// >>> stress = tissue.stress()
/// >>> stress.von_mises_pa.shape == model.node_ids.shape
/// True
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Stress {
    pub(crate) stresses: Vec<chaincell_kernel::Stress>,
    /// Number of the tick.
    #[pyo3(get)]
    pub(crate) tick: u64,
}

#[pymethods]
impl Stress {
    fn __len__(&self) -> usize {
        self.stresses.len()
    }

    /// Principal stretches, the largest first, float32 (nodes, 3).
    #[getter]
    fn stretches<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        rows(self.stresses.iter().map(|of| of.stretches).collect()).into_pyarray(py)
    }

    /// Cauchy stress xx, yy, zz, xy, yz, xz [Pa], above 0 where the tissue is pulled, float32 (nodes, 6).
    #[getter]
    fn cauchy_pa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        let elements = self.stresses.iter().map(chaincell_kernel::Stress::elements_pa);
        rows(elements.collect()).into_pyarray(py)
    }

    /// Stress after von Mises [Pa]: that of a bar under tension is its tension, float32 (nodes,).
    #[getter]
    fn von_mises_pa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, &self.stresses, chaincell_kernel::Stress::von_mises_pa)
    }

    /// Mean stress [Pa], below 0 where the tissue is pressed from all sides, float32 (nodes,).
    #[getter]
    fn mean_pa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, &self.stresses, chaincell_kernel::Stress::mean_pa)
    }

    fn __repr__(&self) -> String {
        format!("<chaincell.Stress: of {} nodes after tick {}>", self.stresses.len(), self.tick)
    }
}

/// Strain and stress of the tissue of a running scene, from `Session.stress`, a row for each node by ascending id: of
/// one pass over the body, in `first_tick` to `tick`. A node that a cut has parted has the values of the side with
/// the largest stress after von Mises. Arrays are copies.
///
/// >>> stress = session.stress()
/// >>> stress.von_mises_pa.shape == stress.node_ids.shape
/// True
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct SessionStress {
    pub(crate) rows: Vec<NodeStress>,
    /// Number of the last answered tick at the end of the pass, 0 before the first.
    #[pyo3(get)]
    pub(crate) tick: u64,
    /// Number of the last answered tick at its begin.
    #[pyo3(get)]
    pub(crate) first_tick: u64,
}

#[pymethods]
impl SessionStress {
    fn __len__(&self) -> usize {
        self.rows.len()
    }

    /// Ids of the nodes, ascending, uint32 (nodes,).
    #[getter]
    fn node_ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        column(py, &self.rows, |of| of.node)
    }

    /// Principal stretches, the largest first, float32 (nodes, 3).
    #[getter]
    fn stretches<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        rows(self.rows.iter().map(|of| of.stretches).collect()).into_pyarray(py)
    }

    /// Stress after von Mises [Pa]: that of a bar under tension is its tension, float32 (nodes,).
    #[getter]
    fn von_mises_pa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, &self.rows, |of| of.von_mises_pa)
    }

    /// Mean stress [Pa], below 0 where the tissue is pressed from all sides, float32 (nodes,).
    #[getter]
    fn mean_pa<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, &self.rows, |of| of.mean_pa)
    }

    fn __repr__(&self) -> String {
        let (nodes, first, last) = (self.rows.len(), self.first_tick, self.tick);
        format!("<chaincell.SessionStress: of {nodes} nodes in ticks {first} to {last}>")
    }
}
