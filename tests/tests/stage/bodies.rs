//! The output stage with forces that come late, on bodies of links and
//! of nodal shapes, elastic ones and one that relaxes, under tools on their surface.
//!
//! The ways of poses and forces, devices and hands are those of the walls in `delay`. A press begins
//! outside the stage's ramp, within it, or the tool engages inside the body. Some of all loops are
//! run; more with `CHAINCELL_SLOW=1`.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::stage::passive_stiffness_n_per_m;
use chaincell_loops::closed_loop::{self, DEVICES, GRIPS, Wall};
use chaincell_loops::late::{Moment, Seen, Way, run, run_looking};
use chaincell_tests::bodies::Body;
use nalgebra::Vector3;

use crate::delay::{held, settings, ways};

type V = Vector3<f64>;

/// Length of a loop [s].
const SECONDS: f64 = 5.0;
/// Of how many loops one is run, of links and of nodal shapes, whose tick takes longer.
const STRIDES: [usize; 2] = [1153, 4049];
/// The same of a body that relaxes: all presses, devices and ages are among its loops.
const RELAXING_STRIDE: usize = 937;
/// How much further on each body begins than the one before it, so that each has loops of its own.
const FURTHER: usize = 389;
/// The same with `CHAINCELL_SLOW`.
const SLOW_STRIDES: [usize; 2] = [31, 97];

/// A press by its way down from where the tool begins to touch, in parts of its depth.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Press {
    /// 2.4 s down, 0.8 s there, 1 s back.
    Slow,
    /// [`closed_loop::busy`].
    Busy,
    /// All the way in 30 ms, within the ramp.
    InRamp,
    /// Engaged at its depth.
    Inside,
    /// Engaged at its depth by a hand that goes to and fro between there and half of it, at 2 Hz.
    InsideBusy,
}

impl Press {
    const ALL: [Self; 5] = [Self::Slow, Self::Busy, Self::InRamp, Self::Inside, Self::InsideBusy];

    /// The way at a time [m].
    fn at(self, depth_m: f64, t_s: f64) -> V {
        let ramp = |from: f64, length: f64| ((t_s - from) / length).clamp(0.0, 1.0);
        let above = V::new(0.0, 0.0, 0.002);
        let down = |share: f64| V::new(0.0, 0.0, -share * (depth_m + 0.002));
        match self {
            Self::Slow => above + down(ramp(0.3, 2.4) - ramp(3.5, 1.0)),
            Self::Busy => above + closed_loop::busy(1000.0 * t_s) * depth_m,
            Self::InRamp => above + down(ramp(0.0, 0.03) - ramp(3.0, 1.0)),
            Self::Inside => V::new(0.0, 0.0, -depth_m),
            Self::InsideBusy => {
                let share = 0.75 + 0.25 * (std::f64::consts::TAU * 2.0 * t_s).cos();
                V::new(0.0, 0.0, -share * depth_m)
            }
        }
    }

    /// Most that may be made [J].
    fn most_j(self) -> f64 {
        match self {
            Self::Slow | Self::Busy => 1.0e-3,
            Self::InRamp => 3.0e-3,
            Self::Inside | Self::InsideBusy => 13.0e-3,
        }
    }
}

/// True if the whole suite is run.
fn is_slow() -> bool {
    std::env::var_os("CHAINCELL_SLOW").is_some()
}

/// A loop of the matrix.
#[derive(Debug, Clone, Copy)]
struct Case {
    way: Way,
    device: usize,
    grip: usize,
    tool: usize,
    press: Press,
}

impl Case {
    /// All loops, in an order in which a stride goes through all that is chosen.
    fn all() -> impl Iterator<Item = Self> {
        ways().flat_map(|way| {
            let presses = Press::ALL.into_iter();
            presses.flat_map(move |press| {
                (0..DEVICES.len() * GRIPS.len() * 3).map(move |of| {
                    let (device, of) = (of % DEVICES.len(), of / DEVICES.len());
                    Self { way, device, grip: of % 2, tool: of / 2, press }
                })
            })
        })
    }

    /// Loops of a body, by its place.
    fn some(of_body: usize) -> impl Iterator<Item = Self> {
        let (strides, from) =
            if is_slow() { (SLOW_STRIDES, 0) } else { (STRIDES, FURTHER * of_body) };
        Self::all().skip(from).step_by(strides[usize::from(of_body >= 3)])
    }

    /// What is expected of a loop that does not hold, `stiffness_n_per_m` being what is shown at the end
    /// of the slow press.
    fn lacks(&self, seen: &Seen, stiffness_n_per_m: f64) -> Vec<&'static str> {
        let is_outside = matches!(self.press, Press::Slow | Press::Busy);
        let made_j = if is_outside { seen.made_j } else { seen.got_j };
        let late = self.way.ages[1] as f32;
        let is_soon = self.way.lost == 0.0 && late <= 1.0;
        let is_told_all = late >= 2.0 && self.way.lost == 0.0 && !self.way.measures;
        let passive = f64::from(passive_stiffness_n_per_m(0.5, late, self.way.tick_s as f32));
        let has_coupling = stiffness_n_per_m.is_finite();
        let wanted =
            (0.5 * passive).min(f64::from(0.95 * DEVICES[self.device].0.coupling_n_per_m()));
        let is_slow = self.press == Press::Slow;
        let lacks = [
            ("more energy than it may", made_j > self.press.most_j()),
            ("let go", is_outside && seen.withheld > 0),
            ("less than 0.95 of the force", is_slow && seen.shown_n < 0.95 * seen.tissue_n),
            ("no force", is_slow && is_soon && seen.zeros > 0),
            ("nothing felt", is_slow && seen.tissue_n < 1.0),
            (
                "less than is passive",
                is_slow && is_told_all && has_coupling && stiffness_n_per_m < wanted,
            ),
        ];
        lacks.into_iter().filter(|(_, is)| *is).map(|(why, _)| why).collect()
    }
}

