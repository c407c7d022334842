//! Poses out and answers in, message by message: a controller's ports, its waiting, and the force that it
//! shows. [`Client`](crate::Client) matches answers to its poses on top of it.

use iceoryx2::port::update_connections::UpdateConnections;

use crate::clock::{MILLISECOND_NS, now_ns, sleep_until_ns};
use crate::error::{Error, Kind, Result};
use crate::hearing::{Answer, Hearing};
use crate::options::{Options, Role};
use crate::services::{Ports, SceneServices};
use crate::tools::{ToolForces, ToolPoses};
use crate::wait::{Wait, Waiter};

/// First guess of a round trip \[ns\].
const ROUND_TRIP_GUESS_NS: u64 = 200_000;
/// Period at which the shown force is updated while no message comes, and the server is looked for \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;

/// The controller's side of a scene, message by message: for programs whose poses overtake each other, are
/// sent twice, or have tick numbers that they choose.
///
/// ```no_run
/// # fn ask() -> chaincell_client::Result<()> {
/// use chaincell_client::clock::{MILLISECOND_NS, now_ns};
/// use chaincell_client::services::{Domain, SceneServices};
/// use chaincell_client::{Exchange, Options, ToolPose, tools::ToolPoses};
///
/// let scene = SceneServices::open(Some("left"), &Domain::default())?;
/// let mut exchange = Exchange::open(&scene, &Options::default(), || false)?;
/// let end_ns = now_ns() + MILLISECOND_NS;
/// exchange.send(ToolPoses::of(41, now_ns(), &[ToolPose::AWAY]))?;
/// while exchange.pause(end_ns) {
///     if let Some(forces) = exchange.receive() {
///         println!("tick {}: {:?} N", forces.tick, forces.each[0].force_n);
///     }
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Exchange {
    ports: Ports<ToolForces, ToolPoses>,
    waiter: Waiter,
    hearing: Hearing,
}

impl Exchange {
    /// Joins a scene as its controller and waits for its server; calls `stop` every millisecond of the wait,
    /// and ends if it returns true. The scene's name, domain and the role in `options` do not matter.
    ///
    /// # Errors
    /// Another controller, too little memory, no server in time; [`Kind::Stopped`] if `stop` returned true.
    pub fn open(
        scene: &SceneServices,
        options: &Options,
        stop: impl FnMut() -> bool,
    ) -> Result<Self> {
        let ports = scene.control_ports(options.wait == Wait::Event)?;
        wait_for_server(scene, options.role, options.server_wait_ns, stop)?;
        // Without a history, a pose sent before the connection exists would be lost.
        ports.publisher.update_connections().map_err(|why| {
            let text = format!("cannot connect to the server ({why:?}): start it again");
            Error::new(Kind::Connection, text)
        })?;
        Ok(Self {
            ports,
            waiter: Waiter::new(options.wait, ROUND_TRIP_GUESS_NS),
            hearing: Hearing::new(options.watchdog_ms, options.ramp_ms, now_ns()),
        })
    }

    /// Sends a message as it is. Allocates 104 bytes.
    ///
    /// # Errors
    /// Shared memory that takes no message.
    pub fn send(&mut self, poses: ToolPoses) -> Result<()> {
        self.waiter.expect_after(poses.send_ns);
        let sent = self.ports.publisher.send_copy(poses);
        self.ports.ring.ring();
        sent.map(|_| ()).map_err(|why| {
            Error::new(Kind::Connection, format!("shared memory took no pose ({why:?})"))
        })
    }

    /// Returns the next message that has come, also one for another program. A failed connection shows as a
    /// missing message.
    pub fn receive(&mut self) -> Option<ToolForces> {
        self.ports.subscriber.receive().ok()?.map(|forces| *forces)
    }

    /// Shows the forces of a message. Returns true if it is an answer, false if it is the server's falling
    /// force in a silence.
    pub fn show(&mut self, forces: &ToolForces, now_ns: u64) -> bool {
        self.hearing.hear(forces, now_ns)
    }

    /// Notes that the answer to a pose sent at `sent_ns` has come, and if another one is due.
    pub fn answered(&mut self, now_ns: u64, sent_ns: u64, is_another_due: bool) {
        self.waiter.arrived(now_ns, now_ns.saturating_sub(sent_ns));
        if is_another_due {
            self.waiter.expect_after(now_ns);
        }
    }

    /// Waits a part of the time up to `moment_ns`, at most a millisecond. Returns false if the moment has
    /// passed.
    pub fn pause(&mut self, moment_ns: u64) -> bool {
        let now_ns = now_ns();
        self.hearing.wait(now_ns);
        if now_ns >= moment_ns {
            return false;
        }
        self.waiter.pause(moment_ns.min(now_ns + LOOK_NS), &self.ports.wake);
        true
    }

    /// Returns the answer to show now, from the messages shown so far.
    pub fn shown(&mut self) -> Answer {
        let now_ns = now_ns();
        self.hearing.wait(now_ns);
        self.hearing.answer(now_ns)
    }

    /// Returns true if no message has come for the time of the watchdog.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        self.hearing.is_silent()
    }

    /// Returns the number of silences of the watchdog's length.
    #[must_use]
    pub fn silences(&self) -> u64 {
        self.hearing.silences()
    }

    /// Returns the largest change of a tool's force between two updates \[N\].
    #[must_use]
    pub fn largest_step_n(&self) -> f32 {
        self.hearing.largest_step_n()
    }
}

/// Waits until a server is registered on the scene, or for a viewer one that shows a session of another place.
pub(crate) fn wait_for_server(
    scene: &SceneServices,
    role: Role,
    at_most_ns: u64,
    mut stop: impl FnMut() -> bool,
) -> Result<()> {
    let end_ns = now_ns().saturating_add(at_most_ns);
    let is_there = || scene.is_served() || role == Role::Viewer && scene.is_shown();
    while !is_there() {
        if stop() {
            return Err(Error::new(Kind::Stopped, "asked to stop before a server came"));
        }
        if now_ns() >= end_ns {
            let program = match role {
                Role::Controller => "`chaincell serve`",
                Role::Viewer => "`chaincell serve` or `chaincell follow`",
            };
            let text = format!(
                "no server on {}: start {program} with the same `scene`, or wait longer for it",
                scene.label()
            );
            return Err(Error::new(Kind::NoServer, text));
        }
        sleep_until_ns(now_ns() + LOOK_NS);
    }
    Ok(())
}
