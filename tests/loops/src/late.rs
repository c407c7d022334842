//! A modelled device in a hand, far from its tissue: forces come late, by turns, or not at all.
//!
//! Device and hand are those of [`crate::handle`]. A pose gets lost with a given chance; the answer to
//! one that arrives acts so many ticks after it, within a given range, never before an older one.
//!
//! **Energy made**: what the device's force has done on the handle less what the handle's damping has
//! taken is what hand and handle have got. It may not rise, in any five seconds, by more than tissue and
//! coupling stored at their beginning. A span begins where the handle is slower than 5 mm/s: before
//! that forces are on their way whose work nobody has stored.

use std::collections::VecDeque;

use chaincell_kernel::stage::{Stage, StageSettings};
use chaincell_kernel::{Flags, TickOutput, ToolPose};
use nalgebra::Vector3;

use crate::handle::{Hand, Handle, Moving};

type V = Vector3<f64>;

/// Span in which energy is counted \[s\].
const SPAN_S: f64 = 5.0;
/// Slowest motion at which a span may begin \[m/s\].
const SLOW_M_PER_S: f64 = 5.0e-3;

/// The way of poses and forces.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    /// Time of a tick \[s\].
    pub tick_s: f64,
    /// Least and largest age of a force, from the pose that it answers \[ticks\].
    pub ages: [usize; 2],
    /// Share of the poses that get lost.
    pub lost: f64,
    /// Whether the stage is told each answer's age, and else the largest once.
    pub measures: bool,
}

/// A handle, and stiffness \[N/m\] and damping [N s/m] of the hand that holds it.
pub type Held = (Handle, (f64, f64));

/// What came of a loop.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    /// Most energy made in a span \[J\].
    pub made_j: f64,
    /// Sum over ticks of the force at the handle \[N\].
    pub shown_n: f64,
    /// Sum of the tissue's forces, each as old as that at the handle \[N\].
    pub tissue_n: f64,
    /// Ticks in which the tissue had a force, as in the tick before, and the hand felt none.
    pub zeros: u32,
    /// The force that acts at the end \[N\].
    pub last_n: f64,
    /// Ticks in which the stage let the force go.
    pub withheld: u32,
    /// Most that hand and handle have got out of nothing since the beginning \[J\].
    pub got_j: f64,
}

/// A loop at the end of a tick.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    /// Time \[s\].
    pub time_s: f64,
    /// The force that acts \[N\].
    pub force_n: f64,
    /// From the handle to the tool in the tissue \[m\].
    pub apart_m: f64,
    /// What hand and handle have got out of nothing so far \[J\].
    pub got_j: f64,
    /// What the device has given to the handle so far \[J\].
    pub port_j: f64,
    /// How fast the handle moves \[m/s\].
    pub speed_m_per_s: f64,
}

/// Repeatable chances.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Forces on their way, each with what the tissue's was; the one that acts.
struct Line {
    queue: VecDeque<(usize, V, f64)>,
    acts: (V, f64),
    last: usize,
}

impl Line {
    /// A force of this tick, due in so many; gives its age.
    fn send(&mut self, tick: usize, age: usize, force: V, tissue_n: f64) -> usize {
        self.last = self.last.max(tick + age);
        self.queue.push_back((self.last, force, tissue_n));
        self.last - tick
    }

    fn take(&mut self, tick: usize) {
        while self.queue.front().is_some_and(|(due, ..)| *due <= tick) {
            if let Some((_, force, tissue_n)) = self.queue.pop_front() {
                self.acts = (force, tissue_n);
            }
        }
    }
}

/// The least of what hand, handle, tissue and coupling had in the last span.
#[derive(Default)]
struct Least(VecDeque<(usize, f64)>);

impl Least {
    fn note(&mut self, tick: usize, span: usize, has_j: f64) {
        while self.0.back().is_some_and(|(_, least)| *least >= has_j) {
            self.0.pop_back();
        }
        self.0.push_back((tick, has_j));
        while self.0.len() > 1 && self.0.front().is_some_and(|(at, _)| at + span < tick) {
            self.0.pop_front();
        }
    }

