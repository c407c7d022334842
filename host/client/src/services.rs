//! The scene's services in shared memory: opening them, their limits, and who may connect.
//!
//! **Access**: programs of the user that runs the first one may connect, and nobody else. iceoryx2
//! keeps lists of services and nodes in `/tmp/iceoryx2`, messages in `/dev/shm`. Every file it
//! makes is readable and writable by its owner alone, whatever the umask; the folder must be this
//! user's and no other may write in it (its feature `dev_permissions`, which would open all of it,
//! is not built in). One file is open to all: a word of 16 bytes in `/dev/shm` that counts nodes.
//! It is mapped only while a program starts; a node's id also holds the process and the time.
//! By corrupting it, other users of the machine can hinder a start but not a session; they see no
//! message. Root may do anything. The configuration is iceoryx2's built-in one: no file in the
//! working folder, in the home folder or in /etc changes it.
//!
//! **Sizes** are fixed by the types of [`crate::payload`] and [`crate::tools`]. A service refuses a
//! program whose message has another name, size or alignment, or is a slice where it should be none;
//! states and contacts are slices, their length bounded by the model. No message allocates memory of the
//! server.
//!
//! **Rates**: poses `--max-pose-hz` a second with 1,024 at once; commands one every 10 ms, 4 pending
//! for each of at most 8 programs; states and contacts `--state-hz` a second, only while somebody
//! reads; a hash is part of an answer, `--hash-every`. Messages beyond these rates are dropped; dropped
//! poses are counted. A reader that does not read loses the oldest messages and delays nobody.
//!
//! **No path from a message to a file.** Messages hold only numbers ([`crate::payload`]): none can
//! name a file. The command line of `serve` gives the folder and the names of the files that it
//! writes; a message can only become a row in them, up to `--record-ticks`.

use std::fmt::Debug;
use std::sync::Arc;
use std::time::Duration;

use iceoryx2::identifiers::{UniqueNodeId, UniquePublisherId};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, publish_subscribe};

pub use crate::domain::Domain;
use crate::error::{Error, Kind, Result};
use crate::foreign;
use crate::leftovers::Leftovers;
pub use crate::limits::{
    NODES_MAX, PUBLISHERS_MAX, QUEUE_MESSAGES, SUBSCRIBERS_MAX, port_error, service_error,
};
use crate::memory;
pub use crate::names::Ipc;
use crate::names::SceneNames;
use crate::opening::Opening;
use crate::tools::{TOOL_FORCES, TOOL_POSES, ToolForces, ToolPoses};

/// Longest wait for another process that clears up after a killed one.
pub(crate) const CLEAR_UP_LIMIT: Duration = Duration::from_millis(500);

/// Name of the ports of `control`, by which a second one is recognised.
const CONTROL_PORT: &str = "chaincell.control";

/// Name of the port of one that shows a session of another place, whose poses no server executes.
pub const SHOW_PORT: &str = "chaincell.follow";

/// Factory of the ports of one publish-subscribe service.
pub type Topic<Payload> = publish_subscribe::PortFactory<Ipc, Payload, ()>;

/// One scene's services, open in this process.
#[derive(Debug)]
pub struct SceneServices {
    /// The node of this process in shared memory.
    pub node: Arc<Node<Ipc>>,
    opening: Opening,
    /// Service of states.
    pub state_name: ServiceName,
    /// Service of strain and stress.
    pub stress_name: ServiceName,
    /// Service of surfaces.
    pub surface_name: ServiceName,
    /// Service of contacts.
    pub contacts_name: ServiceName,
    /// Service of commands.
    pub command_name: ServiceName,
    /// Service that shows where it is recorded.
    pub(crate) recording_name: ServiceName,
    /// Poses, from the controller to the tissue.
    pub tools: Topic<ToolPoses>,
    /// Answers, from the tissue to the controller.
    pub forces: Topic<ToolForces>,
    /// Announces poses.
    tools_wake: event::PortFactory<Ipc>,
    /// Announces answers.
    forces_wake: event::PortFactory<Ipc>,
}

/// The ports of one side: it reads `In` and writes `Out`.
#[derive(Debug)]
pub struct Ports<In: ZeroCopySend + Debug + 'static, Out: ZeroCopySend + Debug + 'static> {
    /// Receives messages.
    pub subscriber: Subscriber<Ipc, In, ()>,
    /// Sends messages.
    pub publisher: Publisher<Ipc, Out, ()>,
    /// Wakes the readers of `Out`.
    pub ring: Ring,
    /// Wakes this side when something was written to `In`.
    pub wake: Wake,
}

