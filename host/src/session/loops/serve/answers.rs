//! What leaves of each tick: a row of the recording and an answer, which goes where its pose came from.

use chaincell_kernel::{Flags, TOOLS_MAX, TickOutput};

use super::Run;
use super::intake::Arrived;
use crate::engine::tools::Felt;
use crate::session::ipc::complain::complain;
use crate::session::ipc::payload::ToolForce;
use crate::session::ipc::tools::Answer;
use crate::session::loops::peers::Call;
use crate::session::loops::record::Row;
use crate::session::timing::clock::now_ns;

impl Run<'_> {
    /// Records a tick and sends its answer.
    pub(super) fn publish(
        &mut self,
        arrived: Arrived,
        output: &TickOutput,
        step_ns: u64,
        state_hash: u64,
    ) {
        let Arrived { pose, asked, restarts_ramp: ramp_restarted, .. } = arrived;
        let felt = self.felt(&arrived);
        let mut flags = output.flags;
        if arrived.release_first.contains(&true) {
            flags.insert(Flags::RELEASE_FIRST);
        }
        felt.iter().for_each(|felt| flags.insert(felt.flags));
        let force = ToolForce {
            tick: pose.tick,
            force_n: output.force_n.into(),
            energy_j: output.energy_j,
            contacts: output.contacts,
            flags: flags.0,
            step_ns: u32::try_from(step_ns).unwrap_or(u32::MAX),
            reserved: 0,
            state_hash,
        };
        if output.sweeps > 0 {
            self.force_tick = pose.tick;
        }
        let sweeps = self.is_anytime().then_some(output.sweeps);
        // First, so that no answer is seen whose tick a kill could lose.
        let row = Row { pose, force, sweeps, ramp_restarted, delay_ticks: self.delay.told };
        self.recorder.record_tools(row, arrived.tools.each(), &felt);
        let (force_tick, sweeps) = (self.force_tick, output.sweeps.into());
        let chosen = self.chosen as u32;
        let answer = Answer { force, force_tick, sweeps, asked, chosen, felt };
        let shown = self.shared.voice().shown(answer, now_ns());
        self.flag_ticks.add(Flags(force.flags | shown.force.flags & Flags::LATE.0));
        self.send(&shown);
    }

    /// What each chosen tool felt in the tick; nothing while paused, when no tool is moved.
    fn felt(&mut self, arrived: &Arrived) -> [Felt; TOOLS_MAX] {
        let mut all = [Felt::default(); TOOLS_MAX];
        if self.chosen == 0 {
            return all;
        }
        let before = self.shared.voice().answer;
        for (tool, felt) in all.iter_mut().enumerate().take(self.chosen) {
            if self.paused {
                felt.contacts = before.map_or(0, |before| before.felt[tool].contacts);
            } else {
                *felt = self.engine.felt(tool);
            }
            if arrived.release_first[tool] {
                felt.flags.insert(Flags::RELEASE_FIRST);
            }
        }
        all
    }

    /// Lets the published force fall to 0 when poses stop coming.
    pub(super) fn watch(&mut self) {
        let falling = self.shared.voice().falling(now_ns());
        if let Some(answer) = falling {
            self.send(&answer);
        }
    }

    fn send(&mut self, answer: &Answer) {
        let (server, failed) = (self.server, &mut self.failed);
        self.peers.timed(
            || server.scene.ports_count(),
            || {
                if let Err(why) = server.ports.mouth.send(answer) {
                    complain(failed, "cannot send an answer", why);
                }
                (Call::Send, ())
            },
        );
        server.ports.ring();
    }
}
