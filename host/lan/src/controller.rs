//! The hand's side: a function of datagrams, poses and times. The force that it shows falls to 0 by itself.

use chaincell_client::tools::TOOLS_MAX;
use chaincell_client::{Answer, Error, Hearing, Kind, Result, ToolPose};

use crate::agent::LATE_NS;
use crate::datagram::{AgedPose, Fault, LastPoses, Message, Nonce, POSES_MAX, open, seal};
use crate::key::Key;
use crate::side::Side;

/// Stage of a session.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// No agent has answered.
    Greeting,
    /// Another hand has the agent.
    Occupied,
    /// The agent measures the round trip.
    Measuring,
    /// Poses are answered.
    Open,
    /// The session has ended, as the p99.9 of its round trips is too long \[ns\].
    Refused(u64),
}

/// What a datagram brought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Came {
    /// A word of the agent, or nothing of use.
    Word,
    /// The answer to a pose.
    Answer {
        /// Number of the pose.
        number: u64,
        /// Time since it was sent \[ns\].
        round_trip_ns: u64,
    },
}

/// Datagrams that were dropped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Dropped {
    /// With a wrong code.
    pub forged: u64,
    /// Of other programs, versions and sessions.
    pub foreign: u64,
    /// Repeated or overtaken.
    pub old: u64,
    /// Forces older than [`LATE_NS`].
    pub late: u64,
}

/// The hand's side of a session.
#[derive(Debug)]
pub struct Controller {
    key: Key,
    /// The agent's number is zero before it is known.
    side: Side,
    state: State,
    /// The last poses, the newest first; the age is the time at which each was sent.
    number: u64,
    recent: [AgedPose; POSES_MAX],
    hearing: Hearing,
    watchdog_ms: u32,
    ramp_ms: u32,
    dropped: Dropped,
}

impl Controller {
    /// Starts a session with a random number; watchdog and ramp as in [`chaincell_client::Options`].
    #[must_use]
    pub fn new(key: Key, hand: Nonce, watchdog_ms: u32, ramp_ms: u32, now_ns: u64) -> Self {
        Self {
            key,
            side: Side::new(hand, Nonce::default(), now_ns),
            state: State::Greeting,
            number: 0,
            recent: [AgedPose::AWAY; POSES_MAX],
            hearing: Hearing::new(watchdog_ms, ramp_ms, now_ns),
            watchdog_ms,
            ramp_ms,
            dropped: Dropped::default(),
        }
    }

    /// Returns the datagram of a hand that sends no pose.
    pub fn hello(&mut self, now_ns: u64) -> Vec<u8> {
        let agent = self.side.agent;
        // The number may be of an agent that is gone: every second time it is asked for again.
        let is_greeting = matches!(self.state, State::Greeting | State::Occupied);
        if is_greeting && self.side.sequence % 2 == 1 {
            self.side.agent = Nonce::default();
        }
        let bytes = self.seal(&Message::Hello, now_ns);
        self.side.agent = agent;
        bytes
    }

    /// Returns the datagram of the next pose, of tools 0, 1 and so on, and its number.
    ///
    /// # Errors
    /// A value that is no pose, no tools, or too many.
    pub fn poses(&mut self, tools: &[ToolPose], now_ns: u64) -> Result<(u64, Vec<u8>)> {
        if !(1..=TOOLS_MAX).contains(&tools.len()) {
            let text = format!("poses of {} tools: give those of 1 to {TOOLS_MAX}", tools.len());
            return Err(Error::new(Kind::Pose, text));
        }
        if let Some(number) = tools.iter().position(|tool| !tool.is_good()) {
            let text = format!(
                "tool {number}: its pose has a number that is not finite, no unit quaternion, or an \
                 `engaged` that is neither 0 nor 1; nothing was sent"
            );
            return Err(Error::new(Kind::Pose, text));
        }
        if self.number == 0 {
            // No silence was one before the first pose.
            self.hearing = Hearing::new(self.watchdog_ms, self.ramp_ms, now_ns);
        }
        self.number += 1;
        self.recent.rotate_right(1);
        self.recent[0] = AgedPose { age_ns: now_ns, ..AgedPose::AWAY };
        self.recent[0].tools[..tools.len()].copy_from_slice(tools);
        let mut each = self.recent;
        for pose in &mut each {
            pose.age_ns = now_ns.saturating_sub(pose.age_ns);
        }
        let poses = POSES_MAX.min(self.number as usize);
        let last = LastPoses { newest: self.number, poses, tools: tools.len(), each };
        Ok((self.number, self.seal(&Message::Poses(Box::new(last)), now_ns)))
    }

