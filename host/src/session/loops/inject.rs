//! Faults on purpose, between the schedule of poses and shared memory: the same for a seed.
//!
//! They are drawn pose by pose from the seed alone: what is known before a run is known after it,
//! and the memory does not depend on its length.

use std::collections::VecDeque;
use std::str::FromStr;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use crate::engine::motion::Pose;
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS};
use crate::words::percent;

/// Longest delay of a late pose, and longest stop \[ms\].
const SPAN_MS_MAX: u32 = 60_000;
/// Most poses in a burst.
const BURST_MAX: u32 = 1000;
/// Most pose periods that a sweep is stretched to.
const SWEEP_PERIODS_MAX: f64 = 1000.0;
/// Highest rate \[Hz\].
const RATE_HZ_MAX: u32 = 100_000;

/// Which faults, and how often: `late:5%@3,lost:1%,dup:1%,reorder:1%,nan:1%,burst:2%@10,rate:1000,
/// stop:200@1000`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Faults {
    /// Share of the poses that are late; those behind them wait.
    pub late: f64,
    /// Longest delay of a late pose \[ms\].
    pub late_ms: u32,
    /// Share of the poses that are never sent.
    pub lost: f64,
    /// Share of the poses that are sent twice.
    pub dup: f64,
    /// Share of the poses that are sent behind the next one.
    pub reorder: f64,
    /// Share of the poses whose position is no number.
    pub nan: f64,
    /// Share of the poses that begin a burst.
    pub burst: f64,
    /// Poses in a burst, all sent at the last one's moment.
    pub burst_poses: u32,
    /// Poses a second.
    pub rate_hz: u32,
    /// A stop, in which nothing is sent.
    pub stop: Option<Stop>,
    /// A sweep of the tissue takes at least so many pose periods, 0 for what it takes.
    pub sweep: f64,
    /// Poses before that.
    pub sweep_after: u32,
}

/// A span without poses; those that were due are sent at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Stop {
    /// Its length \[ms\].
    pub ms: u32,
    /// Poses before it.
    pub after_poses: u32,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            late: 0.0,
            late_ms: 5,
            lost: 0.0,
            dup: 0.0,
            reorder: 0.0,
            nan: 0.0,
            burst: 0.0,
            burst_poses: 10,
            rate_hz: 1000,
            stop: None,
            sweep: 0.0,
            sweep_after: 0,
        }
    }
}

impl FromStr for Faults {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut faults = Self::default();
        let mut seen = Vec::new();
        for part in text.split(',').map(str::trim) {
            let (kind, value) = part.split_once(':').ok_or_else(|| {
                format!("\"{part}\" is no fault; give KIND:VALUE, for instance late:5%")
            })?;
            if seen.contains(&kind) {
                return Err(format!("{kind} is given twice"));
            }
            seen.push(kind);
            faults.set(kind, value)?;
        }
        Ok(faults)
    }
}

impl Faults {
    fn set(&mut self, kind: &str, value: &str) -> Result<(), String> {
        let (front, extra) = match value.split_once('@') {
            Some((front, extra)) => (front, Some(extra)),
            None => (value, None),
        };
        match (kind, extra) {
            ("late", _) => {
                self.late = share(kind, front)?;
                self.late_ms = whole(kind, "ms", extra, self.late_ms, SPAN_MS_MAX)?;
            }
            ("burst", _) => {
                self.burst = share(kind, front)?;
                self.burst_poses = whole(kind, "poses", extra, self.burst_poses, BURST_MAX)?;
            }
            ("lost", None) => self.lost = share(kind, front)?,
            ("dup", None) => self.dup = share(kind, front)?,
            ("reorder", None) => self.reorder = share(kind, front)?,
            ("nan", None) => self.nan = share(kind, front)?,
            ("rate", None) => self.rate_hz = whole(kind, "Hz", Some(front), 0, RATE_HZ_MAX)?,
            ("sweep", _) => {
                self.sweep = periods(kind, front)?;
                self.sweep_after = match extra {
                    None => 0,
                    Some(_) => whole(kind, "poses", extra, 0, u32::MAX)?,
                };
            }
            ("stop", Some(_)) => {
                let ms = whole(kind, "ms", Some(front), 0, SPAN_MS_MAX)?;
                let after_poses = whole(kind, "poses", extra, 0, u32::MAX)?;
                self.stop = Some(Stop { ms, after_poses });
            }
            ("stop", None) => return Err("stop: give stop:MS@POSES, as in stop:200@1000".into()),
            ("lost" | "dup" | "reorder" | "nan" | "rate", Some(extra)) => {
                return Err(format!("{kind}: it has no \"@{extra}\""));
            }
            _ => {
                return Err(format!(
                    "\"{kind}\" is no fault; there are late, lost, dup, reorder, nan, burst, rate, \
                     stop and sweep"
                ));
            }
        }
        Ok(())
    }