/// Wakes the readers that sleep until they are woken.
#[derive(Debug)]
pub struct Ring(Notifier<Ipc>);

impl Ring {
    /// Wakes them. A reader that can't be woken finds the message itself a little later.
    pub fn ring(&self) {
        let _ = self.0.notify();
    }
}

/// Wakes a sleeping reader; absent if the reader polls.
#[derive(Debug)]
pub struct Wake(Option<Listener<Ipc>>);

impl Wake {
    /// Sleeps until woken or until the time is up; returns false if that is impossible.
    pub fn wait(&self, at_most: Duration) -> bool {
        self.0.as_ref().is_some_and(|listener| listener.timed_wait(|_| {}, at_most).is_ok())
    }
}

impl SceneServices {
    /// Opens or creates the services after clearing up leftovers of killed processes: within seconds, or
    /// fails.
    ///
    /// # Errors
    /// A service with other types or limits, files of another user, too little memory, or a program that
    /// blocks the services.
    pub fn open(scene: Option<&str>, domain: &Domain) -> Result<Self> {
        Self::open_unless(scene, domain, || false)
    }

    /// As [`Self::open`], but calls `stop` every 2 ms, and ends if it returns true.
    ///
    /// # Errors
    /// As there, and [`Kind::Stopped`] if `stop` returned true.
    pub fn open_unless(
        scene: Option<&str>,
        domain: &Domain,
        stop: impl FnMut() -> bool,
    ) -> Result<Self> {
        // Silences iceoryx2's log on standard error unless IOX2_LOG_LEVEL asks for it.
        set_log_level_from_env_or(LogLevel::Fatal);
        let names = SceneNames::new(scene)?;
        let config = domain.config()?;
        memory::check("joining a scene", memory::JOIN_BYTES)?;
        memory::take_files("joining a scene", memory::JOIN_FILES)?;
        let opening = Opening {
            leftovers: Leftovers::of(&config),
            label: names.label.clone(),
            names: names.services(),
        };
        opening.clone().within(stop, move || Self::join(&names, &config, opening.clone()))
    }

    fn join(names: &SceneNames, config: &Config, opening: Opening) -> Result<Self> {
        let node = NodeBuilder::new()
            .name(&node_name()?)
            .config(config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|why| {
                Error::new(
                    Kind::Permission,
                    format!(
                        "cannot use shared memory ({why:?}): iceoryx2 keeps its files in \
                     /tmp/iceoryx2 and /dev/shm; check that both are yours and writable, or end \
                     the other user's programs"
                    ),
                )
            })?;
        node.blocking_cleanup_dead_nodes(CLEAR_UP_LIMIT);
        Ok(Self {
            tools: topic(&node, &names.tools, TOOL_POSES)?,
            forces: topic(&node, &names.forces, TOOL_FORCES)?,
            tools_wake: wake_topic(&node, &names.tools)?,
            forces_wake: wake_topic(&node, &names.forces)?,
            state_name: names.state,
            stress_name: names.stress,
            surface_name: names.surface,
            contacts_name: names.contacts,
            command_name: names.command,
            recording_name: names.recording,
            opening,
            node: Arc::new(node),
        })
    }

    /// Returns the cleaner that removes leftovers of killed programs.
    #[must_use]
    pub fn leftovers(&self) -> Leftovers {
        self.opening.leftovers.clone()
    }

