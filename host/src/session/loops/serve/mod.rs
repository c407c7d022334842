//! Serves a tissue: one tick and one answer for each pose.
//!
//! If poses have piled up, only the newest one gets sweeps and so a new force. The ones before it move the
//! tool without a sweep, and their answers repeat the present force, see
//! [`Budget::LATE`](chaincell_kernel::Budget::LATE). With a fixed number of sweeps all poses are executed in
//! full, and the force falls to 0 while they pile up.
//!
//! One thread receives, ticks and sends. A second thread for shared memory would still be between each pose
//! and its answer. Instead, new readers are connected while no pose waits, so that only a reader that joins
//! during a tick delays that tick's answer (see [`PeerCost`](crate::session::loops::peers::PeerCost)). States
//! for viewers and commands are also handled while no pose waits.

mod answers;
mod arrived;
mod beside;
mod budget;
mod charge;
mod delay;
mod execute;
mod intake;
mod options;
mod overload;
mod rate;
mod session;
mod snapshots;
mod speed;
mod voice;
mod watcher;

use std::collections::VecDeque;

use chaincell_client::recording;
use iceoryx2::identifiers::UniquePublisherId;

use crate::engine::estimates::Estimates;
use crate::engine::flag_ticks::FlagTicks;
use crate::engine::stress_limit::StressLimit;
use crate::engine::tissue::TissueEngine;
use crate::error::Result;
use crate::interrupt;
use crate::session::ipc;
use crate::session::ipc::command::CommandServer;
use crate::session::ipc::contacts::ContactPublisher;
use crate::session::ipc::services::{QUEUE_MESSAGES, SceneServices};
use crate::session::ipc::serving::ServePorts;
use crate::session::ipc::state::StatePublisher;
use crate::session::ipc::stress::StressPublisher;
use crate::session::ipc::surface::SurfacePublisher;
use crate::session::loops::peers::{Call, PeerWatch};
use crate::session::loops::realtime::{self, Role};
use crate::session::loops::record::Recorder;
use crate::session::loops::wait::{Wait, Waiter};
use crate::session::timing::clock::{MILLISECOND_NS, PERIOD_NS, now_ns, sleep_until_ns, span_ns};
use crate::session::timing::histogram::Latencies;
use crate::terminal;

pub use arrived::Arrived;
pub use budget::SweepBudget;
use budget::TimeBudget;
pub use charge::{Charge, Resumed};
use delay::LoopDelay;
pub use options::{Ending, ServeOptions, ServeReport, SweepCounts};
pub use overload::Behind;
use rate::PoseRate;
pub use rate::{POSE_HZ, POSE_HZ_MAX};
pub use session::Session;
pub use snapshots::SnapshotPlace;
use snapshots::Snapshots;
pub use voice::Voice;
pub use watcher::Shared;

/// Longest pause between checks for Ctrl-C and for the end of the run \[ns\].
const LOOK_NS: u64 = 5 * MILLISECOND_NS;
/// Waits without a pose after which a scene rests.
const RESTS: u32 = 4;
/// Time for readers to receive the last answer \[ns\].
const LINGER_NS: u64 = 10 * MILLISECOND_NS;

/// A scene with open services, ready for poses.
#[derive(Debug)]
pub struct Server {
    options: ServeOptions,
    scene: SceneServices,
    ports: ServePorts,
    length_ns: u64,
    rate: PoseRate,
    state: Option<StatePublisher>,
    stress: Option<StressPublisher>,
    surface: Option<SurfacePublisher>,
    contacts: Option<ContactPublisher>,
    commands: Option<CommandServer>,
    snapshots: Option<SnapshotPlace>,
    _recording: Option<recording::Shown>,
    resumed: Option<Resumed>,
}

/// Serves a scene until its end, after printing `ready`.
pub fn serve(
    engine: &mut dyn TissueEngine,
    options: &ServeOptions,
    recorder: &mut Recorder,
) -> Result<ServeReport> {
    let server = Server::open(options)?;
    server.say_ready()?;
    server.run(engine, recorder)
}

impl Server {
    /// Opens the scene's services; refused while another server is alive on the scene.
    pub fn open(options: &ServeOptions) -> Result<Self> {
        Self::on(ipc::open(options.scene.as_deref(), &options.domain)?, options)
    }

    /// Like [`Self::open`], on an open scene.
    ///
    /// # Errors
    /// Another server that is alive on it; a length or a rate out of range.
    pub fn on(scene: SceneServices, options: &ServeOptions) -> Result<Self> {
        let length_ns = match options.seconds {
            Some(seconds) => span_ns("`seconds`", seconds)?,
            None => u64::MAX,
        };
        let rate = PoseRate::new(options.max_pose_hz)?;
        if options.ends_with_parent {
            realtime::end_with_parent()?;
        }
        let ports = ServePorts::open(&scene, options.wait == Wait::Event)?;
        Ok(Self {
            options: options.clone(),
            scene,
            ports,
            length_ns,
            rate,
            state: None,
            stress: None,
            surface: None,
            contacts: None,
            commands: None,
            snapshots: None,
            _recording: None,
            resumed: None,
        })
    }

