//! The output stage at its limits, in closed loop with a modelled handle against a lossless wall.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::stage::StageSettings;
use chaincell_loops::closed_loop::{DEVICES, Wall, handle};
use chaincell_loops::late::{Moment, Way, run_looking};
use nalgebra::{Rotation3, Vector3};

/// What came of a loop.
#[derive(Debug, Clone, Copy, Default)]
struct Seen {
    /// Most that the device gave to the handle \[J\].
    port_j: f64,
    /// What hand and handle got out of nothing in the end \[J\].
    got_j: f64,
    speed_m_per_s: f64,
}

/// Runs a device's handle against a wall for so long, `grip` being stiffness and damping of a hand that
/// wants to be at `wish_m` of the time.
fn run(
    device: usize,
    stiffness_n_per_m: f32,
    seconds: f64,
    grip: (f64, f64),
    wish_m: impl Fn(f64) -> f64,
) -> Seen {
    let mut wall = Wall::new(stiffness_n_per_m);
    let way = Way { tick_s: 1.0e-3, ages: [1; 2], lost: 0.0, measures: false };
    let held = (handle(device, Rotation3::identity()), grip);
    let mut seen = Seen::default();
    let mut look = |now: Moment| {
        seen.port_j = seen.port_j.max(now.port_j);
        seen.got_j = now.got_j;
        seen.speed_m_per_s = seen.speed_m_per_s.max(now.speed_m_per_s);
    };
    let settings = StageSettings::for_device(DEVICES[device].0);
    let wish = |t_s: f64| Vector3::new(0.0, 0.0, wish_m(t_s));
    run_looking(settings, (&held, &way), seconds, &mut |tool| wall.tick(tool), &wish, &mut look);
    seen
}

/// 20 mm deep in a wall a coupling has some 0.1 J to push a handle out with: nobody has paid for it.
// REQ-STG-02
#[test]
fn a_handle_that_engages_inside_is_not_thrown() {
    for (device, (profile, ..)) in DEVICES.iter().enumerate() {
        for grip in [(0.0, 0.0), (50.0, 0.5)] {
            let seen = run(device, 5000.0, 1.0, grip, |_| -0.02);
            let Seen { port_j, speed_m_per_s, .. } = seen;
            println!("inside {profile:?}, hand {grip:?}: {port_j:.1e} J, {speed_m_per_s:.2} m/s");
            assert!(port_j < 0.003 && speed_m_per_s < 0.2, "{profile:?}: {seen:?}");
        }
    }
}

/// Taps as hard as an arm can, in a stiff grip, for 15 s.
// REQ-STG-02
#[test]
fn hard_taps_get_nothing() {
    for (device, &(profile, ..)) in DEVICES.iter().enumerate() {
        for (reach_m, hz) in [(0.02, 4.0), (0.02, 2.0), (0.01, 4.0), (0.005, 4.0)] {
            let wish = |t_s: f64| reach_m * (std::f64::consts::TAU * hz * t_s).cos();
            let seen = run(device, 2.0e4, 15.0, (1000.0, 5.0), wish);
            let watts = seen.got_j / 15.0;
            println!("taps {profile:?}, {reach_m} m, {hz} Hz: {watts:.1e} W, {seen:?}");
            assert!(watts <= 0.0, "{profile:?}, {reach_m} m, {hz} Hz: {watts} W");
        }
    }
}
