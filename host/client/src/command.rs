//! Commands of another program to the server, carried out between ticks.
//!
//! The service is iceoryx2's request and response: a reply belongs to its command and never waits for
//! a reader, and a request whose sender has ended is dropped. At most one command is carried out
//! every 10 ms; commands that overflow the queue get no reply. A command is a few numbers and
//! names no file.

use iceoryx2::port::client::Client;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::request_response;

use chaincell_kernel::trace::{Command, CommandError};

use crate::clock::{MILLISECOND_NS, now_ns, sleep_until_ns};
use crate::error::{Error, Kind, Result};
use crate::foreign;
use crate::payload::{COMMAND, CommandMessage, ReplyMessage};
use crate::services::{Ipc, NODES_MAX, SceneServices, port_error, service_error};

/// Polling period for a reply \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;
/// Most sweeps that a command may set: a tick must stay short.
pub const SWEEPS_MAX: u16 = 1000;
/// The running server, and a killed one that is not yet cleared up.
const SERVERS_MAX: usize = 2;
/// Programs that may send commands at a time.
const CLIENTS_MAX: usize = 8;
/// Pending commands of one program.
const ACTIVE_MAX: usize = 4;
/// Number of the command that pins at a place.
const PIN_AT: u32 = 10;

chaincell_kernel::codes! {
    /// The reason for which a command was refused, by the number in its reply.
    ///
    /// ```
    /// use chaincell_client::command::Refusal;
    ///
    /// assert_eq!(Refusal::text_of(9), Some(Refusal::NoTool.text()));
    /// assert_eq!(Refusal::text_of(0), None); // the command was carried out
    /// ```
    Refusal: u32, str {
        /// No such command, or a reserved word that is not zero.
        Unknown = 1, "unknown command, or the server is of another release";
        /// No such parameter.
        Parameter = 2, "unknown parameter; sweeps, max_force_n, max_tool_step_m, unloading and cut may be set";
        /// The value is out of the parameter's range.
        Value = 3,
            "the value is out of range; sweeps are a whole number from 1 to 1000, limits above 0, unloading \
                0 to 2, cut 0 or 1, the ticks of letting go and of unpin a whole number from 1 to 65535, the stiffness of a \
                pin at least 1e-6 N/m, and 0 where there is nothing to set; a place only for a pin at a place";
        /// The parameter is fixed for a run, or under this scheme.
        Fixed = 4, "fixed for a run: start chaincell serve again with another value";
        /// The recording has no capacity for a further command.
        Recording = 5, "the recording has no room for a further command: start chaincell serve again";
        /// The body could not be reset.
        Reset = 6, "the body could not be reset: start chaincell serve again";
        /// This server takes no commands.
        Unsupported = 7, "this server takes no commands";
        /// The contact is not one of tools on a surface: nothing can be gripped.
        NoSurface = 8,
            "nothing can be gripped here, nor pinned: start chaincell serve with a tool (--contact probe:RADIUS or --tool)";
        /// There is no tool of this number.
        NoTool = 9, "there is no tool of this number; they count from 0";
        /// The tool is in contact with nothing, or grips nothing.
        NothingHeld = 10, "the tool is in contact with nothing to grip or pin, or has no grip to let go";
        /// The session is not recorded: a snapshot is stored next to its trace.
        NoTrace = 11,
            "a snapshot stands beside the trace of the session: start chaincell serve with --record or --out";
        /// The last snapshot is still being written.
        Busy = 12, "the last snapshot is still being written: ask again";
        /// The snapshot could not be written.
        NotWritten = 13,
            "the snapshot could not be written: the disk is full, or the folder of the trace cannot be \
                written; chaincell serve has said why";
        /// The session has taken as many snapshots as it may.
        Snapshots = 14,
            "a session takes at most 1000 snapshots: start chaincell serve again, with --restore to go on";
        /// There is no pin of this number.
        NoPin = 15, "there is no pin of this number; a new pin takes the lowest free one, from 0";
        /// Pins hold as many samples as they may.
        PinRoom = 16, "pins hold at most 2048 samples of the surface in all: release one, or pin a smaller region";
        /// No sample of the surface is near enough to the point.
        PinReach = 17,
            "no sample of the surface lies within the radius of the point: move the point, or take a larger radius";
        /// The point of a pin is not finite.
        PinPoint = 18, "point_m: give the point of a pin as three finite numbers, in metres in the frame of the mesh";
        /// The radius of a pin is not a finite length above 0.
        PinRadius = 19, "radius_m: give the radius of a pin as a finite number above 0, in metres";
    }
}