    /// Publishes states of `nodes` nodes at most `hz` times a second, 0 for none.
    ///
    /// # Errors
    /// A rate out of range; a service with other types or limits.
    pub fn with_state(mut self, nodes: usize, hz: u32) -> Result<Self> {
        if hz > 0 {
            self.state = Some(StatePublisher::open(&self.scene, nodes, hz)?);
            self.scene.take_memory()?;
        }
        Ok(self)
    }

    /// Publishes strain and stress of a body with these numbers of nodes and cells, at most `hz` times a second, 0
    /// for never.
    ///
    /// # Errors
    /// As [`Self::with_state`].
    pub fn with_stress(mut self, size: (usize, usize), hz: u32) -> Result<Self> {
        if hz > 0 {
            self.stress = Some(StressPublisher::open(&self.scene, size, hz)?);
            self.scene.take_memory()?;
        }
        Ok(self)
    }

    /// Publishes the surface of a body that can be cut, in messages of at most `rows` rows, at most `hz` times a
    /// second, 0 for never.
    ///
    /// # Errors
    /// As [`Self::with_state`].
    pub fn with_surface(mut self, rows: usize, hz: u32) -> Result<Self> {
        if hz > 0 {
            self.surface = Some(SurfacePublisher::open(&self.scene, rows, hz)?);
            self.scene.take_memory()?;
        }
        Ok(self)
    }

    /// Watches a limit of the stress, if it is published, with or without a reader.
    #[must_use]
    pub fn with_stress_limit(mut self, limit: StressLimit) -> Self {
        if let Some(stress) = &mut self.stress {
            stress.limit = Some(limit);
        }
        self
    }

    /// Publishes contacts at most `hz` times a second, 0 for none, if there are `tools` on a contact surface.
    ///
    /// # Errors
    /// As [`Self::with_state`].
    pub fn with_contacts(mut self, tools: usize, hz: u32) -> Result<Self> {
        if tools > 0 && hz > 0 {
            self.contacts = Some(ContactPublisher::open(&self.scene, hz)?);
            self.scene.take_memory()?;
        }
        Ok(self)
    }

    /// Accepts commands.
    ///
    /// # Errors
    /// A service with other types or limits.
    pub fn with_commands(mut self) -> Result<Self> {
        self.commands = Some(CommandServer::open(&self.scene)?);
        Ok(self)
    }

    /// Accepts snapshot commands, and shows mirrors where the session is recorded.
    #[must_use]
    pub fn with_snapshots(self, place: SnapshotPlace) -> Self {
        let recording = recording::show(&self.scene, &place.trace);
        if let Err(why) = &recording {
            log::warn!(
                "mirrors find this session by its folder alone, and not by its scene: {why}"
            );
        }
        Self { snapshots: Some(place), _recording: recording.ok(), ..self }
    }

    /// Resumes a session from a snapshot, from which the tissue has been restored.
    #[must_use]
    pub fn resuming(self, resumed: Resumed) -> Self {
        Self { resumed: Some(resumed), ..self }
    }

    /// Prints that clients may connect.
    ///
    /// # Errors
    /// Too little shared memory for them; standard output that cannot be written.
    pub fn say_ready(&self) -> Result<()> {
        self.scene.check_room_to_join()?;
        terminal::say("ready")
    }

    /// Serves until the end of the run. Allocates no memory from the first pose on, except for snapshots.
    pub fn run(
        mut self,
        engine: &mut dyn TissueEngine,
        recorder: &mut Recorder,
    ) -> Result<ServeReport> {
        // Share the voice with the watcher, and prepare the run.
        let beside = Beside {
            state: self.state.take(),
            stress: self.stress.take(),
            surface: self.surface.take(),
            contacts: self.contacts.take(),
            commands: self.commands.take(),
        };
        let shared = Shared::new(Voice::new(&self.options, now_ns()));
        let snapshots = self.snapshots.take().map(Snapshots::new).unzip();
        let mut run = Run::new(&self, &shared, beside, engine, recorder)?;
        let (answers, leftovers) = (&self.ports.answers, self.scene.leftovers());
        // Run the loop, with threads for snapshots' files, for the falling force and for leftovers.
        let (ended_by, refused) = std::thread::scope(|scope| {
            let (taken, files) = snapshots;
            run.snapshots = taken;
            if let Some(files) = files {
                scope.spawn(move || files.write_all());
            }
            // Started before the loop requests its privileges, which a thread would inherit: on the loop's
            // core and at its priority it would not run while the loop is in a tick.
            scope.spawn(|| shared.watch(answers));
            let of_leftovers =
                scope.spawn(|| shared.clear_when_it_stands(|| _ = leftovers.clear()));
            let ended = self.ask_and_loop(&mut run);
            shared.end();
            of_leftovers.thread().unpark();
            run.end_snapshots();
            run.look_at_stress(StressPublisher::finish);
            ended
        });
        // A reader that has just joined misses messages that a publisher sends right before its end.
        sleep_until_ns(now_ns() + LINGER_NS);
        Ok(run.report(ended_by, refused))
    }

