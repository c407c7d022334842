//! Cost of a peer that joins or leaves: the thread that notices it maps or unmaps its memory.

use serde::{Deserialize, Serialize};

use crate::session::timing::clock::now_ns;

/// Cost of peers that joined and left.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PeerCost {
    /// Ports that appeared on the scene's services while the loop ran.
    pub joins: u64,
    /// Ports that disappeared.
    pub leaves: u64,
    /// Longest call in which a change was noticed while no pose was under way \[ns\].
    pub idle_ns_max: u64,
    /// Longest receive that delivered a pose and in which a change was noticed \[ns\].
    pub receive_ns_max: u64,
    /// Longest send in which a change was noticed \[ns\].
    pub send_ns_max: u64,
}

impl PeerCost {
    /// Returns the longest call in which a change was noticed \[ns\].
    #[must_use]
    pub fn longest_ns(&self) -> u64 {
        self.idle_ns_max.max(self.receive_ns_max).max(self.send_ns_max)
    }
}

/// Watches the number of ports around calls that may connect or disconnect peers.
#[derive(Debug)]
pub(crate) struct PeerWatch {
    known: usize,
    settle: bool,
    cost: PeerCost,
}

/// Kind of a timed call.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Call {
    Idle,
    Receive,
    Send,
}

impl PeerWatch {
    pub(crate) fn new(ports_count: usize) -> Self {
        Self { known: ports_count, settle: false, cost: PeerCost::default() }
    }

    /// Runs a call, and records its duration if the number of ports changed shortly before or during it.
    pub(crate) fn timed<R>(
        &mut self,
        count: impl Fn() -> usize,
        call: impl FnOnce() -> (Call, R),
    ) -> R {
        let changed = self.look(count());
        let start_ns = now_ns();
        let (kind, result) = call();
        let span_ns = now_ns() - start_ns;
        // A change during the call may be noticed by this call or by the next one.
        let settling = std::mem::replace(&mut self.settle, false);
        self.settle = self.look(count());
        if changed || settling || self.settle {
            self.book(kind, span_ns);
        }
        result
    }

    pub(crate) fn cost(&self) -> PeerCost {
        self.cost
    }

    fn look(&mut self, count: usize) -> bool {
        let before = std::mem::replace(&mut self.known, count);
        self.cost.joins += count.saturating_sub(before) as u64;
        self.cost.leaves += before.saturating_sub(count) as u64;
        before != count
    }

    fn book(&mut self, kind: Call, span_ns: u64) {
        let max = match kind {
            Call::Idle => &mut self.cost.idle_ns_max,
            Call::Receive => &mut self.cost.receive_ns_max,
            Call::Send => &mut self.cost.send_ns_max,
        };
        *max = (*max).max(span_ns);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_calls_around_a_change_are_booked() {
        let mut watch = PeerWatch::new(4);
        watch.timed(|| 4, || (Call::Send, ()));
        assert_eq!(watch.cost(), PeerCost::default());
        watch.timed(
            || 6,
            || (Call::Receive, std::thread::sleep(std::time::Duration::from_micros(1))),
        );
        watch.timed(|| 5, || (Call::Idle, ()));
        let cost = watch.cost();
        assert_eq!((cost.joins, cost.leaves), (2, 1));
        assert!(cost.receive_ns_max >= 1000);
        assert_eq!(cost.send_ns_max, 0);
    }
}
