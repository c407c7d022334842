//! States for viewers: all node positions, sent between ticks at a limited rate.

pub use chaincell_client::state::StateReader;

use crate::engine::tissue::{Node, TissueEngine};
use crate::error::Result;
use crate::session::ipc::payload::{NodePosition, StateHeader};
use crate::session::ipc::services::SceneServices;
use crate::session::ipc::viewed::Feed;
use crate::session::timing::clock::now_ns;

/// The server's side.
#[derive(Debug)]
pub(crate) struct StatePublisher {
    pub feed: Feed<NodePosition>,
    nodes: Vec<Node>,
}

impl StatePublisher {
    /// Opens a publisher with capacity for `nodes` nodes, sent at most `hz` times per second.
    pub(crate) fn open(scene: &SceneServices, nodes: usize, hz: u32) -> Result<Self> {
        Ok(Self { feed: Feed::open(scene, nodes, hz)?, nodes: vec![Node::default(); nodes] })
    }

    /// Sends the state. Does not allocate itself.
    pub(crate) fn send(&mut self, header: StateHeader, engine: &mut dyn TissueEngine) {
        let start_ns = now_ns();
        engine.read_nodes(&mut self.nodes);
        let nodes = u32::try_from(self.nodes.len()).unwrap_or(u32::MAX);
        let header = StateHeader { nodes, ..header };
        self.feed.send(start_ns, header, (self.nodes.len(), |at| self.nodes[at].into()));
    }
}
