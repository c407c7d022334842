//! Deep presses, to 60 % of a body's thickness, behind the output stage: what softens, gives way or
//! slips aside is felt as the tissue has it, the force is never let go, and the hand gets back no more
//! than it has put in.
//!
//! The handle goes straight down at a given speed, 100 ticks of the ramp and 200 more after it has
//! engaged, and up again. One press in every few is run; all with `CHAINCELL_SLOW=1`.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::stage::{Stage, StageSettings};
use chaincell_kernel::{Flags, ToolPose};
use chaincell_loops::closed_loop::DEVICES;
use chaincell_tests::bodies::Body;
use nalgebra::Vector3;

/// How far down, in parts of the thickness.
const SHARE: f64 = 0.6;
/// Speeds [m/s], a tick being 1 ms.
const SPEEDS: [f64; 5] = [0.005, 0.01, 0.02, 0.05, 0.1];
/// Ticks for which the tool stands engaged before it goes.
const STANDS: u32 = 300;
/// Above the place where the tool touches [m].
const ABOVE_M: f64 = 0.002;
/// Most that the hand gets back \[J\].
const GOT_MAX_J: f64 = 5.0e-4;
/// Of how many presses one is run without `CHAINCELL_SLOW`.
const STRIDE: usize = 17;

/// What came of a press.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    /// Sum over ticks of the force at the handle, and of the tissue's at the proxy [N].
    shown_n: f64,
    tissue_n: f64,
    /// Largest force of the tissue [N].
    most_n: f64,
    /// What the hand has got in the end \[J\].
    got_j: f64,
    /// Ticks without a force where the tissue had one, and ticks in which the force was let go.
    zeros: u32,
    withheld: u32,
    /// Ticks in which the tissue's force fell.
    falls: u32,
    /// Ticks in which the tissue let the tool go no deeper (flag 1): the hand then feels the coupling's
    /// spring, which is more than the tissue.
    cut: u32,
}

fn press(body: &Body, tool: usize, speed: f64, settings: StageSettings) -> Seen {
    let mut stage = Stage::new(settings).unwrap();
    let mut tissue = body.tissue(tool);
    let step_m = speed * 1.0e-3;
    let ticks = ((ABOVE_M + SHARE * body.thickness_m) / step_m) as u32;
    let above = body.touch_m(tool) + Vector3::new(0.0, 0.0, ABOVE_M);
    let (mut seen, mut last_n) = (Seen::default(), 0.0);
    let (mut before_m, mut given_n) = (0.0, 0.0_f64);
    for tick in 0..STANDS + 2 * ticks {
        let way = tick.saturating_sub(STANDS);
        let down_m = step_m * f64::from(way.min(2 * ticks - way));
        seen.got_j += given_n * (before_m - down_m);
        before_m = down_m;
        let position_m = (above - Vector3::new(0.0, 0.0, down_m)).map(|x| x as f32);
        let answer = tissue(&stage.sample(&ToolPose::at(position_m, 1)));
        let output = stage.output(&answer);
        seen.withheld += u32::from(output.flags.contains(Flags::FORCE_WITHHELD));
        given_n = output.force_n.z.into();
        if way > ticks {
            continue;
        }
        let (tissue_n, shown_n) =
            (f64::from(answer.force_n.norm()), f64::from(output.force_n.norm()));
        seen.falls += u32::from(tissue_n < last_n);
        seen.cut += u32::from(answer.flags.contains(Flags::MOTION_CLAMPED));
        seen.most_n = seen.most_n.max(tissue_n);
        if tissue_n > 0.02 && last_n > 0.02 && tissue_n < 0.9 * f64::from(settings.max_force_n) {
            seen.zeros += u32::from(shown_n == 0.0);
            (seen.shown_n, seen.tissue_n) = (seen.shown_n + shown_n, seen.tissue_n + tissue_n);
        }
        last_n = tissue_n;
    }
    seen
}

// REQ-STG-12
#[test]
fn a_deep_press_is_felt_and_never_let_go() {
    let is_slow = std::env::var_os("CHAINCELL_SLOW").is_some();
    let (mut faults, mut softens) = (0, false);
    for (at, body) in Body::all().iter().enumerate() {
        // On each body others.
        let (from, stride) = if is_slow { (0, 1) } else { (at, STRIDE) };
        let (mut least, mut most, mut presses) =
            ((f64::INFINITY, String::new()), [(0.0, String::new()), (0.0, String::new())], 0);
        let of = SPEEDS.len() * DEVICES.len();
        for case in (from..3 * of).step_by(stride) {
            let (tool, speed, (device, ..)) =
                (case / of, SPEEDS[case % SPEEDS.len()], DEVICES[case % of / SPEEDS.len()]);
            let seen = press(body, tool, speed, StageSettings::for_device(device));
            let share = seen.shown_n / seen.tissue_n;
            let shape = body.tool(tool);
            let name = format!("{}, {shape:?}, {device:?}, {speed} m/s: {seen:?}", body.name);
            presses += 1;
            softens |= seen.falls > 100;
            let is_felt = seen.zeros == 0 && share >= 0.95 && seen.tissue_n >= 1.0;
            if seen.withheld > 0 || !is_felt || seen.got_j > GOT_MAX_J {
                println!("FAULT {share:.3}, {name}");
                faults += 1;
            }
            let of = usize::from(seen.cut > 0);
            if share > most[of].0 {
                most[of] = (share, name.clone());
            }
            if share < least.0 {
                least = (share, name);
            }
        }
        println!("{presses} presses, {:.3} of the force at least, {}", least.0, least.1);
        for (kind, (share, name)) in ["  never cut short", "  cut short"].iter().zip(most) {
            println!("{kind}: {share:.3} at most, {name}");
        }
    }
    assert!(softens, "no force ever falls: this is no test");
    assert_eq!(faults, 0);
}
