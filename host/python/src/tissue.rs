//! `Tissue`: a body that is advanced one tick at a time, without a server.

use std::ops::RangeInclusive;
use std::sync::Arc;

use chaincell_client::contacts::Contact;
use chaincell_host::engine::tissue::TissueEngine;
use chaincell_host::files::recording::Recording;
use chaincell_kernel::TOOLS_MAX;
use chaincell_kernel::trace::Command;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::reals;
use crate::contacts::Contacts;
use crate::errors::Class;
use crate::given::offline;
use crate::live::Live;
use crate::model::{Model, rows};
use crate::numbers::{Arg, bytes, object, real, whole};
use crate::output::Output;
use crate::poses::{Engaged, Tick};
use crate::stress::Stress;
use crate::surface::Surface;
use crate::turns::{Turn, Turns};

/// Numbers of tools.
pub(crate) const TOOL: RangeInclusive<u32> = 0..=TOOLS_MAX as u32 - 1;
/// Ticks in which a tool lets go.
pub(crate) const LET_GO_TICKS: RangeInclusive<u16> = 1..=u16::MAX;
/// Numbers of pins.
pub(crate) const PIN: RangeInclusive<u16> = 0..=u16::MAX;

/// The stiffness of a pin \[N/m\], infinite for a rigid one.
pub(crate) fn stiffness(given: Option<&Bound<'_, PyAny>>) -> PyResult<f32> {
    given.map_or(Ok(f32::INFINITY), |given| Ok(real("stiffness_n_per_m", given)? as f32))
}

/// The point \[m\], the radius \[m\] and the stiffness \[N/m\] of a pin at a place.
pub(crate) fn place(
    point_m: &Bound<'_, PyAny>,
    radius_m: &Bound<'_, PyAny>,
    stiffness_n_per_m: Option<&Bound<'_, PyAny>>,
) -> PyResult<([f32; 3], f32, f32)> {
    let stiffness_n_per_m = stiffness(stiffness_n_per_m)?;
    let given = reals("point_m", point_m)?;
    let [x, y, z] = given.values[..] else {
        return Err(given.wrong_shape("point_m", "(3,): x, y, z [m]"));
    };
    let point_m = [x, y, z].map(|x| x as f32);
    let radius_m = real("radius_m", radius_m)? as f32;
    Ok((point_m, radius_m, stiffness_n_per_m))
}

/// A body with its tools, advanced by `tick` without a server. Threads may share it: each call
/// waits for its turn.
///
/// - `model`: a `Model`.
/// - `options`: as of `chaincell run`, with their units, see `chaincell.options.TissueOptions`.
///
/// Raises `ArgumentError` for a wrong value, a contact that the model does not have, or `force_error` where no error
/// of a force is known.
///
/// >>> tissue = chaincell.Tissue(model, contact="probe:0.012", sweeps=2)
/// >>> output = tissue.tick([0.0, 0.0, 0.07])
/// >>> tissue.ticks, output.force_n.shape
/// (1, (3,))
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Tissue {
    live: Turns<Live>,
    /// What a trace of it begins with: a snapshot belongs to it.
    begun: Vec<u8>,
    /// The `Model` of the body.
    #[pyo3(get)]
    model: Py<Model>,
}

impl Tissue {
    /// The tissue, for this thread alone. Not while attached to Python: another thread may have it and
    /// wait for Python.
    fn live(&self) -> PyResult<Turn<'_, Live>> {
        self.live.take()
    }
}

#[pymethods]
impl Tissue {
    /// Puts a model at rest, with its tools outside.
    #[new]
    #[pyo3(signature = (model, **options))]
    fn new(
        py: Python<'_>,
        model: &Bound<'_, PyAny>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let model = object::<Model>("model", "a chaincell.Model", model)?;
        let options = offline(options)?;
        let body = Arc::clone(&model.get().body);
        let (live, begun) = py.detach(|| {
            let mut live = Live::new(&body, &options)?;
            let begun = live.with(|staged| {
                let (engine, stage) = (staged.engine(), staged.settings());
                Recording::begin(engine, engine.scheme(), options.numbers(), stage)
            });
            PyResult::Ok((live, begun.map_err(|why| Class::Argument.host(why))?))
        })?;
        let model = model.clone().unbind();
        Ok(Self { live: Turns::new(live), begun: begun.bytes().to_vec(), model })
    }

