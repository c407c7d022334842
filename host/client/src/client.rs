//! The client: one handle on a scene, as its controller or as a viewer.

use chaincell_kernel::ToolPose;
use chaincell_kernel::trace::Command;

use crate::clock::{SECOND_NS, now_ns};
use crate::command::{CommandClient, refusal_text};
use crate::contacts::{Contact, ContactReader};
use crate::error::{Error, Kind, Result};
use crate::exchange::{Exchange, wait_for_server};
use crate::hearing::Answer;
use crate::options::{MS_MAX, Options, Role};
use crate::payload::{CommandMessage, NodePosition, ReplyMessage};
use crate::pose;
use crate::services::{QUEUE_MESSAGES, SceneServices};
use crate::state::StateReader;
use crate::stress::{NodeStress, StressReader};
use crate::viewed::View;

/// Upper limit of every wait \[ns\]: an hour.
const WAIT_NS_MAX: u64 = 3600 * SECOND_NS;

/// How a call that looked for an answer ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// An answer has come; if a pose was sent, the answer to it.
    Answered,
    /// No answer has come, and the watchdog has not expired: the last force counts.
    NoAnswer,
    /// No answer has come for the time of the watchdog: the force falls to 0, or is 0.
    Silent,
}

/// An open scene.
///
/// Dropping it leaves the scene; the server's watchdog then lets its force fall.
#[derive(Debug)]
pub struct Client {
    control: Option<Control>,
    state: Option<StateReader>,
    stress: Option<StressReader>,
    contacts: Option<ContactReader>,
    commands: Option<CommandClient>,
    // After its ports: fields are dropped in order.
    scene: SceneServices,
}

#[derive(Debug)]
struct Control {
    exchange: Exchange,
    tick: u64,
    /// Send times of the last poses, by tick modulo the length \[ns\].
    sent_ns: Box<[u64]>,
    foreign: u64,
}

impl Client {
    /// Opens a scene, waiting for its server. Allocates, maps memory, looks at files, and sleeps.
    ///
    /// # Errors
    /// No such scene, messages of another version, another controller, no free place, no permission, or too
    /// little memory.
    pub fn open(options: &Options) -> Result<Self> {
        Self::open_unless(options, || false)
    }

    /// As [`Self::open`], but calls `stop` every millisecond of the wait, and ends if it returns true.
    ///
    /// # Errors
    /// As there, and [`Kind::Stopped`] if `stop` returned true.
    pub fn open_unless(options: &Options, mut stop: impl FnMut() -> bool) -> Result<Self> {
        for (name, ms) in [("watchdog_ms", options.watchdog_ms), ("ramp_ms", options.ramp_ms)] {
            if ms > MS_MAX {
                let text = format!("`{name}` {ms}: must be from 0 to {MS_MAX}");
                return Err(Error::new(Kind::Argument, text));
            }
        }
        let scene =
            SceneServices::open_unless(options.scene.as_deref(), &options.domain, &mut stop)?;
        let server_wait_ns = options.server_wait_ns.min(WAIT_NS_MAX);
        let control = match options.role {
            Role::Viewer => {
                wait_for_server(&scene, options.role, server_wait_ns, stop)?;
                None
            }
            Role::Controller => {
                let options = Options { server_wait_ns, ..options.clone() };
                Some(Control::new(Exchange::open(&scene, &options, stop)?))
            }
        };
        Ok(Self { control, state: None, stress: None, contacts: None, commands: None, scene })
    }

    /// Sends the poses of tools 0, 1 and so on, and waits at most `wait_ns` for the answer to them.
    /// Allocates 104 bytes; waits as [`Options::wait`] says.
    ///
    /// # Errors
    /// A value that is no pose (nothing was sent then), or a viewer's handle.
    pub fn step(&mut self, poses: &[ToolPose], wait_ns: u64) -> Result<(Outcome, Answer)> {
        let control = self.control()?;
        let tick = control.send(poses)?;
        Ok(control.receive(Some(tick), wait_ns))
    }

    /// Sends the poses of tools 0, 1 and so on, and returns the number of the tick without waiting.
    /// Allocates 104 bytes.
    ///
    /// # Errors
    /// A value that is no pose (nothing was sent then), or a viewer's handle.
    pub fn send(&mut self, poses: &[ToolPose]) -> Result<u64> {
        self.control()?.send(poses)
    }

    /// Waits at most `wait_ns` for the answer to a tick that was sent; the second half of [`Self::step`].
    ///
    /// # Errors
    /// A viewer's handle.
    pub fn receive(&mut self, tick: u64, wait_ns: u64) -> Result<(Outcome, Answer)> {
        Ok(self.control()?.receive(Some(tick), wait_ns))
    }

    /// Takes all answers that have come, and returns the newest. Does not wait and does not allocate.
    ///
    /// # Errors
    /// A viewer's handle.
    pub fn try_receive(&mut self) -> Result<(Outcome, Answer)> {
        Ok(self.control()?.receive(None, 0))
    }

    /// Returns the answer to show now, from the answers taken so far.
    ///
    /// # Errors
    /// A viewer's handle.
    pub fn shown(&mut self) -> Result<Answer> {
        Ok(self.control()?.exchange.shown())
    }

    /// Returns true if a server is registered on the scene. A killed one may stay registered until another
    /// program starts.
    #[must_use]
    pub fn is_served(&self) -> bool {
        self.scene.is_served()
    }

    /// Returns the number of silences of the watchdog's length, the number of answers to other programs, and
    /// the largest change of a tool's force between two updates \[N\].
    ///
    /// # Errors
    /// A viewer's handle.
    pub fn counts(&mut self) -> Result<(u64, u64, f32)> {
        let Control { exchange, foreign, .. } = self.control()?;
        Ok((exchange.silences(), *foreign, exchange.largest_step_n()))
    }

