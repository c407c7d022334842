//! Surfaces of bodies that can be cut, for viewers: sent between ticks at the rate of states.

pub use chaincell_client::surface::{SurfaceHeader, SurfaceReader, SurfaceRow};

use crate::engine::tissue::TissueEngine;
use crate::error::Result;
use crate::session::ipc::payload::StateHeader;
use crate::session::ipc::services::SceneServices;
use crate::session::ipc::viewed::Feed;
use crate::session::timing::clock::now_ns;

/// The server's side.
#[derive(Debug)]
pub(crate) struct SurfacePublisher {
    pub feed: Feed<SurfaceRow>,
    rows: Vec<SurfaceRow>,
}

impl SurfacePublisher {
    /// Opens a publisher with capacity for `most` rows, sent at most `hz` times per second.
    pub(crate) fn open(scene: &SceneServices, most: usize, hz: u32) -> Result<Self> {
        Ok(Self { feed: Feed::open(scene, most, hz)?, rows: vec![SurfaceRow::default(); most] })
    }

    /// Sends the surface, with the header of the state. Does not allocate itself.
    pub(crate) fn send(&mut self, state: StateHeader, engine: &mut dyn TissueEngine) {
        let start_ns = now_ns();
        let StateHeader { tick, ticks_answered, state_hash, flags, model_checksum, .. } = state;
        let count = engine.read_surface(&mut self.rows);
        let header =
            SurfaceHeader { tick, ticks_answered, state_hash, flags, model_checksum, ..count };
        let rows = (count.nodes + count.copies).max(count.triangles) as usize;
        self.feed.send(start_ns, header, (rows, |at| self.rows[at]));
    }
}
