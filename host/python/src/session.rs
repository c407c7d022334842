//! `Session`: the client of `chaincell serve`.

use chaincell_client::clock::{MILLISECOND_NS, now_ns, sleep_until_ns};
use chaincell_client::command::SWEEPS_MAX;
use chaincell_client::payload::ReplyMessage;
use chaincell_client::services::Domain;
use chaincell_client::stress::StressHeader;
use chaincell_client::wait::Wait;
use chaincell_client::{Client, Command, MS_MAX, Options, Outcome, Role};
use chaincell_kernel::{Choice, Cutting, Unloading};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::answer::Answer;
use crate::contacts::Contacts;
use crate::errors::{self, Class};
use crate::numbers::{Arg, real, text, whole};
use crate::poses::{Engaged, Tick};
use crate::process::{self, Owned};
use crate::signals::{LOOK, Signals, span_ns};
use crate::state::State;
use crate::stress::SessionStress;
use crate::tissue::{LET_GO_TICKS, PIN, TOOL, place, stiffness};
use crate::turns::{Turn, Turns};

/// A handle on a running scene of `chaincell serve`: its controller, or a viewer. Threads may share it:
/// each call waits for its turn. `with` closes it.
///
/// - `scene`: the name after `--scene`; None for the unnamed one.
/// - `role`: "controller", which sends poses, or "viewer", which looks and commands.
/// - `wait`: how a step waits for its answer, "hybrid", "spin" or "event".
/// - `server_wait_s`: longest wait for the server [s].
/// - `watchdog_ms`, `ramp_ms`: time without an answer after which the force falls, and that of the
///   fall [ms].
/// - `lost_s`: time without an answer after which a step raises `NoServer` [s]; None for never.
///
/// Raises `NoServer` without a server in time, `Taken` beside another controller, `Full`,
/// `OtherVersion` or `NoPermission`.
///
/// >>> session = chaincell.Session("left")
/// >>> force_n = session.step([0.0, 0.0, 0.08], engaged=False)  # first released
/// >>> force_n.shape
/// (3,)
#[pyclass(frozen, weakref, module = "chaincell")]
pub(crate) struct Session {
    held: Turns<Held>,
    /// The process that opened it.
    process: u32,
    /// Name of the scene, None for the unnamed one.
    #[pyo3(get)]
    scene: Option<String>,
    /// Time without an answer after which a step raises \[ns\].
    lost_ns: Option<u64>,
}

struct Held {
    client: Owned<Client>,
    answer: Option<Answer>,
}

/// The reply to a command of a session.
///
/// >>> reply = session.reset()
/// >>> len(reply.state_hash)
/// 16
#[pyclass(frozen, module = "chaincell")]
pub(crate) struct Reply {
    message: ReplyMessage,
    pin: Option<u32>,
}

#[pymethods]
impl Reply {
    /// Number of the last tick answered before the command, 0 before the first.
    #[getter]
    fn tick(&self) -> u64 {
        self.message.tick
    }

    /// Number of ticks answered before the command since the server began.
    #[getter]
    fn ticks_answered(&self) -> u64 {
        self.message.ticks_answered
    }

    /// Hash of the state after the command, 16 hexadecimal digits.
    #[getter]
    fn state_hash(&self) -> String {
        format!("{:016x}", self.message.state_hash)
    }

    /// Number of the pin that the command set; `None` for other commands.
    #[getter]
    fn pin(&self) -> Option<u32> {
        self.pin
    }

    fn __repr__(&self) -> String {
        format!(
            "<chaincell.Reply: after tick {}, state hash {}>",
            self.message.tick,
            self.state_hash()
        )
    }
}

