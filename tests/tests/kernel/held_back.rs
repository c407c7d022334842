//! A tool that goes on while the tissue holds it back feels a steady force.
//!
//! Each tool on each body in one of three schemes and numbers of sweeps; in all three with `CHAINCELL_SLOW=1`.
#![allow(clippy::unwrap_used)]

use chaincell_host::engine::Scheme;
use chaincell_kernel::{Flags, ToolPose};
use chaincell_tests::bodies::Body;
use nalgebra::Vector3;

/// Way of the tool in a tick: 0.1 m/s \[m\].
const STEP_M: f64 = 1.0e-4;
/// Ticks from the first one that holds the tool back until the force is looked at.
const SETTLES: usize = 1000;
/// Ticks in which the tool goes on, and then as many in which it stands.
const LOOKS: usize = 500;
/// Ticks in which a hand feels a hum: from 4 Hz on.
const WINDOW: usize = 250;
/// Most that the force may rise and fall, as a share of its mean.
const RIPPLE: f64 = 0.01;

/// Peak to peak of these forces less their linear trend, as a share of their mean.
fn ripple(forces_n: &[f64]) -> f64 {
    let count = forces_n.len() as f64;
    let (mean, middle) = (forces_n.iter().sum::<f64>() / count, 0.5 * (count - 1.0));
    let apart = |at: usize| at as f64 - middle;
    let slope = forces_n.iter().enumerate().map(|(at, force)| apart(at) * force).sum::<f64>()
        / (0..forces_n.len()).map(|at| apart(at) * apart(at)).sum::<f64>();
    let rest = forces_n.iter().enumerate().map(|(at, force)| force - mean - slope * apart(at));
    let (least, most) =
        rest.fold((f64::MAX, f64::MIN), |(least, most), x| (least.min(x), most.max(x)));
    (most - least) / mean
}

/// Forces while the tool goes on held back, and then while it stands; `None` if the body never holds it back.
fn forces_n(body: &Body, tool: usize, by: (Scheme, u16)) -> Option<[Vec<f64>; 2]> {
    let (mut tick, touch_m) = (body.tissue_by(tool, by), body.touch_m(tool));
    let (mut way_m, mut held_ticks) = (0.0, 0);
    let mut force_n = |step_m: f64| {
        way_m += step_m;
        let at = (touch_m - Vector3::new(0.0, 0.0, way_m)).map(|x| x as f32);
        let output = tick(&ToolPose::at(at, 1));
        (f64::from(output.force_n.norm()), output.flags.contains(Flags::MOTION_CLAMPED), way_m)
    };
    // Press until the tissue has held it back for a while.
    while held_ticks < SETTLES {
        let (_, is_held, way_m) = force_n(STEP_M);
        held_ticks = if is_held { held_ticks + 1 } else { 0 };
        if !is_held && way_m > 2.0 * body.thickness_m {
            return None;
        }
    }
    Some([STEP_M, 0.0].map(|step_m| (0..LOOKS).map(|_| force_n(step_m).0).collect()))
}

// REQ-CON-12
#[test]
fn a_tool_that_goes_on_while_it_is_held_back_feels_no_hum() {
    let is_slow = std::env::var_os("CHAINCELL_SLOW").is_some();
    let mut held = 0;
    for (of, body) in Body::all().iter().enumerate() {
        for tool in 0..3 {
            let ways = [(Scheme::Predict, 2), (Scheme::Predict, 4), (Scheme::Track, 4)];
            let (from, stride) = if is_slow { (0, 1) } else { ((of + tool) % 3, 3) };
            for by in ways.into_iter().skip(from).step_by(stride) {
                let Some(forces_n) = forces_n(body, tool, by) else { continue };
                held += 1;
                for (forces_n, name) in forces_n.iter().zip(["goes on", "stands"]) {
                    let worst =
                        forces_n.windows(WINDOW).step_by(50).map(ripple).fold(0.0, f64::max);
                    let name = format!("{}, {:?}, {by:?}, {name}", body.name, body.tool(tool));
                    println!("HUM {name}: {:.2} %", 100.0 * worst);
                    assert!(worst <= RIPPLE, "{name}: {worst}");
                }
            }
        }
    }
    assert!(held > if is_slow { 20 } else { 6 }, "{held}");
}
