//! The tissue's side: a function of datagrams, answers of the tissue and times.
//!
//! One hand at a time holds the agent. It begins with the agent's random number, so no datagram of an earlier session
//! counts, and each number of a datagram counts once. The agent first measures a second of round trips, from the
//! send times that come back in each datagram; a round trip includes the time of the tissue's answer. After
//! that it hands on poses, and measures on: if the p99.9 of the window is above the limit, the session ends, and the
//! silence lets the server's force fall.
//!
//! Of the poses in a datagram those that were not seen yet go on, in order, the newest last: a lost datagram loses
//! no tick, and no pose goes on after a newer one. The server makes no sweep for those before the newest.

use std::net::SocketAddr;

use chaincell_client::clock::{MILLISECOND_NS, SECOND_NS};
use chaincell_client::tools::{TOOLS_MAX, ToolForces, ToolPoses};
use chaincell_client::{Flags, ToolPose};

use crate::datagram::{AgedPose, Fault, Head, LastPoses, Message, Nonce, open, seal};
use crate::key::Key;
use crate::side::Side;
use crate::trips::Trips;

/// Longest round trip, up to the p99.9: six ticks at 1 kHz \[ns\].
pub const LIMIT_NS: u64 = 6 * MILLISECOND_NS;
/// Age at which a pose or a force counts as lost \[ns\].
pub const LATE_NS: u64 = 20 * MILLISECOND_NS;
/// Silence after which another hand may have the agent \[ns\].
pub const FREE_NS: u64 = SECOND_NS;
/// Poses under way in the tissue whose answers are known again.
const UNDER_WAY: usize = 64;
/// Largest gap between the numbers of two poses: an hour at 1 kHz, as the server takes it.
const GAP_MAX: u64 = 3_600_000;
/// The random number of no agent.
const NOBODY: Nonce = [0; 16];

/// Counts since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Sessions of hands.
    pub hands: u64,
    /// Poses handed on, and those among them that came in a later datagram than their own.
    pub poses: u64,
    /// See `poses`.
    pub recovered: u64,
    /// Poses that never came.
    pub lost: u64,
    /// Datagrams with poses older than [`LATE_NS`], which were not handed on.
    pub late: u64,
    /// Forces sent to the hand.
    pub answers: u64,
    /// Sessions that ended for their round trips.
    pub refused: u64,
    /// Datagrams that were repeated or overtaken.
    pub old: u64,
    /// Datagrams with a wrong code.
    pub forged: u64,
    /// Datagrams of other programs, versions and sessions.
    pub foreign: u64,
}

/// News for people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum News {
    /// A hand has the agent now.
    Began(SocketAddr),
    /// Poses go on; the p99.9 of the round trip \[ns\].
    Opened(u64),
    /// The session ended for the p99.9 of its round trips \[ns\].
    Refused(u64),
    /// The hand was silent, and another one may have the agent.
    Silent,
    /// The server's force has fallen to 0.
    Fallen,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Measuring,
    Open,
    Refused(u64),
}

/// A pose that was handed on.
#[derive(Debug, Clone, Copy, Default)]
struct UnderWay {
    tick: u64,
    /// Send time by the hand's clock, and arrival by the agent's \[ns\].
    stamp_ns: u64,
    arrival_ns: u64,
    /// True if a tool was taken as not engaged that the hand says is.
    is_held_back: bool,
}

/// Poses that have come and were not handed on yet.
#[derive(Debug)]
struct Waiting {
    last: Box<LastPoses>,
    stamp_ns: u64,
    arrival_ns: u64,
}

#[derive(Debug)]
struct Session {
    address: SocketAddr,
    side: Side,
    phase: Phase,
    trips: Trips,
    /// Last round trip without the tissue, and last time of the tissue \[ns\].
    link_ns: u64,
    answering_ns: u64,
    /// The server's tick of the hand's pose 0, and the number of the last pose handed on.
    offset: u64,
    handed: u64,
    /// Tools that were released once.
    released: [bool; TOOLS_MAX],
    waiting: Option<Waiting>,
    under_way: [UnderWay; UNDER_WAY],
}

/// The agent.
#[derive(Debug)]
pub struct Agent {
    key: Key,
    limit_ns: u64,
    /// The random number with which the next session begins.
    challenge: Nonce,
    fresh: fn() -> Nonce,
    session: Option<Session>,
    /// Last tick handed on to the server.
    tick: u64,
    has_fallen: bool,
    counts: Counts,
    news: Vec<News>,
}

impl Agent {
    /// Starts without a hand; `fresh` returns another random number for each session.
    #[must_use]
    pub fn new(key: Key, limit_ns: u64, fresh: fn() -> Nonce) -> Self {
        Self {
            key,
            limit_ns,
            challenge: fresh(),
            fresh,
            session: None,
            tick: 0,
            has_fallen: true,
            counts: Counts::default(),
            news: Vec::new(),
        }
    }