/// Runs a loop; gives the stiffness shown in the slow press's hold too [N/m].
fn look(body: &Body, case: &Case) -> (Seen, f64) {
    let depth_m = (0.5 * body.thickness_m).min(0.01);
    let touch = body.touch_m(case.tool);
    let wish = |t_s: f64| touch + case.press.at(depth_m, t_s);
    let mut shown = (0.0, 0.0);
    let seen = run_looking(
        settings(case.device, &case.way),
        (&held(case.device, case.grip), &case.way),
        SECONDS,
        &mut body.tissue(case.tool),
        &wish,
        &mut |now: Moment| {
            if (3.2..3.4).contains(&now.time_s) {
                shown = (shown.0 + now.force_n, shown.1 + now.apart_m);
            }
        },
    );
    (seen, shown.0 / shown.1)
}

/// Runs these loops of a body, prints the worst of them and returns those that do not hold.
fn faults(body: &Body, cases: impl Iterator<Item = Case>) -> Vec<String> {
    let mut faults = Vec::new();
    let mut worst = [(0.0, String::new()), (0.0, String::new()), (0.0, String::new())];
    let mut least = (f64::INFINITY, String::new());
    let mut loops = 0;
    for case in cases {
        let (seen, stiffness) = look(body, &case);
        loops += 1;
        let name = format!(
            "{}, {:?}, {:?}, hand {} N/m, {case:?}: {stiffness:.0} N/m, {seen:?}",
            body.name,
            body.tool(case.tool),
            DEVICES[case.device].0,
            GRIPS[case.grip].0
        );
        let (at, made_j) = match case.press {
            Press::Slow | Press::Busy => (0, seen.made_j),
            Press::InRamp => (1, seen.got_j),
            Press::Inside | Press::InsideBusy => (2, seen.got_j),
        };
        if made_j >= worst[at].0 {
            worst[at] = (made_j, name.clone());
        }
        let share = seen.shown_n / seen.tissue_n;
        if case.press == Press::Slow && share < least.0 {
            least = (share, name.clone());
        }
        let lacks = case.lacks(&seen, stiffness);
        if !lacks.is_empty() {
            println!("FAULT {lacks:?}: {name}");
            faults.push(name);
        }
    }
    println!("{}: {loops} loops", body.name);
    println!("  {:.3} of the force at least, {}", least.0, least.1);
    for (kind, (made_j, name)) in ["outside", "in the ramp", "inside"].iter().zip(worst) {
        println!("  {kind}: {made_j:.1e} J at most, {name}");
    }
    faults
}

// REQ-STG-02, REQ-STG-11
#[test]
fn bodies_are_felt_and_give_nothing_for_nothing_however_late() {
    let bodies = Body::all();
    let each = bodies.iter().enumerate().flat_map(|(of, body)| faults(body, Case::some(of)));
    let faults: Vec<String> = each.collect();
    assert!(faults.is_empty(), "{} loops", faults.len());
}

/// The energy that a body's branches hold fades, and the hand gets none of it for nothing.
// REQ-STG-02, REQ-STG-11
#[test]
fn a_body_that_relaxes_gives_nothing_for_nothing_however_late() {
    let stride = if is_slow() { SLOW_STRIDES[1] } else { RELAXING_STRIDE };
    let faults = faults(&Body::relaxing(), Case::all().step_by(stride));
    assert!(faults.is_empty(), "{} loops", faults.len());
}

/// The same on walls: a press of 12 mm within the ramp, and a tool that engages 20 mm inside. One of seven ways,
/// devices and hands; all with `CHAINCELL_SLOW=1`.
// REQ-STG-11
#[test]
fn walls_throw_no_tool_that_engages_however_late() {
    let stride = if is_slow() { 1 } else { 7 };
    for stiffness in [300.0, 1000.0, 5000.0, 10_000.0] {
        for (press, depth_m) in
            [(Press::InRamp, 0.01), (Press::Inside, 0.02), (Press::InsideBusy, 0.02)]
        {
            let (mut most, mut of) = (0.0, String::new());
            let all = ways().flat_map(|way| (0..10).map(move |of| (way, of % 5, of / 5)));
            for (way, device, grip) in all.step_by(stride) {
                let mut wall = Wall::new(stiffness);
                let wish = |t_s: f64| press.at(depth_m, t_s);
                let held = held(device, grip);
                let mut tissue = |tool: &_| wall.tick(tool);
                let seen = run(settings(device, &way), (&held, &way), 5.0, &mut tissue, &wish);
                if seen.got_j >= most {
                    let (device, hand) = (DEVICES[device].0, GRIPS[grip].0);
                    (most, of) =
                        (seen.got_j, format!("{device:?}, hand {hand} N/m, {way:?}: {seen:?}"));
                }
            }
            println!("wall of {stiffness} N/m, {press:?}: {most:.1e} J, {of}");
            assert!(most <= press.most_j(), "{stiffness} N/m, {press:?}: {most} J, {of}");
        }
    }
}
