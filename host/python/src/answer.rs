//! `Answer`: all that a server said to a pose, and what the client says of it.

use chaincell_client::{Answer as Heard, Outcome};
use pyo3::prelude::*;

use crate::output::{flags, notes, vectors};

/// The whole answer to a step of a session, from `Session.answer`; its arrays are copies.
///
/// >>> answer = session.answer
/// >>> answer.force_n.shape
/// (3,)
#[pyclass(frozen, module = "chaincell")]
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    pub(crate) of: Heard,
    pub(crate) outcome: Outcome,
    /// Tools that the step moved, and whether it was given several.
    pub(crate) tools: usize,
    pub(crate) is_several: bool,
}

impl Answer {
    pub(crate) fn forces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let each = self.of.tools.iter().take(self.tools);
        vectors(py, each.map(|felt| felt.force_n).collect(), self.is_several)
    }
}

#[pymethods]
impl Answer {
    /// "answered", "no answer" (the last force counts) or "silent" (the force falls to 0, or is 0).
    #[getter]
    fn outcome(&self) -> &'static str {
        match self.outcome {
            Outcome::Answered => "answered",
            Outcome::NoAnswer => "no answer",
            Outcome::Silent => "silent",
        }
    }

    /// Force to show [N], float32 (3,), or of each of several tools, (tools, 3).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.forces(py)
    }

    /// Torque on the tool about its position [N m], float32 (3,), or on each of several, (tools, 3).
    #[getter]
    fn torque_n_m<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let each = self.of.tools.iter().take(self.tools);
        vectors(py, each.map(|felt| felt.torque_n_m).collect(), self.is_several)
    }

    /// Estimated error of the force on each tool [N], before its limit; None where it is not known, where an output
    /// stage answers another force than the tissue's, and while another force than the server's is shown.
    #[getter]
    fn force_error_n(&self) -> Vec<Option<f32>> {
        self.of.force_error_n.iter().take(self.tools).copied().collect()
    }

    /// Estimated error of the torque on each tool [N m], likewise; None for held cells too.
    #[getter]
    fn torque_error_n_m(&self) -> Vec<Option<f32>> {
        self.of.torque_error_n_m.iter().take(self.tools).copied().collect()
    }

    /// Number of held cells, or of triangles in contact with a tool.
    #[getter]
    fn contacts(&self) -> u32 {
        self.of.tools.iter().take(self.tools).map(|felt| felt.contacts).sum()
    }

    /// Limits and faults that acted at each tool, a list of `Flags`.
    #[getter]
    fn tool_flags<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        self.of.tools.iter().take(self.tools).map(|felt| flags(py, felt.flags)).collect()
    }

    /// Limits and faults that acted during the tick, `Flags`.
    #[getter]
    fn flags<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        flags(py, self.of.flags)
    }

    /// Notes of the client itself, `Notes`.
    #[getter]
    fn notes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        notes(py, self.of.notes.0)
    }

    /// Number of the tick answered last, 0 before the first.
    #[getter]
    fn tick(&self) -> u64 {
        self.of.tick
    }

    /// Number of the tick whose pose the force is of.
    #[getter]
    fn force_tick(&self) -> u64 {
        self.of.force_tick
    }

    /// Number of answers since the session was opened.
    #[getter]
    fn answers(&self) -> u64 {
        self.of.answers
    }

    /// Number of the server's session, another one for each.
    #[getter]
    fn session_id(&self) -> u64 {
        self.of.session_id
    }

    /// Hash of the state after the tick, 16 hexadecimal digits; None where none was taken.
    #[getter]
    fn state_hash(&self) -> Option<String> {
        (self.of.state_hash != 0).then(|| format!("{:016x}", self.of.state_hash))
    }

    /// Certified upper bound of the elastic energy [J].
    #[getter]
    fn energy_j(&self) -> f32 {
        self.of.energy_j
    }

    /// Number of sweeps made in the tick, 0 in a late one.
    #[getter]
    fn sweeps(&self) -> u32 {
        self.of.sweeps
    }

    /// Time that the tick took the server [ns].
    #[getter]
    fn step_ns(&self) -> u32 {
        self.of.step_ns
    }

    /// Time from sending the pose to its answer [ns].
    #[getter]
    fn round_trip_ns(&self) -> u64 {
        self.of.round_trip_ns
    }

    /// Time since the answer came [ns].
    #[getter]
    fn age_ns(&self) -> u64 {
        self.of.age_ns
    }

    fn __repr__(&self) -> String {
        let force_n = self.of.tools.first().map(|felt| felt.force_n).unwrap_or_default();
        format!("<chaincell.Answer: tick {}, {}, {force_n:?} N>", self.of.tick, self.outcome())
    }
}
