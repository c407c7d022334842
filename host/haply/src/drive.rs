//! The loop between device and tissue, at most 1,000 times a second: a force out and a state in, then a pose out
//! and an answer in.

use std::panic::{AssertUnwindSafe, catch_unwind};

use chaincell_client::clock::{MILLISECOND_NS, PERIOD_NS, SECOND_NS};
use chaincell_client::{Notes, ToolPose};
use serde_json::Value;

use crate::doubt::Doubt;
use crate::frame::Frame;
use crate::guard::{Guard, OFF_NS, RAMP_MS};
use crate::message::{self, ForceKey};

/// Wait for a state, from the begin of a period \[ns\].
const STATE_NS: u64 = 600_000;
/// Wait for an answer, from the begin of a period \[ns\].
const ANSWER_NS: u64 = 950_000;
/// Time between messages to a silent service that has got a force of zero \[ns\].
const KNOCK_NS: u64 = 100 * MILLISECOND_NS;
/// Silence of service or tissue after which the program ends \[ns\].
const GONE_NS: u64 = 2 * SECOND_NS;

/// The service's end of a connection.
pub trait Service {
    /// Sends a message.
    ///
    /// # Errors
    /// A connection that takes none.
    fn send(&mut self, message: &str) -> Result<(), String>;

    /// Takes all messages that have come, waits for one until `end_ns` where there is none, and returns the
    /// newest.
    ///
    /// # Errors
    /// A connection that has ended.
    fn receive(&mut self, end_ns: u64) -> Result<Option<String>, String>;

    /// Closes the connection after all that was sent.
    fn close(&mut self);
}

/// What the tissue answered last.
#[derive(Debug, Clone, Copy)]
pub struct Felt {
    /// Force on the tool \[N\].
    pub force_n: [f32; 3],
    /// The client's notes.
    pub notes: Notes,
    /// True if it is the answer to the last pose.
    pub is_answered: bool,
}

/// The tissue's end.
pub trait Tissue {
    /// Sends a pose and waits for its answer until `end_ns`.
    ///
    /// # Errors
    /// Shared memory that takes no pose.
    fn step(&mut self, pose: &ToolPose, end_ns: u64) -> Result<Felt, String>;

    /// Returns true if a server is registered on the scene.
    fn is_served(&self) -> bool;
}

/// A clock.
pub trait Clock {
    /// Returns the time \[ns\].
    fn now_ns(&self) -> u64;

    /// Sleeps until a time.
    fn sleep_until_ns(&self, moment_ns: u64);
}

/// How to drive.
#[derive(Debug, Clone)]
pub struct Options {
    /// Device of the service.
    pub device_id: String,
    /// Field of a force.
    pub force_key: ForceKey,
    /// From the device to the scene.
    pub frame: Frame,
    /// Largest force on the hand \[N\].
    pub max_force_n: f32,
    /// Fastest motion of a hand \[m/s\].
    pub max_speed_m_per_s: f32,
    /// Time after which to end \[ns\].
    pub end_ns: Option<u64>,
}

/// How a session ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// The caller asked to stop.
    Stopped,
    /// The time is up.
    TimeUp,
    /// The tissue's server has ended.
    SessionEnded,
    /// The connection to the service has ended, for a reason.
    ServiceClosed(String),
    /// No good state for two seconds, for the last doubt.
    ServiceGone(Option<Doubt>),
    /// No answer for two seconds from a server that is registered.
    TissueGone,
    /// The client refused a pose.
    TissueFailed(String),
    /// A panic.
    Panicked,
}

/// Counts of a session.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Messages sent to the service.
    pub forces_sent: u64,
    /// Messages of the service that were looked at, the newest of each period.
    pub states: u64,
    /// Poses sent to the tissue.
    pub poses: u64,
    /// Poses answered within their period.
    pub answered: u64,
}

/// A session that has ended.
#[derive(Debug, Clone)]
pub struct Report {
    /// How it ended.
    pub ended: Ended,
    /// Its counts.
    pub counts: Counts,
    /// How often each doubt began.
    pub doubts: [u64; Doubt::ALL.len()],
    /// Largest force sent \[N\].
    pub largest_force_n: f32,
}

/// Drives until one of the sides ends or `stop` returns true. However it ends, a panic included, the force falls
/// along its ramp, and the last message to the service is a force of zero. `say` gets each doubt as it begins.
pub fn drive<S: Service, T: Tissue, C: Clock>(
    service: &mut S,
    tissue: &mut T,
    clock: &C,
    options: &Options,
    stop: impl Fn() -> bool,
    say: impl Fn(Doubt),
) -> Report {
    let mut hand = Hand::new(service, clock, options);
    let ended = catch_unwind(AssertUnwindSafe(|| hand.run(tissue, stop, say)));
    hand.let_go();
    Report {
        ended: ended.unwrap_or(Ended::Panicked),
        counts: hand.counts,
        doubts: hand.guard.counts(),
        largest_force_n: hand.guard.largest_n(),
    }
}

struct Hand<'a, S, C> {
    service: &'a mut S,
    clock: &'a C,
    options: &'a Options,
    guard: Guard,
    /// Names this program in the first message to a service that takes it.
    profile: Option<Value>,
    /// Time of the last message to the service, and of the first pose of those without an answer \[ns\].
    sent_ns: u64,
    unanswered_ns: Option<u64>,
    /// True if the last message was a force of zero.
    is_zero_sent: bool,
    wanted_n: [f32; 3],
    pose: ToolPose,
    counts: Counts,
}

