//! `State`: positions of all nodes, where they lie in shared memory.

use std::sync::{Mutex, PoisonError};

use chaincell_client::payload::{NodePosition, StateHeader};
use chaincell_client::viewed::View;
use numpy::ndarray::{ArrayView1, ArrayView2, ShapeBuilder};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::output::flags;
use crate::process::Owned;

/// Words of 4 bytes in a row: the id, then x, y, z.
const ROW: usize = size_of::<NodePosition>() / 4;

/// A state of a running scene, from `Session.state`. Its arrays are views into shared memory that
/// cannot be written; the message stays there until the state and its arrays are gone.
///
/// >>> state = session.state()
/// >>> state.positions_m.shape == (len(state), 3)
/// True
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct State {
    view: Mutex<Owned<View<NodePosition>>>,
    header: StateHeader,
}

impl State {
    pub(crate) fn new(view: View<NodePosition>) -> Self {
        Self { header: view.header(), view: Mutex::new(Owned::new(view)) }
    }

    /// Where the rows lie, and how many there are.
    fn rows(&self) -> PyResult<(*const NodePosition, usize)> {
        let mut view = self.view.lock().unwrap_or_else(PoisonError::into_inner);
        let rows = view.get()?.rows();
        Ok((rows.as_ptr(), rows.len()))
    }
}

#[pymethods]
impl State {
    fn __len__(&self) -> PyResult<usize> {
        Ok(self.rows()?.1)
    }

    /// Ids of the nodes, ascending, uint32 (nodes,), a view.
    #[getter]
    fn node_ids<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let (rows, count) = slf.get().rows()?;
        if count == 0 {
            return Ok(PyArray1::zeros(slf.py(), 0, false));
        }
        // The rows are `repr(C)`, an id and three floats each.
        // SAFETY: they lie in a message that its writer leaves alone while it is held: the object holds
        // it until it is dropped, and the array holds the object.
        #[allow(unsafe_code, reason = "a view instead of a copy")]
        let array = unsafe {
            let ids = ArrayView1::from_shape_ptr(count.strides(ROW), rows.cast::<u32>());
            PyArray1::borrow_from_array(&ids, slf.clone().into_any())
        };
        array.readwrite().make_nonwriteable();
        Ok(array)
    }

    /// Positions of the nodes [m], float32 (nodes, 3), in the order of `node_ids`, a view.
    #[getter]
    fn positions_m<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (rows, count) = slf.get().rows()?;
        if count == 0 {
            return Ok(PyArray2::zeros(slf.py(), [0, 3], false));
        }
        // SAFETY: as above; the three floats stand behind the id of each row.
        #[allow(unsafe_code, reason = "a view instead of a copy")]
        let array = unsafe {
            let first = rows.cast::<f32>().add(1);
            let places = ArrayView2::from_shape_ptr((count, 3).strides((ROW, 1)), first);
            PyArray2::borrow_from_array(&places, slf.clone().into_any())
        };
        array.readwrite().make_nonwriteable();
        Ok(array)
    }

    /// Number of the last answered tick, 0 before the first.
    #[getter]
    fn tick(&self) -> u64 {
        self.header.tick
    }

    /// Number of ticks answered since the server began.
    #[getter]
    fn ticks_answered(&self) -> u64 {
        self.header.ticks_answered
    }

    /// Hash of the state, 16 hexadecimal digits.
    #[getter]
    fn state_hash(&self) -> String {
        format!("{:016x}", self.header.state_hash)
    }

    /// Checksum of the server's model, 8 hexadecimal digits, as `Model.checksum`.
    #[getter]
    fn model_checksum(&self) -> String {
        format!("{:08x}", self.header.model_checksum)
    }

    /// Limits and faults of the last answer, `Flags`.
    #[getter]
    fn flags<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        flags(py, self.header.flags)
    }

    fn __repr__(&self) -> String {
        format!("<chaincell.State: {} nodes after tick {}>", self.header.nodes, self.header.tick)
    }
}