    /// Opens a further service of the scene: within seconds, or fails.
    pub(crate) fn further<T: Send + 'static>(
        &self,
        open: impl Fn(&Node<Ipc>) -> Result<T> + Send + 'static,
    ) -> Result<T> {
        let node = Arc::clone(&self.node);
        self.opening.within(|| false, move || open(&node))
    }

    /// Returns the ring that wakes the readers of answers, and the wake that poses trigger.
    ///
    /// # Errors
    /// All places are taken.
    pub fn server_bells(&self, woken: bool) -> Result<(Ring, Wake)> {
        Ok((ring(&self.forces_wake)?, wake(&self.tools_wake, woken)?))
    }

    /// Opens the ports of the controller's side; fails while another `control` is alive on the scene.
    ///
    /// # Errors
    /// Another controller, no free place, or too little memory.
    pub fn control_ports(&self, woken: bool) -> Result<Ports<ToolForces, ToolPoses>> {
        self.refuse_second(&self.tools, CONTROL_PORT, None, "control")?;
        let messages = (QUEUE_MESSAGES * SUBSCRIBERS_MAX * size_of::<ToolPoses>()) as u64;
        memory::check("a controller", messages + memory::JOIN_BYTES)?;
        let ports = Ports {
            subscriber: subscriber(&self.forces, CONTROL_PORT)?,
            publisher: self.publisher(&self.tools, CONTROL_PORT, "control")?,
            ring: ring(&self.tools_wake)?,
            wake: wake(&self.forces_wake, woken)?,
        };
        // Two controllers that started at the same time see each other now.
        self.refuse_second(&self.tools, CONTROL_PORT, Some(ports.publisher.id()), "control")?;
        self.take_memory()?;
        Ok(ports)
    }

    /// Checks that memory and open files suffice for a server and its clients.
    ///
    /// # Errors
    /// The amount of memory or open files that is left, and the amount needed.
    pub fn check_room_to_serve(&self) -> Result<()> {
        memory::take_files("a server with its clients", memory::SERVER_FILES)?;
        memory::check("a server with its clients", memory::SERVER_BYTES)
    }

    /// Checks that memory suffices for clients to join, before a server reports that it is ready.
    ///
    /// # Errors
    /// The amount of memory that is left, and the amount needed.
    pub fn check_room_to_join(&self) -> Result<()> {
        memory::check("what joins a server", memory::CLIENTS_BYTES)
    }

    /// Allocates the memory of all ports opened so far, so that no later write fails.
    ///
    /// # Errors
    /// Too little memory.
    pub fn take_memory(&self) -> Result<()> {
        memory::take(&self.node.config().global.prefix.to_string())
    }

    /// Returns true if a program reads poses and one writes answers.
    #[must_use]
    pub fn is_served(&self) -> bool {
        self.tools.dynamic_config().number_of_subscribers() > 0
            && self.forces.dynamic_config().number_of_publishers() > 0
    }

    /// Returns true if a program shows a session of another place, as `chaincell follow --scene` does. Reads files: not
    /// for every tick.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.owner_of(&self.tools, SHOW_PORT, None).is_some()
    }

    /// Returns true if a program besides this controller could publish poses: a bridge, or another
    /// controller.
    #[must_use]
    pub fn has_other_pose_publisher(&self) -> bool {
        self.tools.dynamic_config().number_of_publishers() > 1
    }

    /// Returns the id of the publisher of poses, if there is one alone.
    #[must_use]
    pub fn only_pose_publisher(&self) -> Option<u128> {
        let (mut count, mut id) = (0, 0);
        self.tools.dynamic_config().list_publishers(|publisher| {
            if self.is_alive(publisher.node_id) {
                (count, id) = (count + 1, publisher.publisher_id.value());
            }
            CallbackProgression::Continue
        });
        (count == 1).then_some(id)
    }

    /// Returns the number of ports on the services of poses and answers, including those of this process.
    #[must_use]
    pub fn ports_count(&self) -> usize {
        ports(&self.tools) + ports(&self.forces)
    }

    /// Returns the scene's name in error messages.
    #[must_use]
    pub fn label(&self) -> &str {
        &self.opening.label
    }

    /// Returns the node of a publisher of poses, if it is still registered.
    #[must_use]
    pub fn pose_publisher_node(&self, id: UniquePublisherId) -> Option<UniqueNodeId> {
        publisher_node(&self.tools, id)
    }

    /// Returns true if a node's process is alive. Reads files: not for every tick.
    #[must_use]
    pub fn is_alive(&self, node_id: UniqueNodeId) -> bool {
        match Node::<Ipc>::state_of(self.node.config(), node_id) {
            Ok(None | Some(NodeState::Dead(_))) => false,
            // A node that can't be inspected may be alive.
            Ok(Some(_)) | Err(_) => true,
        }
    }

    /// Checks that no other running program has a publisher of this port's name.
    ///
    /// # Errors
    /// The process of the other program, and the remedy.
    pub fn refuse_second<Payload: ZeroCopySend + Debug>(
        &self,
        topic: &Topic<Payload>,
        port: &str,
        own: Option<UniquePublisherId>,
        program: &str,
    ) -> Result<()> {
        match self.owner_of(topic, port, own) {
            None => Ok(()),
            Some(node) => Err(self.second(program, node.pid::<Ipc>().ok())),
        }
    }

    /// Returns a live node with a publisher of this name other than `own`.
    fn owner_of<Payload: ZeroCopySend + Debug>(
        &self,
        topic: &Topic<Payload>,
        port: &str,
        own: Option<UniquePublisherId>,
    ) -> Option<UniqueNodeId> {
        let mut owner = None;
        topic.dynamic_config().list_publishers(|details| {
            let is_other = details.publisher_name == port && Some(details.publisher_id) != own;
            if is_other && self.is_alive(details.node_id) {
                owner = Some(details.node_id);
                return CallbackProgression::Stop;
            }
            CallbackProgression::Continue
        });
        owner
    }

    fn second(&self, program: &str, pid: Option<ProcessId>) -> Error {
        let is_own = pid.is_some_and(|pid| pid.value().unsigned_abs() == std::process::id());
        let text = if is_own {
            format!(
                "this process has a running chaincell {program} on {} already; close it",
                self.label()
            )
        } else {
            let pid = pid.map(|pid| format!(" (process {pid})")).unwrap_or_default();
            format!(
                "{} has a running chaincell {program}, or a program that has its part{pid}; end it",
                self.label()
            )
        };
        Error::new(Kind::Taken, format!("{text}, or take another scene with `scene` NAME"))
    }

    /// Creates a publisher with this port's name, which never blocks.
    ///
    /// # Errors
    /// All places are taken.
    pub fn publisher<Payload: ZeroCopySend + Debug>(
        &self,
        topic: &Topic<Payload>,
        port: &str,
        program: &str,
    ) -> Result<Publisher<Ipc, Payload, ()>> {
        topic
            .publisher_builder()
            .name(&port_name(port)?)
            .max_loaned_samples(1)
            // A stuck or killed reader must never block the sender.
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|why| match why {
                PublisherCreateError::ExceedsMaxSupportedPublishers => self.second(program, None),
                other => port_error(topic.name(), other),
            })
    }
}

