//! The tissue's side: driven by poses, one tick and one answer for each.
//!
//! One thread receives, ticks and sends. A second thread for shared memory would stand between
//! each pose and its answer all the same; instead, new readers are connected while no pose waits,
//! so that only one that joins during a tick delays that tick's answer (see
//! [`PeerCost`](crate::session::loops::peers::PeerCost)). States for viewers and commands have their turn while no
//! pose waits too.

mod beside;
mod options;
mod rate;
mod watchdog;

use iceoryx2::identifiers::UniquePublisherId;
use iceoryx2::port::update_connections::UpdateConnections;

use chaincell_kernel::ToolSample;

use crate::engine::flag_ticks::FlagTicks;
use crate::engine::order::{TickOrder, TickPlace};
use crate::engine::tissue::TissueEngine;
use crate::error::Result;
use crate::interrupt;
use crate::session::ipc::command::CommandServer;
use crate::session::ipc::complain::complain;
use crate::session::ipc::payload::{ToolForce, ToolPose};
use crate::session::ipc::services::{Ports, SceneServices};
use crate::session::ipc::state::StatePublisher;
use crate::session::loops::peers::{Call, PeerWatch};
use crate::session::loops::realtime::{self, Role};
use crate::session::loops::record::Recorder;
use crate::session::loops::shaper::ForceShaper;
use crate::session::loops::wait::{Wait, Waiter};
use crate::session::timing::clock::{MILLISECOND_NS, PERIOD_NS, now_ns, sleep_until_ns, span_ns};
use crate::session::timing::histogram::Latencies;
use crate::terminal;

pub use options::{Ending, ServeOptions, ServeReport};
use rate::PoseRate;
pub use rate::{POSE_HZ, POSE_HZ_MAX};

/// Longest pause between looks at Ctrl-C and at the end of the run \[ns\].
const LOOK_NS: u64 = 5 * MILLISECOND_NS;
/// Time for readers to take the last answer \[ns\].
const LINGER_NS: u64 = 10 * MILLISECOND_NS;
/// Span between looks whether the publisher in charge is still alive \[ns\].
const ALIVE_CHECK_NS: u64 = 100 * MILLISECOND_NS;

/// A scene whose services exist and that is ready for poses.
#[derive(Debug)]
pub struct Server {
    options: ServeOptions,
    scene: SceneServices,
    ports: Ports<ToolPose, ToolForce>,
    length_ns: u64,
    rate: PoseRate,
    state: Option<StatePublisher>,
    commands: Option<CommandServer>,
}

/// Serves a scene until its end, after printing `ready`.
pub fn serve(
    engine: &mut dyn TissueEngine,
    options: &ServeOptions,
    recorder: &mut Recorder,
) -> Result<ServeReport> {
    let server = Server::open(options)?;
    terminal::say("ready")?;
    server.run(engine, recorder)
}

impl Server {
    /// Opens the scene's services; refused while another server is alive on the scene.
    pub fn open(options: &ServeOptions) -> Result<Self> {
        let length_ns = match options.seconds {
            Some(seconds) => span_ns("`seconds`", seconds)?,
            None => u64::MAX,
        };
        let rate = PoseRate::new(options.max_pose_hz)?;
        if options.ends_with_parent {
            realtime::end_with_parent()?;
        }
        let scene = SceneServices::open(options.scene.as_deref(), &options.domain)?;
        let ports = scene.serve_ports(options.wait == Wait::Event)?;
        let options = options.clone();
        Ok(Self { options, scene, ports, length_ns, rate, state: None, commands: None })
    }

    /// Sends states of `nodes` nodes at most `hz` times a second, 0 for none.
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

    /// Takes commands.
    ///
    /// # Errors
    /// A service with other types or limits.
    pub fn with_commands(mut self) -> Result<Self> {
        self.commands = Some(CommandServer::open(&self.scene)?);
        Ok(self)
    }

    /// Serves until the end of the run. Allocates nothing of its own from the first pose on.
    pub fn run(
        mut self,
        engine: &mut dyn TissueEngine,
        recorder: &mut Recorder,
    ) -> Result<ServeReport> {
        let refused = if self.options.realtime {
            realtime::ask(Role::Serve, self.options.wait)
        } else {
            Vec::new()
        };
        let beside = (self.state.take(), self.commands.take());
        let mut run = Run::new(&self, beside, engine, recorder)?;
        let ended_by = run.until_the_end();
        // A reader that has only just joined loses what a publisher sends right before its end.
        sleep_until_ns(now_ns() + LINGER_NS);
        Ok(run.report(ended_by, refused))
    }
}

