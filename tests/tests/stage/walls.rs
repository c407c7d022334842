//! The output stage at its limits, in closed loop with a modelled handle against a lossless wall.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::stage::{Stage, StageSettings};
use chaincell_tests::closed_loop::{DEVICES, Wall, handle};
use chaincell_tests::handle::{Hand, Moving};
use nalgebra::{Rotation3, Vector3};

/// What came of a loop.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// Most that the device gave to the handle [J].
    port_j: f64,
    /// What hand and handle got out of nothing in the end [J].
    got_j: f64,
    speed_m_per_s: f64,
}

/// Runs a device's handle from `from_m` above the wall for `ticks`, `grip` being stiffness and damping
/// of a hand that wants to be at `wish_m` of the tick; without a grip the handle is free.
fn run(
    device: usize,
    stiffness_n_per_m: f32,
    (from_m, ticks): (f64, u32),
    grip: Option<(f64, f64)>,
    wish_m: impl Fn(u32) -> f64,
) -> Seen {
    let mut stage = Stage::new(StageSettings::for_device(DEVICES[device].0)).unwrap();
    let mut wall = Wall::new(stiffness_n_per_m);
    let handle = handle(device, Rotation3::identity());
    let mut moving = Moving::new(handle, Vector3::new(0.0, 0.0, from_m));
    let (mut port_j, mut speed_m_per_s) = (0.0_f64, 0.0_f64);
    for tick in 0..ticks {
        let tool = stage.sample(&moving.sample(true));
        let output = stage.output(&wall.tick(&tool));
        let (stiffness_n_per_m, damping_n_s_per_m) = grip.unwrap_or_default();
        let at = Vector3::new(0.0, 0.0, wish_m(tick));
        let holds = grip.is_some();
        let hand = Hand { stiffness_n_per_m, damping_n_s_per_m, holds, at };
        moving.tick(output.force_n, &hand);
        port_j = port_j.max(moving.port_j);
        speed_m_per_s = speed_m_per_s.max(moving.velocity.norm());
    }
    Seen { port_j, got_j: moving.got_j(), speed_m_per_s }
}

/// 20 mm deep in a wall a coupling has some 0.1 J to push a handle out with: nobody has paid for it.
// REQ-STG-02
#[test]
fn a_handle_that_engages_inside_is_not_thrown() {
    for (device, (profile, ..)) in DEVICES.iter().enumerate() {
        for grip in [None, Some((50.0, 0.5))] {
            let seen = run(device, 5000.0, (-0.02, 1000), grip, |_| -0.02);
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
            let wish =
                |tick: u32| reach_m * (std::f64::consts::TAU * hz * f64::from(tick) * 1.0e-3).cos();
            let seen = run(device, 2.0e4, (reach_m, 15_000), Some((1000.0, 5.0)), wish);
            let watts = seen.got_j / 15.0;
            println!("taps {profile:?}, {reach_m} m, {hz} Hz: {watts:.1e} W, {seen:?}");
            assert!(watts <= 0.0, "{profile:?}, {reach_m} m, {hz} Hz: {watts} W");
        }
    }
}
