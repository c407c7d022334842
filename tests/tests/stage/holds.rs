//! Long holds behind the output stage: no chatter, no hum beyond two counts of the encoder.
//!
//! A hand presses by 10 mm, at once, within the stage's ramp, or later and slower, and holds still.
//! From ten seconds on the force stays within two counts of the coupling's spring and 0.03 N. What
//! hand and handle get out of a hum they cannot see is bounded as power. What they get on the way in
//! is at most what tissue and coupling store: the ramp lets go what was not paid for.
//!
//! 20 s a case; ten minutes with `CHAINCELL_SLOW=1`.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::ImageBytes;
use chaincell_loops::closed_loop::{Choice, DEVICES, GRIPS, Loop, TISSUES, column};
use nalgebra::Vector3;

/// First tick of a press, and the ticks that it takes.
const PRESSES: [(u32, u32); 3] = [(0, 30), (0, 60), (400, 600)];
/// Ticks after which all should be quiet.
const QUIET: u32 = 10_000;
/// Most that a hand gets out of a hum [W].
const HUM_W: f64 = 1.0e-5;
/// Most that it gets of a press within the ramp [J], and while a withheld force comes back [W].
const IN_RAMP_J: f64 = 3.0e-3;
const COMES_BACK_W: f64 = 3.0e-4;

#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    /// Least and largest force once all should be quiet [N].
    force_n: [f64; 2],
    /// Mean power that hand and handle got since [W].
    power_w: f64,
    /// Most that they got out of nothing before [J], and most that was stored [J].
    made_j: f64,
    stored_j: f64,
    /// Ticks since all should be quiet in which force is withheld, and the most that the force fell
    /// meanwhile below its largest [N].
    withheld: u32,
    fell_n: f64,
}

fn hold(image: &ImageBytes, choice: Choice, press: usize, ticks: u32) -> Seen {
    let (start, length) = PRESSES[press];
    let mut the = Loop::new(image, choice);
    let mut seen = Seen { force_n: [f64::INFINITY, 0.0], ..Seen::default() };
    let mut quiet_j = 0.0;
    for tick in 0..ticks {
        let share = f64::from(tick.saturating_sub(start).min(length)) / f64::from(length);
        the.tick(Vector3::new(0.0, 0.0, -0.01 * share), true);
        if tick < QUIET {
            seen.made_j = seen.made_j.max(the.got_j());
            seen.stored_j = seen.stored_j.max(the.stored_j);
            quiet_j = the.got_j();
        } else {
            let size = the.force_n.norm();
            seen.withheld += u32::from(the.is_withheld);
            seen.force_n = [seen.force_n[0].min(size), seen.force_n[1].max(size)];
            seen.fell_n = seen.fell_n.max(seen.force_n[1] - size);
        }
    }
    seen.power_w = (the.got_j() - quiet_j) / (f64::from(ticks - QUIET) * 1.0e-3);
    seen
}

/// Every device in both grips, pressed in every way.
fn cases() -> impl Iterator<Item = (Choice, usize)> {
    Choice::all().flat_map(|choice| (0..PRESSES.len()).map(move |press| (choice, press)))
}

fn print(name: &str, choice: &Choice, press: usize, tissue: f32, seen: &Seen) {
    let Seen { force_n: [least, largest], power_w, made_j, stored_j, withheld, fell_n } = seen;
    println!(
        "{name} {:?}, links {tissue} N/m, hand {} N/m, press {:?}: {least:.3} to {largest:.3} N, {power_w:.1e} W, made \
         {made_j:.1e} J, stored {stored_j:.1e} J, withheld in {withheld} ticks, fell by {fell_n:.3} N",
        DEVICES[choice.device].0, GRIPS[choice.grip].0, PRESSES[press],
    );
}

// REQ-STG-02
#[test]
fn a_hold_is_quiet() {
    let slow = std::env::var_os("CHAINCELL_SLOW").is_some();
    let ticks = if slow { 600_000 } else { 20_000 };
    if !slow {
        println!("SKIPPED ten minutes for each case: CHAINCELL_SLOW is not set");
    }
    for stiffness in TISSUES {
        let image = column(stiffness);
        for (choice, press) in cases() {
            let seen = hold(&image, choice, press, ticks);
            print("with", &choice, press, stiffness, &seen);
            let [least, largest] = seen.force_n;
            assert!(seen.made_j <= seen.stored_j, "{seen:?}");
            if seen.withheld > 0 {
                // A stiff hand within the ramp, that has paid for too little: the force comes back slowly.
                assert!(
                    PRESSES[press].0 == 0 && choice.grip == 1 && stiffness > 1000.0,
                    "{seen:?}"
                );
                assert!(seen.made_j <= IN_RAMP_J && seen.power_w <= COMES_BACK_W, "{seen:?}");
                // And does not come and go.
                assert!(seen.fell_n <= choice.swing_n() + 0.05, "{seen:?}");
                continue;
            }
            assert!(least > 0.1 && largest - least <= choice.swing_n(), "{seen:?}");
            assert!(seen.power_w <= HUM_W, "{seen:?}");
        }
    }
}
