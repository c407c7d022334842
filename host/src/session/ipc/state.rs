//! States for viewers: all node positions, a bounded number of times a second, beside the loop.
//!
//! A state is a slice of [`NodePosition`], one for every node by ascending input id, as in
//! cells_final.csv; each row names its node, so that a reader needs nothing but the sample. It is
//! sent between ticks while nobody waits for an answer, if somebody reads and something is new: a
//! tick, a command, or a reader. Readers keep the newest state alone.

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe;

use crate::engine::tissue::{Node, TissueEngine};
use crate::error::{Error, Result};
use crate::session::ipc::complain::complain;
use crate::session::ipc::pace::Pace;
use crate::session::ipc::payload::{NodePosition, StateHeader};
use crate::session::ipc::services::{
    Ipc, NODES_MAX, PUBLISHERS_MAX, SUBSCRIBERS_MAX, SceneServices, port_error, service_error,
};
use crate::session::timing::clock::now_ns;
use crate::session::timing::histogram::{Latencies, Summary};

type Topic = publish_subscribe::PortFactory<Ipc, [NodePosition], StateHeader>;

fn topic(scene: &SceneServices) -> Result<Topic> {
    scene
        .node
        .service_builder(&scene.state_name)
        .publish_subscribe::<[NodePosition]>()
        .user_header::<StateHeader>()
        .enable_safe_overflow(true)
        .history_size(0)
        .subscriber_max_buffer_size(1)
        .max_publishers(PUBLISHERS_MAX)
        .max_subscribers(SUBSCRIBERS_MAX)
        .max_nodes(NODES_MAX)
        .open_or_create()
        .map_err(|why| service_error(&scene.state_name, why))
}

/// The server's side.
#[derive(Debug)]
pub(crate) struct StatePublisher {
    topic: Topic,
    publisher: Publisher<Ipc, [NodePosition], StateHeader>,
    nodes: Vec<Node>,
    pace: Pace,
    failed: u64,
    cost: Latencies,
}

impl StatePublisher {
    /// Room for `nodes` nodes, sent at most `hz` times a second.
    pub(crate) fn open(scene: &SceneServices, nodes: usize, hz: u32) -> Result<Self> {
        let pace = Pace::new(hz)?;
        let topic = topic(scene)?;
        let publisher = topic
            .publisher_builder()
            .initial_max_slice_len(nodes.max(1))
            .allocation_strategy(AllocationStrategy::Static)
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|why| port_error(&scene.state_name, why))?;
        Ok(Self {
            topic,
            publisher,
            nodes: vec![Node::default(); nodes],
            pace,
            failed: 0,
            cost: Latencies::new()?,
        })
    }

    /// The state is another one than the last that was sent.
    pub(crate) fn changed(&mut self) {
        self.pace.changed();
    }

    /// Whether a state is to be sent now; where a pose may be waiting (`idle` is false) only once
    /// it is overdue by a period.
    pub(crate) fn is_due(&mut self, now_ns: u64, idle: bool) -> bool {
        self.pace.is_due(&self.topic, now_ns, idle)
    }

    /// Sends the state. Allocates nothing of its own.
    pub(crate) fn send(&mut self, header: StateHeader, engine: &mut dyn TissueEngine) {
        let start_ns = now_ns();
        engine.read_nodes(&mut self.nodes);
        let nodes = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        let sent = self.publisher.loan_slice_uninit(self.nodes.len()).map(|mut sample| {
            *sample.user_header_mut() = StateHeader { nodes, ..header };
            sample.write_from_fn(|at| self.nodes[at].into()).send()
        });
        match sent {
            Ok(Ok(_)) => {}
            Ok(Err(why)) => complain(&mut self.failed, "cannot send a state", why),
            Err(why) => complain(&mut self.failed, "cannot take memory for a state", why),
        }
        self.pace.sent();
        self.cost.record(now_ns() - start_ns);
    }

    /// States sent, and the time each took \[ns\].
    pub(crate) fn cost(&self) -> (u64, Summary) {
        (self.cost.count(), self.cost.summary())
    }
}

/// A reader of states.
#[derive(Debug)]
pub struct StateReader {
    topic: Topic,
    subscriber: Subscriber<Ipc, [NodePosition], StateHeader>,
}

impl StateReader {
    /// Joins the scene's readers.
    ///
    /// # Errors
    /// A service with other types or limits; too many readers.
    pub fn open(scene: &SceneServices) -> Result<Self> {
        let topic = topic(scene)?;
        let subscriber = topic.subscriber_builder().buffer_size(1).create();
        let subscriber = subscriber.map_err(|why| port_error(&scene.state_name, why))?;
        Ok(Self { topic, subscriber })
    }

    /// Whether a server sends states.
    #[must_use]
    pub fn is_served(&self) -> bool {
        // Meanwhile the connection is made, so that no state is missed.
        let _ = self.subscriber.update_connections();
        self.topic.dynamic_config().number_of_publishers() > 0
    }

    /// Limits and types of the service.
    #[must_use]
    pub fn topic(&self) -> &publish_subscribe::PortFactory<Ipc, [NodePosition], StateHeader> {
        &self.topic
    }

    /// The newest state that has not been taken, if any.
    ///
    /// # Errors
    /// What shared memory says.
    pub fn take(&self) -> Result<Option<(StateHeader, Vec<NodePosition>)>> {
        let sample = self.subscriber.receive();
        let sample = sample.map_err(|why| Error::check(format!("cannot read a state: {why:?}")))?;
        Ok(sample.map(|sample| (*sample.user_header(), sample.payload().to_vec())))
    }
}
