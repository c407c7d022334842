//! What a program beside the device links: poses out, the force to show in.

use chaincell_client::clock::{MILLISECOND_NS, PERIOD_NS, SECOND_NS, now_ns};
use chaincell_client::{Answer, Error, Kind, Result, ToolPose};

use crate::controller::{Came, Controller, Dropped, State};
use crate::key::{Key, random};
use crate::socket::Socket;

/// Longest measurement of the round trip before the first pose \[ns\].
const MEASURING_NS: u64 = 5 * SECOND_NS;

/// How a hand begins.
#[derive(Debug, Clone)]
pub struct Options {
    /// Host and port of the agent.
    pub agent: String,
    /// The key that it has too.
    pub key: Key,
    /// Longest wait for an agent that answers and is free \[ns\].
    pub wait_ns: u64,
    /// Time without an answer after which the force falls \[ms\].
    pub watchdog_ms: u32,
    /// Time in which it falls, and in which it rises when answers come again \[ms\].
    pub ramp_ms: u32,
}

impl Options {
    /// Waits 5 s for the agent; watchdog and ramp are 20 ms.
    #[must_use]
    pub fn new(agent: String, key: Key) -> Self {
        Self { agent, key, wait_ns: 5 * SECOND_NS, watchdog_ms: 20, ramp_ms: 20 }
    }
}

/// A hand on the tissue of another machine. Dropping it lets the server's force fall.
///
/// ```no_run
/// use std::path::Path;
///
/// use chaincell_client::ToolPose;
/// use chaincell_lan::hand::{Hand, Options};
/// use chaincell_lan::key::Key;
///
/// # fn drive() -> chaincell_client::Result<()> {
/// let key = Key::read(Path::new("lan.key"))?;
/// let mut hand = Hand::open(Options::new("10.0.0.5:7200".to_owned(), key), || false)?;
/// loop {
///     let pose = ToolPose::at([0.0, 0.0, 0.01].into(), 0); // of the device [m]
///     let number = hand.send(&[pose])?;
///     let (_is_answered, answer) = hand.receive(number, 900_000); // waits at most 0.9 ms
///     println!("{:?} N", answer.tools[0].force_n); // for the device, also in a silence
/// }
/// # }
/// ```
#[derive(Debug)]
pub struct Hand {
    socket: Socket,
    controller: Controller,
}

impl Hand {
    /// Finds the agent, and measures the round trip for a second. Sleeps; ends if `stop` returns true.
    ///
    /// # Errors
    /// No agent with this key, one that another hand has, or a round trip above its limit.
    pub fn open(options: Options, stop: impl Fn() -> bool) -> Result<Self> {
        let socket = Socket::connect(&options.agent)?;
        let Options { agent, key, wait_ns, watchdog_ms, ramp_ms } = options;
        let start_ns = now_ns();
        let controller = Controller::new(key, random()?, watchdog_ms, ramp_ms, start_ns);
        let mut hand = Self { socket, controller };
        let mut begin_ns = start_ns;
        let mut greeted_ns = None;
        loop {
            if stop() {
                return Err(Error::new(Kind::Stopped, "asked to stop before the agent was ready"));
            }
            hand.hello();
            begin_ns = now_ns().max(begin_ns + PERIOD_NS);
            while hand.next(begin_ns).is_some() {}
            let now_ns = now_ns();
            let waited_ns = now_ns - greeted_ns.unwrap_or(start_ns);
            match hand.state() {
                State::Open => return Ok(hand),
                State::Refused(p999_ns) => return Err(refusal(p999_ns)),
                State::Measuring if waited_ns < MEASURING_NS => {
                    _ = greeted_ns.get_or_insert(now_ns)
                }
                State::Greeting | State::Occupied if waited_ns < wait_ns => {}
                state => return Err(absence(&agent, state, hand.dropped())),
            }
        }
    }

    /// Sends the poses of tools 0, 1 and so on, and returns their number. Allocates one datagram. A network that
    /// takes nothing is a silence, and no error.
    ///
    /// # Errors
    /// A value that is no pose: nothing was sent then.
    pub fn send(&mut self, tools: &[ToolPose]) -> Result<u64> {
        let (number, bytes) = self.controller.poses(tools, now_ns())?;
        self.socket.send(&bytes);
        Ok(number)
    }

    /// Says that the hand is there, without a pose: the agent keeps its place, and the server's force falls.
    pub fn hello(&mut self) {
        let bytes = self.controller.hello(now_ns());
        self.socket.send(&bytes);
    }

    /// Waits at most `wait_ns` for the answer to a pose. Returns if it has come, and the answer to show now: if
    /// answers stay out for the time of the watchdog, its force falls to 0.
    pub fn receive(&mut self, number: u64, wait_ns: u64) -> (bool, Answer) {
        let end_ns = now_ns().saturating_add(wait_ns);
        while let Some(came) = self.next(end_ns) {
            if matches!(came, Came::Answer { number: answered, .. } if answered == number) {
                return (true, self.shown());
            }
        }
        (false, self.shown())
    }

    /// Returns the next datagram that comes until `end_ns`.
    pub fn next(&mut self, end_ns: u64) -> Option<Came> {
        loop {
            if let Some(arrived) = self.socket.take() {
                return Some(self.controller.take(arrived.bytes(), now_ns()));
            }
            let now_ns = now_ns();
            if now_ns >= end_ns {
                return None;
            }
            // A falling force is shown a millisecond at a time, however long the wait.
            self.controller.shown(now_ns);
            self.socket.wait(end_ns.min(now_ns + MILLISECOND_NS));
        }
    }

    /// Returns the answer to show now.
    pub fn shown(&mut self) -> Answer {
        self.controller.shown(now_ns())
    }

    /// Returns the stage of the session; a refused one comes back by another [`Self::open`] alone.
    #[must_use]
    pub fn state(&self) -> State {
        self.controller.state()
    }

    /// Returns the time since the agent was heard \[ns\].
    #[must_use]
    pub fn silent_ns(&self) -> u64 {
        now_ns().saturating_sub(self.controller.heard_ns())
    }

    /// Returns the number of silences of the watchdog's length.
    #[must_use]
    pub fn silences(&self) -> u64 {
        self.controller.silences()
    }

    /// Returns the datagrams that were dropped.
    #[must_use]
    pub fn dropped(&self) -> Dropped {
        self.controller.dropped()
    }
}

/// Returns the refusal of a round trip.
#[must_use]
pub fn refusal(p999_ns: u64) -> Error {
    let text = format!(
        "the agent refuses: one round trip in a thousand takes {:.2} ms or more, above its six ticks; take a wired \
         network without other load, or run the tissue on this machine",
        p999_ns as f64 * 1e-6
    );
    Error::new(Kind::Refused, text)
}

/// Returns the reason for which no session began.
fn absence(agent: &str, state: State, dropped: Dropped) -> Error {
    match state {
        State::Occupied => {
            let text = format!("{agent}: another hand has the agent; end that one, or wait longer");
            Error::new(Kind::Taken, text)
        }
        State::Greeting if dropped.forged > 0 => {
            let text =
                format!("{agent}: it answers with another key; copy the agent's key file here");
            Error::new(Kind::NoServer, text)
        }
        State::Greeting => {
            let text = format!(
                "{agent}: no agent answers; is `chaincell-lan agent` running there with the same key, and the port \
                 open for UDP? An agent says nothing to a wrong key"
            );
            Error::new(Kind::NoServer, text)
        }
        _ => {
            let text = format!("{agent}: too few datagrams come back to measure the round trip");
            Error::new(Kind::NoServer, text)
        }
    }
}
