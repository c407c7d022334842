//! Poses on their way in: which are accepted, and what their ticks and the clock say of the time
//! between them.

use chaincell_kernel::{TOOLS_MAX, ToolSample};
use iceoryx2::identifiers::UniquePublisherId;

use super::Run;
use crate::engine::order::{TickOrder, TickPlace, follows};
use crate::engine::tools::Poses;
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
    pub id: UniquePublisherId,
    order: TickOrder,
    /// From its last tick but one to its last.
    step: u64,
}

/// A pose that was accepted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Arrived {
    pub pose: ToolPose,
    /// Poses of the tools that were chosen by their parts.
    pub tools: Poses,
    /// What its message asks for, `None` for one of version 1.
    pub asked: Option<Asked>,
    pub at_ns: u64,
    /// There was a silence, a gap or a pause before it: the output stage's ramp begins anew.
    pub restarts_ramp: bool,
    /// Which tools count as not engaged, since they were not seen released yet.
    pub release_first: [bool; TOOLS_MAX],
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
            || match server.ports.receive(self.tools_first, self.chosen) {
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
    fn accept(&mut self, Came { pose, tools, asked, publisher }: Came) {
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
                self.resume(publisher.value());
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
            complain(
                &mut self.throttled,
                "poses come faster than --max-pose-hz and are dropped, tick",
                pose.tick,
            );
            return;
        }
        self.waiter
            .arrived(arrival_ns, arrival_ns.saturating_sub(self.shared.voice().shaper.heard_ns()));
        self.waiter.expect_after(arrival_ns);
        let restarts_ramp = self.has_gap(step, usual, arrival_ns);
        let at_ns = arrival_ns;
        let release_first = [false; TOOLS_MAX];
        let mut arrived = Arrived { pose, tools, asked, at_ns, restarts_ramp, release_first };
        self.release(&mut arrived);
        self.inbox.push_back(arrived);
    }

    /// The poses of all tools: each counts as not engaged until it was seen released. A pose of version
    /// 1 is that of tool 0, and says nothing of the others.
    fn release(&mut self, arrived: &mut Arrived) {
        let is_alone = arrived.asked.is_none();
        if is_alone {
            arrived.tools = self.standing.with_first_alone(&ToolSample::from(arrived.pose));
        }
        let said = if is_alone { 1 } else { TOOLS_MAX };
        let seen = self.has_released.iter_mut().zip(&mut arrived.release_first).take(said);
        if self.chosen == 0 {
            seen.take(1).for_each(|seen| unless_released(seen, &mut arrived.pose.engaged));
        } else {
            let each = arrived.tools.each_mut().iter_mut().map(|pose| &mut pose.engaged);
            seen.zip(each).for_each(|(seen, engaged)| unless_released(seen, engaged));
            arrived.pose.engaged = arrived.tools.each().first().map_or(0, |pose| pose.engaged);
        }
        if arrived.tools.are_good() {
            self.standing = arrived.tools;
        }
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

/// Takes a tool as not engaged where it was not seen released yet, and notes that.
fn unless_released((has_released, release_first): (&mut bool, &mut bool), engaged: &mut u32) {
    *has_released |= *engaged == 0;
    if !*has_released && *engaged == 1 {
        (*engaged, *release_first) = (0, true);
    }
}
