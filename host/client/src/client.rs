//! The client: one handle on a scene, as its controller or as a viewer.

use chaincell_kernel::ToolPose;
use chaincell_kernel::trace::Command;
use iceoryx2::port::update_connections::UpdateConnections;

use crate::clock::{SECOND_NS, now_ns, sleep_until_ns};
use crate::command::{CommandClient, refusal_text};
use crate::contacts::{Contact, ContactReader};
use crate::error::{Error, Kind, Result};
use crate::hearing::{Answer, Hearing};
use crate::payload::{CommandMessage, NodePosition, ReplyMessage};
use crate::pose;
use crate::services::{Domain, Ports, QUEUE_MESSAGES, SceneServices};
use crate::state::StateReader;
use crate::tools::{ToolForces, ToolPoses};
use crate::viewed::View;
use crate::wait::{Wait, Waiter};

/// First guess of a round trip \[ns\].
const ROUND_TRIP_GUESS_NS: u64 = 200_000;
/// Longest watchdog and ramp \[ms\].
pub const MS_MAX: u32 = 60_000;
/// Upper limit of every wait \[ns\]: an hour.
const WAIT_NS_MAX: u64 = 3600 * SECOND_NS;

/// Purpose of a handle.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Role {
    /// Sends poses; a scene has one.
    #[default]
    Controller,
    /// Looks at states and contacts, and sends commands.
    Viewer,
}

/// How to open a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Name of the scene, `None` for the unnamed one.
    pub scene: Option<String>,
    /// Place of iceoryx2's files.
    pub domain: Domain,
    /// Purpose of the handle.
    pub role: Role,
    /// How to wait for answers.
    pub wait: Wait,
    /// Longest wait for a server \[ns\].
    pub server_wait_ns: u64,
    /// Time without an answer after which the force falls to 0; 0 for never; at most [`MS_MAX`] \[ms\].
    pub watchdog_ms: u32,
    /// Time in which it falls, and in which it rises when answers come again; 0 for at once \[ms\].
    pub ramp_ms: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            scene: None,
            domain: Domain::default(),
            role: Role::Controller,
            wait: Wait::Hybrid,
            server_wait_ns: 10 * SECOND_NS,
            watchdog_ms: 20,
            ramp_ms: 20,
        }
    }
}

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
    contacts: Option<ContactReader>,
    commands: Option<CommandClient>,
    // After its ports: fields are dropped in order.
    scene: SceneServices,
}

#[derive(Debug)]
struct Control {
    ports: Ports<ToolForces, ToolPoses>,
    waiter: Waiter,
    hearing: Hearing,
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
        let ports = match options.role {
            Role::Viewer => None,
            Role::Controller => Some(scene.control_ports(options.wait == Wait::Event)?),
        };
        wait_for_server(&scene, options.server_wait_ns, stop)?;
        let control = ports.map(|ports| Control::new(ports, options)).transpose()?;
        Ok(Self { control, state: None, contacts: None, commands: None, scene })
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
        let control = self.control()?;
        let now_ns = now_ns();
        control.hearing.wait(now_ns);
        Ok(control.hearing.answer(now_ns))
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
        let Control { hearing, foreign, .. } = self.control()?;
        Ok((hearing.silences(), *foreign, hearing.largest_step_n()))
    }

    /// Returns the newest state that was not taken yet, without a copy. The first call joins the readers and
    /// allocates; a state comes with the next tick.
    ///
    /// # Errors
    /// No place for a further reader, or two states are held already.
    pub fn state(&mut self) -> Result<Option<View<NodePosition>>> {
        joined(&mut self.state, || StateReader::open(&self.scene))?.borrow()
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
    fn new(ports: Ports<ToolForces, ToolPoses>, options: &Options) -> Result<Self> {
        // Without a history, a pose sent before the connection exists would be lost.
        ports.publisher.update_connections().map_err(|why| {
            let text = format!("cannot connect to the server ({why:?}): start it again");
            Error::new(Kind::Connection, text)
        })?;
        Ok(Self {
            ports,
            waiter: Waiter::new(options.wait, ROUND_TRIP_GUESS_NS),
            hearing: Hearing::new(options.watchdog_ms, options.ramp_ms, now_ns()),
            tick: 0,
            sent_ns: vec![0; QUEUE_MESSAGES].into_boxed_slice(),
            foreign: 0,
        })
    }

    fn sent_ns_mut(&mut self, tick: u64) -> &mut u64 {
        &mut self.sent_ns[tick as usize % QUEUE_MESSAGES]
    }

    fn send(&mut self, poses: &[ToolPose]) -> Result<u64> {
        let (tick, send_ns) = (self.tick + 1, now_ns());
        let message = pose::message(tick, send_ns, poses)?;
        self.ports.publisher.send_copy(message).map_err(|why| {
            Error::new(Kind::Connection, format!("shared memory took no pose ({why:?})"))
        })?;
        self.ports.ring.ring();
        (self.tick, *self.sent_ns_mut(tick)) = (tick, send_ns);
        self.waiter.expect_after(send_ns);
        Ok(tick)
    }

    /// Takes answers until that to `tick` is among them or the time is up; without a tick, any answer will
    /// do.
    fn receive(&mut self, tick: Option<u64>, wait_ns: u64) -> (Outcome, Answer) {
        let end_ns = now_ns().saturating_add(wait_ns.min(WAIT_NS_MAX));
        let mut is_answered = false;
        let now_ns = loop {
            while let Some(answered) = self.take() {
                is_answered |= answered != 0 && tick.is_none_or(|tick| tick == answered);
            }
            let now_ns = now_ns();
            self.hearing.wait(now_ns);
            if is_answered || now_ns >= end_ns {
                break now_ns;
            }
            // The force is updated every millisecond, also in a long wait.
            self.waiter.pause(end_ns.min(now_ns + Hearing::LOOK_NS), &self.ports.wake);
        };
        let outcome = match (is_answered, self.hearing.is_silent()) {
            (true, _) => Outcome::Answered,
            (false, true) => Outcome::Silent,
            (false, false) => Outcome::NoAnswer,
        };
        (outcome, self.hearing.answer(now_ns))
    }

    /// Returns the tick of the next message, 0 if it is no answer to this client, none if there is none. A
    /// failed connection shows as a missing answer.
    fn take(&mut self) -> Option<u64> {
        let forces = *self.ports.subscriber.receive().ok()??;
        if forces.tick == 0 || *self.sent_ns_mut(forces.tick) != forces.send_ns {
            self.foreign += 1;
            return Some(0);
        }
        let now_ns = now_ns();
        let is_answer = self.hearing.hear(&forces, now_ns);
        if !is_answer {
            return Some(0);
        }
        self.waiter.arrived(now_ns, now_ns.saturating_sub(forces.send_ns));
        if forces.tick < self.tick {
            self.waiter.expect_after(now_ns);
        }
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

fn wait_for_server(
    scene: &SceneServices,
    at_most_ns: u64,
    mut stop: impl FnMut() -> bool,
) -> Result<()> {
    let end_ns = now_ns().saturating_add(at_most_ns.min(WAIT_NS_MAX));
    while !scene.is_served() {
        if stop() {
            return Err(Error::new(Kind::Stopped, "asked to stop before a server came"));
        }
        if now_ns() >= end_ns {
            let text = format!(
                "no server on {}: start `chaincell serve` with the same `scene`, or wait longer for it",
                scene.label()
            );
            return Err(Error::new(Kind::NoServer, text));
        }
        sleep_until_ns(now_ns() + Hearing::LOOK_NS);
    }
    Ok(())
}
