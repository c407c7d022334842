//! `Contacts`: the triangles that tools touch, as columns.

use chaincell_client::contacts::Contact;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::model::{column, rows};

/// What tools touched in a tick, a row for each triangle and part of a tool. Arrays are copies.
///
/// >>> contacts = tissue.contacts()
/// >>> contacts.positions_m.shape == (len(contacts), 3)
/// True
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Contacts {
    pub(crate) contacts: Vec<Contact>,
    /// Number of the tick.
    #[pyo3(get)]
    pub(crate) tick: u64,
}

impl Contacts {
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

    /// Number of the tool, uint32 (contacts,).
    #[getter]
    fn tools<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        column(py, &self.contacts, |of| of.tool)
    }

    /// Number of its part, uint32 (contacts,).
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        column(py, &self.contacts, |of| of.part)
    }

    /// Id of the triangle's corner that takes the largest share, uint32 (contacts,).
    #[getter]
    fn node_ids<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        column(py, &self.contacts, |of| of.node)
    }

    /// Position at which the force acts [m], float32 (contacts, 3).
    #[getter]
    fn positions_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.vectors(py, |of| of.position_m)
    }

    /// Normal force on the tool [N], float32 (contacts, 3).
    #[getter]
    fn normal_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.vectors(py, |of| of.normal_n)
    }

    /// Friction, or the pull of a grip, on the tool [N], float32 (contacts, 3).
    #[getter]
    fn tangential_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        self.vectors(py, |of| of.tangential_n)
    }

    /// Area of the triangle at rest, as far as it is in contact [m2], float32 (contacts,).
    #[getter]
    fn area_m2<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, &self.contacts, |of| of.area_m2)
    }

    fn __repr__(&self) -> String {
        format!("<chaincell.Contacts: {} after tick {}>", self.contacts.len(), self.tick)
    }
}