/// The publisher whose poses are executed.
#[derive(Debug, Clone, Copy)]
struct InCharge {
    id: UniquePublisherId,
    order: TickOrder,
}

struct Run<'a> {
    server: &'a Server,
    state: Option<StatePublisher>,
    commands: Option<CommandServer>,
    engine: &'a mut dyn TissueEngine,
    recorder: &'a mut Recorder,
    paused: bool,
    waiter: Waiter,
    peers: PeerWatch,
    step: Latencies,
    in_charge: Option<InCharge>,
    rate: PoseRate,
    alive_until_ns: u64,
    answer: Option<ToolForce>,
    shaper: ForceShaper,
    end_ns: u64,
    publishers: u64,
    executed: u64,
    flag_ticks: FlagTicks,
    repeated: u64,
    refused: u64,
    throttled: u64,
    failed: u64,
    paused_ticks: u64,
    obeyed: u64,
    disobeyed: u64,
}

impl<'a> Run<'a> {
    fn new(
        server: &'a Server,
        (state, commands): (Option<StatePublisher>, Option<CommandServer>),
        engine: &'a mut dyn TissueEngine,
        recorder: &'a mut Recorder,
    ) -> Result<Self> {
        let start_ns = now_ns();
        let ServeOptions { watchdog_ms, ramp_ms, max_slew_n_per_s, .. } = server.options;
        let mut waiter = Waiter::new(server.options.wait, PERIOD_NS);
        waiter.expect_after(start_ns);
        Ok(Self {
            server,
            state,
            commands,
            engine,
            recorder,
            paused: false,
            waiter,
            peers: PeerWatch::new(server.scene.ports_count()),
            step: Latencies::new()?,
            in_charge: None,
            rate: server.rate,
            alive_until_ns: 0,
            answer: None,
            shaper: ForceShaper::new(watchdog_ms, ramp_ms, max_slew_n_per_s, start_ns),
            end_ns: start_ns.saturating_add(server.length_ns),
            publishers: 0,
            executed: 0,
            flag_ticks: FlagTicks::default(),
            repeated: 0,
            refused: 0,
            throttled: 0,
            failed: 0,
            paused_ticks: 0,
            obeyed: 0,
            disobeyed: 0,
        })
    }

    fn until_the_end(&mut self) -> Ending {
        loop {
            if self.server.options.ticks.is_some_and(|ticks| self.executed >= ticks) {
                return Ending::Ticks;
            }
            if interrupt::asked() {
                return Ending::Interrupt;
            }
            if now_ns() >= self.end_ns {
                return Ending::Seconds;
            }
            match self.receive() {
                Some((pose, publisher)) if self.accepts(pose, publisher) => {
                    self.execute(pose);
                    self.beside(false);
                    continue;
                }
                // Poses that are not executed keep commands and viewers waiting no more than others.
                Some(_) => self.beside(false),
                None => {
                    // Before the wait: behind it poses may lie in the queue.
                    self.watch(now_ns());
                    self.beside(true);
                    self.wait();
                }
            }
        }
    }

    fn wait(&mut self) {
        self.connect_peers();
        let deadline_ns = (now_ns() + LOOK_NS).min(self.end_ns);
        let deadline_ns =
            self.shaper.fall_ns().map_or(deadline_ns, |due_ns| due_ns.min(deadline_ns));
        self.waiter.pause(deadline_ns, &self.server.ports.wake);
    }

    fn receive(&mut self) -> Option<(ToolPose, UniquePublisherId)> {
        let (server, failed) = (self.server, &mut self.failed);
        self.peers.timed(
            || server.scene.ports_count(),
            || match server.ports.subscriber.receive() {
                Ok(Some(sample)) => {
                    let pose = (*sample, sample.header().publisher_id());
                    (Call::Receive, Some(pose))
                }
                Ok(None) => (Call::Idle, None),
                Err(why) => {
                    complain(failed, "cannot receive a pose", why);
                    (Call::Idle, None)
                }
            },
        )
    }

    /// Connects new readers while no pose waits, so that no answer pays for it.
    fn connect_peers(&mut self) {
        let server = self.server;
        self.peers.timed(
            || server.scene.ports_count(),
            || {
                // A failure shows again, and is counted, when the next answer is sent.
                let _ = server.ports.publisher.update_connections();
                (Call::Idle, ())
            },
        );
    }

