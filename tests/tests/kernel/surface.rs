//! A sphere on the triangles of a surface: it never slips through, its force does not jump, and what
//! it costs the hand is what the body holds.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::ImageBytes;
use chaincell_host::engine::motion::Press;
use chaincell_host::engine::place::place;
use chaincell_host::engine::{Contact, Engine, Scheme};
use chaincell_kernel::{Flags, TickOutput, ToolPose};
use chaincell_tests::bodies::{model, nodal, under};

/// Height of the top of the bodies \[m\].
const TOP_M: f32 = 0.04;

/// A block of liver on a fixed ground, 40 mm high, with edges of about 8 mm.
fn block() -> ImageBytes {
    nodal("box:11x11x6x0.008", 5000.0)
}

fn engine(image: &ImageBytes, radius_m: f32, sweeps: u16) -> Engine<'_> {
    under(image, Contact::sphere(radius_m, 0.0), (Scheme::Track, sweeps), 0.01).unwrap()
}

/// The sphere `depth_m` below the top, aside by `x_m`.
fn at(x_m: f32, radius_m: f32, depth_m: f32) -> ToolPose {
    ToolPose::at([x_m, 0.3 * x_m, TOP_M + radius_m - depth_m].into(), 1)
}

/// Presses down to a depth within `ticks` ticks.
fn press(
    engine: &mut Engine<'_>,
    (x_m, radius_m, depth_m): (f32, f32, f32),
    ticks: u16,
) -> TickOutput {
    let mut last = None;
    for tick in 0..=ticks {
        let share = f32::from(tick) / f32::from(ticks);
        last = Some(engine.tick(&at(x_m, radius_m, share * depth_m)));
    }
    last.unwrap()
}

// REQ-CON-06
#[test]
fn a_sphere_smaller_than_an_edge_never_slips_through() {
    let image = block();
    for (radius_m, x_m) in [(0.003, 0.0), (0.003, 0.0037), (0.002, 0.002)] {
        let mut engine = engine(&image, radius_m, 4);
        let (mut most, mut clamped) = (0.0_f32, false);
        for tick in 0..300_u16 {
            // 0.3 m/s down to 20 mm, then still.
            let output = engine.tick(&at(x_m, radius_m, f32::from(tick.min(67)) * 0.0003));
            let force = output.force_n.norm();
            most = most.max(force);
            clamped |= output.flags.contains(Flags::MOTION_CLAMPED);
            if tick > 5 {
                assert!(force > 0.9 * most, "{radius_m} {x_m} tick {tick}: {force} of {most}");
            }
        }
        assert!(clamped && most > 0.005, "{radius_m} {x_m}: {most}");
    }
}

/// Far beyond what the contact can bear: the tool is left behind, the force stays.
#[test]
fn a_sphere_pressed_far_into_an_organ_never_gets_through() {
    let image = nodal("organ:1000", 5000.0);
    for sweeps in [1, 4] {
        let mut engine = engine(&image, 0.012, sweeps);
        let place = place(&model(&image), engine.contact(), None).unwrap();
        let press = Press::new(place.touch_m, place.direction, 0.09, 4000).unwrap();
        let (mut most, mut clamped) = (0.0_f32, false);
        for tick in 400..1600 {
            let output = engine.tick(&press.pose(tick).into());
            let force = output.force_n.norm();
            most = most.max(force);
            clamped |= output.flags.contains(Flags::MOTION_CLAMPED);
            if tick > 800 {
                assert!(force > 0.4 * most, "{sweeps} sweeps, tick {tick}: {force} of {most} N");
            }
        }
        assert!(clamped && most > 0.5, "{sweeps} sweeps: {most} N");
    }
}

// REQ-CON-07
#[test]
fn a_slow_press_and_release_costs_nothing() {
    let image = block();
    let radius_m = 0.006;
    let mut engine = engine(&image, radius_m, 16);
    let mut work = 0.0;
    for tick in -50..=400_i16 {
        work += f64::from(engine.tick(&at(0.001, radius_m, f32::from(tick) * 7.5e-6)).work_j);
    }
    let pressed = engine.tick(&at(0.001, radius_m, 0.003));
    let energy = f64::from(pressed.energy_j);
    assert!(pressed.force_n.z > 0.02 && pressed.contacts > 0, "{pressed:?}");
    assert!((work / energy - 1.0).abs() < 0.01, "{work} {energy}");
    let before = work;
    for tick in (-50..=400_i16).rev() {
        work += f64::from(engine.tick(&at(0.001, radius_m, f32::from(tick) * 7.5e-6)).work_j);
    }
    assert!(work.abs() < 0.002 * before, "{work} of {before}");
    let mut released = at(0.001, radius_m, 0.0);
    released.engaged = 0;
    let output = engine.tick(&released);
    assert!(
        output.force_n.norm() == 0.0 && f64::from(output.energy_j) < 1e-4 * energy,
        "{output:?}"
    );
}

#[test]
fn a_drag_and_back_leaves_nothing() {
    let image = block();
    let radius_m = 0.008;
    let mut engine = engine(&image, radius_m, 8);
    let shape = (0.0, radius_m, 0.003);
    press(&mut engine, shape, 200);
    let mut settle = |ticks: u16, x_m: f32| {
        (0..ticks).map(|_| engine.tick(&at(x_m, radius_m, 0.003))).last().unwrap().force_n
    };
    let before = settle(100, 0.0);
    for tick in (0..=400_u16).chain((0..400).rev()) {
        settle(1, f32::from(tick) * 2.0e-5);
    }
    let after = settle(100, 0.0);
    assert!((after - before).norm() < 0.005 * before.norm(), "{before} {after}");
}

// REQ-CON-06
#[test]
fn the_force_of_a_slide_does_not_jump() {
    let image = block();
    let radius_m = 0.012;
    let mut engine = engine(&image, radius_m, 8);
    let mut last = press(&mut engine, (-0.01, radius_m, 0.003), 300).force_n;
    let (first, mut most) = (last.norm(), 0.0_f32);
    for tick in 0..200_u16 {
        // 0.1 m/s.
        let force = engine.tick(&at(-0.01 + f32::from(tick) * 1.0e-4, radius_m, 0.003)).force_n;
        most = most.max((force - last).norm() / first);
        last = force;
    }
    assert!(most < 0.02, "{most}");
}

// REQ-CON-06, REQ-CON-11
#[test]
fn a_sphere_engaged_in_contact_starts_small_and_grows() {
    let image = block();
    let mut engine = engine(&image, 0.006, 8);
    let first = engine.tick(&at(0.0, 0.006, 0.0045)).force_n.norm();
    let later =
        (0..300).map(|_| engine.tick(&at(0.0, 0.006, 0.0045)).force_n.norm()).last().unwrap();
    assert!(first < 0.5 * later && later > 0.05, "{first} {later}");
}

// REQ-CON-05
#[test]
fn what_cannot_meet_a_surface_says_so() {
    let image = block();
    let of = |scheme, radius_m| {
        under(&image, Contact::sphere(radius_m, 0.0), (scheme, 4), 0.01).map(drop)
    };
    let small = of(Scheme::Track, 1.0e-4).unwrap_err().to_string();
    assert!(small.contains("must be at least 0.0003"), "{small}");
    assert!(of(Scheme::Track, 0.001).is_ok() && of(Scheme::Predict, 0.001).is_ok());
}