    /// Returns the newest state that was not taken yet, without a copy. The first call joins the readers and
    /// allocates; a state comes with the next tick.
    ///
    /// # Errors
    /// No place for a further reader, or two states are held already.
    pub fn state(&mut self) -> Result<Option<View<NodePosition>>> {
        joined(&mut self.state, || StateReader::open(&self.scene))?.borrow()
    }

    /// Returns the newest strain and stress of all nodes that were not taken yet, without a copy; as [`Self::state`].
    /// The server computes them from the first call on.
    ///
    /// # Errors
    /// No place for a further reader, or two messages are held already.
    pub fn stress(&mut self) -> Result<Option<View<NodeStress>>> {
        joined(&mut self.stress, || StressReader::open(&self.scene))?.borrow()
    }

    /// Returns the newest contacts that were not taken yet, without a copy; as [`Self::state`].
    ///
    /// # Errors
    /// No place for a further reader, or two messages are held already.
    pub fn contacts(&mut self) -> Result<Option<View<Contact>>> {
        joined(&mut self.contacts, || ContactReader::open(&self.scene))?.borrow()
    }

    /// Sends a command and waits at most `wait_ns` for its reply: not for the loop of a device.
    ///
    /// # Errors
    /// No reply in time: then it is unknown if the command was carried out. A refusal, as
    /// [`Kind::Refused`] with the reason.
    pub fn command(&mut self, command: &Command, wait_ns: u64) -> Result<ReplyMessage> {
        self.command_unless(command, wait_ns, || false)
    }

    /// As [`Self::command`], but calls `stop` every millisecond of the wait, and ends if it returns true.
    ///
    /// # Errors
    /// As there, and [`Kind::Stopped`] if `stop` returned true: the command may still be carried out.
    pub fn command_unless(
        &mut self,
        command: &Command,
        wait_ns: u64,
        stop: impl Fn() -> bool,
    ) -> Result<ReplyMessage> {
        let reply = self.ask_unless(CommandMessage::new(command), wait_ns, stop)?;
        match reply.result {
            0 => Ok(reply),
            _ => Err(Error::new(
                Kind::Refused,
                format!(
                    "{} refused the command: {}",
                    self.scene.label(),
                    refusal_text(reply.reason)
                ),
            )),
        }
    }

    /// Sends a message that may be no command, and returns the reply, also a refusal.
    ///
    /// # Errors
    /// No reply in time.
    pub fn ask(&mut self, message: CommandMessage, wait_ns: u64) -> Result<ReplyMessage> {
        self.ask_unless(message, wait_ns, || false)
    }

    fn ask_unless(
        &mut self,
        message: CommandMessage,
        wait_ns: u64,
        stop: impl Fn() -> bool,
    ) -> Result<ReplyMessage> {
        let commands = joined(&mut self.commands, || CommandClient::open(&self.scene))?;
        commands.send(message, wait_ns.min(WAIT_NS_MAX), stop)
    }

    fn control(&mut self) -> Result<&mut Control> {
        self.control.as_mut().ok_or_else(|| {
            Error::new(Kind::Viewer, "a viewer has no tools: open the scene as its controller")
        })
    }
}

impl Control {
    fn new(exchange: Exchange) -> Self {
        Self { exchange, tick: 0, sent_ns: vec![0; QUEUE_MESSAGES].into_boxed_slice(), foreign: 0 }
    }

    fn sent_ns_mut(&mut self, tick: u64) -> &mut u64 {
        &mut self.sent_ns[tick as usize % QUEUE_MESSAGES]
    }

    fn send(&mut self, poses: &[ToolPose]) -> Result<u64> {
        let (tick, send_ns) = (self.tick + 1, now_ns());
        self.exchange.send(pose::message(tick, send_ns, poses)?)?;
        (self.tick, *self.sent_ns_mut(tick)) = (tick, send_ns);
        Ok(tick)
    }

    /// Takes answers until that to `tick` is among them or the time is up; without a tick, any answer will
    /// do.
    fn receive(&mut self, tick: Option<u64>, wait_ns: u64) -> (Outcome, Answer) {
        let end_ns = now_ns().saturating_add(wait_ns.min(WAIT_NS_MAX));
        let mut is_answered = false;
        loop {
            while let Some(answered) = self.take() {
                is_answered |= answered != 0 && tick.is_none_or(|tick| tick == answered);
            }
            if is_answered || !self.exchange.pause(end_ns) {
                break;
            }
        }
        let answer = self.exchange.shown();
        let outcome = match (is_answered, self.exchange.is_silent()) {
            (true, _) => Outcome::Answered,
            (false, true) => Outcome::Silent,
            (false, false) => Outcome::NoAnswer,
        };
        (outcome, answer)
    }

    /// Returns the tick of the next message, 0 if it is no answer to this client, none if there is none.
    fn take(&mut self) -> Option<u64> {
        let forces = self.exchange.receive()?;
        if forces.tick == 0 || *self.sent_ns_mut(forces.tick) != forces.send_ns {
            self.foreign += 1;
            return Some(0);
        }
        let now_ns = now_ns();
        if !self.exchange.show(&forces, now_ns) {
            return Some(0);
        }
        self.exchange.answered(now_ns, forces.send_ns, forces.tick < self.tick);
        Some(forces.tick)
    }
}

/// Returns the opened value, and opens it if it is not open yet.
fn joined<T>(place: &mut Option<T>, open: impl FnOnce() -> Result<T>) -> Result<&mut T> {
    let opened = match place.take() {
        Some(opened) => opened,
        None => open()?,
    };
    Ok(place.insert(opened))
}
