//! Coupling and passivity control against a wall on given paths.

use super::*;

const DEVICES: [Device; 5] =
    [Device::Touch, Device::Premium, Device::Falcon, Device::Omega, Device::Sigma];

/// Forces of a stage on a given path against a wall of `stiffness` N/m at 0 with an exact ledger.
fn against_a_wall(settings: StageSettings, stiffness: f32, path: impl Fn(u16) -> f32) -> Vec<f32> {
    outputs(settings, stiffness, path).iter().map(|output| output.force_n.z).collect()
}

/// Like [`against_a_wall`], with the whole outputs.
fn outputs(settings: StageSettings, stiffness: f32, path: impl Fn(u16) -> f32) -> Vec<TickOutput> {
    let (mut stage, mut wall) = (Stage::new(settings).unwrap(), Wall::new(stiffness));
    let tick = |tick: u16| {
        let tool = stage.sample(&at_height(path(tick)));
        stage.output(&wall.tick(&tool))
    };
    (0..4000).map(tick).collect()
}

// REQ-STG-04
#[test]
fn a_press_beyond_the_clamp_keeps_its_force() {
    for device in DEVICES {
        let settings = StageSettings::for_device(device);
        // 0.1 m/s down to 60 mm, then held.
        let path = |tick: u16| 0.001 - 1.0e-4 * f32::from(tick.min(600));
        let forces = against_a_wall(settings, 2.0e4, path);
        assert!(forces[2000..].iter().all(|&f| f > 0.99 * settings.max_force_n), "{device:?}");
    }
}

// REQ-STG-04
#[test]
fn in_free_air_a_coupling_shows_nothing() {
    let settings = StageSettings { passivity: None, ..StageSettings::for_device(Device::Omega) };
    let path = |tick: u16| 0.1 + 1.0e-4 * f32::from(tick % 600);
    // The rounding of positions at 0.1 m, times the spring.
    assert!(against_a_wall(settings, 2.0e4, path).iter().all(|f| f.abs() < 1e-4));
}

/// After a press into a wall far stiffer than the coupling and a withdrawal, the coupling shows nothing.
// REQ-STG-04
#[test]
fn in_free_air_a_coupling_shows_nothing_after_a_touch_either() {
    for device in DEVICES {
        let settings = StageSettings { passivity: None, ..StageSettings::for_device(device) };
        let path = |tick: u16| match tick {
            0..1000 => 1.0e-3 - 1.0e-5 * f32::from(tick.min(300)),
            _ => 2.0e-4 * f32::from(tick % 500 + 10),
        };
        let forces = against_a_wall(settings, 2.0e4, path);
        assert!(forces[900] > 0.3, "{device:?}: no touch, {} N", forces[900]);
        assert!(forces[1015..].iter().all(|f| f.abs() < 1e-3), "{device:?}");
    }
}

/// The coupling of a delay that turns out to be short stiffens between two presses: in a press nobody would have paid
/// for it, and the force would be taken off on the way out.
// REQ-STG-11
#[test]
fn a_coupling_stiffens_out_of_contact_alone() {
    for device in DEVICES {
        let passivity = Passivity { device_damping_n_s_per_m: 0.5, delay_ticks: 16 };
        let settings =
            StageSettings { passivity: Some(passivity), ..StageSettings::for_device(device) };
        let (mut stage, mut wall) = (Stage::new(settings).unwrap(), Wall::new(60.0));
        let mut stiffest = Vec::new();
        for press in 0..2 {
            let (mut before_n, mut largest_n, mut step_n) = (0.0_f32, 0.0_f32, 0.0_f32);
            let mut couplings = Vec::new();
            for tick in 0..2400_u16 {
                // From 1 mm above the wall 11 mm down and up, with the ramp over before.
                let after = tick.saturating_sub(200);
                let way = f32::from(after.min(2000_u16.saturating_sub(after))) / 1000.0;
                stage.delayed(1);
                let tool = stage.sample(&at_height(0.001 - 0.011 * way));
                let output = stage.output(&wall.tick(&tool));
                let force_n = output.force_n.z;
                step_n = step_n.max((force_n - before_n).abs());
                largest_n = largest_n.max(force_n);
                before_n = force_n;
                if output.force_n.z > 0.0 && tool.position_m.z < 0.0 {
                    couplings.push(stage.coupling().unwrap().stiffness_n_per_m);
                }
            }
            assert!(largest_n > 0.1, "{device:?}: {largest_n} N");
            assert!(step_n < 0.04 * largest_n, "{device:?} {press}: {step_n} of {largest_n} N");
            assert!(couplings.iter().all(|k| *k == couplings[0]), "{device:?} {press}");
            stiffest.push(couplings[0]);
        }
        assert!(stiffest[1] > 3.0 * stiffest[0], "{device:?}: {stiffest:?}");
    }
}

/// The ledger's debt fades, so a withheld force returns to a hand at rest.
// REQ-STG-09
#[test]
fn a_force_that_was_let_go_comes_back_to_a_hand_at_rest() {
    let settings = StageSettings { coupling: None, ..StageSettings::for_device(Device::Omega) };
    // 0.3 m/s down to 5 mm, which generates more energy than the controller can compensate.
    let path = |tick: u16| 1.0e-3 - 3.0e-4 * f32::from(tick.min(20));
    let seen = outputs(settings, 1.0e4, path);
    let has_let_go = |output: &TickOutput| output.flags.contains(Flags::FORCE_WITHHELD);
    assert!(seen[..200].iter().any(|output| has_let_go(output) && output.force_n.z < 6.0));
    assert!(seen[1000..].iter().all(|output| output.force_n.z > 11.9), "{:?}", seen[3999]);
}