    fn ask_and_loop(&self, run: &mut Run<'_>) -> (Ending, Vec<String>) {
        let refused = if self.options.realtime {
            realtime::ask(Role::Serve, self.options.wait)
        } else {
            Vec::new()
        };
        (run.until_the_end(), refused)
    }
}

/// Publishers and commands that are handled between ticks.
struct Beside {
    state: Option<StatePublisher>,
    stress: Option<StressPublisher>,
    surface: Option<SurfacePublisher>,
    contacts: Option<ContactPublisher>,
    commands: Option<CommandServer>,
}

struct Run<'a> {
    server: &'a Server,
    shared: &'a Shared,
    state: Option<StatePublisher>,
    stress: Option<StressPublisher>,
    surface: Option<SurfacePublisher>,
    contacts: Option<ContactPublisher>,
    commands: Option<CommandServer>,
    snapshots: Option<Snapshots>,
    session: Session<'a>,
    recorder: &'a mut Recorder,
    waiter: Waiter,
    peers: PeerWatch,
    step: Latencies,
    /// Poses accepted and not yet executed, oldest first.
    inbox: VecDeque<Arrived>,
    in_charge: Option<UniquePublisherId>,
    /// Waits since the last pose.
    idle_rounds: u32,
    rate: PoseRate,
    alive_until_ns: u64,
    budget: TimeBudget,
    delay: LoopDelay,
    looked_ns: u64,
    end_ns: u64,
    publishers: u64,
    late: u64,
    /// Late ticks that follow a silence or a gap; and whether the current run of late ticks does.
    late_behind_gaps: u64,
    behind_gap: bool,
    flag_ticks: FlagTicks,
    sweeps: Latencies,
    estimates: Estimates,
    repeated: u64,
    refused: u64,
    throttled: u64,
    failed: u64,
    paused_ticks: u64,
    obeyed: u64,
    disobeyed: u64,
    /// True once the user has been told that the record is full.
    is_full_told: bool,
}

impl<'a> Run<'a> {
    fn new(
        server: &'a Server,
        shared: &'a Shared,
        Beside { state, stress, surface, contacts, commands }: Beside,
        engine: &'a mut dyn TissueEngine,
        recorder: &'a mut Recorder,
    ) -> Result<Self> {
        let start_ns = now_ns();
        let mut inbox = VecDeque::new();
        // Touch the pages once now, to avoid page faults in the loop.
        inbox.resize(QUEUE_MESSAGES, Arrived::default());
        inbox.clear();
        let mut waiter = Waiter::new(server.options.wait, PERIOD_NS);
        waiter.expect_after(start_ns);
        // Go on where a restored session stood.
        let resumed = server.resumed;
        let charge = resumed.map_or_else(Charge::new, Charge::resuming);
        let paused = resumed.is_some_and(|of| of.is_paused);
        // Prepare the time budget and the session.
        let least = engine.least_sweeps();
        let budget = TimeBudget::new(server.options.budget, least, server.options.max_pose_hz);
        let session = Session::new(engine, shared, &server.options, (charge, paused));
        Ok(Self {
            server,
            shared,
            state,
            stress,
            surface,
            contacts,
            commands,
            snapshots: None,
            session,
            recorder,
            waiter,
            peers: PeerWatch::new(server.scene.ports_count()),
            step: Latencies::new()?,
            inbox,
            in_charge: None,
            idle_rounds: 0,
            rate: server.rate,
            alive_until_ns: 0,
            budget,
            delay: LoopDelay::new(server.options.delay_period_ns),
            looked_ns: start_ns,
            end_ns: start_ns.saturating_add(server.length_ns),
            publishers: 0,
            late: 0,
            late_behind_gaps: 0,
            behind_gap: false,
            flag_ticks: FlagTicks::default(),
            sweeps: Latencies::new()?,
            estimates: Estimates::new()?,
            repeated: 0,
            refused: 0,
            throttled: 0,
            failed: 0,
            paused_ticks: 0,
            obeyed: 0,
            disobeyed: 0,
            is_full_told: false,
        })
    }