impl From<CommandError> for Refusal {
    fn from(why: CommandError) -> Self {
        match why {
            CommandError::Kind => Self::Unknown,
            CommandError::Parameter => Self::Parameter,
            CommandError::Fixed => Self::Fixed,
            CommandError::Value => Self::Value,
        }
    }
}

/// Returns a sentence for the reason of a refused command, by its number in a reply.
///
/// ```
/// use chaincell_client::command::{Refusal, refusal_text};
///
/// let reason = Refusal::NoTool as u32; // as in a reply
/// assert_eq!(refusal_text(reason), "there is no tool of this number; they count from 0");
/// ```
#[must_use]
pub fn refusal_text(reason: u32) -> &'static str {
    Refusal::text_of(reason).unwrap_or("for a reason unknown to this release")
}

impl CommandMessage {
    /// Returns the message of a command, 32 bytes.
    ///
    /// ```
    /// use chaincell_client::{Command, command::Refusal, payload::CommandMessage};
    ///
    /// let message = CommandMessage::new(&Command::MaxForceN(3.0)); // [N]
    /// assert_eq!((message.kind, message.parameter, message.value), (4, 2, 3.0));
    /// assert_eq!(message.command(), Ok(Command::MaxForceN(3.0)));
    /// let too_many = CommandMessage::new(&Command::Sweeps(1001));
    /// assert_eq!(too_many.command(), Err(Refusal::Value));
    ///
    /// let (point_m, stiffness_n_per_m) = ([0.0, 0.0, 0.04], f32::INFINITY);
    /// let pin = Command::PinAt { point_m, radius_m: 0.006, stiffness_n_per_m };
    /// let message = CommandMessage::new(&pin);
    /// assert_eq!((message.kind, message.point_m, message.radius_m), (10, point_m, 0.006));
    /// assert_eq!(message.command(), Ok(pin));
    /// ```
    #[must_use]
    pub fn new(command: &Command) -> Self {
        if let Command::PinAt { point_m, radius_m, stiffness_n_per_m } = *command {
            let value = stiffness_n_per_m;
            return Self { kind: PIN_AT, value, point_m, radius_m, ..Self::default() };
        }
        let [kind, parameter, value] = command.words();
        Self { kind, parameter, value: f32::from_bits(value), ..Self::default() }
    }

    /// Returns the command of the message.
    ///
    /// # Errors
    /// The refusal of the first word that is not valid.
    pub fn command(&self) -> std::result::Result<Command, Refusal> {
        if self.reserved != 0 {
            return Err(Refusal::Unknown);
        }
        if self.kind == PIN_AT {
            return self.pin_at();
        }
        let command = Command::from_words([self.kind, self.parameter, self.value.to_bits()])?;
        // The place is that of a pin alone.
        let [x, y, z] = self.point_m;
        if [x, y, z, self.radius_m].iter().any(|number| number.to_bits() != 0) {
            return Err(Refusal::Value);
        }
        match command {
            Command::Sweeps(sweeps) if sweeps > SWEEPS_MAX => Err(Refusal::Value),
            Command::Snapshot { checksum: 1.. } => Err(Refusal::Parameter),
            command => Ok(command),
        }
    }

    /// Returns the pin at the place of the message, or the refusal of the first field that cannot be.
    fn pin_at(&self) -> std::result::Result<Command, Refusal> {
        let Self { parameter, value: stiffness_n_per_m, point_m, radius_m, .. } = *self;
        if parameter != 0 {
            Err(Refusal::Parameter)
        } else if !point_m.iter().all(|number| number.is_finite()) {
            Err(Refusal::PinPoint)
        } else if !radius_m.is_finite() || radius_m <= 0.0 {
            Err(Refusal::PinRadius)
        } else if stiffness_n_per_m.is_nan() || stiffness_n_per_m <= 0.0 {
            Err(Refusal::Value)
        } else {
            Ok(Command::PinAt { point_m, radius_m, stiffness_n_per_m })
        }
    }
}

/// The service of commands.
pub type Service = request_response::PortFactory<Ipc, CommandMessage, (), ReplyMessage, ()>;

/// Opens or creates the service.
///
/// # Errors
/// The service exists with other types or limits.
pub fn service(scene: &SceneServices) -> Result<Service> {
    let name = scene.command_name;
    scene.further(move |node| opened(node, &name))
}

fn opened(node: &Node<Ipc>, name: &ServiceName) -> Result<Service> {
    node.service_builder(name)
        .request_response::<CommandMessage, ReplyMessage>()
        .enable_safe_overflow_for_requests(true)
        .enable_safe_overflow_for_responses(true)
        .enable_fire_and_forget_requests(false)
        .max_active_requests_per_client(ACTIVE_MAX)
        .max_response_buffer_size(1)
        .max_servers(SERVERS_MAX)
        .max_clients(CLIENTS_MAX)
        .max_nodes(NODES_MAX)
        .open_or_create()
        .map_err(|why| {
            foreign::request_refusal::<CommandMessage>(node.config(), name, COMMAND)
                .unwrap_or_else(|| service_error(name, why))
        })
}

