//! States for viewers: all node positions, a bounded number of times a second, beside the loop.
//!
//! A state is a slice of [`NodePosition`], one for every node by ascending input id, as in
//! cells_final.csv; each row names its node, so that a reader needs nothing but the sample. It is
//! sent between ticks while nobody waits for an answer, if somebody reads and something is new: a
//! tick, a command, or a reader. Readers keep the newest state alone.

use iceoryx2::prelude::*;

use crate::engine::tissue::{Node, TissueEngine};
use crate::error::Result;
use crate::session::ipc::payload::{NodePosition, StateHeader};
use crate::session::ipc::services::SceneServices;
use crate::session::ipc::viewed::{Feed, Reader, Viewed};
use crate::session::timing::clock::now_ns;

impl Viewed for NodePosition {
    type Header = StateHeader;
    const WHAT: &'static str = "a state";
    const NONE: &'static str = "no state";

    fn name(scene: &SceneServices) -> &ServiceName {
        &scene.state_name
    }
}

/// The server's side.
#[derive(Debug)]
pub(crate) struct StatePublisher {
    pub feed: Feed<NodePosition>,
    nodes: Vec<Node>,
}

impl StatePublisher {
    /// Room for `nodes` nodes, sent at most `hz` times a second.
    pub(crate) fn open(scene: &SceneServices, nodes: usize, hz: u32) -> Result<Self> {
        Ok(Self { feed: Feed::open(scene, nodes, hz)?, nodes: vec![Node::default(); nodes] })
    }

    /// Sends the state. Allocates nothing of its own.
    pub(crate) fn send(&mut self, header: StateHeader, engine: &mut dyn TissueEngine) {
        let start_ns = now_ns();
        engine.read_nodes(&mut self.nodes);
        let nodes = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        let header = StateHeader { nodes, ..header };
        self.feed.send(start_ns, header, (self.nodes.len(), |at| self.nodes[at].into()));
    }
}

/// A reader of states.
pub type StateReader = Reader<NodePosition>;
