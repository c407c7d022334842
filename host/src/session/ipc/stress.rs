//! Strain and stress for viewers, and a limit that is watched: computed between ticks, some nodes at a time, so that no
//! pose waits for a whole body.

pub use chaincell_client::stress::{NodeStress, StressHeader, StressReader};

use crate::engine::stress_limit::StressLimit;
use crate::engine::stress_rows::StressRows;
use crate::engine::tissue::TissueEngine;
use crate::error::Result;
use crate::session::ipc::services::SceneServices;
use crate::session::ipc::viewed::Feed;
use crate::session::timing::clock::{MILLISECOND_NS, now_ns};

/// Nodes at a time: some 3 us each.
const STEP_NODES: usize = 24;
/// Time without a step after which one is made although a pose may be waiting \[ns\].
const OVERDUE_NS: u64 = 4 * MILLISECOND_NS;

/// The server's side.
#[derive(Debug)]
pub(crate) struct StressPublisher {
    pub feed: Feed<NodeStress>,
    /// Watched in every pass, and then also without a reader.
    pub limit: Option<StressLimit>,
    rows: StressRows,
    pass: Pass,
    stepped_ns: u64,
}

/// A pass over the body.
#[derive(Debug, Default)]
struct Pass {
    first_tick: u64,
    /// Time spent on it \[ns\].
    work_ns: u64,
    /// True if it is for readers.
    is_read: bool,
    /// True if the body has changed since it began.
    is_old: bool,
}

impl StressPublisher {
    /// Opens a publisher for a body with these numbers of nodes and cells, sent at most `hz` times per second.
    pub(crate) fn open(
        scene: &SceneServices,
        (nodes, cells): (usize, usize),
        hz: u32,
    ) -> Result<Self> {
        let feed = Feed::open(scene, nodes, hz)?;
        let rows = StressRows::new(nodes, cells);
        // A body that goes on from a snapshot is looked at although nothing has changed.
        let pass = Pass { is_old: true, ..Pass::default() };
        Ok(Self { feed, limit: None, rows, pass, stepped_ns: 0 })
    }

    /// Notes that the body has changed.
    pub(crate) fn changed(&mut self) {
        self.pass.is_old = true;
        self.feed.changed();
    }

    /// Returns true within a pass.
    pub(crate) fn is_in_pass(&self) -> bool {
        self.rows.is_in_pass()
    }

    /// Looks at the whole body once more, if a limit is watched: the session has ended. Returns as [`Self::step`].
    pub(crate) fn finish(
        &mut self,
        header: StressHeader,
        engine: &mut dyn TissueEngine,
    ) -> Option<String> {
        let limit = self.limit.as_mut()?;
        self.rows.read_all(engine);
        limit.take(self.rows.rows(), header.tick)
    }

    /// Computes the next nodes, if somebody reads or a limit is watched, and sends the body behind the last of them.
    /// While a pose may be waiting (`idle` is false) a step has to be overdue. Returns a warning for the first nodes
    /// ever above the limit. `header` is that of now. Does not allocate itself, but for the warning.
    pub(crate) fn step(
        &mut self,
        header: StressHeader,
        engine: &mut dyn TissueEngine,
        idle: bool,
    ) -> Option<String> {
        let start_ns = now_ns();
        if !idle && start_ns < self.stepped_ns + OVERDUE_NS {
            return None;
        }
        self.stepped_ns = start_ns;
        let (Self { feed, limit, rows, pass, .. }, tick) = (self, header.tick);
        // Begin a pass.
        if !rows.is_in_pass() {
            let is_read = feed.is_due(start_ns, true);
            let is_watched = limit.is_some() && pass.is_old;
            if !is_read && !is_watched {
                return None;
            }
            *pass = Pass { first_tick: tick, is_read, ..Pass::default() };
        }
        // Compute the next nodes.
        let is_last = rows.step(STEP_NODES, engine)?;
        pass.work_ns += now_ns() - start_ns;
        if !is_last {
            return None;
        }
        // End the pass.
        let rows = rows.rows();
        if pass.is_read {
            let (first_tick, work_ns) = (pass.first_tick, pass.work_ns);
            let nodes = u32::try_from(rows.len()).unwrap_or(u32::MAX);
            let header = StressHeader { first_tick, nodes, ..header };
            feed.send(now_ns().saturating_sub(work_ns), header, (rows.len(), |at| rows[at]));
            if pass.is_old {
                feed.changed();
            }
        }
        limit.as_mut().and_then(|limit| limit.take(rows, tick))
    }
}