    /// Takes a datagram, and returns the one to send back to its sender; none to a stranger.
    pub fn take(&mut self, bytes: &[u8], from: SocketAddr, now_ns: u64) -> Option<Vec<u8>> {
        let (head, message) = match open(&self.key, bytes) {
            Ok(read) => read,
            Err(Fault::Forged) => return self.drop_as(|counts| &mut counts.forged),
            Err(Fault::Foreign) => return self.drop_as(|counts| &mut counts.foreign),
        };
        if !message.is_of_hand() {
            return self.drop_as(|counts| &mut counts.foreign);
        }
        if head.agent == NOBODY {
            return Some(self.greet(&head, from, now_ns));
        }
        if head.agent == self.challenge && message == Message::Hello && !self.is_held(now_ns) {
            self.begin(&head, from, now_ns);
        }
        let is_of = |session: &&mut Session| {
            (session.address, session.side.hand, session.side.agent)
                == (from, head.hand, head.agent)
        };
        let Some(session) = self.session.as_mut().filter(is_of) else {
            return self.drop_as(|counts| &mut counts.foreign);
        };
        if !session.hear(&head, now_ns) {
            return self.drop_as(|counts| &mut counts.old);
        }
        let before = session.phase;
        session.judge();
        if session.phase != before {
            match session.phase {
                Phase::Measuring => {}
                Phase::Open => self.news.push(News::Opened(session.trips.quantile_ns(999))),
                Phase::Refused(p999_ns) => {
                    self.counts.refused += 1;
                    self.news.push(News::Refused(p999_ns));
                }
            }
        }
        if let (Phase::Open, Message::Poses(last)) = (session.phase, message) {
            if session.link_ns <= LATE_NS {
                let stamp_ns = head.stamp_ns;
                session.waiting = Some(Waiting { last, stamp_ns, arrival_ns: now_ns });
                return None; // the tissue's answer follows
            }
            self.counts.late += 1;
        }
        let said = match session.phase {
            Phase::Measuring => Message::Measuring,
            Phase::Open => Message::Open,
            Phase::Refused(p999_ns) => Message::Refused(p999_ns),
        };
        Some(session.seal(&self.key, &said, now_ns))
    }

    fn drop_as(&mut self, count: impl Fn(&mut Counts) -> &mut u64) -> Option<Vec<u8>> {
        *count(&mut self.counts) += 1;
        None
    }

    /// Answers a hand without a session, and keeps nothing of it.
    fn greet(&mut self, head: &Head, from: SocketAddr, now_ns: u64) -> Vec<u8> {
        // To the hand of the session, whose first word was lost, its number again.
        let session = self.session.as_ref().filter(|_| self.is_held(now_ns));
        let (said, agent) = match session {
            None => (Message::Challenge, self.challenge),
            Some(session) if (session.address, session.side.hand) == (from, head.hand) => {
                (Message::Challenge, session.side.agent)
            }
            Some(_) => (Message::Occupied, NOBODY),
        };
        let (echo_ns, stamp_ns) = (head.stamp_ns, now_ns);
        seal(
            &self.key,
            &Head { hand: head.hand, agent, stamp_ns, echo_ns, ..Head::default() },
            &said,
        )
    }

    /// Returns true if a hand has the agent.
    fn is_held(&self, now_ns: u64) -> bool {
        self.session.as_ref().is_some_and(|session| {
            !matches!(session.phase, Phase::Refused(_)) && !session.is_silent(now_ns)
        })
    }

    fn begin(&mut self, head: &Head, address: SocketAddr, now_ns: u64) {
        let agent = std::mem::replace(&mut self.challenge, (self.fresh)());
        self.session = Some(Session {
            address,
            side: Side::new(head.hand, agent, now_ns),
            phase: Phase::Measuring,
            trips: Trips::new(self.limit_ns),
            link_ns: 0,
            answering_ns: 0,
            offset: self.tick,
            handed: 0,
            released: [false; TOOLS_MAX],
            waiting: None,
            under_way: [UnderWay::default(); UNDER_WAY],
        });
        self.counts.hands += 1;
        self.news.push(News::Began(address));
    }

    /// Returns the poses to hand on, after all datagrams were taken that have come.
    pub fn poses(&mut self) -> Vec<ToolPoses> {
        let Some(session) = self.session.as_mut() else { return Vec::new() };
        let Some(waiting) = session.waiting.take() else { return Vec::new() };
        let mut handed_on = Vec::new();
        for (back, pose) in waiting.last.each.iter().take(waiting.last.poses).enumerate().rev() {
            let number = waiting.last.newest.saturating_sub(back as u64);
            let gap = number.saturating_sub(session.handed);
            if gap == 0 || gap > GAP_MAX {
                continue;
            }
            let tick = session.offset.saturating_add(number);
            self.counts.poses += 1;
            self.counts.recovered += u64::from(back > 0);
            self.counts.lost += gap - 1;
            handed_on.push(session.hand_on(number, tick, pose, &waiting));
            self.tick = tick;
        }
        self.has_fallen &= handed_on.is_empty();
        handed_on
    }

