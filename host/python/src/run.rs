//! `run`: a path through a tissue, without a server.

use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::given::offline;
use crate::model::Model;
use crate::numbers::object;
use crate::output::Output;
use crate::poses::Tick;
use crate::signals::Signals;
use crate::tissue::Live;

/// What a path gave, a row for each tick.
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Run {
    ticks: Vec<Output>,
    tools: usize,
    is_several: bool,
    /// Hash of the state after the last tick, 16 hexadecimal digits.
    #[pyo3(get)]
    state_hash: String,
}

impl Run {
    fn vectors<'py>(
        &self,
        py: Python<'py>,
        of: fn(&chaincell_host::engine::tools::Felt) -> [f32; 3],
    ) -> Bound<'py, PyAny> {
        let each = self.ticks.iter().flat_map(|tick| tick.felt.iter().flat_map(of));
        let values: Vec<f32> = each.collect();
        let ticks = self.ticks.len();
        if self.is_several {
            let shape = (ticks, self.tools, 3);
            let array = Array3::from_shape_vec(shape, values).unwrap_or_default();
            return array.into_pyarray(py).into_any();
        }
        let array = Array2::from_shape_vec((ticks, 3), values).unwrap_or_default();
        array.into_pyarray(py).into_any()
    }

    fn column<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        of: fn(&Output) -> T,
    ) -> Bound<'py, PyArray1<T>> {
        self.ticks.iter().map(of).collect::<Vec<T>>().into_pyarray(py)
    }
}

#[pymethods]
impl Run {
    fn __len__(&self) -> usize {
        self.ticks.len()
    }

    /// Forces on the tool, (ticks, 3), or on several, (ticks, tools, 3) [N].
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.vectors(py, |of| of.force_n)
    }

    /// Torques about the positions, as the forces [N m].
    #[getter]
    fn torque_n_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.vectors(py, |of| of.torque_n_m)
    }

    /// Certified upper bounds of the elastic energy [J].
    #[getter]
    fn energy_j<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.column(py, |of| of.of.energy_j)
    }

    /// What the tool's motion did to the tissue [J].
    #[getter]
    fn work_j<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        self.column(py, |of| of.of.work_j)
    }

    /// Contacts, as `Output.contacts`.
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, Output::contacts)
    }

    /// Sweeps made.
    #[getter]
    fn sweeps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u16>> {
        self.column(py, |of| of.of.sweeps)
    }

    /// What bit, as sums of `Flags`.
    #[getter]
    fn flags<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |of| of.of.flags.0)
    }

    fn __repr__(&self) -> String {
        format!("<chaincell.Run: {} ticks, state hash {}>", self.ticks.len(), self.state_hash)
    }
}

/// Plays a path through a tissue at rest; Ctrl-C ends it.
#[pyfunction]
#[pyo3(signature = (model, path, engaged=None, *, sweeps_made=None, **options))]
pub(crate) fn run(
    py: Python<'_>,
    model: &Bound<'_, PyAny>,
    path: &Bound<'_, PyAny>,
    engaged: Option<&Bound<'_, PyAny>>,
    sweeps_made: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Run> {
    let model = object::<Model>("model", "a chaincell.Model", model)?;
    let options = offline(options)?;
    let path = Tick::path(path, engaged)?;
    let sweeps = sweeps_made.map(|given| sweeps_of(given, path.len())).transpose()?;
    let body = &model.get().body;
    py.detach(|| {
        let mut live = Live::new(body, &options)?;
        let mut ticks = Vec::with_capacity(path.len());
        let signals = Signals::new();
        for (at, tick) in path.iter().enumerate() {
            let sweeps = sweeps.as_ref().and_then(|sweeps| sweeps.get(at).copied());
            live.check(tick, sweeps)?;
            ticks.push(live.tick(tick, sweeps));
            if signals.stop() {
                signals.raised()?;
            }
        }
        let tools = live.tools().max(1);
        let is_several = tools > 1 || path.first().is_some_and(|tick| tick.is_several);
        Ok(Run { ticks, tools, is_several, state_hash: live.state_hash() })
    })
}

/// Sweeps of each tick.
fn sweeps_of(given: &Bound<'_, PyAny>, ticks: usize) -> PyResult<Vec<u16>> {
    let sweeps = arrays::up_to("sweeps_made", given, u16::MAX.into())?;
    let sweeps = sweeps.one_each("sweeps_made", ticks, "tick")?;
    Ok(sweeps.into_iter().map(|count| count as u16).collect())
}
