//! `Output`: what a tick answers.

use chaincell_host::engine::tools::Felt;
use chaincell_kernel::TickOutput;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::model::rows;

/// The answer of a tick; its arrays are copies.
///
/// >>> tissue.tick([0.0, 0.0, 0.05]).sweeps
/// 2
#[pyclass(frozen, module = "chaincell")]
#[derive(Debug, Clone)]
pub(crate) struct Output {
    pub(crate) of: TickOutput,
    /// What each tool felt.
    pub(crate) felt: Vec<Felt>,
    pub(crate) is_several: bool,
    /// Number of the tick, from 1.
    #[pyo3(get)]
    pub(crate) tick: u64,
}

#[pymethods]
impl Output {
    /// Force of the tissue on the tool [N], float32 (3,), or on each of several, (tools, 3).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vectors(py, self.felt.iter().map(|of| of.force_n).collect(), self.is_several)
    }

    /// Torque on the tool about its position [N m], float32 (3,), or on each of several, (tools, 3).
    #[getter]
    fn torque_n_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        vectors(py, self.felt.iter().map(|of| of.torque_n_m).collect(), self.is_several)
    }

    /// Estimated distance of each tool's force, of held cells one, from that of the body in equilibrium [N]: within it
    /// are 99 of 100 errors. None where it is not known: away from the tissue, in a tick whose motion is shortened, in
    /// late ticks after one, a release or a restore and of cells held in a body that relaxes, where an output stage
    /// changes the force, under another scheme than predict, and for a model of links, cut, or without a coarse
    /// level.
    #[getter]
    fn force_error_n(&self) -> Vec<Option<f32>> {
        self.felt.iter().map(|of| of.force_error_n).collect()
    }

    /// Estimated distance of each tool's torque from that of the body in equilibrium [N m], likewise; None for held
    /// cells too.
    #[getter]
    fn torque_error_n_m(&self) -> Vec<Option<f32>> {
        self.felt.iter().map(|of| of.torque_error_n_m).collect()
    }

    /// Certified upper bound of the elastic energy [J].
    #[getter]
    fn energy_j(&self) -> f32 {
        self.of.energy_j
    }

    /// Work of the tool's motion on the tissue [J].
    #[getter]
    fn work_j(&self) -> f32 {
        self.of.work_j
    }

    /// Upper bound of the stiffness that the tool meets within a tick [N/m].
    #[getter]
    fn stiffness_n_per_m(&self) -> f32 {
        self.of.stiffness_n_per_m
    }

    /// Number of held cells, or of triangles in contact with a tool.
    #[getter]
    pub(crate) fn contacts(&self) -> u32 {
        self.felt.iter().map(|felt| felt.contacts).sum()
    }

    /// Number of sweeps made, 0 in a late tick.
    #[getter]
    fn sweeps(&self) -> u16 {
        self.of.sweeps
    }

    /// Limits and faults that acted during the tick, `Flags`.
    #[getter]
    fn flags<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        flags(py, self.of.flags.0)
    }

    fn __repr__(&self) -> String {
        let force_n = self.felt.first().map(|of| of.force_n).unwrap_or_default();
        format!("<chaincell.Output: tick {}, force {force_n:?} N>", self.tick)
    }
}

/// One vector for each tool, of one tool alone the vector itself.
pub(crate) fn vectors<'py>(
    py: Python<'py>,
    each: Vec<[f32; 3]>,
    is_several: bool,
) -> PyResult<Bound<'py, PyAny>> {
    if is_several {
        return Ok(rows(each).into_pyarray(py).into_any());
    }
    let first = each.first().copied().unwrap_or_default();
    let array: Bound<'py, PyArray1<f32>> = PyArray1::from_slice(py, &first);
    array.reshape([3]).map(Bound::into_any)
}

/// A number as `chaincell.Flags`.
pub(crate) fn flags(py: Python<'_>, bits: u32) -> PyResult<Bound<'_, PyAny>> {
    static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    CLASS.import(py, "chaincell.flags", "Flags")?.call1((bits,))
}

/// A number as `chaincell.Notes`.
pub(crate) fn notes(py: Python<'_>, bits: u32) -> PyResult<Bound<'_, PyAny>> {
    static CLASS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    CLASS.import(py, "chaincell.flags", "Notes")?.call1((bits,))
}
