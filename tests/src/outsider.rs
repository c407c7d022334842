//! A program of somebody else on the scene's services: it knows the names and the bytes of the
//! messages, which the reference's table is compared with, and nothing else of chaincell's code.

pub mod tools;

use std::time::{Duration, Instant};

use chaincell_client::contacts::{Contact, ContactsHeader};
pub use chaincell_client::payload::{
    CommandMessage as Order, NodePosition as Row, ReplyMessage as Reply, StateHeader as Stamp,
};
use chaincell_client::stress::StressHeader;
use chaincell_client::surface::SurfaceHeader;
use iceoryx2::node::{Node, NodeView};
use iceoryx2::port::client::Client;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe;
use tools::{Forces, ToolsOutsider, one_tool};

/// Longest wait for a service or a message.
const LIMIT: Duration = Duration::from_secs(60);

/// Flag: the sample was bad.
pub const BAD_SAMPLE: u32 = 2;
/// Flag: poses have stopped coming; the message is no answer.
pub const STALE: u32 = 4;
/// Flag: the force is zero.
pub const SAFE: u32 = 16;
/// Flag: the force is not of this pose.
pub const LATE: u32 = 256;
/// Flag: the tool counts as not engaged.
pub const RELEASE_FIRST: u32 = 512;

/// What a program with one tool says in a tick.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Pose {
    /// Number of the tick.
    pub tick: u64,
    /// Tool position \[m\].
    pub position_m: [f32; 3],
    /// 1 while the tool holds the contact cells.
    pub engaged: u32,
}

/// What it looks at in an answer: the tick, and tool 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Force {
    /// Number of the tick.
    pub tick: u64,
    /// Force on the tool \[N\].
    pub force_n: [f32; 3],
    /// Certified level \[J\].
    pub energy_j: f32,
    /// Number of held cells.
    pub contacts: u32,
    /// What bit.
    pub flags: u32,
    /// Time of the tick \[ns\].
    pub step_ns: u32,
    /// Hash after the tick.
    pub state_hash: u64,
}

impl From<Forces> for Force {
    fn from(forces: Forces) -> Self {
        let tool = forces.each.into_iter().take(forces.tools as usize).find(|of| of.number == 0);
        let tool = tool.unwrap_or_default();
        Self {
            tick: forces.tick,
            force_n: tool.force_n,
            energy_j: forces.energy_j,
            contacts: tool.contacts,
            flags: forces.flags,
            step_ns: forces.step_ns,
            state_hash: forces.state_hash,
        }
    }
}

/// What messages of a topic belong to.
pub trait Header: Copy + std::fmt::Debug + ZeroCopySend + 'static {
    /// Last part of the service's name.
    const TOPIC: &'static str;

    /// Ticks answered.
    fn ticks_answered(&self) -> u64;
}

impl Header for Stamp {
    const TOPIC: &'static str = "state";

    fn ticks_answered(&self) -> u64 {
        self.ticks_answered
    }
}

impl Header for ContactsHeader {
    const TOPIC: &'static str = "contacts";

    fn ticks_answered(&self) -> u64 {
        self.ticks_answered
    }
}

impl Header for SurfaceHeader {
    const TOPIC: &'static str = "surface";

    fn ticks_answered(&self) -> u64 {
        self.ticks_answered
    }
}

impl Header for StressHeader {
    const TOPIC: &'static str = "stress";

    /// Those before the pass, where the first tick is number 0.
    fn ticks_answered(&self) -> u64 {
        self.first_tick + 1
    }
}

/// A reader of somebody else: rows and what they belong to.
#[derive(Debug)]
pub struct Reader<Row: ZeroCopySend + std::fmt::Debug + 'static, H: Header> {
    subscriber: Subscriber<ipc::Service, [Row], H>,
    _node: Node<ipc::Service>,
}

/// A viewer of somebody else.
pub type Viewer = Reader<Row, Stamp>;

/// A reader of contacts of somebody else.
pub type Watcher = Reader<Contact, ContactsHeader>;

impl<Row: Clone + ZeroCopySend + std::fmt::Debug, H: Header> Reader<Row, H> {
    /// Joins a scene's readers.
    #[track_caller]
    #[must_use]
    pub fn join(scene: &str) -> Self {
        let node = node();
        let name = service(scene, H::TOPIC);
        let topic = eventually(|| {
            let service = node.service_builder(&name).publish_subscribe::<[Row]>();
            service.user_header::<H>().open().ok()
        });
        let subscriber = topic.subscriber_builder().create().unwrap();
        Self { subscriber, _node: node }
    }

    /// A message that has arrived.
    #[must_use]
    pub fn try_receive(&self) -> Option<(H, Vec<Row>)> {
        let sample = self.subscriber.receive().unwrap()?;
        Some((*sample.user_header(), sample.payload().to_vec()))
    }

    /// The first message of at least so many answered ticks.
    #[track_caller]
    #[must_use]
    pub fn after(&self, ticks_answered: u64) -> (H, Vec<Row>) {
        eventually(|| self.try_receive().filter(|found| found.0.ticks_answered() >= ticks_answered))
    }
}