    /// Least time of a sweep \[ns\].
    #[must_use]
    pub fn sweep_ns(&self) -> u64 {
        (self.sweep * self.period_ns() as f64) as u64
    }

    /// The faults of the tissue alone, as they are given.
    #[must_use]
    pub fn of_sweeps(&self) -> String {
        match self.sweep_after {
            0 => format!("sweep:{}", self.sweep),
            after => format!("sweep:{}@{after}", self.sweep),
        }
    }

    /// Whether there is a fault in the poses sent.
    #[must_use]
    pub fn in_poses(&self) -> bool {
        let Self { sweep, sweep_after, .. } = *self;
        *self != Self { sweep, sweep_after, ..Self::default() }
    }

    /// Time from one scheduled pose to the next \[ns\].
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        SECOND_NS / u64::from(self.rate_hz)
    }
}

fn periods(kind: &str, text: &str) -> Result<f64, String> {
    let periods =
        text.parse().ok().filter(|&periods| periods > 0.0 && periods <= SWEEP_PERIODS_MAX);
    periods.ok_or_else(|| {
        format!("{kind}:{text}: give more than 0 and at most {SWEEP_PERIODS_MAX} pose periods, as in {kind}:0.8")
    })
}

fn share(kind: &str, text: &str) -> Result<f64, String> {
    percent(text)
        .ok_or_else(|| format!("{kind}:{text}: give a share from 0% to 100%, as in {kind}:1%"))
}

fn whole(
    kind: &str,
    unit: &str,
    text: Option<&str>,
    otherwise: u32,
    most: u32,
) -> Result<u32, String> {
    let Some(text) = text else { return Ok(otherwise) };
    let number = text.parse().ok().filter(|number| (1..=most).contains(number));
    number.ok_or_else(|| format!("{kind}: \"{text}\" must be from 1 to {most} [{unit}]"))
}

/// What was done on purpose so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Injected {
    /// Seed that it was drawn with.
    pub seed: u64,
    /// Poses sent later than scheduled because they were late, bursts and stops aside.
    pub late: u64,
    /// Poses never sent.
    pub lost: u64,
    /// Poses sent a second time.
    pub duplicated: u64,
    /// Poses sent behind a later one: the server counts them and executes none.
    pub overtaken: u64,
    /// Poses whose position is no number.
    pub nan: u64,
    /// Bursts.
    pub bursts: u64,
    /// Stops.
    pub stops: u64,
    /// Rate of the schedule \[Hz\].
    pub rate_hz: u32,
}

/// One message to send.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sending {
    /// Which pose.
    pub index: u64,
    /// When it is sent, counted from the beginning \[ns\].
    pub due_ns: u64,
    /// Whether the pose was sent already.
    pub again: bool,
    /// Whether its position is to be no number.
    pub nan: bool,
    /// Whether a later pose was sent already: the server counts it and does not execute it.
    pub overtaken: bool,
}

impl Sending {
    /// The message.
    #[must_use]
    pub fn pose(&self, pose: Pose) -> Pose {
        if self.nan { Pose { position_m: [f32::NAN; 3], ..pose } } else { pose }
    }
}

/// The messages of a run, one after the other in the order of sending.
#[derive(Debug, Clone)]
pub struct Plan {
    faults: Faults,
    random: Pcg64,
    poses: u64,
    /// The next pose to look at.
    next: u64,
    /// Messages ready to be sent.
    ready: VecDeque<Sending>,
    /// A pose that waits for the next one to be sent.
    behind: Option<Sending>,
    /// The last message's moment.
    time_ns: u64,
    /// The highest pose sent.
    highest: Option<u64>,
    done: Injected,
    asked: bool,
}

