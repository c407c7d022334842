//! Faults on purpose, between the schedule of poses and shared memory: the same for a seed.
//!
//! All of them are drawn before the first pose, so that the loop that sends only looks them up.

use std::str::FromStr;

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use super::clock::{MILLISECOND_NS, PERIOD_NS, SECOND_NS};
use super::payload::ToolPose;

/// Longest delay of a late pose, and longest stop \[ms\].
const SPAN_MS_MAX: u32 = 60_000;
/// Most poses in a burst.
const BURST_MAX: u32 = 1000;
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
                    "\"{kind}\" is no fault; there are late, lost, dup, reorder, nan, burst, rate \
                     and stop"
                ));
            }
        }
        Ok(())
    }

    /// Time from one scheduled pose to the next \[ns\].
    #[must_use]
    pub fn period_ns(&self) -> u64 {
        SECOND_NS / u64::from(self.rate_hz)
    }
}

fn share(kind: &str, text: &str) -> Result<f64, String> {
    let percent = text.strip_suffix('%').and_then(|number| number.parse::<f64>().ok());
    match percent {
        Some(percent) if (0.0..=100.0).contains(&percent) => Ok(percent / 100.0),
        _ => Err(format!("{kind}:{text}: give a share from 0% to 100%, as in {kind}:1%")),
    }
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

/// What was done on purpose.
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
}

impl Sending {
    /// The message.
    #[must_use]
    pub fn pose(&self, pose: ToolPose) -> ToolPose {
        if self.nan { ToolPose { position_m: [f32::NAN; 3], ..pose } } else { pose }
    }
}

/// All messages of a run, in the order of sending.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    messages: Messages,
    /// Time from one scheduled pose to the next \[ns\].
    pub period_ns: u64,
    /// What was done, `None` for a plan without faults.
    pub injected: Option<Injected>,
}

#[derive(Debug, Clone, PartialEq)]
enum Messages {
    /// So many poses, each once and on time: they take no memory.
    OnTime(u64),
    Drawn(Vec<Sending>),
}

impl Plan {
    /// Every pose once, on time.
    #[must_use]
    pub fn faultless(poses: u64) -> Self {
        Self { messages: Messages::OnTime(poses), period_ns: PERIOD_NS, injected: None }
    }

    /// The messages of so many poses with faults; 24 bytes each.
    #[must_use]
    pub fn new(poses: u64, faults: &Faults, seed: u64) -> Self {
        let mut draft = Draft {
            random: Pcg64::seed_from_u64(seed),
            done: Injected { seed, rate_hz: faults.rate_hz, ..Injected::default() },
            sendings: Vec::new(),
            behind: None,
        };
        for index in 0..poses {
            draft.pose(index, faults);
        }
        let Draft { mut done, mut sendings, behind, .. } = draft;
        sendings.extend(behind);
        done.stops = u64::from(stop(&mut sendings, faults));
        done.overtaken = put_in_time(&mut sendings);
        Self {
            messages: Messages::Drawn(sendings),
            period_ns: faults.period_ns(),
            injected: Some(done),
        }
    }

    /// The messages in order.
    pub fn sendings(&self) -> impl Iterator<Item = Sending> + '_ {
        let (on_time, drawn) = match &self.messages {
            Messages::OnTime(poses) => (*poses, [].as_slice()),
            Messages::Drawn(sendings) => (0, sendings.as_slice()),
        };
        let due = |index| Sending { index, due_ns: index * PERIOD_NS, again: false, nan: false };
        (0..on_time).map(due).chain(drawn.iter().copied())
    }

    /// Poses that the server should execute and answer.
    #[must_use]
    pub fn answers(&self) -> u64 {
        let (sent, overtaken) = (self.poses_sent(), self.injected.map_or(0, |done| done.overtaken));
        sent - overtaken
    }

    /// Poses that are sent, each counted once.
    #[must_use]
    pub fn poses_sent(&self) -> u64 {
        self.sendings().filter(|sending| !sending.again).count() as u64
    }
}

/// Holds back what is due in the stop; false where the run ends before it.
fn stop(sendings: &mut [Sending], faults: &Faults) -> bool {
    let Some(stop) = faults.stop else { return false };
    let begins = u64::from(stop.after_poses);
    let ends_ns = begins * faults.period_ns() + u64::from(stop.ms) * MILLISECOND_NS;
    let mut any = false;
    for sending in sendings.iter_mut().filter(|sending| sending.index >= begins) {
        sending.due_ns = sending.due_ns.max(ends_ns);
        any = true;
    }
    any
}

/// No message is due before the one ahead of it. Returns the number of those that a later pose is
/// ahead of.
fn put_in_time(sendings: &mut [Sending]) -> u64 {
    let (mut time_ns, mut highest, mut overtaken) = (0, None, 0);
    for sending in sendings {
        time_ns = sending.due_ns.max(time_ns);
        sending.due_ns = time_ns;
        let is_behind = highest.is_some_and(|highest| sending.index < highest);
        overtaken += u64::from(!sending.again && is_behind);
        highest = highest.max(Some(sending.index));
    }
    overtaken
}

/// A plan under way.
struct Draft {
    random: Pcg64,
    done: Injected,
    sendings: Vec<Sending>,
    /// A pose that waits for the next one to be sent.
    behind: Option<Sending>,
}

impl Draft {
    /// From 0 to below 1.
    fn draw(&mut self) -> f64 {
        f64::from(self.random.next_u32()) / 4_294_967_296.0
    }

    fn pose(&mut self, index: u64, faults: &Faults) {
        // Always the same number of draws, so that one fault's share leaves the others' poses be.
        let [late, delay, lost, dup, reorder, nan, burst] = [(); 7].map(|()| self.draw());
        if lost < faults.lost {
            self.done.lost += 1;
            return;
        }
        let mut due_ns = index * faults.period_ns();
        if late < faults.late {
            let delay_ms = 1.0 + delay * f64::from(faults.late_ms - 1);
            due_ns += (delay_ms * MILLISECOND_NS as f64) as u64;
            self.done.late += 1;
        }
        if burst < faults.burst {
            due_ns += u64::from(faults.burst_poses - 1) * faults.period_ns();
            self.done.bursts += 1;
        }
        let nan = nan < faults.nan;
        self.done.nan += u64::from(nan);
        let sending = Sending { index, due_ns, again: false, nan };
        if reorder < faults.reorder && self.behind.is_none() {
            self.behind = Some(sending);
            return;
        }
        self.sendings.push(sending);
        self.sendings.extend(self.behind.take());
        if dup < faults.dup {
            self.sendings.push(Sending { again: true, ..sending });
            self.done.duplicated += 1;
        }
    }
}

#[cfg(test)]
mod tests;