fn topic<Payload: ZeroCopySend + Debug + Copy>(
    node: &Node<Ipc>,
    name: &ServiceName,
    type_name: &str,
) -> Result<Topic<Payload>> {
    node.service_builder(name)
        .publish_subscribe::<Payload>()
        .enable_safe_overflow(true)
        .history_size(0)
        .subscriber_max_buffer_size(QUEUE_MESSAGES)
        .max_publishers(PUBLISHERS_MAX)
        .max_subscribers(SUBSCRIBERS_MAX)
        .max_nodes(NODES_MAX)
        .open_or_create()
        .map_err(|why| {
            foreign::refusal::<Payload>(node.config(), name, type_name)
                .unwrap_or_else(|| service_error(name, why))
        })
}

fn ports<Payload: ZeroCopySend + Debug>(topic: &Topic<Payload>) -> usize {
    let ports = topic.dynamic_config();
    ports.number_of_publishers() + ports.number_of_subscribers()
}

fn publisher_node<Payload: ZeroCopySend + Debug>(
    topic: &Topic<Payload>,
    id: UniquePublisherId,
) -> Option<UniqueNodeId> {
    let mut found = None;
    topic.dynamic_config().list_publishers(|details| {
        if details.publisher_id == id {
            found = Some(details.node_id);
            return CallbackProgression::Stop;
        }
        CallbackProgression::Continue
    });
    found
}

fn wake_topic(node: &Node<Ipc>, name: &ServiceName) -> Result<event::PortFactory<Ipc>> {
    node.service_builder(name).event().open_or_create().map_err(|why| service_error(name, why))
}

/// Creates a subscriber with this port's name and the whole queue.
///
/// # Errors
/// All places are taken.
pub fn subscriber<Payload: ZeroCopySend + Debug>(
    topic: &Topic<Payload>,
    port: &str,
) -> Result<Subscriber<Ipc, Payload, ()>> {
    topic
        .subscriber_builder()
        .name(&port_name(port)?)
        .buffer_size(QUEUE_MESSAGES)
        .create()
        .map_err(|why| port_error(topic.name(), why))
}

fn ring(topic: &event::PortFactory<Ipc>) -> Result<Ring> {
    let notifier = topic.notifier_builder().create();
    notifier.map(Ring).map_err(|why| port_error(topic.name(), why))
}

fn wake(topic: &event::PortFactory<Ipc>, woken: bool) -> Result<Wake> {
    if !woken {
        return Ok(Wake(None));
    }
    let listener = topic.listener_builder().create();
    listener.map(|listener| Wake(Some(listener))).map_err(|why| port_error(topic.name(), why))
}

fn node_name() -> Result<NodeName> {
    NodeName::new("chaincell")
        .map_err(|why| Error::new(Kind::Connection, format!("node name: {why:?}")))
}

fn port_name(name: &str) -> Result<PortName> {
    PortName::new(name)
        .map_err(|why| Error::new(Kind::Connection, format!("port name {name}: {why:?}")))
}