    /// Advances the tissue by a millisecond, and returns the `Output`.
    ///
    /// - `pose`: position [m], (3,), or with a unit quaternion x, y, z, w behind it, (7,); of several
    ///   tools (tools, 3) or (tools, 7).
    /// - `engaged`: whether the tool acts on the tissue; of several tools (tools,).
    /// - `opening_rad`: opening angle of scissors [rad], 0 to pi; of several tools (tools,). Closed by default.
    /// - `sweeps`: repeats a tick of a session that made fewer sweeps than `sweeps` of the tissue.
    ///
    /// Raises `PoseError` for a pose that is none, `ArgumentError` for other values; no tick is made then.
    ///
    /// >>> tissue.tick([0.0, 0.0, 0.05], engaged=True).force_n.shape
    /// (3,)
    #[pyo3(
        signature = (pose, engaged=Engaged::All(true), *, opening_rad=None, sweeps=None),
        text_signature = "($self, pose, engaged=True, *, opening_rad=None, sweeps=None)"
    )]
    fn tick(
        &self,
        py: Python<'_>,
        pose: &Bound<'_, PyAny>,
        engaged: Engaged<'_>,
        opening_rad: Option<&Bound<'_, PyAny>>,
        sweeps: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Output> {
        let tick = Tick::of(pose, &engaged, opening_rad)?;
        let sweeps = sweeps.map(|given| whole("sweeps", given, 0..=u16::MAX)).transpose()?;
        py.detach(|| {
            let mut live = self.live()?;
            live.check(&tick, sweeps)?;
            Ok(live.tick(&tick, sweeps))
        })
    }

    /// Puts the tissue back to rest, its tools released.
    ///
    /// >>> tissue.reset()
    /// >>> tissue.ticks
    /// 0
    fn reset(&self, py: Python<'_>) -> PyResult<()> {
        py.detach(|| {
            let mut live = self.live()?;
            live.command(&Command::Reset)?;
            live.ticks = 0;
            Ok(())
        })
    }

    /// Makes a tool hold what it touches, until it lets go or is not engaged.
    ///
    /// `tool` is its number from 0. Raises `Refused` where it touches nothing.
    ///
    /// >>> tissue.grip()
    #[pyo3(signature = (tool=Arg::Default(0)), text_signature = "($self, tool=0)")]
    fn grip(&self, py: Python<'_>, tool: Arg<'_, u32>) -> PyResult<()> {
        let tool = tool.whole("tool", TOOL)?;
        py.detach(|| self.live()?.command(&Command::Grip { tool }))
    }

    /// Makes a tool let go; its pull falls to 0.
    ///
    /// - `tool`: its number from 0.
    /// - `ticks`: length of the fall in ticks, 1 to 65,535.
    ///
    /// Raises `Refused` where it holds nothing.
    ///
    /// >>> tissue.grip()
    /// >>> tissue.let_go(ticks=20)
    #[pyo3(
        signature = (tool=Arg::Default(0), ticks=Arg::Default(20)),
        text_signature = "($self, tool=0, ticks=20)"
    )]
    fn let_go(&self, py: Python<'_>, tool: Arg<'_, u32>, ticks: Arg<'_, u16>) -> PyResult<()> {
        let (tool, ticks) = (tool.whole("tool", TOOL)?, ticks.whole("ticks", LET_GO_TICKS)?);
        py.detach(|| self.live()?.command(&Command::LetGo { tool, ticks }))
    }

    /// Pins the surface around a point where it is now: it is held in the world. Returns the pin's number.
    ///
    /// - `point_m`: the point [m], (3,).
    /// - `radius_m`: radius around it [m].
    /// - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.
    ///
    /// Pinning makes no force. Raises `Refused` where no surface is near enough, or without tools.
    ///
    /// >>> pin = tissue.pin_at([0.0, 0.0, 0.05], 0.02)
    /// >>> pin in tissue.pins
    /// True
    #[pyo3(
        signature = (point_m, radius_m, stiffness_n_per_m=None),
        text_signature = "($self, point_m, radius_m, stiffness_n_per_m=None)"
    )]
    fn pin_at(
        &self,
        py: Python<'_>,
        point_m: &Bound<'_, PyAny>,
        radius_m: &Bound<'_, PyAny>,
        stiffness_n_per_m: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<u16> {
        let (point_m, radius_m, stiffness_n_per_m) = place(point_m, radius_m, stiffness_n_per_m)?;
        py.detach(|| {
            let mut live = self.live()?;
            let done = live
                .with(|staged| staged.engine_mut().pin_at(point_m, radius_m, stiffness_n_per_m));
            done.map_err(|why| Class::Refused.error(why.to_string()))
        })
    }

    /// Pins what a tool grips, or what it touches, where it is now. Returns the pin's number.
    ///
    /// - `tool`: its number from 0. It keeps its grip: `let_go` passes its pull to the pin.
    /// - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.
    ///
    /// Raises `Refused` where it touches nothing.
    ///
    /// >>> pin = tissue.pin(tool=0)
    #[pyo3(
        signature = (tool=Arg::Default(0), stiffness_n_per_m=None),
        text_signature = "($self, tool=0, stiffness_n_per_m=None)"
    )]
    fn pin(
        &self,
        py: Python<'_>,
        tool: Arg<'_, u32>,
        stiffness_n_per_m: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<u16> {
        let tool = tool.whole("tool", TOOL)? as usize;
        let stiffness_n_per_m = stiffness(stiffness_n_per_m)?;
        py.detach(|| {
            let mut live = self.live()?;
            let done = live.with(|staged| staged.engine_mut().pin_held(tool, stiffness_n_per_m));
            done.map_err(|why| Class::Refused.error(why.to_string()))
        })
    }

    /// Releases a pin; its force falls to 0, and it is gone.
    ///
    /// - `pin`: its number.
    /// - `ticks`: length of the fall in ticks, 1 to 65,535.
    ///
    /// Raises `Refused` where no pin has this number.
    ///
    /// >>> tissue.unpin(tissue.pin(), ticks=20)
    #[pyo3(
        signature = (pin, ticks=Arg::Default(20)),
        text_signature = "($self, pin, ticks=20)"
    )]
    fn unpin(&self, py: Python<'_>, pin: &Bound<'_, PyAny>, ticks: Arg<'_, u16>) -> PyResult<()> {
        let pin = whole("pin", pin, PIN)?;
        let ticks = ticks.whole("ticks", LET_GO_TICKS)?;
        py.detach(|| {
            let done = self.live()?.with(|staged| staged.engine_mut().unpin(pin, ticks));
            done.map_err(|why| Class::Refused.error(why.to_string()))
        })
    }

    /// Force of the tissue on a pin [N], float64 (3,); None without such a pin.
    ///
    /// `pin` is its number.
    ///
    /// >>> tissue.pin_force_n(tissue.pin())
    /// array([0., 0., 0.])
    fn pin_force_n<'py>(
        &self,
        py: Python<'py>,
        pin: &Bound<'_, PyAny>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let pin = whole("pin", pin, PIN)?;
        let output = py.detach(|| {
            PyResult::Ok(self.live()?.with(|staged| staged.engine_mut().pin_output(pin)))
        })?;
        // -0.0 becomes 0.0.
        let force_n = output.map(|of| <[f32; 3]>::from(of.force_n).map(|x| f64::from(x) + 0.0));
        Ok(force_n.map(|force_n| PyArray1::from_slice(py, &force_n)))
    }

    /// The numbers of the pins, in the order in which they were set.
    ///
    /// >>> pins = tissue.pins
    #[getter]
    fn pins(&self, py: Python<'_>) -> PyResult<Vec<u16>> {
        py.detach(|| Ok(self.live()?.with(|staged| staged.engine_mut().pins())))
    }

    /// Returns the whole state as bytes, for `restore`.
    ///
    /// >>> saved = tissue.snapshot()
    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| self.live()?.snapshot(&self.begun))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Takes over the state of a `snapshot`, bytes, of a tissue with the same model and options.
    ///
    /// Raises `SnapshotError` where it is damaged, or of another model, options or release.
    ///
    /// >>> tissue.restore(tissue.snapshot())
    fn restore(&self, py: Python<'_>, snapshot: &Bound<'_, PyAny>) -> PyResult<()> {
        let snapshot = bytes("snapshot", snapshot)?;
        py.detach(|| self.live()?.restore(&snapshot, &self.begun))
    }

    /// Torque of the tissue on the handles of a tool's scissors in the last tick [N m]; None without scissors.
    ///
    /// `tool` is its number from 0. Above 0 it resists closing.
    ///
    /// >>> tissue.opening_torque_n_m() is None
    /// True
    #[pyo3(signature = (tool=Arg::Default(0)), text_signature = "($self, tool=0)")]
    fn opening_torque_n_m(&self, py: Python<'_>, tool: Arg<'_, u32>) -> PyResult<Option<f32>> {
        let tool = tool.whole("tool", TOOL)? as usize;
        py.detach(|| Ok(self.live()?.with(|staged| staged.engine_mut().opening_torque_n_m(tool))))
    }

    /// Number of ticks since it was at rest.
    #[getter]
    fn ticks(&self, py: Python<'_>) -> PyResult<u64> {
        py.detach(|| Ok(self.live()?.ticks))
    }

    /// Hash of the state, 16 hexadecimal digits: of equal states alone it is equal.
    #[getter]
    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        py.detach(|| Ok(self.live()?.state_hash()))
    }

    /// Cuts since it was at rest, by the names of `chaincell run`; None for a model that cannot be cut.
    ///
    /// `cut_area_m2` is the area that blades have swept [m2], `cut_work_j` the work that it took to part the tissue
    /// there [J]; `opened_faces` counts the faces between tetrahedra that are open, `copied_cells` the copies of
    /// split cells, `refused_splits` the splits for which there was no spare cell, `loose_pieces` the pieces that
    /// hang on no fixed cell, `loose_cells` their cells. Of a model that tears `torn_cells` counts the cells at which
    /// it has torn by itself.
    ///
    /// >>> tissue.cuts is None
    /// True
    #[getter]
    fn cuts<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let cut = py.detach(|| PyResult::Ok(self.live()?.cuts()))?;
        let Some(cut) = cut else { return Ok(None) };
        let said = PyDict::new(py);
        said.set_item("cut_area_m2", cut.cut_area_m2)?;
        said.set_item("cut_work_j", cut.cut_work_j)?;
        said.set_item("opened_faces", cut.opened_faces)?;
        said.set_item("copied_cells", cut.copied_cells)?;
        said.set_item("refused_splits", cut.refused_splits)?;
        let [pieces, cells, torn] = [cut.loose_pieces, cut.loose_cells, cut.torn_cells];
        for (name, count) in
            [("loose_pieces", pieces), ("loose_cells", cells), ("torn_cells", torn)]
        {
            if let Some(count) = count {
                said.set_item(name, count)?;
            }
        }
        Ok(Some(said))
    }

    /// Energy that its branches have relaxed since it was at rest [J]; None for a model baked without branches.
    ///
    /// >>> tissue.relaxed_j is None
    /// True
    #[getter]
    fn relaxed_j(&self, py: Python<'_>) -> PyResult<Option<f32>> {
        py.detach(|| Ok(self.live()?.relaxed_j()))
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let checksum = self.model.get().checksum();
        Ok(format!("<chaincell.Tissue: of model {checksum}, tick {}>", self.ticks(py)?))
    }

    /// Positions of the nodes [m], float32 (nodes, 3), in the order of `Model.node_ids`, a copy.
    #[getter]
    fn positions_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let positions_m = py.detach(|| PyResult::Ok(self.live()?.positions_m()))?;
        Ok(rows(positions_m).into_pyarray(py))
    }

    /// Returns strain and stress at the nodes, as `Stress`; None for a body of links.
    ///
    /// A tick computes none of it; the call takes as long as some twenty ticks.
    ///
    /// >>> tissue.stress().stretches.shape == tissue.positions_m.shape
    /// True
    fn stress(&self, py: Python<'_>) -> PyResult<Option<Stress>> {
        py.detach(|| {
            let mut live = self.live()?;
            let stresses = live.with(|staged| staged.engine_mut().node_stresses());
            Ok(stresses.map(|stresses| Stress { stresses, tick: live.ticks }))
        })
    }

    /// Returns the surface as it is cut now, as `Surface`; None for a model that cannot be cut.
    ///
    /// >>> tissue.surface() is None
    /// True
    fn surface(&self, py: Python<'_>) -> PyResult<Option<Surface>> {
        py.detach(|| Ok(self.live()?.surface()))
    }

    /// Returns what the tools touch, as `Contacts`; nothing for held cells.
    ///
    /// >>> len(tissue.contacts()) > 0
    /// True
    fn contacts(&self, py: Python<'_>) -> PyResult<Contacts> {
        py.detach(|| {
            let mut live = self.live()?;
            let mut contacts = Vec::new();
            live.with(|staged| {
                staged.read_contacts(&mut |node, of| {
                    contacts.push(Contact {
                        tool: of.tool.into(),
                        part: of.part.into(),
                        node,
                        position_m: of.position_m,
                        normal_n: of.normal_n,
                        tangential_n: of.tangential_n,
                        area_m2: of.area_m2,
                    });
                });
            });
            Ok(Contacts { contacts, tick: live.ticks })
        })
    }
}