    fn until_the_end(&mut self) -> Ending {
        loop {
            self.shared.begin_round();
            // Leave the loop at the end of the run.
            if self.server.options.ticks.is_some_and(|ticks| self.session.executed >= ticks) {
                return Ending::Ticks;
            }
            if interrupt::asked() {
                return Ending::Interrupt;
            }
            if now_ns() >= self.end_ns {
                return Ending::Seconds;
            }
            // Execute the oldest pose, or wait for one.
            let has_come = self.take_in();
            if has_come {
                self.idle_rounds = 0;
            }
            if let Some(arrived) = self.inbox.pop_front() {
                if self.is_anytime() && !self.inbox.is_empty() {
                    self.execute_late(arrived);
                } else {
                    self.execute(arrived);
                    self.beside(false);
                }
            } else if has_come {
                // Poses that are not executed delay commands and viewers no more than others.
                self.beside(false);
            } else {
                // Before the wait: after it poses may be in the queue.
                self.watch();
                self.beside(true);
                self.wait();
            }
        }
    }

    /// Returns true if ticks end when their time is up, and poses may be late.
    fn is_anytime(&self) -> bool {
        self.server.options.budget != SweepBudget::Off
            && self.session.engine.is_anytime()
            && !self.session.is_paused()
    }

    fn wait(&mut self) {
        if self.recorder.is_full() && !self.is_full_told {
            self.is_full_told = true;
            terminal::note(
                "note: the record is full; the session goes on without, and nobody can follow it or take it over",
            );
        }
        self.connect_peers();
        // Nobody waits for an answer while a scene rests: the stress goes on without a pause.
        self.idle_rounds = self.idle_rounds.saturating_add(1);
        let is_in_pass = self.stress.as_ref().is_some_and(StressPublisher::is_in_pass);
        let look_ns = if is_in_pass && self.idle_rounds > RESTS { 0 } else { LOOK_NS };
        let deadline_ns = (now_ns() + look_ns).min(self.end_ns);
        let deadline_ns = self
            .shared
            .voice()
            .shaper
            .fall_ns()
            .map_or(deadline_ns, |due_ns| due_ns.min(deadline_ns));
        self.waiter.pause(deadline_ns, self.server.ports.wake());
    }

    /// Connects new readers while no pose waits, so that no answer is delayed.
    fn connect_peers(&mut self) {
        let server = self.server;
        self.peers.timed(
            || server.scene.ports_count(),
            || {
                server.ports.connect();
                (Call::Idle, ())
            },
        );
    }

    fn report(self, ended_by: Ending, refused: Vec<String>) -> ServeReport {
        // Costs of the readers.
        let (states_sent, state_ns) =
            self.state.as_ref().map_or_else(Default::default, |state| state.feed.cost());
        let (stresses_sent, stress_ns) =
            self.stress.as_ref().map_or_else(Default::default, |stress| stress.feed.cost());
        let (surfaces_sent, surface_ns) =
            self.surface.as_ref().map_or_else(Default::default, |surface| surface.feed.cost());
        let (contacts_sent, contacts_ns) =
            self.contacts.as_ref().map_or_else(Default::default, |contacts| contacts.feed.cost());
        // Silences and steps of the published forces.
        let voice = self.shared.voice();
        ServeReport {
            ticks_executed: self.session.executed,
            ticks_late: self.late,
            ticks_late_behind_gaps: self.late_behind_gaps,
            poses_missing: self.session.missing,
            overloads: voice.overloads(),
            sweeps: SweepCounts {
                p1: self.sweeps.at(0.01),
                p50: self.sweeps.at(0.5),
                max: self.sweeps.summary().max,
            },
            budget_us: self.server.options.budget,
            poses_repeated: self.repeated,
            poses_refused: self.refused,
            poses_throttled: self.throttled,
            publishers: self.publishers,
            sends_failed: self.failed,
            watchdog_fired: voice.shaper.silences(),
            largest_force_step_n: voice.shaper.largest_step_n(),
            ticks_recorded: self.recorder.ticks(),
            ticks_unrecorded: self.recorder.left_out_ticks(),
            flag_ticks: self.flag_ticks,
            tool_courses: self.session.courses(),
            force_error_estimate: self.estimates.result(),
            cut: self.session.engine.cut(),
            relaxed_j: self.session.engine.relaxed_j(),
            ticks_paused: self.paused_ticks,
            commands_done: self.obeyed,
            commands_refused: self.disobeyed,
            states_sent,
            state_ns,
            stresses_sent,
            stress_ns,
            surfaces_sent,
            surface_ns,
            stress: self.stress.as_ref().and_then(|of| Some(of.limit.as_ref()?.report())),
            contacts_sent,
            contacts_ns,
            step_ns: self.step.summary(),
            peers: self.peers.cost(),
            state_hash: format!("{:016x}", self.session.engine.state_hash()),
            ended_by,
            refused,
            step_histogram: self.server.options.histogram.then(|| self.step.spans()),
        }
    }
}
