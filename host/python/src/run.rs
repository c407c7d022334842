//! `run`: a path through a tissue, without a server.

use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays;
use crate::errors::Class;
use crate::given::offline;
use crate::live::Live;
use crate::model::{Model, column, rows};
use crate::numbers::{object, text};
use crate::output::Output;
use crate::poses::Tick;
use crate::signals::Signals;

/// The result of `run`: a row for each tick. A tick is a millisecond; arrays are copies.
///
/// >>> result = chaincell.run(model, path_m, contact="probe:0.012", sweeps=2)
/// >>> len(result), result.force_n.shape, result.positions_m.shape
/// (100, (100, 3), (499, 3))
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Run {
    ticks: Vec<Output>,
    tools: usize,
    is_several: bool,
    /// Positions of the tools that the path has, by ticks.
    path_m: Vec<[f32; 3]>,
    /// Positions of the nodes after the last tick.
    positions_m: Vec<[f32; 3]>,
    /// The `Model` of the body.
    #[pyo3(get)]
    model: Py<Model>,
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
        let each = self.ticks.iter().flat_map(|tick| tick.felt.iter().map(of));
        self.by_tick(py, each.collect(), self.tools)
    }

    /// Vectors of this many tools in each tick.
    fn by_tick<'py>(
        &self,
        py: Python<'py>,
        each: Vec<[f32; 3]>,
        tools: usize,
    ) -> Bound<'py, PyAny> {
        if !self.is_several {
            return rows(each).into_pyarray(py).into_any();
        }
        let shape = (self.ticks.len(), tools, 3);
        let array = Array3::from_shape_vec(shape, each.into_flattened()).unwrap_or_default();
        array.into_pyarray(py).into_any()
    }
}

#[pymethods]
impl Run {
    fn __len__(&self) -> usize {
        self.ticks.len()
    }

    /// Forces on the tool [N], float32 (ticks, 3), or on several, (ticks, tools, 3).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.vectors(py, |of| of.force_n)
    }

    /// Torques about the tool's position [N m], float32, of the shape of `force_n`.
    #[getter]
    fn torque_n_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        self.vectors(py, |of| of.torque_n_m)
    }

    /// Certified upper bounds of the elastic energy [J], float32 (ticks,).
    #[getter]
    fn energy_j<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, &self.ticks, |of| of.of.energy_j)
    }

    /// Work of the tool's motion on the tissue in each tick [J], float32 (ticks,).
    #[getter]
    fn work_j<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        column(py, &self.ticks, |of| of.of.work_j)
    }

    /// Numbers of held cells, or of triangles in contact with a tool, uint32 (ticks,).
    #[getter]
    fn contacts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        column(py, &self.ticks, Output::contacts)
    }

    /// Numbers of sweeps made, uint16 (ticks,).
    #[getter]
    fn sweeps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u16>> {
        column(py, &self.ticks, |of| of.of.sweeps)
    }

    /// Limits and faults that acted, sums of `Flags`, uint32 (ticks,).
    #[getter]
    fn flags<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        column(py, &self.ticks, |of| of.of.flags.0)
    }

    /// Positions of the tool [m], float32 (ticks, 3), or of the tools of the path, (ticks, tools, 3).
    #[getter]
    fn path_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        let tools = self.path_m.len() / self.ticks.len().max(1);
        self.by_tick(py, self.path_m.clone(), tools)
    }

    /// Positions of the nodes after the last tick [m], float32 (nodes, 3), in the order of
    /// `Model.node_ids`.
    #[getter]
    fn positions_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f32>> {
        rows(self.positions_m.clone()).into_pyarray(py)
    }

    /// Draws the magnitude of the force [N] by matplotlib, a line for each tool, and returns the axes.
    ///
    /// - `axes`: where to draw; None for new ones.
    /// - `against`: "time" [ms], or "depth" [mm], the distance from where a tool first touched.
    ///
    /// Raises `ArgumentError` for another word, `ImportError` where matplotlib is not installed.
    ///
    /// >>> result.plot_force(against="depth")  # doctest: +SKIP
    #[pyo3(
        signature = (axes=None, *, against=None),
        text_signature = "($self, axes=None, *, against='time')"
    )]
    fn plot_force<'py>(
        slf: &Bound<'py, Self>,
        axes: Option<&Bound<'py, PyAny>>,
        against: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let against = against.map_or_else(|| Ok("time".into()), |given| text("against", given))?;
        if against != "time" && against != "depth" {
            let refused = format!("`against` \"{against}\": give time or depth");
            return Err(Class::Argument.error(refused));
        }
        slf.py().import("chaincell.pictures")?.call_method1("plot_force", (slf, axes, against))
    }

    /// Shows the body after the last tick by PyVista, coloured by displacement: in a notebook in place,
    /// else in a window.
    ///
    /// `options` go to `pyvista.Plotter.show`, such as `screenshot="press.png"`. Returns what that
    /// returns. Raises `ImportError` where PyVista is not installed.
    ///
    /// >>> result.show()  # doctest: +SKIP
    #[pyo3(signature = (**options))]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let of = (slf.getattr("model")?, slf.getattr("positions_m")?);
        slf.py().import("chaincell.pictures")?.call_method("show", of, options)
    }

    fn __repr__(&self) -> String {
        format!("<chaincell.Run: {} ticks, state hash {}>", self.ticks.len(), self.state_hash)
    }
}