impl Session {
    /// The handle, for this thread alone; not while attached to Python.
    fn held(&self) -> PyResult<Turn<'_, Held>> {
        if self.process != std::process::id() {
            return Err(process::forked());
        }
        self.held.take()
    }

    /// Waits for something new to look at, at most so long.
    fn look<T: Send>(
        &self,
        py: Python<'_>,
        timeout_s: Arg<'_, f64>,
        look: impl Fn(&mut Client) -> chaincell_client::Result<Option<T>> + Sync,
    ) -> PyResult<Option<T>> {
        let wait_ns = span_ns("timeout_s", timeout_s)?;
        py.detach(|| {
            let end_ns = now_ns().saturating_add(wait_ns);
            let signals = Signals::new();
            loop {
                // Others may step between two looks.
                let found = look(self.held()?.client.get()?).map_err(errors::client)?;
                let now_ns = now_ns();
                if found.is_some() || now_ns >= end_ns {
                    return Ok(found);
                }
                if signals.stop() {
                    signals.raised()?;
                }
                sleep_until_ns(end_ns.min(now_ns + MILLISECOND_NS));
            }
        })
    }

    fn command(
        &self,
        py: Python<'_>,
        command: &Command,
        timeout_s: Arg<'_, f64>,
    ) -> PyResult<Reply> {
        let wait_ns = span_ns("timeout_s", timeout_s)?;
        py.detach(|| {
            let signals = Signals::new();
            let mut held = self.held()?;
            let client = held.client.get()?;
            let reply = client.command_unless(command, wait_ns, || signals.stop());
            signals.raised()?;
            let message = reply.map_err(errors::client)?;
            let sets_pin = matches!(command, Command::Pin { .. } | Command::PinAt { .. });
            Ok(Reply { message, pin: sets_pin.then_some(message.reason) })
        })
    }

    /// Where no answer has come for long the server is gone.
    fn check_lost(&self, answer: &Answer) -> PyResult<()> {
        let age_ns = answer.of.age_ns;
        if answer.outcome == Outcome::Answered || self.lost_ns.is_none_or(|most| age_ns < most) {
            return Ok(());
        }
        let scene =
            self.scene.as_ref().map_or("the unnamed scene".into(), |of| format!("scene {of}"));
        Err(Class::NoServer.error(format!(
            "no answer on {scene} for {:.1} s, the force is 0: the server has ended or stands still; \
             start chaincell serve again, steps then go on",
            age_ns as f64 * 1e-9
        )))
    }
}

impl Held {
    /// Sends the poses and waits for their answer, at most so long.
    fn step(&mut self, tick: &Tick, wait_ns: u64) -> PyResult<Answer> {
        let client = self.client.get()?;
        let number = client.send(&tick.poses).map_err(errors::client)?;
        let end_ns = now_ns().saturating_add(wait_ns);
        let signals = Signals::new();
        let (outcome, of) = loop {
            let look_ns = LOOK.as_nanos() as u64;
            let wait_ns = end_ns.saturating_sub(now_ns()).min(look_ns);
            let (outcome, of) = client.receive(number, wait_ns).map_err(errors::client)?;
            if outcome == Outcome::Answered || now_ns() >= end_ns {
                break (outcome, of);
            }
            if signals.stop() {
                signals.raised()?;
            }
        };
        let (tools, is_several) = (tick.poses.len(), tick.is_several);
        let answer = Answer { of, outcome, tools, is_several };
        self.answer = Some(answer.clone());
        Ok(answer)
    }
}

/// A word that names one of the choices.
fn choice<T: Choice>(name: &str, word: &str) -> PyResult<T> {
    T::from_name(word).ok_or_else(|| {
        let words: Vec<&str> = T::ALL.iter().map(|of| of.name()).collect();
        Class::Argument.error(format!("`{name}` \"{word}\": give {}", words.join(", ")))
    })
}

