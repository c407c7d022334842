//! The output stage with a probe that touches, drags, leaves and taps: no energy is made.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::stage::StageSettings;
use chaincell_tests::closed_loop::{Choice, DEVICES, GRIPS, Loop};
use nalgebra::Vector3;

/// Ticks of a run.
const TICKS: u32 = 12_000;
/// Ticks of the hold that is looked at.
const HOLD: std::ops::Range<u32> = 3_500..5_000;
/// Radius of the probe, and its way above the body at the beginning [m].
const RADIUS_M: f32 = 0.008;
const ABOVE_M: f64 = 0.004;

/// A slab of 324 cells, 15 mm thick, links of 5 mm and 1000 N/m, its lower side fixed.
fn slab() -> ImageBytes {
    let mesh = load("box:9x9x4x0.005", &MeshOptions::default()).unwrap();
    let options = BakeOptions {
        stiffness_n_per_m: PerCell::Uniform(1000.0),
        coarse_basis: BasisSpacing::None,
        ..BakeOptions::default()
    };
    let lower: Vec<u32> = (0..81).map(|column| 4 * column).collect();
    bake(&mesh, &lower, &options).unwrap()
}

/// A press of 5 mm into the body, a hold, away, a press and a drag along it, away, taps [m].
fn wish(tick: u32) -> Vector3<f64> {
    let t = f64::from(tick);
    let ramp = |from: f64, ticks: f64| ((t - from) / ticks).clamp(0.0, 1.0);
    let press =
        ramp(200.0, 400.0) - ramp(5_000.0, 300.0) + ramp(6_000.0, 200.0) - ramp(8_500.0, 100.0);
    let tap = if tick > 9_000 { ((t - 9_000.0) * 0.03).sin().max(0.0) } else { 0.0 };
    let drag = ramp(6_500.0, 800.0) - ramp(7_300.0, 800.0);
    Vector3::new(0.006 * drag, 0.0, -0.009 * press - 0.006 * tap)
}

/// Most that hand and handle got out of nothing [J], and least and largest force of the hold [N].
fn run(image: &ImageBytes, choice: Choice) -> (f64, [f64; 2]) {
    let start = Vector3::new(0.0, 0.0, 0.015 + f64::from(RADIUS_M) + ABOVE_M);
    let mut the = Loop::with_probe(image, choice, RADIUS_M, start);
    let (mut made_j, mut force_n) = (0.0_f64, [f64::INFINITY, 0.0]);
    for tick in 0..TICKS {
        the.tick(wish(tick), true);
        made_j = made_j.max(the.got_j());
        if HOLD.contains(&tick) {
            let size = the.force_n.norm();
            force_n = [force_n[0].min(size), force_n[1].max(size)];
        }
    }
    let Choice { device, grip, .. } = choice;
    println!(
        "{:?}, hand {} N/m: {made_j:.1e} J, {force_n:.2?} N",
        DEVICES[device].0, GRIPS[grip].0
    );
    (made_j, force_n)
}

// REQ-STG-02
#[test]
fn a_probe_makes_no_energy() {
    let image = slab();
    for choice in Choice::all() {
        let (made_j, [least, largest]) = run(&image, choice);
        assert!(made_j <= 1.0e-6, "{made_j} J");
        assert!(least > 0.1 && largest - least <= choice.swing_n(), "{least} to {largest} N");
    }
}

// REQ-STG-03
#[test]
fn without_the_stage_a_probe_comes_off() {
    let image = slab();
    for choice in Choice::all().filter(|choice| choice.grip == 0) {
        let choice = Choice { settings: StageSettings::NONE, ..choice };
        let (_, [least, largest]) = run(&image, choice);
        assert!(least < 0.01 && largest > 0.4, "{least} to {largest} N");
    }
}
