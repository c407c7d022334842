//! One side of a session: which datagrams of the other one are new, and the head of its own.

use crate::datagram::{Head, Nonce};

/// What a side has sent and heard.
#[derive(Debug, Default)]
pub(crate) struct Side {
    /// Random numbers of the session, of the hand and of the agent.
    pub hand: Nonce,
    pub agent: Nonce,
    /// Number of the last datagram that was sent.
    pub sequence: u64,
    /// Arrival of the newest datagram of the other side \[ns\].
    pub heard_ns: u64,
    /// Number of that, and its send time by the other side's clock, 0 before the first \[ns\].
    newest: u64,
    echo_ns: u64,
}

impl Side {
    /// Starts with these random numbers.
    pub fn new(hand: Nonce, agent: Nonce, now_ns: u64) -> Self {
        Self { hand, agent, heard_ns: now_ns, ..Self::default() }
    }

    /// Takes the head of a datagram; returns false for one that was repeated or overtaken.
    pub fn hear(&mut self, head: &Head, now_ns: u64) -> bool {
        if head.sequence <= self.newest {
            return false;
        }
        (self.newest, self.echo_ns, self.heard_ns) = (head.sequence, head.stamp_ns, now_ns);
        true
    }

    /// Returns the head of the next datagram.
    pub fn head(&mut self, now_ns: u64) -> Head {
        self.sequence += 1;
        Head {
            hand: self.hand,
            agent: self.agent,
            sequence: self.sequence,
            stamp_ns: now_ns,
            echo_ns: self.echo_ns,
            hold_ns: if self.echo_ns == 0 { 0 } else { now_ns.saturating_sub(self.heard_ns) },
        }
    }
}