    /// Takes a message of the server, and returns the datagram for the hand, if it answers a pose of its session.
    pub fn answer(&mut self, forces: &ToolForces, now_ns: u64) -> Option<(SocketAddr, Vec<u8>)> {
        // The server's force in a silence is no answer.
        if Flags(forces.flags).contains(Flags::STALE) {
            if Flags(forces.flags).contains(Flags::SAFE_STATE) && !self.has_fallen {
                self.has_fallen = true;
                self.news.push(News::Fallen);
            }
            return None;
        }
        let session = self.session.as_mut().filter(|session| session.phase == Phase::Open)?;
        let under_way = session.under_way[forces.tick as usize % UNDER_WAY];
        if under_way.tick != forces.tick || forces.tick == 0 {
            return None;
        }
        session.answering_ns = now_ns.saturating_sub(under_way.arrival_ns);
        let must_release = if under_way.is_held_back { Flags::RELEASE_FIRST.0 } else { 0 };
        let told = ToolForces {
            tick: forces.tick - session.offset,
            force_tick: forces.force_tick.saturating_sub(session.offset),
            send_ns: under_way.stamp_ns,
            flags: forces.flags | must_release,
            tools: forces.tools.min(TOOLS_MAX as u32),
            ..*forces
        };
        self.counts.answers += 1;
        let datagram = session.seal(&self.key, &Message::Forces(Box::new(told)), now_ns);
        Some((session.address, datagram))
    }

    /// Looks at the time: a hand that was silent has left.
    pub fn look(&mut self, now_ns: u64) {
        if self.session.as_ref().is_some_and(|session| session.is_silent(now_ns)) {
            self.session = None;
            self.news.push(News::Silent);
        }
    }

    /// Returns the news since the last call.
    pub fn news(&mut self) -> Vec<News> {
        std::mem::take(&mut self.news)
    }

    /// Returns the counts since the start.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns the last round trips of the session, if there is one.
    #[must_use]
    pub fn trips(&self) -> Option<&Trips> {
        self.session.as_ref().map(|session| &session.trips)
    }
}

impl Session {
    /// Takes the head of a datagram, and the round trip in it; returns false for one that is old.
    fn hear(&mut self, head: &Head, now_ns: u64) -> bool {
        let is_new = self.side.hear(head, now_ns);
        if is_new && head.echo_ns != 0 {
            let away_ns = now_ns.saturating_sub(head.echo_ns);
            self.link_ns = away_ns.saturating_sub(head.hold_ns);
            self.trips.push(self.link_ns.saturating_add(self.answering_ns));
        }
        is_new
    }

    fn is_silent(&self, now_ns: u64) -> bool {
        now_ns.saturating_sub(self.side.heard_ns) >= FREE_NS
    }

    fn judge(&mut self) {
        if matches!(self.phase, Phase::Refused(_)) {
            return;
        }
        if self.trips.is_slow() {
            (self.phase, self.waiting) = (Phase::Refused(self.trips.quantile_ns(999)), None);
        } else if self.trips.is_known() {
            self.phase = Phase::Open;
        }
    }

    /// Returns the message of a pose; its send time is that of the hand, by the agent's clock.
    fn hand_on(&mut self, number: u64, tick: u64, pose: &AgedPose, waiting: &Waiting) -> ToolPoses {
        let mut tools = pose.tools;
        let mut is_held_back = false;
        for (tool, released) in tools.iter_mut().zip(&mut self.released) {
            *released |= tool.engaged == 0;
            if !*released {
                (tool.engaged, is_held_back) = (0, true);
            }
        }
        self.handed = number;
        self.under_way[tick as usize % UNDER_WAY] = UnderWay {
            tick,
            stamp_ns: waiting.stamp_ns.saturating_sub(pose.age_ns),
            arrival_ns: waiting.arrival_ns,
            is_held_back,
        };
        let way_ns = self.link_ns / 2;
        let send_ns = waiting.arrival_ns.saturating_sub(way_ns).saturating_sub(pose.age_ns);
        let tools: &[ToolPose] = &tools[..waiting.last.tools];
        ToolPoses::of(tick, send_ns, tools)
    }

    fn seal(&mut self, key: &Key, message: &Message, now_ns: u64) -> Vec<u8> {
        seal(key, &self.side.head(now_ns), message)
    }
}