/// Plays a path through a tissue at rest, without a server, and returns the `Run`. Ctrl-C ends it.
///
/// - `model`: a `Model`.
/// - `path`: positions [m], (ticks, 3), or with unit quaternions x, y, z, w, (ticks, 7); of several
///   tools (ticks, tools, 3) or (ticks, tools, 7). A row is a millisecond.
/// - `engaged`: whether the tool acts on the tissue, (ticks,) or (ticks, tools); True by default.
/// - `opening_rad`: opening angle of scissors [rad], (ticks,) or (ticks, tools); closed by default.
/// - `sweeps_made`: numbers of sweeps of a session that ended ticks early, (ticks,); they go before `force_error`.
/// - `options`: as of `chaincell run`, with their units, see `chaincell.options.TissueOptions`.
///
/// Raises `PoseError` for a path that is none, `ArgumentError` for other wrong values.
///
/// >>> path_m = np.linspace([0, 0, 0.08], [0, 0, 0.05], 100)
/// >>> result = chaincell.run(model, path_m, contact="probe:0.012", sweeps=2)
/// >>> bool(np.linalg.norm(result.force_n, axis=1).max() > 0.01)
/// True
#[pyfunction]
#[pyo3(signature = (model, path, engaged=None, *, opening_rad=None, sweeps_made=None, **options))]
pub(crate) fn run(
    py: Python<'_>,
    model: &Bound<'_, PyAny>,
    path: &Bound<'_, PyAny>,
    engaged: Option<&Bound<'_, PyAny>>,
    opening_rad: Option<&Bound<'_, PyAny>>,
    sweeps_made: Option<&Bound<'_, PyAny>>,
    options: Option<&Bound<'_, PyDict>>,
) -> PyResult<Run> {
    let model = object::<Model>("model", "a chaincell.Model", model)?;
    let options = offline(options)?;
    let path = Tick::path(path, engaged, opening_rad)?;
    let sweeps = sweeps_made.map(|given| sweeps_of(given, path.len())).transpose()?;
    let body = &model.get().body;
    let kept = model.clone().unbind();
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
        let path_m = path.iter().flat_map(|tick| &tick.poses).map(|pose| pose.position_m.into());
        let (path_m, positions_m) = (path_m.collect(), live.positions_m());
        let state_hash = live.state_hash();
        Ok(Run { ticks, tools, is_several, path_m, positions_m, model: kept, state_hash })
    })
}

/// Sweeps of each tick.
fn sweeps_of(given: &Bound<'_, PyAny>, ticks: usize) -> PyResult<Vec<u16>> {
    let sweeps = arrays::up_to("sweeps_made", given, u16::MAX.into())?;
    let sweeps = sweeps.one_each("sweeps_made", ticks, "tick")?;
    Ok(sweeps.into_iter().map(|count| count as u16).collect())
}