/// A program of somebody else that commands.
#[derive(Debug)]
pub struct Commander {
    client: Client<ipc::Service, Order, (), Reply, ()>,
    _node: Node<ipc::Service>,
}

impl Commander {
    /// Joins a scene.
    #[track_caller]
    #[must_use]
    pub fn join(scene: &str) -> Self {
        let node = node();
        let name = service(scene, "command");
        let command = eventually(|| {
            node.service_builder(&name).request_response::<Order, Reply>().open().ok()
        });
        let client = command.client_builder().create().unwrap();
        Self { client, _node: node }
    }

    /// The reply to a command.
    #[track_caller]
    #[must_use]
    pub fn order(&self, order: Order) -> Reply {
        let pending = self.client.send_copy(order).unwrap();
        eventually(|| pending.receive().unwrap().map(|reply| *reply))
    }
}

/// The poses as another release might declare them.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolPoses.v3")]
#[repr(C)]
pub struct PosesOfAnotherRelease {
    /// Tool position \[m\].
    pub position_m: [f64; 3],
}

/// The poses under their own name in another layout.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolPoses.v2")]
#[repr(C)]
pub struct OtherPoses {
    /// Number of the tick.
    pub tick: u64,
    /// Tool position \[m\].
    pub position_m: [f64; 3],
}

/// A program that has one of the scene's services open for its own messages.
#[derive(Debug)]
pub struct OtherService<Message: ZeroCopySend + std::fmt::Debug + 'static> {
    _service: publish_subscribe::PortFactory<ipc::Service, Message, ()>,
    _node: Node<ipc::Service>,
}

impl<Message: ZeroCopySend + std::fmt::Debug> OtherService<Message> {
    /// Opens the scene's service, or creates it.
    ///
    /// # Errors
    /// What iceoryx2 says when it is there for other messages.
    pub fn create(scene: &str, topic: &str) -> Result<Self, String> {
        let node = node();
        let builder = node.service_builder(&service(scene, topic)).publish_subscribe::<Message>();
        let service = builder.open_or_create().map_err(|why| format!("{why:?}"))?;
        Ok(Self { _service: service, _node: node })
    }
}

/// Nodes of a process that has died which nobody has cleared up.
#[must_use]
pub fn dead_nodes_of(process: u32) -> usize {
    let mut found = 0;
    let listed = Node::<ipc::Service>::list(&Config::default(), |node| {
        if let NodeState::Dead(view) = &node
            && view.id().pid::<ipc::Service>().is_ok_and(|pid| pid.value() as u32 == process)
        {
            found += 1;
        }
        CallbackProgression::Continue
    });
    listed.unwrap();
    found
}

fn node() -> Node<ipc::Service> {
    set_log_level(LogLevel::Fatal);
    NodeBuilder::new()
        .config(&Config::default())
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .unwrap()
}

fn service(scene: &str, topic: &str) -> ServiceName {
    format!("chaincell/{scene}/{topic}").as_str().try_into().unwrap()
}

/// The outside program with one tool, on one scene.
#[derive(Debug)]
pub struct Outsider(ToolsOutsider);

impl Outsider {
    /// Joins a scene as a reader of answers once its services exist; as a sender of poses too if
    /// it `sends`.
    #[track_caller]
    #[must_use]
    pub fn join(scene: &str, sends: bool) -> Self {
        Self(ToolsOutsider::join_as(scene, sends))
    }

    /// Sends one pose.
    pub fn send(&self, pose: Pose) {
        self.0.send(one_tool(pose.tick, pose.position_m, pose.engaged));
    }

    /// The next answer.
    #[track_caller]
    #[must_use]
    pub fn receive(&self) -> Force {
        self.0.receive().into()
    }

    /// Sends the poses of ticks, each after the answer to the one before; the answers.
    #[track_caller]
    pub fn play(&self, ticks: std::ops::Range<u64>, pose: impl Fn(u64) -> Pose) -> Vec<Force> {
        let answer = |tick| {
            self.send(pose(tick));
            self.receive()
        };
        ticks.map(answer).collect()
    }

    /// Waits for an answer to a tick of at least this number.
    #[track_caller]
    pub fn after(&self, tick: u64) -> u64 {
        loop {
            let seen = self.receive().tick;
            if seen >= tick {
                return seen;
            }
        }
    }

    /// An answer that has arrived.
    #[must_use]
    pub fn try_receive(&self) -> Option<Force> {
        self.0.try_receive().map(Force::from)
    }
}

/// Length of a vector.
#[must_use]
pub fn size(of: [f32; 3]) -> f64 {
    of.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>().sqrt()
}

/// Largest change of the force from a message to the next one \[N\].
#[must_use]
pub fn largest_step_n(seen: &[Force]) -> f64 {
    let step = |pair: &[Force]| {
        size(std::array::from_fn(|axis| pair[1].force_n[axis] - pair[0].force_n[axis]))
    };
    seen.windows(2).map(step).fold(0.0, f64::max)
}

#[track_caller]
fn eventually<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < LIMIT, "nothing within {LIMIT:?}");
        std::thread::sleep(Duration::from_micros(200));
    }
}
