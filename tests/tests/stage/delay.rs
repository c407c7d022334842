//! The output stage with forces that come late: in closed loop nothing is made, and what may be shown is.
//!
//! Ages of 0 to 6 ticks, constant and by turns, half of the poses lost, 500 Hz to 4 kHz, five devices,
//! hands of 50 and 1,000 N/m, lossless walls of 100 N/m to 10 kN/m; `bodies` has those that yield.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::stage::{StageSettings, passive_stiffness_n_per_m};
use chaincell_kernel::{TickOutput, ToolPose};
use chaincell_loops::closed_loop::{self, DEVICES, GRIPS, Wall, handle};
use chaincell_loops::late::{Held, Seen, Way, run};
use nalgebra::{Rotation3, Vector3};

type V = Vector3<f64>;

/// Most energy made in any five seconds [J].
const MADE_J: f64 = 1.0e-3;
/// Stiffness of the walls [N/m].
const WALLS: [f32; 4] = [100.0, 1000.0, 5000.0, 10_000.0];
/// Ages of forces [ticks], and share of poses that get lost.
const WAYS: [([usize; 2], f64); 9] = [
    ([0, 0], 0.0),
    ([1, 1], 0.0),
    ([2, 2], 0.0),
    ([3, 3], 0.0),
    ([4, 4], 0.0),
    ([6, 6], 0.0),
    ([1, 6], 0.0),
    ([0, 1], 0.5),
    ([1, 6], 0.5),
];

/// Times of a tick [s].
const TICKS_S: [f64; 3] = [1.0e-3, 2.0e-3, 2.5e-4];

pub(crate) fn held(device: usize, grip: usize) -> Held {
    (handle(device, Rotation3::identity()), GRIPS[grip])
}

/// The profile of a device at a rate; told the largest age, lost poses counting as two ticks more.
pub(crate) fn settings(device: usize, way: &Way) -> StageSettings {
    let mut settings = StageSettings::for_device(DEVICES[device].0);
    settings.tick_s = way.tick_s as f32;
    (settings.ramp_ticks, settings.watchdog_ticks) =
        ((0.1 / way.tick_s) as u16, (0.02 / way.tick_s) as u16);
    let told = if way.measures { 1 } else { way.ages[1] + if way.lost > 0.0 { 2 } else { 0 } };
    settings.passivity.as_mut().unwrap().delay_ticks = told as u8;
    settings
}

/// A wall as a tissue.
fn wall(stiffness_n_per_m: f32) -> impl FnMut(&ToolPose) -> TickOutput {
    let mut wall = Wall::new(stiffness_n_per_m);
    move |tool| wall.tick(tool)
}

/// A busy hand, 10 mm deep, from 2 mm above.
fn busy(t_s: f64) -> V {
    V::new(0.0, 0.0, 0.002) + closed_loop::busy(1000.0 * t_s) * 0.01
}

/// A press by 12 mm in 2.4 s, a hold, and back in a second; from 2 mm above.
fn slow(t_s: f64) -> V {
    let t = (t_s * 1000.0) % 5000.0;
    let ramp = |from: f64, ticks: f64| ((t - from) / ticks).clamp(0.0, 1.0);
    V::new(0.0, 0.0, 0.002 - 0.012 * (ramp(300.0, 2400.0) - ramp(3500.0, 1000.0)))
}

/// Every case against every wall, told and measured.
fn each(way: &Way, mut look: impl FnMut(String, StageSettings, f32, &Held)) {
    for (device, (profile, ..)) in DEVICES.iter().enumerate() {
        for (grip, (hand, _)) in GRIPS.iter().enumerate() {
            for stiffness in WALLS {
                let name = format!("{profile:?}, hand {hand} N/m, wall {stiffness} N/m, {way:?}");
                look(name, settings(device, way), stiffness, &held(device, grip));
            }
        }
    }
}

fn seconds() -> f64 {
    if std::env::var_os("CHAINCELL_SLOW").is_some() { 40.0 } else { 5.0 }
}