#[pymethods]
impl Session {
    /// Opens a scene, and waits for its server.
    #[new]
    #[pyo3(
        signature = (scene=None, *, role=Arg::Default("controller"), wait=Arg::Default("hybrid"),
            server_wait_s=Arg::Default(10.0),
            watchdog_ms=Arg::Default(20), ramp_ms=Arg::Default(20), lost_s=Some(Arg::Default(1.0))),
        text_signature = "(scene=None, *, role='controller', wait='hybrid', server_wait_s=10.0, watchdog_ms=20, ramp_ms=20, lost_s=1.0)"
    )]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments")]
    fn new(
        py: Python<'_>,
        scene: Option<&Bound<'_, PyAny>>,
        role: Arg<'_, &'static str>,
        wait: Arg<'_, &'static str>,
        server_wait_s: Arg<'_, f64>,
        watchdog_ms: Arg<'_, u32>,
        ramp_ms: Arg<'_, u32>,
        lost_s: Option<Arg<'_, f64>>,
    ) -> PyResult<Self> {
        let scene = scene.map(|given| text("scene", given)).transpose()?;
        let role = role.text("role")?;
        let role = match role.as_str() {
            "controller" => Role::Controller,
            "viewer" => Role::Viewer,
            _ => {
                let text = format!("`role` \"{role}\": give controller or viewer");
                return Err(Class::Argument.error(text));
            }
        };
        let options = Options {
            scene: scene.clone(),
            domain: Domain::default(),
            role,
            wait: choice::<Wait>("wait", &wait.text("wait")?)?,
            server_wait_ns: span_ns("server_wait_s", server_wait_s)?,
            watchdog_ms: watchdog_ms.whole("watchdog_ms", 0..=MS_MAX)?,
            ramp_ms: ramp_ms.whole("ramp_ms", 0..=MS_MAX)?,
        };
        let lost_ns = lost_s.map(|seconds| span_ns("lost_s", seconds)).transpose()?;
        let client = py.detach(|| {
            let signals = Signals::new();
            let client = Client::open_unless(&options, || signals.stop());
            signals.raised()?;
            client.map_err(errors::client)
        })?;
        let held = Held { client: Owned::new(client), answer: None };
        Ok(Self { held: Turns::new(held), process: std::process::id(), scene, lost_ns })
    }

    /// Sends the pose of the tool, or of several, and returns the force to show [N], float32 (3,), or
    /// (tools, 3).
    ///
    /// - `pose`: position [m], (3,), or with a unit quaternion x, y, z, w behind it, (7,); of several
    ///   tools (tools, 3) or (tools, 7).
    /// - `engaged`: whether the tool acts on the tissue; of several tools (tools,). A tool has no force
    ///   until one of its poses was not engaged.
    /// - `opening_rad`: opening angle of scissors [rad], 0 to pi; of several tools (tools,). Closed by default.
    /// - `timeout_s`: longest wait for the answer to this pose [s].
    ///
    /// Raises `PoseError` for a pose that is none, and nothing is sent then; `NoServer` after `lost_s`
    /// without an answer; `Closed`.
    ///
    /// >>> force_n = session.step([0.0, 0.0, 0.0795])
    #[pyo3(
        signature = (pose, engaged=Engaged::All(true), *, opening_rad=None, timeout_s=Arg::Default(0.02)),
        text_signature = "($self, pose, engaged=True, *, opening_rad=None, timeout_s=0.02)"
    )]
    fn step<'py>(
        &self,
        py: Python<'py>,
        pose: &Bound<'py, PyAny>,
        engaged: Engaged<'py>,
        opening_rad: Option<&Bound<'py, PyAny>>,
        timeout_s: Arg<'py, f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let tick = Tick::of(pose, &engaged, opening_rad)?;
        let wait_ns = span_ns("timeout_s", timeout_s)?;
        let answer = py.detach(|| self.held()?.step(&tick, wait_ns))?;
        self.check_lost(&answer)?;
        answer.forces(py)
    }

    /// The whole `Answer` to the last step; None before the first.
    #[getter]
    fn answer(&self, py: Python<'_>) -> PyResult<Option<Answer>> {
        py.detach(|| Ok(self.held()?.answer.clone()))
    }

    /// Returns the newest `State` that was not taken yet; None where none comes within `timeout_s` [s].
    ///
    /// Raises `Full` where two states are still held, `Closed`.
    ///
    /// >>> state = session.state(timeout_s=1.0)
    #[pyo3(signature = (timeout_s=Arg::Default(1.0)), text_signature = "($self, timeout_s=1.0)")]
    fn state(&self, py: Python<'_>, timeout_s: Arg<'_, f64>) -> PyResult<Option<State>> {
        Ok(self.look(py, timeout_s, Client::state)?.map(State::new))
    }

    /// Returns the newest `Contacts` that were not taken yet; None where none come within `timeout_s`
    /// [s]. Raises `Closed`.
    ///
    /// >>> contacts = session.contacts(timeout_s=1.0)
    #[pyo3(signature = (timeout_s=Arg::Default(1.0)), text_signature = "($self, timeout_s=1.0)")]
    fn contacts(&self, py: Python<'_>, timeout_s: Arg<'_, f64>) -> PyResult<Option<Contacts>> {
        let found = self.look(py, timeout_s, |client| {
            let view = client.contacts()?;
            Ok(view.map(|view| (view.header().tick, view.rows().to_vec())))
        })?;
        Ok(found.map(|(tick, contacts)| Contacts { contacts, tick }))
    }

    /// Returns the newest `SessionStress` that was not taken yet; None where none comes within `timeout_s` [s]. The
    /// server computes it only while it is read, and not of a body of links. Raises `Closed`.
    ///
    /// >>> stress = session.stress(timeout_s=1.0)
    #[pyo3(signature = (timeout_s=Arg::Default(1.0)), text_signature = "($self, timeout_s=1.0)")]
    fn stress(&self, py: Python<'_>, timeout_s: Arg<'_, f64>) -> PyResult<Option<SessionStress>> {
        self.look(py, timeout_s, |client| {
            let view = client.stress()?;
            Ok(view.map(|view| {
                let StressHeader { tick, first_tick, .. } = view.header();
                SessionStress { rows: view.rows().to_vec(), tick, first_tick }
            }))
        })
    }

    /// Pauses: poses are answered with force 0 from here on, and no cell moves.
    ///
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> reply = session.pause()
    #[pyo3(signature = (*, timeout_s=Arg::Default(5.0)), text_signature = "($self, *, timeout_s=5.0)")]
    fn pause(&self, py: Python<'_>, timeout_s: Arg<'_, f64>) -> PyResult<Reply> {
        self.command(py, &Command::Pause, timeout_s)
    }

    /// Goes on after a pause.
    ///
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> reply = session.resume()
    #[pyo3(signature = (*, timeout_s=Arg::Default(5.0)), text_signature = "($self, *, timeout_s=5.0)")]
    fn resume(&self, py: Python<'_>, timeout_s: Arg<'_, f64>) -> PyResult<Reply> {
        self.command(py, &Command::Resume, timeout_s)
    }

    /// Puts the tissue back to rest, its tools released.
    ///
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> reply = session.reset()
    #[pyo3(signature = (*, timeout_s=Arg::Default(5.0)), text_signature = "($self, *, timeout_s=5.0)")]
    fn reset(&self, py: Python<'_>, timeout_s: Arg<'_, f64>) -> PyResult<Reply> {
        self.command(py, &Command::Reset, timeout_s)
    }

    /// Saves the session beside its trace, as TRACE.TICK.snapshot; the server needs `--record`.
    ///
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> reply = session.snapshot()
    #[pyo3(signature = (*, timeout_s=Arg::Default(5.0)), text_signature = "($self, *, timeout_s=5.0)")]
    fn snapshot(&self, py: Python<'_>, timeout_s: Arg<'_, f64>) -> PyResult<Reply> {
        self.command(py, &Command::Snapshot { checksum: 0 }, timeout_s)
    }

    /// Makes a tool, by its number from 0, hold what it touches.
    ///
    /// `tool` is the number. Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s`
    /// [s].
    ///
    /// >>> try:
    /// ...     session.grip(tool=0)
    /// ... except chaincell.Refused:
    /// ...     print("it touches nothing")
    /// it touches nothing
    #[pyo3(
        signature = (tool=Arg::Default(0), *, timeout_s=Arg::Default(5.0)),
        text_signature = "($self, tool=0, *, timeout_s=5.0)"
    )]
    fn grip(&self, py: Python<'_>, tool: Arg<'_, u32>, timeout_s: Arg<'_, f64>) -> PyResult<Reply> {
        let tool = tool.whole("tool", TOOL)?;
        self.command(py, &Command::Grip { tool }, timeout_s)
    }

    /// Makes a tool let go; its pull falls to 0.
    ///
    /// - `tool`: its number from 0.
    /// - `ticks`: length of the fall in ticks, 1 to 65,535.
    ///
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> try:
    /// ...     session.let_go(tool=0, ticks=20)
    /// ... except chaincell.Refused:
    /// ...     print("it holds nothing")
    /// it holds nothing
    #[pyo3(
        signature = (tool=Arg::Default(0), ticks=Arg::Default(20), *, timeout_s=Arg::Default(5.0)),
        text_signature = "($self, tool=0, ticks=20, *, timeout_s=5.0)"
    )]
    fn let_go(
        &self,
        py: Python<'_>,
        tool: Arg<'_, u32>,
        ticks: Arg<'_, u16>,
        timeout_s: Arg<'_, f64>,
    ) -> PyResult<Reply> {
        let (tool, ticks) = (tool.whole("tool", TOOL)?, ticks.whole("ticks", LET_GO_TICKS)?);
        self.command(py, &Command::LetGo { tool, ticks }, timeout_s)
    }

    /// Pins what a tool grips, or what it touches, where it is now: it is held in the world.
    ///
    /// - `tool`: its number from 0.
    /// - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.
    ///
    /// The pin takes the lowest free number, from 0, which `pin` of the reply is.
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> try:
    /// ...     session.pin(tool=0)
    /// ... except chaincell.Refused:
    /// ...     print("it touches nothing")
    /// it touches nothing
    #[pyo3(
        signature = (tool=Arg::Default(0), stiffness_n_per_m=None, *, timeout_s=Arg::Default(5.0)),
        text_signature = "($self, tool=0, stiffness_n_per_m=None, *, timeout_s=5.0)"
    )]
    fn pin(
        &self,
        py: Python<'_>,
        tool: Arg<'_, u32>,
        stiffness_n_per_m: Option<&Bound<'_, PyAny>>,
        timeout_s: Arg<'_, f64>,
    ) -> PyResult<Reply> {
        let tool = tool.whole("tool", TOOL)?;
        let stiffness_n_per_m = stiffness(stiffness_n_per_m)?;
        self.command(py, &Command::Pin { tool, stiffness_n_per_m }, timeout_s)
    }

    /// Pins the surface around a point where it is now: it is held in the world.
    ///
    /// - `point_m`: the point [m], (3,).
    /// - `radius_m`: radius around it [m].
    /// - `stiffness_n_per_m`: stiffness of the pin [N/m]; rigid by default.
    ///
    /// The pin takes the lowest free number, from 0, which `pin` of the reply is.
    /// Raises `Refused` where no surface is near enough, or the server has no tools, `NoReply` without a reply within
    /// `timeout_s` [s].
    ///
    /// >>> try:
    /// ...     session.pin_at([0.0, 0.0, 1.0], 0.005)
    /// ... except chaincell.Refused:
    /// ...     print("no surface is near")
    /// no surface is near
    #[pyo3(
        signature = (point_m, radius_m, stiffness_n_per_m=None, *, timeout_s=Arg::Default(5.0)),
        text_signature = "($self, point_m, radius_m, stiffness_n_per_m=None, *, timeout_s=5.0)"
    )]
    fn pin_at(
        &self,
        py: Python<'_>,
        point_m: &Bound<'_, PyAny>,
        radius_m: &Bound<'_, PyAny>,
        stiffness_n_per_m: Option<&Bound<'_, PyAny>>,
        timeout_s: Arg<'_, f64>,
    ) -> PyResult<Reply> {
        let (point_m, radius_m, stiffness_n_per_m) = place(point_m, radius_m, stiffness_n_per_m)?;
        self.command(py, &Command::PinAt { point_m, radius_m, stiffness_n_per_m }, timeout_s)
    }

    /// Releases a pin; its force falls to 0, and it is gone.
    ///
    /// - `pin`: its number.
    /// - `ticks`: length of the fall in ticks, 1 to 65,535.
    ///
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> try:
    /// ...     session.unpin(0, ticks=20)
    /// ... except chaincell.Refused:
    /// ...     print("there is no such pin")
    /// there is no such pin
    #[pyo3(
        signature = (pin, ticks=Arg::Default(20), *, timeout_s=Arg::Default(5.0)),
        text_signature = "($self, pin, ticks=20, *, timeout_s=5.0)"
    )]
    fn unpin(
        &self,
        py: Python<'_>,
        pin: &Bound<'_, PyAny>,
        ticks: Arg<'_, u16>,
        timeout_s: Arg<'_, f64>,
    ) -> PyResult<Reply> {
        let (pin, ticks) = (whole("pin", pin, PIN)?, ticks.whole("ticks", LET_GO_TICKS)?);
        self.command(py, &Command::Unpin { pin, ticks }, timeout_s)
    }

    /// Sets one parameter of the tissue.
    ///
    /// - `sweeps`: sweeps of a tick, from 1 on.
    /// - `max_force_n`: largest force [N], inf for no limit.
    /// - `max_tool_step_m`: largest motion of held cells in a tick [m].
    /// - `unloading`: "off", "release" or "retreat".
    /// - `cut`: "on" or "off", whether blades cut and bodies tear.
    ///
    /// Raises `TypeError` for none or several of them, `ArgumentError` for a value out of range.
    /// Raises `Refused` where the server does not, `NoReply` without a reply within `timeout_s` [s].
    ///
    /// >>> reply = session.set(sweeps=6)
    #[pyo3(signature = (*, sweeps=None, max_force_n=None, max_tool_step_m=None, unloading=None, cut=None,
        timeout_s=Arg::Default(5.0)), text_signature = "($self, *, sweeps=None, max_force_n=None, \
        max_tool_step_m=None, unloading=None, cut=None, timeout_s=5.0)")]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments")]
    fn set(
        &self,
        py: Python<'_>,
        sweeps: Option<&Bound<'_, PyAny>>,
        max_force_n: Option<&Bound<'_, PyAny>>,
        max_tool_step_m: Option<&Bound<'_, PyAny>>,
        unloading: Option<&Bound<'_, PyAny>>,
        cut: Option<&Bound<'_, PyAny>>,
        timeout_s: Arg<'_, f64>,
    ) -> PyResult<Reply> {
        let unloading =
            unloading.map(|given| choice::<Unloading>("unloading", &text("unloading", given)?));
        let unloading = unloading.transpose()?;
        let cut = cut.map(|given| choice::<Cutting>("cut", &text("cut", given)?)).transpose()?;
        let above_0 = |name: &str, given: Option<&Bound<'_, PyAny>>, most: f32| {
            let Some(given) = given else { return Ok(None) };
            let value = real(name, given)? as f32;
            if value > 0.0 && value <= most {
                return Ok(Some(value));
            }
            Err(Class::Argument.error(format!("`{name}` {value}: must be above 0 and finite")))
        };
        let sweeps = sweeps.map(|given| whole("sweeps", given, 1..=SWEEPS_MAX)).transpose()?;
        let force = above_0("max_force_n", max_force_n, f32::INFINITY)?;
        let step = above_0("max_tool_step_m", max_tool_step_m, f32::MAX)?;
        let given = [
            sweeps.map(Command::Sweeps),
            force.map(Command::MaxForceN),
            step.map(Command::MaxToolStepM),
            unloading.map(Command::Unloading),
            cut.map(Command::Cut),
        ];
        let mut given = given.into_iter().flatten();
        match (given.next(), given.next()) {
            (Some(command), None) => self.command(py, &command, timeout_s),
            _ => Err(PyTypeError::new_err(
                "set() takes one of sweeps, max_force_n, max_tool_step_m, unloading and cut",
            )),
        }
    }

    /// Whether a server is registered on the scene; one that was killed may be for a while.
    #[getter]
    fn is_served(&self, py: Python<'_>) -> PyResult<bool> {
        py.detach(|| Ok(self.held()?.client.get()?.is_served()))
    }

    /// Number of times that no answer came for the watchdog's time, and of answers to somebody else.
    #[getter]
    fn silences(&self, py: Python<'_>) -> PyResult<(u64, u64)> {
        py.detach(|| {
            let counts = self.held()?.client.get()?.counts().map_err(errors::client)?;
            Ok((counts.0, counts.1))
        })
    }

    /// Whether the session was closed.
    #[getter]
    fn is_closed(&self, py: Python<'_>) -> PyResult<bool> {
        if self.process != std::process::id() {
            return Ok(true);
        }
        py.detach(|| Ok(self.held()?.client.is_closed()))
    }

    /// Leaves the scene; a second time it does nothing.
    ///
    /// >>> session.close()
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        if self.process != std::process::id() {
            return Ok(());
        }
        py.detach(|| {
            self.held()?.client.close();
            Ok(())
        })
    }

    fn __enter__(slf: Py<Self>, py: Python<'_>) -> PyResult<Py<Self>> {
        py.detach(|| slf.get().held()?.client.get().map(|_| ()))?;
        Ok(slf)
    }

    #[pyo3(signature = (*_why))]
    fn __exit__(&self, py: Python<'_>, _why: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<()> {
        self.close(py)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let scene = self.scene.as_deref().unwrap_or("unnamed");
        let is = self.is_closed(py).map_or("in use", |is| if is { "closed" } else { "open" });
        format!("<chaincell.Session: scene {scene}, {is}>")
    }
}