    /// Whether a pose is the next one of the publisher in charge.
    fn accepts(&mut self, pose: ToolPose, publisher: UniquePublisherId) -> bool {
        let arrival_ns = now_ns();
        let in_charge = self.in_charge;
        let mut order = match in_charge {
            Some(known) if known.id == publisher => known.order,
            Some(known) if self.is_in_charge(known.id, arrival_ns) => {
                complain(&mut self.refused, "a second publisher sends poses", publisher.value());
                return false;
            }
            _ => {
                self.publishers += 1;
                self.shaper.begin_ramp();
                TickOrder::default()
            }
        };
        let place = order.take(pose.tick);
        self.in_charge = Some(InCharge { id: publisher, order });
        match place {
            TickPlace::Next => {}
            TickPlace::Repeated => {
                complain(&mut self.repeated, "tick not above the last one", pose.tick);
                return false;
            }
            TickPlace::Bad => {
                complain(&mut self.refused, "bad tick, far from the last one", pose.tick);
                return false;
            }
        }
        if !self.rate.takes(arrival_ns) {
            complain(&mut self.throttled, "poses come faster than the limit a second", pose.tick);
            return false;
        }
        self.waiter.arrived(arrival_ns, arrival_ns.saturating_sub(self.shaper.heard_ns()));
        self.waiter.expect_after(arrival_ns);
        self.shaper.hear(arrival_ns);
        true
    }

    fn execute(&mut self, pose: ToolPose) {
        let sample = ToolSample::from(pose);
        let start_ns = now_ns();
        let output = if self.paused { self.rest() } else { self.engine.tick(&sample) };
        let step_ns = now_ns() - start_ns;
        self.executed += 1;
        self.flag_ticks.add(output.flags);
        let every = self.server.options.hash_every;
        let hashed = every != 0 && self.executed.is_multiple_of(every);
        let force = ToolForce {
            tick: pose.tick,
            force_n: output.force_n.into(),
            energy_j: output.energy_j,
            contacts: output.contacts,
            flags: output.flags.0,
            step_ns: u32::try_from(step_ns).unwrap_or(u32::MAX),
            reserved: 0,
            state_hash: if hashed { self.engine.state_hash() } else { 0 },
        };
        // First, so that no answer is seen whose tick a kill could lose.
        self.recorder.record(pose, force);
        let shown = self.shown(force, now_ns());
        self.send(shown);
        if self.paused {
            self.paused_ticks += 1;
        } else {
            self.step.record(step_ns);
            if let Some(state) = &mut self.state {
                state.changed();
            }
        }
        self.answer = Some(force);
    }

    fn send(&mut self, force: ToolForce) {
        let (server, failed) = (self.server, &mut self.failed);
        self.peers.timed(
            || server.scene.ports_count(),
            || {
                if let Err(why) = server.ports.publisher.send_copy(force) {
                    complain(failed, "cannot send an answer", why);
                }
                (Call::Send, ())
            },
        );
        server.ports.ring.ring();
    }

    fn is_in_charge(&mut self, id: UniquePublisherId, now_ns: u64) -> bool {
        let Some(node) = self.server.scene.pose_publisher_node(id) else {
            return false;
        };
        if now_ns < self.alive_until_ns {
            return true;
        }
        self.alive_until_ns = now_ns + ALIVE_CHECK_NS;
        self.server.scene.is_alive(node)
    }

    fn report(self, ended_by: Ending, refused: Vec<String>) -> ServeReport {
        let (states_sent, state_ns) =
            self.state.as_ref().map_or_else(Default::default, StatePublisher::cost);
        ServeReport {
            ticks_executed: self.executed,
            poses_repeated: self.repeated,
            poses_refused: self.refused,
            poses_throttled: self.throttled,
            publishers: self.publishers,
            sends_failed: self.failed,
            watchdog_fired: self.shaper.silences(),
            largest_force_step_n: self.shaper.largest_step_n(),
            ticks_recorded: self.recorder.ticks(),
            ticks_unrecorded: self.recorder.left_out_ticks(),
            flag_ticks: self.flag_ticks,
            ticks_paused: self.paused_ticks,
            commands_done: self.obeyed,
            commands_refused: self.disobeyed,
            states_sent,
            state_ns,
            step_ns: self.step.summary(),
            peers: self.peers.cost(),
            state_hash: format!("{:016x}", self.engine.state_hash()),
            ended_by,
            refused,
            step_histogram: self.server.options.histogram.then(|| self.step.spans()),
        }
    }
}