/// A tool that engages 6 mm inside and is drawn out has no credit: the ramp holds. If it stood there before
/// and is drawn out fast, the push is taken off. A withheld force is reported.
#[test]
fn a_push_that_nobody_has_paid_for_is_said_to_be_withheld() {
    let ways = [(0_u16, 2.0e-5, 290), (500, 1.0e-4, 56)];
    for (device, (stands, rate_m, ticks)) in
        DEVICES.into_iter().flat_map(|device| ways.map(|way| (device, way)))
    {
        let out = |tick: u16| f32::from(tick.saturating_sub(stands).min(600));
        let path = |tick: u16| (rate_m * out(tick) - 6.0e-3).min(2.0e-3);
        let seen = outputs(StageSettings::for_device(device), 33.0, path);
        let is_said = |output: &TickOutput| output.flags.contains(Flags::FORCE_WITHHELD);
        assert!(!seen[..stands.into()].iter().any(is_said), "{device:?}");
        let mut count = 0;
        for tick in stands + 10..stands + ticks {
            let output = &seen[usize::from(tick)];
            let is_whole = output.force_n.z >= -12.0 * path(tick);
            assert!(is_whole || is_said(output), "{device:?}, {tick}: {output:?}");
            count += u16::from(is_said(output));
        }
        assert!(count > ticks / 3, "{device:?}: said {count} times of {ticks}");
        assert!(!seen[3000..].iter().any(is_said), "{device:?}: outside");
    }
}

/// Without a ramp no force is lowered, and none is reported as withheld.
// REQ-STG-09
#[test]
fn without_a_ramp_no_force_is_let_go() {
    let settings = StageSettings {
        coupling: None,
        ramp_ticks: 0,
        max_force_n: f32::INFINITY,
        ..StageSettings::for_device(Device::Omega)
    };
    let path = |tick: u16| 1.0e-3 - 3.0e-4 * f32::from(tick.min(20));
    let seen = outputs(settings, 1.0e4, path);
    assert!(seen.iter().all(|output| !output.flags.contains(Flags::FORCE_WITHHELD)));
    assert!((seen[3999].force_n.z - 50.0).abs() < 0.1, "{}", seen[3999].force_n.z);
}

/// Energy that the tissue has dissipated for long gives no credit for a later push.
// REQ-STG-09
#[test]
fn what_was_lost_in_the_tissue_is_no_credit() {
    let settings = StageSettings { coupling: None, ..StageSettings::for_device(Device::Falcon) };
    // 2 N against the motion, or none, for 10 s back and forth; then 2 N along the motion.
    let pushed = |rubs: bool| {
        let mut stage = Stage::new(settings).unwrap();
        let mut z = 0.0;
        let mut tick = |step: f32, force: f32| {
            z += step;
            let position_m = Vector3::new(0.0, 0.0, z);
            let _ = stage.sample(&ToolPose::at(position_m, 1));
            let answer = TickOutput {
                force_n: Vector3::new(0.0, 0.0, force),
                work_j: -force * step,
                stiffness_n_per_m: 5000.0,
                ..TickOutput::NONE
            };
            stage.output(&answer).force_n.z
        };
        for at in 0..10_000 {
            let step = if at % 500 < 250 { -1.0e-4 } else { 1.0e-4 };
            tick(step, if rubs { -2.0 * step.signum() } else { 0.0 });
        }
        (0..200).map(|_| tick(1.0e-4, 2.0)).sum::<f32>() / 200.0
    };
    let (after_rubbing, without) = (pushed(true), pushed(false));
    assert!(without < 1.5, "{without} N");
    assert!((after_rubbing - without).abs() < 0.05, "{after_rubbing} N, {without} N");
}

/// A hand that is pushed out of a wall in which it began has put nothing in: the ramp holds.
// REQ-STG-09
#[test]
fn a_ramp_gives_no_push_that_was_not_paid_for() {
    for device in DEVICES {
        let settings = StageSettings::for_device(device);
        let path = |step: f32| move |tick: u16| -0.02 + step * f32::from(tick.min(200));
        // 50 mm/s outwards, and for comparison a hand at rest.
        let (leaves, rests) = (
            against_a_wall(settings, 5000.0, path(5.0e-5)),
            against_a_wall(settings, 5000.0, path(0.0)),
        );
        let (most, full) = (leaves[..200].iter().fold(0.0, |a: f32, &b| a.max(b)), rests[200]);
        assert!(full > 3.0 && most < 0.1 * full, "{device:?}: {most} N of {full} N");
    }
}

/// A motion of many counts per tick is no noise: a push without credit is taken off completely.
// REQ-STG-09
#[test]
fn a_fast_hand_is_pushed_by_what_it_has_put_in_alone() {
    let settings = StageSettings { coupling: None, ..StageSettings::for_device(Device::Falcon) };
    let mut stage = Stage::new(settings).unwrap();
    let tick = |tick: u16| {
        let force = if tick < 50 { 0.0 } else { 2.0 };
        // 1 m/s, once the ramp is up.
        let step = if tick < 150 { 0.0 } else { 1.0e-3 };
        let position_m = Vector3::new(0.0, 0.0, 1.0e-3 * f32::from(tick.saturating_sub(149)));
        let _ = stage.sample(&ToolPose::at(position_m, 1));
        let answer = TickOutput {
            force_n: Vector3::new(0.0, 0.0, force),
            work_j: -force * step,
            stiffness_n_per_m: 100.0,
            ..TickOutput::NONE
        };
        stage.output(&answer).force_n.z
    };
    let forces: Vec<f32> = (0..250).map(tick).collect();
    assert!(forces[149] == 2.0, "{} N", forces[149]);
    assert!(forces[160..].iter().all(|f| f.abs() < 0.4), "{:?}", &forces[150..]);
}
