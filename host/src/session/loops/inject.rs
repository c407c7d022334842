//! Deliberate faults, injected between the schedule of poses and shared memory; a seed reproduces them.
//!
//! They are drawn pose by pose from the seed alone: the totals of a run are known before it, and the memory
//! does not depend on its length.

use std::collections::VecDeque;
use std::str::FromStr;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use crate::engine::motion::Pose;
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS};
use crate::words::percent;

/// Upper limit of a pose's delay, and of a stop \[ms\].
const SPAN_MS_MAX: u32 = 60_000;
/// Largest number of poses in a burst.
const BURST_MAX: u32 = 1000;
/// Largest duration to which a sweep is stretched, in pose periods.
const SWEEP_PERIODS_MAX: f64 = 1000.0;
/// Highest rate \[Hz\].
const RATE_HZ_MAX: u32 = 100_000;

/// Kinds of faults and their rates: `late:5%@3,lost:1%,dup:1%,reorder:1%,nan:1%,burst:2%@10,rate:1000,
/// stop:200@1000`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Faults {
    /// Share of the poses that are late; those after them wait.
    pub late: f64,
    /// Longest delay of a late pose \[ms\].
    pub late_ms: u32,
    /// Share of the poses that are never sent.
    pub lost: f64,
    /// Share of the poses that are sent twice.
    pub dup: f64,
    /// Share of the poses that are sent after the next one.
    pub reorder: f64,
    /// Share of the poses whose position is NaN.
    pub nan: f64,
    /// Share of the poses that start a burst.
    pub burst: f64,
    /// Poses in a burst, all sent when the last one is due.
    pub burst_poses: u32,
    /// Poses per second.
    pub rate_hz: u32,
    /// A stop, in which nothing is sent.
    pub stop: Option<Stop>,
    /// Minimum duration of a sweep of the tissue in pose periods, 0 for none.
    pub sweep: f64,
    /// Number of poses before `sweep` applies.
    pub sweep_after: u32,
}

/// A time without poses; those that were due are sent at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Stop {
    /// Duration \[ms\].
    pub ms: u32,
    /// Number of poses before it.
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
        // Split the value at the `@`.
        let (front, extra) = match value.split_once('@') {
            Some((front, extra)) => (front, Some(extra)),
            None => (value, None),
        };
        // Set the fields of the fault, or refuse it.
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

    /// Returns the minimum duration of a sweep \[ns\].
    #[must_use]
    pub fn sweep_ns(&self) -> u64 {
        (self.sweep * self.period_ns() as f64) as u64
    }

    /// Returns the text of the tissue's faults alone.
    #[must_use]
    pub fn of_sweeps(&self) -> String {
        match self.sweep_after {
            0 => format!("sweep:{}", self.sweep),
            after => format!("sweep:{}@{after}", self.sweep),
        }
    }

    /// Returns true if there is a fault in the sent poses.
    #[must_use]
    pub fn in_poses(&self) -> bool {
        let Self { sweep, sweep_after, .. } = *self;
        *self != Self { sweep, sweep_after, ..Self::default() }
    }

    /// Returns the time from one scheduled pose to the next \[ns\].
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

/// Numbers of deliberate faults so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Injected {
    /// Seed from which they are drawn.
    pub seed: u64,
    /// Poses drawn as late, without the delays of bursts and stops.
    pub late: u64,
    /// Poses never sent.
    pub lost: u64,
    /// Poses sent a second time.
    pub duplicated: u64,
    /// Poses sent after a later one: the server counts them and executes none.
    pub overtaken: u64,
    /// Poses whose position is NaN.
    pub nan: u64,
    /// Bursts.
    pub bursts: u64,
    /// Stops.
    pub stops: u64,
    /// Rate of the schedule, not a count \[Hz\].
    pub rate_hz: u32,
}

/// One message to send.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sending {
    /// Index of the pose.
    pub index: u64,
    /// Time at which it is sent, from the start of the run \[ns\].
    pub due_ns: u64,
    /// True if the pose was already sent.
    pub again: bool,
    /// True if its position has to be NaN.
    pub nan: bool,
    /// True if a later pose was already sent: the server counts this one and does not execute it.
    pub overtaken: bool,
}

impl Sending {
    /// Returns the pose to send.
    #[must_use]
    pub fn pose(&self, pose: Pose) -> Pose {
        if self.nan { Pose { position_m: [f32::NAN; 3], ..pose } } else { pose }
    }
}

/// Iterator over the messages of a run, in the order in which they are sent.
#[derive(Debug, Clone)]
pub struct Plan {
    faults: Faults,
    random: Pcg64,
    poses: u64,
    /// Index of the next pose.
    next: u64,
    /// Messages that are ready to be sent.
    ready: VecDeque<Sending>,
    /// A pose to be sent after the next one.
    behind: Option<Sending>,
    /// Time at which the last message is sent.
    time_ns: u64,
    /// Highest index of a sent pose.
    highest: Option<u64>,
    done: Injected,
    asked: bool,
}

/// Totals of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Totals {
    /// Poses that the server should execute and answer.
    pub answers: u64,
    /// Time at which the last message is sent, from the start of the run \[ns\].
    pub end_ns: u64,
}

impl Plan {
    /// Plans the messages of `poses` poses: each once and on time, or with faults and their seed.
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

    /// Returns the time from one scheduled pose to the next \[ns\].
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        self.faults.period_ns()
    }

    /// Returns the number of faults so far, `None` if none were requested.
    #[must_use]
    pub fn injected(&self) -> Option<Injected> {
        self.asked.then_some(self.done)
    }

    /// Returns the totals of a plan that is not played yet. Cost: it runs through all of it.
    #[must_use]
    pub fn totals(&self) -> Totals {
        let mut rest = self.clone();
        let sent = rest.by_ref().filter(|sending| !sending.again).count() as u64;
        Totals { answers: sent - rest.done.overtaken, end_ns: rest.time_ns }
    }

    /// Returns a random number from 0 to below 1.
    fn draw(&mut self) -> f64 {
        f64::from(self.random.next_u32()) / 4_294_967_296.0
    }

    /// Prepares the messages of the next pose.
    fn look(&mut self) {
        let index = self.next;
        self.next += 1;
        // Always draw 7 numbers, so that the share of one fault does not change the poses of the others.
        let [late, delay, lost, dup, reorder, nan, burst] = [(); 7].map(|()| self.draw());
        if lost < self.faults.lost {
            self.done.lost += 1;
            return;
        }
        // Delay the pose if it is late or starts a burst.
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
        // Mark it if its position has to be NaN.
        let nan = nan < self.faults.nan;
        self.done.nan += u64::from(nan);
        let sending = Sending { index, due_ns, again: false, nan, overtaken: false };
        // Hold it back until the next one, or queue it with the one that was held back and a duplicate.
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

    /// Returns the end of the stop if it delays this pose, else 0 \[ns\].
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

    /// Does not allocate.
    fn next(&mut self) -> Option<Sending> {
        while self.ready.is_empty() && self.next < self.poses {
            self.look();
        }
        if self.ready.is_empty() {
            self.ready.extend(self.behind.take());
        }
        let mut sending = self.ready.pop_front()?;
        // No message is due before the previous one.
        sending.due_ns = sending.due_ns.max(self.held_until_ns(sending.index)).max(self.time_ns);
        self.time_ns = sending.due_ns;
        sending.overtaken = !sending.again && self.highest > Some(sending.index);
        self.done.overtaken += u64::from(sending.overtaken);
        self.highest = self.highest.max(Some(sending.index));
        Some(sending)
    }
}
