//! Outputs of each tick: a row of the recording, and an answer on the service from which the pose came.

use chaincell_kernel::{Flags, TickOutput};

use super::Run;
use super::arrived::Arrived;
use crate::engine::motion::Pose;
use crate::session::ipc::complain::complain;
use crate::session::ipc::tools::{Answer, TickForce};
use crate::session::loops::peers::Call;
use crate::session::loops::record::Row;
use crate::session::timing::clock::now_ns;

impl Run<'_> {
    /// Records a tick and sends its answer.
    pub(super) fn publish(&mut self, arrived: &Arrived, output: &TickOutput, step_ns: u64) {
        let sweeps = self.is_anytime().then_some(output.sweeps);
        let answer = self.session.answer(arrived, output, step_ns);
        // Recorded first, so that no answer is visible whose tick a kill could lose.
        let row = Row {
            pose: Pose { sweeps, ..arrived.first() },
            force: answer.force,
            ramp_restarted: arrived.restarts_ramp,
            delay_ticks: self.delay.told,
        };
        let tools = arrived.poses.each().get(..self.session.chosen).unwrap_or(&[]);
        self.recorder.record_tools(row, tools, &answer.felt);
        let shown = self.session.publish(answer, now_ns());
        self.flag_ticks.add(Flags(answer.force.flags | shown.force.flags & Flags::LATE.0));
        self.send(&shown);
        // Behind the answer, which does not wait for it.
        if !self.session.is_paused() {
            self.estimate(&answer);
        }
    }

    /// Adds the estimated error of each tool's force.
    fn estimate(&mut self, answer: &Answer) {
        if answer.chosen == 0 {
            let TickForce { force_n, contacts, force_error_n, .. } = answer.force;
            self.estimates.add(force_n, contacts, force_error_n);
        }
        for felt in answer.tools() {
            self.estimates.add(felt.force_n, felt.contacts, felt.force_error_n);
        }
    }

    /// Lets the published force fall to 0 when poses stop coming.
    pub(super) fn watch(&mut self) {
        let falling = self.session.silence(now_ns());
        if let Some(answer) = falling {
            self.send(&answer);
        }
    }

    fn send(&mut self, answer: &Answer) {
        let (server, failed) = (self.server, &mut self.failed);
        self.peers.timed(
            || server.scene.ports_count(),
            || {
                if let Err(why) = server.ports.answers.send(answer) {
                    complain(failed, "cannot send an answer", why);
                }
                (Call::Send, ())
            },
        );
        server.ports.ring();
    }
}
