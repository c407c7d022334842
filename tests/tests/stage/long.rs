//! Long holds with forces that come late, on walls and on bodies: what hums does not grow.
//!
//! A hand presses slowly, and stands still from 2.7 s on. From ten seconds on the range of the force
//! and the power that hand and handle get are taken, in the first half and in the second.
//!
//! Some holds of 20 s; of ten minutes with `CHAINCELL_SLOW=1`.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{TickOutput, ToolPose};
use chaincell_loops::closed_loop::{DEVICES, GRIPS, Wall};
use chaincell_loops::late::{Moment, Way, run_looking};
use chaincell_tests::bodies::Body;
use nalgebra::Vector3;

use crate::delay::{held, settings, ways};

/// When all should be quiet [s].
const QUIET_S: f64 = 10.0;
/// Most that hand and handle get out of a hum [W]: A20 of SAFETY.md.
const HUM_W: f64 = 3.0e-4;
/// How much wider a hum may be in the second half: as a share, and beside that and two counts of the
/// coupling's spring [N].
const GROWTH: (f64, f64) = (1.25, 0.01);

/// A half of a hold.
#[derive(Debug, Clone, Copy)]
struct Half {
    /// Least and largest force [N].
    force_n: [f64; 2],
    /// What hand and handle had got at its beginning and at its end [J].
    got_j: [Option<f64>; 2],
}

impl Half {
    const NEW: Self = Self { force_n: [f64::INFINITY, 0.0], got_j: [None; 2] };

    fn note(&mut self, now: &Moment) {
        let [least, largest] = self.force_n;
        self.force_n = [least.min(now.force_n), largest.max(now.force_n)];
        self.got_j = [self.got_j[0].or(Some(now.got_j)), Some(now.got_j)];
    }

    fn range_n(&self) -> f64 {
        self.force_n[1] - self.force_n[0]
    }

    fn power_w(&self, seconds: f64) -> f64 {
        (self.got_j[1].unwrap() - self.got_j[0].unwrap()) / seconds
    }
}

/// A hold `depth_m` below `touch` of so many seconds, in two halves.
fn hold(
    (way, device, grip): (&Way, usize, usize),
    tissue: &mut dyn FnMut(&ToolPose) -> TickOutput,
    (touch, depth_m): (Vector3<f64>, f64),
    seconds: f64,
) -> [Half; 2] {
    let wish = |t_s: f64| {
        let down = ((t_s - 0.3) / 2.4).clamp(0.0, 1.0);
        touch + Vector3::new(0.0, 0.0, 0.002 - down * (depth_m + 0.002))
    };
    let mut halves = [Half::NEW; 2];
    let middle_s = 0.5 * (QUIET_S + seconds);
    let mut look = |now: Moment| {
        if now.time_s >= QUIET_S {
            halves[usize::from(now.time_s >= middle_s)].note(&now);
        }
    };
    let held = held(device, grip);
    run_looking(settings(device, way), (&held, way), seconds, tissue, &wish, &mut look);
    halves
}

/// Two counts of a device's encoder under its coupling [N].
fn counts_n(device: usize) -> f64 {
    let (of, _, count_m) = DEVICES[device];
    2.0 * count_m * f64::from(of.coupling_n_per_m())
}

/// The worst of some holds.
#[derive(Default)]
struct Worst {
    holds: u32,
    range: (f64, String),
    power: (f64, String),
    growth: (f64, String),
    faults: u32,
}