/// What a whole plan comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Totals {
    /// Poses that the server should execute and answer.
    pub answers: u64,
    /// When the last message is sent, counted from the beginning \[ns\].
    pub end_ns: u64,
}

impl Plan {
    /// The messages of so many poses: each once and on time, or with faults and their seed.
    #[must_use]
    pub fn new(poses: u64, faults: Option<(Faults, u64)>) -> Self {
        let asked = faults.is_some();
        let (faults, seed) = faults.unwrap_or_default();
        Self {
            faults,
            random: Pcg64::seed_from_u64(seed),
            poses,
            next: 0,
            ready: VecDeque::with_capacity(4),
            behind: None,
            time_ns: 0,
            highest: None,
            done: Injected { seed, rate_hz: faults.rate_hz, ..Injected::default() },
            asked,
        }
    }

    /// Time from one scheduled pose to the next \[ns\].
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        self.faults.period_ns()
    }

    /// What was done so far, `None` where no faults were asked for.
    #[must_use]
    pub fn injected(&self) -> Option<Injected> {
        self.asked.then_some(self.done)
    }

    /// What the rest comes to. Cost: that of going through it.
    #[must_use]
    pub fn totals(&self) -> Totals {
        let mut rest = self.clone();
        let sent = rest.by_ref().filter(|sending| !sending.again).count() as u64;
        Totals { answers: sent - rest.done.overtaken, end_ns: rest.time_ns }
    }

    /// From 0 to below 1.
    fn draw(&mut self) -> f64 {
        f64::from(self.random.next_u32()) / 4_294_967_296.0
    }

    /// Makes the messages of the next pose ready.
    fn look(&mut self) {
        let index = self.next;
        self.next += 1;
        // Always the same number of draws, so that one fault's share leaves the others' poses be.
        let [late, delay, lost, dup, reorder, nan, burst] = [(); 7].map(|()| self.draw());
        if lost < self.faults.lost {
            self.done.lost += 1;
            return;
        }
        let mut due_ns = index * self.period_ns();
        if late < self.faults.late {
            let delay_ms = 1.0 + delay * f64::from(self.faults.late_ms - 1);
            due_ns += (delay_ms * MILLISECOND_NS as f64) as u64;
            self.done.late += 1;
        }
        if burst < self.faults.burst {
            due_ns += u64::from(self.faults.burst_poses - 1) * self.period_ns();
            self.done.bursts += 1;
        }
        let nan = nan < self.faults.nan;
        self.done.nan += u64::from(nan);
        let sending = Sending { index, due_ns, again: false, nan, overtaken: false };
        if reorder < self.faults.reorder && self.behind.is_none() {
            self.behind = Some(sending);
            return;
        }
        self.ready.push_back(sending);
        self.ready.extend(self.behind.take());
        if dup < self.faults.dup {
            self.ready.push_back(Sending { again: true, ..sending });
            self.done.duplicated += 1;
        }
    }

    /// The earliest moment of a pose that a stop holds up \[ns\].
    fn held_until_ns(&mut self, index: u64) -> u64 {
        match self.faults.stop {
            Some(stop) if index >= u64::from(stop.after_poses) => {
                self.done.stops = 1;
                u64::from(stop.after_poses) * self.period_ns() + u64::from(stop.ms) * MILLISECOND_NS
            }
            _ => 0,
        }
    }
}

impl Iterator for Plan {
    type Item = Sending;

    /// Allocates nothing.
    fn next(&mut self) -> Option<Sending> {
        while self.ready.is_empty() && self.next < self.poses {
            self.look();
        }
        if self.ready.is_empty() {
            self.ready.extend(self.behind.take());
        }
        let mut sending = self.ready.pop_front()?;
        // No message is due before the one ahead of it.
        sending.due_ns = sending.due_ns.max(self.held_until_ns(sending.index)).max(self.time_ns);
        self.time_ns = sending.due_ns;
        sending.overtaken = !sending.again && self.highest > Some(sending.index);
        self.done.overtaken += u64::from(sending.overtaken);
        self.highest = self.highest.max(Some(sending.index));
        Some(sending)
    }
}