/// Sends commands.
///
/// ```no_run
/// # fn reset() -> chaincell_client::Result<()> {
/// use chaincell_client::command::CommandClient;
/// use chaincell_client::payload::CommandMessage;
/// use chaincell_client::services::{Domain, SceneServices};
/// use chaincell_client::{Command, clock::SECOND_NS};
///
/// let scene = SceneServices::open(Some("left"), &Domain::default())?;
/// let commands = CommandClient::open(&scene)?;
/// let reply = commands.send(CommandMessage::new(&Command::Reset), SECOND_NS, || false)?;
/// println!("{reply:?}");
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct CommandClient {
    service: Service,
    client: Client<Ipc, CommandMessage, (), ReplyMessage, ()>,
    label: String,
}

impl CommandClient {
    /// Joins the scene.
    ///
    /// # Errors
    /// The service exists with other types or limits, or it has too many clients.
    pub fn open(scene: &SceneServices) -> Result<Self> {
        let service = service(scene)?;
        let client = service
            .client_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|why| port_error(&scene.command_name, why))?;
        Ok(Self { service, client, label: scene.label().to_owned() })
    }

    /// Returns true if a server takes commands.
    #[must_use]
    pub fn is_served(&self) -> bool {
        self.service.dynamic_config().number_of_servers() > 0
    }

    /// Sends a command and waits for the reply; calls `stop` every millisecond, and ends if it returns true.
    ///
    /// # Errors
    /// No reply within the time; [`Kind::Stopped`] if `stop` returned true.
    pub fn send(
        &self,
        message: CommandMessage,
        at_most_ns: u64,
        stop: impl Fn() -> bool,
    ) -> Result<ReplyMessage> {
        let failed =
            |why: String| Error::new(Kind::NoReply, format!("no reply on {}: {why}", self.label));
        let pending = self.client.send_copy(message);
        let pending = pending.map_err(|why| failed(format!("{why:?}")))?;
        let end_ns = now_ns().saturating_add(at_most_ns);
        loop {
            match pending.receive() {
                Ok(Some(reply)) => return Ok(*reply),
                Ok(None) => {}
                Err(why) => return Err(failed(format!("{why:?}"))),
            }
            if stop() {
                return Err(Error::new(Kind::Stopped, "asked to stop before the reply"));
            }
            if now_ns() >= end_ns {
                return Err(failed(
                    "the server does not run or is busy; whether the command was carried out is \
                     not known: look with chaincell state"
                        .into(),
                ));
            }
            sleep_until_ns(now_ns() + LOOK_NS);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIN: Command =
        Command::PinAt { point_m: [-0.01, 0.0, 0.04], radius_m: 0.006, stiffness_n_per_m: 50.0 };

    #[test]
    fn a_pin_at_a_place_arrives_as_it_was_sent() {
        let Command::PinAt { point_m, radius_m, .. } = PIN else { panic!("{PIN:?}") };
        let rigid = Command::PinAt { point_m, radius_m, stiffness_n_per_m: f32::INFINITY };
        for pin in [PIN, rigid] {
            assert_eq!(CommandMessage::new(&pin).command(), Ok(pin));
        }
    }

    #[test]
    fn a_place_that_cannot_be_is_refused_by_its_field() {
        let sent = CommandMessage::new(&PIN);
        let at = |z| CommandMessage { point_m: [0.0, 0.0, z], ..sent };
        let radius = |radius_m| CommandMessage { radius_m, ..sent };
        let stiffness = |value| CommandMessage { value, ..sent };
        for (message, why) in [
            (at(f32::NAN), Refusal::PinPoint),
            (at(f32::NEG_INFINITY), Refusal::PinPoint),
            (radius(0.0), Refusal::PinRadius),
            (radius(-0.006), Refusal::PinRadius),
            (radius(f32::NAN), Refusal::PinRadius),
            (radius(f32::INFINITY), Refusal::PinRadius),
            (stiffness(f32::NAN), Refusal::Value),
            (stiffness(0.0), Refusal::Value),
            (CommandMessage { parameter: 1, ..sent }, Refusal::Parameter),
            (CommandMessage { reserved: 1, ..sent }, Refusal::Unknown),
            // Another command has no place.
            (CommandMessage { kind: 8, ..sent }, Refusal::Value),
            (CommandMessage { kind: 11, ..sent }, Refusal::Unknown),
        ] {
            assert_eq!(message.command(), Err(why), "{message:?}");
        }
    }
}