impl<'a, S: Service, C: Clock> Hand<'a, S, C> {
    fn new(service: &'a mut S, clock: &'a C, options: &'a Options) -> Self {
        let now_ns = clock.now_ns();
        Self {
            service,
            clock,
            options,
            guard: Guard::new(options.max_force_n, options.max_speed_m_per_s, now_ns),
            profile: (options.force_key == ForceKey::Vector).then(message::profile),
            sent_ns: now_ns,
            unanswered_ns: None,
            is_zero_sent: false,
            wanted_n: [0.0; 3],
            pose: ToolPose::AWAY,
            counts: Counts::default(),
        }
    }

    fn run(
        &mut self,
        tissue: &mut impl Tissue,
        stop: impl Fn() -> bool,
        say: impl Fn(Doubt),
    ) -> Ended {
        let start_ns = self.clock.now_ns();
        let mut begin_ns = start_ns;
        let mut said = None;
        while !stop() {
            if self.options.end_ns.is_some_and(|end_ns| begin_ns - start_ns >= end_ns) {
                return Ended::TimeUp;
            }
            if let Err(ended) = self.period(tissue, begin_ns) {
                return ended;
            }
            let doubt = self.guard.present_doubt();
            if doubt != said {
                said = doubt;
                doubt.into_iter().for_each(&say);
            }
            // A period that took longer is not made up for.
            begin_ns = self.clock.now_ns().max(begin_ns + PERIOD_NS);
            self.clock.sleep_until_ns(begin_ns);
        }
        Ended::Stopped
    }

    /// One force, state, pose and answer.
    fn period(&mut self, tissue: &mut impl Tissue, begin_ns: u64) -> Result<(), Ended> {
        // The force of the last answer goes out, and a state comes in.
        self.send_force(false).map_err(Ended::ServiceClosed)?;
        let text = self.service.receive(begin_ns + STATE_NS).map_err(Ended::ServiceClosed)?;
        let now_ns = self.clock.now_ns();
        if now_ns - self.guard.heard_ns() >= GONE_NS {
            return Err(Ended::ServiceGone(self.guard.present_doubt()));
        }
        let Some(text) = text else { return Ok(()) };
        self.counts.states += 1;
        // On a doubt the tool lets go where it was last.
        let read = message::position(&text, &self.options.device_id);
        let read = read.map_err(|doubt| self.guard.doubt(doubt));
        if let Ok(position_m) = read
            && self.guard.state(position_m, now_ns).is_ok()
        {
            self.pose = ToolPose::at(self.options.frame.to_scene(position_m).into(), 0);
        }
        self.pose.engaged = u16::from(self.guard.is_engaged());
        self.ask(tissue, begin_ns)
    }

    /// The pose goes out, and its answer comes in.
    fn ask(&mut self, tissue: &mut impl Tissue, begin_ns: u64) -> Result<(), Ended> {
        let felt = tissue.step(&self.pose, begin_ns + ANSWER_NS).map_err(Ended::TissueFailed)?;
        self.counts.poses += 1;
        self.guard.answer(felt.notes);
        self.wanted_n = self.options.frame.to_device(felt.force_n);
        let now_ns = self.clock.now_ns();
        if felt.is_answered {
            self.counts.answered += 1;
            self.unanswered_ns = None;
        } else if felt.notes.contains(Notes::SILENT) && !tissue.is_served() {
            return Err(Ended::SessionEnded);
        } else if now_ns - *self.unanswered_ns.get_or_insert(now_ns) >= GONE_NS {
            return Err(Ended::TissueGone);
        }
        Ok(())
    }

    /// Sends the force of now; to a silent service no more than a knock after it got a force of zero.
    fn send_force(&mut self, is_last: bool) -> Result<(), String> {
        let now_ns = self.clock.now_ns();
        let force_n = self.guard.force(self.wanted_n, now_ns);
        let is_silent = now_ns - self.guard.heard_ns() >= OFF_NS;
        if is_silent && self.is_zero_sent && !is_last && now_ns - self.sent_ns < KNOCK_NS {
            return Ok(());
        }
        self.send(force_n, now_ns)
    }

    fn send(&mut self, force_n: [f32; 3], now_ns: u64) -> Result<(), String> {
        let mut message = message::force(&self.options.device_id, self.options.force_key, force_n);
        if let Some(profile) = self.profile.take() {
            message["session"] = profile;
        }
        (self.sent_ns, self.is_zero_sent) = (now_ns, force_n == [0.0; 3]);
        self.counts.forces_sent += 1;
        self.service.send(&message.to_string())
    }

    /// Lets the force fall along its ramp, and ends with a force of zero. A connection that takes nothing has
    /// nothing to fall.
    fn let_go(&mut self) {
        self.guard.let_go();
        let mut moment_ns = self.clock.now_ns();
        for _ in 0..2 * RAMP_MS {
            if self.guard.shown_n() == [0.0; 3] || self.send_force(true).is_err() {
                break;
            }
            moment_ns += PERIOD_NS;
            self.clock.sleep_until_ns(moment_ns);
        }
        let _ = self.send([0.0; 3], moment_ns);
        self.service.close();
    }
}

#[cfg(test)]
mod tests;