    fn j(&self) -> f64 {
        self.0.front().map_or(0.0, |(_, least)| *least)
    }
}

/// Runs a loop for `seconds`; the hand wants to be at `wish` of the time, where the handle begins.
pub fn run(
    settings: StageSettings,
    of: (&Held, &Way),
    seconds: f64,
    tissue: &mut dyn FnMut(&ToolPose) -> TickOutput,
    wish: &dyn Fn(f64) -> V,
) -> Seen {
    run_looking(settings, of, seconds, tissue, wish, &mut |_| ())
}

/// As [`run`], telling of every tick.
pub fn run_looking(
    settings: StageSettings,
    ((handle, grip), way): (&Held, &Way),
    seconds: f64,
    tissue: &mut dyn FnMut(&ToolPose) -> TickOutput,
    wish: &dyn Fn(f64) -> V,
    look: &mut dyn FnMut(Moment),
) -> Seen {
    let mut stage = Stage::new(settings).expect("settings within their ranges");
    let mut chance = Chance(0x9e37_79b9_7f4a_7c15);
    let mut moving = Moving::new(*handle, wish(0.0));
    let (mut energy_j, mut tool) = (0.0, wish(0.0));
    let mut line = Line { queue: VecDeque::new(), acts: (V::zeros(), 0.0), last: 0 };
    let (mut least, mut seen) = (Least::default(), Seen::default());
    let [from, to] = way.ages;
    let (mut age, mut missed, mut touched) = (from, 0, false);
    let ticks = (seconds / way.tick_s) as usize;
    let span = (SPAN_S / way.tick_s) as usize;
    for tick in 0..ticks {
        if chance.next() < way.lost {
            let _ = stage.missed();
            missed += 1;
        } else {
            if way.measures {
                stage.delayed((age + missed) as u16);
            }
            missed = 0;
            let given = stage.sample(&moving.sample(true));
            let answer = tissue(&given);
            let output = stage.output(&answer);
            seen.withheld += u32::from(output.flags.contains(Flags::FORCE_WITHHELD));
            (energy_j, tool) = (f64::from(answer.energy_j), given.position_m.map(f64::from));
            let late = from + (chance.next() * (to - from + 1) as f64) as usize;
            let tissue_n = f64::from(answer.force_n.norm());
            age = line.send(tick, late, output.force_n.map(f64::from), tissue_n);
        }
        line.take(tick);
        let (force, tissue_n) = line.acts;
        seen.last_n = force.norm();
        let spring = stage.coupling().map_or(0.0, |of| of.stiffness_n_per_m.into());
        if moving.velocity.norm() < SLOW_M_PER_S {
            let apart_m2 = (tool - moving.position).norm_squared();
            least.note(tick, span, moving.got_j() + energy_j + 0.5 * spring * apart_m2);
        }
        let is_counted = tick as f64 * way.tick_s > 0.2 && tissue_n > 0.02;
        if is_counted && tissue_n < 0.9 * f64::from(settings.max_force_n) {
            seen.shown_n += force.norm();
            seen.tissue_n += tissue_n;
            // A coupling shows a touch from the tick behind it on.
            seen.zeros += u32::from(force == V::zeros() && touched);
        }
        touched = tissue_n > 0.02;
        let at = wish(tick as f64 * way.tick_s);
        let (stiffness_n_per_m, damping_n_s_per_m) = *grip;
        let hand = Hand { stiffness_n_per_m, damping_n_s_per_m, holds: true, at };
        moving.go(force, &hand, way.tick_s);
        let (got_j, apart_m) = (moving.got_j(), (tool - moving.position).norm());
        seen.made_j = seen.made_j.max(got_j - least.j());
        seen.got_j = seen.got_j.max(got_j);
        look(Moment {
            time_s: tick as f64 * way.tick_s,
            force_n: force.norm(),
            apart_m,
            got_j,
            port_j: moving.port_j,
            speed_m_per_s: moving.velocity.norm(),
        });
    }
    seen
}
