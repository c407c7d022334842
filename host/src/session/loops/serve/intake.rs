//! Poses on their way in: which are accepted, and what their ticks and the clock say of the time
//! between them.

use iceoryx2::identifiers::UniquePublisherId;

use super::Run;
use crate::engine::order::{TickOrder, TickPlace, follows};
use crate::session::ipc::complain::complain;
use crate::session::ipc::payload::ToolPose;
use crate::session::ipc::services::QUEUE_MESSAGES;
use crate::session::ipc::serving::Came;
use crate::session::ipc::tools::Asked;
use crate::session::loops::peers::Call;
use crate::session::timing::clock::{MILLISECOND_NS, now_ns};

/// Span between looks whether the publisher in charge is still alive \[ns\].
const ALIVE_CHECK_NS: u64 = 100 * MILLISECOND_NS;

/// The publisher whose poses are executed.
#[derive(Debug, Clone, Copy)]
pub(super) struct InCharge {
    id: UniquePublisherId,
    order: TickOrder,
    /// From its last tick but one to its last.
    step: u64,
}

/// A pose that was accepted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Arrived {
    pub pose: ToolPose,
    /// What its message asks for, `None` for one of version 1.
    pub asked: Option<Asked>,
    pub at_ns: u64,
    /// There was a silence or a gap before it: the output stage's ramp begins anew.
    pub restarts_ramp: bool,
    /// It counts as not engaged, since the tool was not seen released yet.
    pub release_first: bool,
}

impl Run<'_> {
    /// Moves what waits in both queues into the inbox, at most a queue full; whether anything came.
    pub(super) fn take_in(&mut self) -> bool {
        let before = self.inbox.len();
        let mut received = 0;
        while received < QUEUE_MESSAGES && self.inbox.len() < QUEUE_MESSAGES {
            let Some(came) = self.receive() else { break };
            received += 1;
            self.accept(came);
        }
        let accepted = self.inbox.len().saturating_sub(before) as u64;
        if accepted > 0 {
            let now_ns = now_ns();
            self.budget.arrived(accepted, now_ns.saturating_sub(self.looked_ns));
            self.looked_ns = now_ns;
        }
        received > 0
    }

    fn receive(&mut self) -> Option<Came> {
        self.tools_first = !self.tools_first;
        let (server, failed) = (self.server, &mut self.failed);
        self.peers.timed(
            || server.scene.ports_count(),
            || match server.ports.receive(self.tools_first) {
                Ok(Some(came)) => (Call::Receive, Some(came)),
                Ok(None) => (Call::Idle, None),
                Err(why) => {
                    complain(failed, "cannot receive a pose", why);
                    (Call::Idle, None)
                }
            },
        )
    }

    /// Puts a pose into the inbox where it is the next one of the publisher in charge.
    fn accept(&mut self, Came { pose, asked, publisher }: Came) {
        let arrival_ns = now_ns();
        let in_charge = self.in_charge;
        let (mut order, usual) = match in_charge {
            Some(known) if known.id == publisher => (known.order, known.step),
            Some(known) if self.is_in_charge(known.id, arrival_ns) => {
                complain(&mut self.refused, "a second publisher sends poses", publisher.value());
                return;
            }
            _ => {
                self.publishers += 1;
                self.shared.voice().shaper.begin_ramp();
                (TickOrder::default(), 1)
            }
        };
        let before = order.last();
        let place = order.take(pose.tick);
        let step = before.filter(|&before| follows(before, pose.tick)).map(|last| pose.tick - last);
        let is_next = place == TickPlace::Next;
        let kept = if is_next { step.unwrap_or(1) } else { usual };
        self.in_charge = Some(InCharge { id: publisher, order, step: kept });
        match place {
            TickPlace::Next => {}
            TickPlace::Repeated => {
                complain(&mut self.repeated, "tick not above the last one", pose.tick);
                return;
            }
            TickPlace::Bad => {
                complain(&mut self.refused, "bad tick, far from the last one", pose.tick);
                return;
            }
        }
        let step = step.unwrap_or(1);
        self.missing += step - 1;
        if !self.rate.takes(arrival_ns) {
            complain(&mut self.throttled, "poses come faster than the limit a second", pose.tick);
            return;
        }
        self.waiter
            .arrived(arrival_ns, arrival_ns.saturating_sub(self.shared.voice().shaper.heard_ns()));
        self.waiter.expect_after(arrival_ns);
        let restarts_ramp = self.has_gap(step, usual, arrival_ns);
        let at_ns = arrival_ns;
        let mut arrived = Arrived { pose, asked, at_ns, restarts_ramp, release_first: false };
        self.has_released |= pose.engaged == 0;
        if !self.has_released && pose.engaged == 1 {
            (arrived.pose.engaged, arrived.release_first) = (0, true);
        }
        self.inbox.push_back(arrived);
    }

    /// Whether the device was without a force, by the clock or by the ticks: the ramp then begins. A
    /// controller that counts in larger steps all the time has no gap.
    fn has_gap(&mut self, step: u64, usual: u64, arrival_ns: u64) -> bool {
        let was_silent = self.shared.voice().shaper.hear(arrival_ns);
        let bearable = u64::from(self.server.options.watchdog_ms);
        let is_gap = bearable != 0 && step > bearable && step / 2 > usual;
        if is_gap && !was_silent {
            self.shared.voice().shaper.begin_ramp();
        }
        is_gap || was_silent
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
}
