//! Intake of poses: accepts or rejects them, and measures the time between them by ticks and clock.

use iceoryx2::identifiers::UniquePublisherId;

use super::Run;
use super::arrived::Arrived;
use crate::engine::order::TickPlace;
use crate::session::ipc::complain::complain;
use crate::session::ipc::services::QUEUE_MESSAGES;
use crate::session::ipc::serving::ReceivedPoses;
use crate::session::loops::peers::Call;
use crate::session::timing::clock::{MILLISECOND_NS, now_ns};

/// Time between checks that the publisher in charge is alive \[ns\].
const ALIVE_CHECK_NS: u64 = 100 * MILLISECOND_NS;

impl Run<'_> {
    /// Moves waiting poses from the queue to the inbox, at most a queue full. Returns true if any came.
    pub(super) fn take_in(&mut self) -> bool {
        let before = self.inbox.len();
        let mut received = 0;
        while received < QUEUE_MESSAGES && self.inbox.len() < QUEUE_MESSAGES {
            let Some(poses) = self.receive() else { break };
            received += 1;
            self.accept(poses);
        }
        let accepted = self.inbox.len().saturating_sub(before) as u64;
        if accepted > 0 {
            let now_ns = now_ns();
            self.budget.arrived(accepted, now_ns.saturating_sub(self.looked_ns));
            self.looked_ns = now_ns;
        }
        received > 0
    }

    fn receive(&mut self) -> Option<ReceivedPoses> {
        let (server, failed) = (self.server, &mut self.failed);
        let chosen = self.session.chosen;
        self.peers.timed(
            || server.scene.ports_count(),
            || match server.ports.receive(chosen) {
                Ok(Some(received)) => (Call::Receive, Some(received)),
                Ok(None) => (Call::Idle, None),
                Err(why) => {
                    complain(failed, "cannot receive a pose", why);
                    (Call::Idle, None)
                }
            },
        )
    }

    /// Puts a pose into the inbox if it is the next one of the publisher in charge.
    fn accept(&mut self, received: ReceivedPoses) {
        let arrival_ns = now_ns();
        let ReceivedPoses { tick, poses, asked, publisher } = received;
        // Refuse a second publisher while the first one is alive.
        if self.in_charge != Some(publisher) {
            if self.in_charge.is_some_and(|known| self.is_in_charge(known, arrival_ns)) {
                complain(&mut self.refused, "a second publisher sends poses", publisher.value());
                return;
            }
            self.publishers += 1;
            self.in_charge = Some(publisher);
            self.session.take_charge(publisher.value());
        }
        // Refuse repeated and bad ticks, and poses above the rate.
        let (place, steps) = self.session.place(tick);
        match place {
            TickPlace::Next => {}
            TickPlace::Repeated => {
                complain(&mut self.repeated, "tick not above the last one", tick);
                return;
            }
            TickPlace::Bad => {
                complain(&mut self.refused, "bad tick, far from the last one", tick);
                return;
            }
        }
        if !self.rate.takes(arrival_ns) {
            complain(
                &mut self.throttled,
                "poses come faster than --max-pose-hz and are dropped, tick",
                tick,
            );
            return;
        }
        // Note the arrival, and queue the pose.
        self.waiter
            .arrived(arrival_ns, arrival_ns.saturating_sub(self.shared.voice().shaper.heard_ns()));
        self.waiter.expect_after(arrival_ns);
        let arrived = Arrived { tick, poses, asked, at_ns: arrival_ns, ..Arrived::default() };
        self.inbox.push_back(self.session.accept(arrived, steps));
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
