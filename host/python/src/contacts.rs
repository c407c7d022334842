//! `Contacts`: the triangles that tools touch, as columns.

use chaincell_client::contacts::Contact;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::model::rows;

/// What tools touched in a tick, a row for each triangle and part of a tool. All arrays are copies.
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Contacts {
    pub(crate) contacts: Vec<Contact>,
    /// Number of the tick.
    #[pyo3(get)]
    pub(crate) tick: u64,
}

impl Contacts {
    fn numbers<'py>(&self, py: Python<'py>, of: fn(&Contact) -> u32) -> Bound<'py, PyArray1<u32>> {
        self.contacts.iter().map(of).collect::<Vec<u32>>().into_pyarray(py)
    }

    fn vectors<'py>(
        &self,
        py: Python<'py>,
        of: fn(&Contact) -> [f32; 3],
    ) -> Bound<'py, PyArray2<f32>> {
        rows(self.contacts.iter().map(of).collect()).into_pyarray(py)
    }
}

#[pymethods]
impl Contacts {
    fn __len__(&self) -> usize {
        self.contacts.len()
    }

    /// Which tool.
    #[getter]
    fn tools<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.numbers(py, |of| of.tool)
    }

    /// Which of its parts.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.numbers(py, |of| of.part)
    }

    /// Id of the corner that takes the largest share.
    #[getter]
    fn node_ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.numbers(py, |of| of.node)
    }

    /// Where it acts [m].
    #[getter]
    fn positions_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.vectors(py, |of| of.position_m)
    }

    /// Pressure on the tool [N].
    #[getter]
    fn normal_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.vectors(py, |of| of.normal_n)
    }

    /// Friction, or the pull of a grip, on the tool [N].
    #[getter]
    fn tangential_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.vectors(py, |of| of.tangential_n)
    }

    /// Area of the triangle at rest, as far as it is in contact [m2].
    #[getter]
    fn area_m2<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.contacts.iter().map(|of| of.area_m2).collect::<Vec<f32>>().into_pyarray(py)
    }

    fn __repr__(&self) -> String {
        format!("<chaincell.Contacts: {} after tick {}>", self.contacts.len(), self.tick)
    }
}