impl Worst {
    fn note(&mut self, name: &str, counts_n: f64, halves: &[Half; 2], seconds: f64) {
        let half_s = 0.5 * (seconds - QUIET_S);
        let ranges = halves.map(|half| half.range_n());
        let power_w = halves.map(|half| half.power_w(half_s));
        let growth = ranges[1] - ranges[0];
        self.holds += 1;
        let text = format!(
            "{name}: {ranges:.3?} N, {:.1e}, {:.1e} W, {:.2?} N",
            power_w[0], power_w[1], halves[1].force_n
        );
        // A force may be small, but not gone.
        let is_quiet = power_w.iter().all(|w| *w <= HUM_W);
        if !is_quiet
            || ranges[1] > GROWTH.0 * ranges[0] + GROWTH.1 + counts_n
            || halves[1].force_n[1] < 0.01
        {
            println!("FAULT {text}");
            self.faults += 1;
        }
        let worst = power_w[0].max(power_w[1]);
        let places = [&mut self.range, &mut self.power, &mut self.growth];
        for (place, is) in places.into_iter().zip([ranges[0].max(ranges[1]), worst, growth]) {
            if place.1.is_empty() || is > place.0 {
                *place = (is, text.clone());
            }
        }
    }

    fn print(&self, what: &str) {
        println!("{what}: {} holds", self.holds);
        println!("  widest {:.3} N, {}", self.range.0, self.range.1);
        println!("  power {:.1e} W, {}", self.power.0, self.power.1);
        println!("  growth {:.4} N, {}", self.growth.0, self.growth.1);
    }
}

/// Length of a hold [s], and of how many one is taken.
fn length(quick: usize, slow: usize) -> (f64, usize) {
    if std::env::var_os("CHAINCELL_SLOW").is_some() {
        (600.0 + QUIET_S, slow)
    } else {
        println!("SKIPPED ten minutes for each hold: CHAINCELL_SLOW is not set");
        (20.0, quick)
    }
}

/// Every way, device and hand from one of them on, or one of so many.
fn cases(from: usize, stride: usize) -> impl Iterator<Item = (Way, usize, usize)> {
    let every = |way: Way| (0..10).map(move |of| (way, of % DEVICES.len(), of / DEVICES.len()));
    ways().flat_map(every).skip(from).step_by(stride)
}

fn name((way, device, grip): &(Way, usize, usize)) -> String {
    format!("{:?}, hand {} N/m, {way:?}", DEVICES[*device].0, GRIPS[*grip].0)
}

// REQ-STG-11
#[test]
fn holds_on_walls_do_not_grow_however_late() {
    let (seconds, stride) = length(7, 13);
    let mut faults = 0;
    for stiffness in [100.0, 1000.0, 5000.0, 10_000.0] {
        let mut worst = Worst::default();
        for case in cases(0, stride) {
            let mut wall = Wall::new(stiffness);
            let (way, device, grip) = (&case.0, case.1, case.2);
            let place = (Vector3::zeros(), 0.01);
            let halves = hold((way, device, grip), &mut |tool| wall.tick(tool), place, seconds);
            worst.note(&name(&case), counts_n(device), &halves, seconds);
        }
        worst.print(&format!("wall of {stiffness} N/m"));
        faults += worst.faults;
    }
    assert_eq!(faults, 0);
}

// REQ-STG-11
#[test]
fn holds_on_bodies_do_not_grow_however_late() {
    let mut faults = 0;
    for (of, body) in Body::all().iter().enumerate() {
        // A tick of nodal shapes takes ten times as long.
        let (seconds, stride) = if of < 3 { length(197, 179) } else { length(397, 397) };
        // Holds of 20 s are others on every body: of all delays and rates between them.
        let from = if seconds < 100.0 { 67 * of } else { 0 };
        let mut worst = Worst::default();
        for (at, case) in cases(from, stride).enumerate() {
            let tool = (at + of) % 3;
            let depth_m = (0.5 * body.thickness_m).min(0.01);
            let (way, device, grip) = (&case.0, case.1, case.2);
            let place = (body.touch_m(tool), depth_m);
            let halves = hold((way, device, grip), &mut body.tissue(tool), place, seconds);
            worst.note(
                &format!("{:?}, {}", body.tool(tool), name(&case)),
                counts_n(device),
                &halves,
                seconds,
            );
        }
        worst.print(body.name);
        faults += worst.faults;
    }
    assert_eq!(faults, 0);
}
