//! Work of the serving loop between two ticks: commands, pauses, states for viewers.

use chaincell_kernel::trace::{Command, CommandRecord};

use super::Run;
use crate::engine::tissue::{Refusal, TissueEngine};
use crate::session::ipc::contacts::ContactsHeader;
use crate::session::ipc::payload::{CommandMessage, ReplyMessage, StateHeader};
use crate::session::ipc::stress::{StressHeader, StressPublisher};
use crate::session::ipc::tools::TickForce;
use crate::session::timing::clock::now_ns;
use crate::terminal;

impl Run<'_> {
    /// The tissue's last answer.
    fn answer(&self) -> Option<TickForce> {
        self.shared.voice().answer.map(|answer| answer.force)
    }

    /// Marks state, stress, surface and contacts as changed since they were last sent.
    pub(super) fn changed(&mut self) {
        if let Some(state) = &mut self.state {
            state.feed.changed();
        }
        if let Some(stress) = &mut self.stress {
            stress.changed();
        }
        if let Some(surface) = &mut self.surface {
            surface.feed.changed();
        }
        if let Some(contacts) = &mut self.contacts {
            contacts.feed.changed();
        }
    }

    /// Handles commands, then publishes states, surfaces, stresses and contacts, between two ticks; `idle` if no pose
    /// waits.
    pub(super) fn beside(&mut self, idle: bool) {
        let has_viewers = self.state.is_some() || self.stress.is_some() || self.contacts.is_some();
        if self.commands.is_none() && !has_viewers {
            return;
        }
        let now_ns = now_ns();
        // One command.
        self.told_of_file();
        if self.commands.as_ref().is_some_and(|commands| commands.is_due(now_ns, idle))
            && let Some(request) = self.commands.as_mut().and_then(|of| of.receive(now_ns))
        {
            let (reply, is_later) = self.carry_out(&request);
            if let Some(commands) = &mut self.commands {
                commands.reply(request, reply, is_later);
            }
        }
        // The state, and of a body that can be cut its surface, if they are due.
        if self.state.as_mut().is_some_and(|state| state.feed.is_due(now_ns, idle)) {
            let header = self.state_header();
            if let Some(state) = &mut self.state {
                state.send(header, self.session.engine);
            }
        }
        if self.surface.as_mut().is_some_and(|surface| surface.feed.is_due(now_ns, idle)) {
            let header = self.state_header();
            if let Some(surface) = &mut self.surface {
                surface.send(header, self.session.engine);
            }
        }
        // The next stresses.
        self.look_at_stress(|stress, header, engine| stress.step(header, engine, idle));
        // The contacts, if they are due.
        if self.contacts.as_mut().is_some_and(|contacts| contacts.feed.is_due(now_ns, idle)) {
            let header = ContactsHeader {
                tick: self.session.last_tick(),
                ticks_answered: self.session.executed,
                contacts: 0,
                flags: self.answer().map_or(0, |last| last.flags),
            };
            if let Some(contacts) = &mut self.contacts {
                contacts.send(header, self.session.engine);
            }
        }
    }

    /// Prints the warning of `look`, which is called if stress is published.
    pub(super) fn look_at_stress(
        &mut self,
        look: impl FnOnce(&mut StressPublisher, StressHeader, &mut dyn TissueEngine) -> Option<String>,
    ) {
        let Some(stress) = &mut self.stress else { return };
        let header = StressHeader {
            tick: self.session.last_tick(),
            model_checksum: self.session.engine.model_checksum(),
            ..StressHeader::default()
        };
        if let Some(warning) = look(stress, header, self.session.engine) {
            terminal::note(format_args!("WARNING: {warning}"));
        }
    }

    /// The header of the state of now.
    fn state_header(&mut self) -> StateHeader {
        StateHeader {
            tick: self.session.last_tick(),
            ticks_answered: self.session.executed,
            state_hash: self.state_hash(),
            nodes: 0,
            flags: self.answer().map_or(0, |last| last.flags),
            model_checksum: self.session.engine.model_checksum(),
            reserved: 0,
        }
    }

    /// The hash of the last answer, or a new one if it has none.
    fn state_hash(&mut self) -> u64 {
        match self.answer() {
            Some(TickForce { state_hash: hash @ 1.., .. }) => hash,
            _ => self.session.engine.state_hash(),
        }
    }

    /// Executes a command. Returns the reply, and whether it has to wait until a snapshot is written.
    fn carry_out(&mut self, message: &CommandMessage) -> (ReplyMessage, bool) {
        let done = message.command().and_then(|command| self.obey(&command));
        let pin = match done {
            Ok(Command::Pin { .. } | Command::PinAt { .. }) => self.session.engine.newest_pin(),
            _ => None,
        };
        let reply = ReplyMessage {
            tick: self.session.last_tick(),
            ticks_answered: self.session.executed,
            state_hash: self.session.engine.state_hash(),
            result: u32::from(done.is_err()),
            reason: done.err().map_or_else(|| pin.unwrap_or_default().into(), |why| why as u32),
        };
        match done {
            Err(_) => self.disobeyed += 1,
            Ok(command) => {
                self.obeyed += 1;
                let state_hash = Some(reply.state_hash);
                self.recorder.command(CommandRecord { tick: reply.tick, command, state_hash });
                self.changed();
            }
        }
        (reply, matches!(done, Ok(Command::Snapshot { .. })))
    }

    fn obey(&mut self, command: &Command) -> Result<Command, Refusal> {
        if !self.recorder.has_room_for_command() {
            return Err(Refusal::Recording);
        }
        match command {
            Command::Snapshot { .. } => {
                self.snapshot().map(|checksum| Command::Snapshot { checksum })
            }
            other => self.session.obey(other).map(|()| *other),
        }
    }
}