/// Every way of poses and forces, at every rate.
pub(crate) fn ways() -> impl Iterator<Item = Way> {
    WAYS.into_iter().flat_map(|(ages, lost)| {
        TICKS_S.into_iter().flat_map(move |tick_s| {
            [false, true].map(|measures| Way { tick_s, ages, lost, measures })
        })
    })
}

// REQ-STG-11
#[test]
fn no_delay_makes_energy() {
    for way in ways() {
        let (mut worst, mut of) = (Seen::default(), String::new());
        each(&way, |name, settings, stiffness, held| {
            let seen = run(settings, (held, &way), seconds(), &mut wall(stiffness), &busy);
            assert!(seen.made_j <= MADE_J, "{name}: {seen:?}");
            if seen.made_j >= worst.made_j {
                (worst, of) = (seen, name);
            }
        });
        println!("busy: {:.1e} J at most, {of}", worst.made_j);
    }
}

/// What the stage guards against: the same loops with an age that it does not know.
// REQ-STG-11
#[test]
fn a_delay_that_is_not_told_makes_energy() {
    for ticks in [2, 3, 6] {
        let way = Way { tick_s: 1.0e-3, ages: [ticks; 2], lost: 0.0, measures: false };
        let told = Way { ages: [1; 2], ..way };
        let mut most_j = 0.0_f64;
        each(&told, |_, settings, stiffness, held| {
            for wish in [busy, slow] {
                let seen = run(settings, (held, &way), 5.0, &mut wall(stiffness), &wish);
                most_j = most_j.max(seen.made_j);
            }
        });
        println!("{ticks} ticks, told one: {most_j:.1e} J");
        assert!(most_j > 2.0 * MADE_J, "{ticks} ticks: {most_j} J");
    }
}

/// Slow presses: at most a tick late the hand feels the tissue's force; later what is passive, at least
/// half of it.
// REQ-STG-11
#[test]
fn a_slow_press_is_felt_whatever_the_delay() {
    for way in ways() {
        let mut least = (f64::INFINITY, String::new());
        each(&way, |name, settings, stiffness, held| {
            let seen = run(settings, (held, &way), seconds(), &mut wall(stiffness), &slow);
            assert!(seen.made_j <= MADE_J, "{name}: {seen:?}");
            assert_eq!(seen.withheld, 0, "{name}: {seen:?}");
            let share = seen.shown_n / seen.tissue_n;
            assert!(share >= 0.95, "{name}: {share}, {seen:?}");
            if way.lost == 0.0 && way.ages[1] <= 1 {
                assert_eq!(seen.zeros, 0, "{name}: {seen:?}");
            }
            if share < least.0 {
                least = (share, name);
            }
        });
        println!("slow: {:.3} of the force at least, {}", least.0, least.1);
    }
}

/// Against a wall far stiffer than that a hand is shown at least half of what is passive.
// REQ-STG-11
#[test]
fn what_is_passive_is_shown() {
    for ticks in 2..=6 {
        let way = Way { tick_s: 1.0e-3, ages: [ticks; 2], lost: 0.0, measures: false };
        let passive = f64::from(passive_stiffness_n_per_m(0.5, ticks as f32, 1.0e-3));
        for device in 0..DEVICES.len() {
            // A stiff hand, 10 mm deep at the end.
            let press = |t_s: f64| V::new(0.0, 0.0, 0.002 - 0.012 * (t_s - 0.5).clamp(0.0, 1.0));
            let stiff = (held(device, 1).0, (1.0e5, 50.0));
            let settings = settings(device, &way);
            let seen = run(settings, (&stiff, &way), 3.0, &mut wall(1.0e4), &press);
            // Clamped forces tell nothing of a stiffness.
            let wanted_n = 0.5 * passive * 0.01;
            assert!(wanted_n < 0.9 * f64::from(settings.max_force_n));
            assert!(seen.last_n >= wanted_n, "{device}, {ticks}: {seen:?}, {passive} N/m");
        }
    }
}