    /// Takes a datagram of the agent.
    pub fn take(&mut self, bytes: &[u8], now_ns: u64) -> Came {
        let (head, message) = match open(&self.key, bytes) {
            Ok(read) => read,
            Err(Fault::Forged) => return self.drop_as(|dropped| &mut dropped.forged),
            Err(Fault::Foreign) => return self.drop_as(|dropped| &mut dropped.foreign),
        };
        if message.is_of_hand() || head.hand != self.side.hand {
            return self.drop_as(|dropped| &mut dropped.foreign);
        }
        // Before the session the agent knows nothing of this hand.
        match message {
            Message::Challenge | Message::Occupied => {
                if matches!(self.state, State::Greeting | State::Occupied) {
                    self.side.agent = head.agent;
                    if message == Message::Occupied {
                        self.state = State::Occupied;
                    }
                }
                return Came::Word;
            }
            _ if head.agent != self.side.agent || self.side.agent == Nonce::default() => {
                return self.drop_as(|dropped| &mut dropped.foreign);
            }
            _ if !self.side.hear(&head, now_ns) => {
                return self.drop_as(|dropped| &mut dropped.old);
            }
            _ => {}
        }
        match message {
            Message::Measuring => self.state = State::Measuring,
            Message::Open => self.state = State::Open,
            Message::Refused(p999_ns) => self.state = State::Refused(p999_ns),
            Message::Forces(forces) if forces.tick <= self.number => {
                let round_trip_ns = now_ns.saturating_sub(forces.send_ns);
                if round_trip_ns > LATE_NS {
                    return self.drop_as(|dropped| &mut dropped.late);
                }
                self.state = State::Open;
                self.hearing.hear(&forces, now_ns);
                return Came::Answer { number: forces.tick, round_trip_ns };
            }
            _ => return self.drop_as(|dropped| &mut dropped.foreign),
        }
        Came::Word
    }

    fn drop_as(&mut self, count: impl Fn(&mut Dropped) -> &mut u64) -> Came {
        *count(&mut self.dropped) += 1;
        Came::Word
    }

    /// Returns the answer to show now: without a newer one its force falls to 0 along a ramp.
    pub fn shown(&mut self, now_ns: u64) -> Answer {
        if self.number > 0 {
            self.hearing.wait(now_ns);
        }
        self.hearing.answer(now_ns)
    }

    /// Returns the stage of the session.
    #[must_use]
    pub fn state(&self) -> State {
        self.state
    }

    /// Returns the arrival of the newest datagram of the agent, that of the start before the first \[ns\].
    #[must_use]
    pub fn heard_ns(&self) -> u64 {
        self.side.heard_ns
    }

    /// Returns the number of silences of the watchdog's length.
    #[must_use]
    pub fn silences(&self) -> u64 {
        self.hearing.silences()
    }

    /// Returns the datagrams that were dropped.
    #[must_use]
    pub fn dropped(&self) -> Dropped {
        self.dropped
    }

    fn seal(&mut self, message: &Message, now_ns: u64) -> Vec<u8> {
        seal(&self.key, &self.side.head(now_ns), message)
    }
}

#[cfg(test)]
mod tests;
