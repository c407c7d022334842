//! Missing samples and answers, and calls out of order.

use super::*;

/// The first answer is lost: the ramp starts with the first one that arrives.
// REQ-STG-06
#[test]
fn the_ramp_waits_for_the_first_answer() {
    let mut stage = Stage::new(StageSettings { ramp_ticks: 4, ..StageSettings::NONE }).unwrap();
    let sample = ToolPose::at(Vector3::new(0.0, 0.0, -0.001), 1);
    stage.sample(&sample);
    stage.missed();
    assert_eq!(tick(&mut stage, -0.001).force_n.z, 0.25);
}

/// A damper uses the duration of a motion, not the tick in which it became known.
// REQ-STG-10
#[test]
fn a_motion_over_lost_ticks_is_no_jump() {
    let coupling = Some(Coupling { stiffness_n_per_m: 1000.0, damping_n_s_per_m: 5.0 });
    let mut stage = Stage::new(StageSettings { coupling, ..StageSettings::NONE }).unwrap();
    let tick = |stage: &mut Stage, z: f32| {
        let tool = stage.sample(&ToolPose::at(Vector3::new(0.0, 0.0, z), 1));
        // A wall that holds the tool where it is.
        let force_n = -1.0e6 * tool.position_m;
        let answer = TickOutput { force_n, stiffness_n_per_m: 1.0e6, ..TickOutput::NONE };
        stage.output(&answer).force_n.z
    };
    for _ in 0..10 {
        tick(&mut stage, 0.0);
    }
    for _ in 0..19 {
        stage.missed();
    }
    // 2 mm in 20 ticks: 2 N of the spring, 0.5 N of the damper.
    let force = tick(&mut stage, -0.002);
    assert!((2.3..2.6).contains(&force), "{force}");
}

/// An answer without a sample does not reset the watchdog: the hand may have gone.
// REQ-STG-10
#[test]
fn answers_alone_do_not_keep_a_force_up() {
    let settings = StageSettings { ramp_ticks: 4, watchdog_ticks: 2, ..StageSettings::NONE };
    let mut stage = Stage::new(settings).unwrap();
    for _ in 0..10 {
        tick(&mut stage, -0.001);
    }
    let answer = TickOutput { force_n: Vector3::new(0.0, 0.0, 1.0), ..TickOutput::NONE };
    let forces: Vec<f32> = (0..8).map(|_| stage.output(&answer).force_n.z).collect();
    assert_eq!(forces, [1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0, 0.0]);
    let output = stage.output(&answer);
    assert!(output.flags.contains(Flags::BAD_SAMPLE) && output.flags.contains(Flags::SAFE_STATE));
    assert_eq!(tick(&mut stage, -0.001).force_n.z, 0.25);
}

// REQ-STG-10
#[test]
fn a_release_whose_answer_is_lost_lets_the_force_go() {
    let settings = StageSettings { max_slew_n_per_s: 400.0, ..StageSettings::NONE };
    let mut stage = Stage::new(settings).unwrap();
    for _ in 0..10 {
        tick(&mut stage, -0.001);
    }
    let _ = stage.sample(&ToolPose::at(Vector3::zeros(), 0));
    let forces = [stage.missed(), stage.missed(), stage.missed()].map(|output| output.force_n.z);
    assert!((forces[0] - 0.6).abs() < 1e-5 && (forces[1] - 0.2).abs() < 1e-5, "{forces:?}");
    assert_eq!(forces[2], 0.0);
}

/// Missed ticks are neither credit nor debt: after silences in which the hand went away and came back, the
/// same motion meets the same forces, less the damping for a hand without credit.
// REQ-STG-09
#[test]
fn ticks_that_are_missing_are_no_debt() {
    let profile = StageSettings::for_device(Device::Omega);
    let settings = StageSettings { coupling: None, ramp_ticks: 10, ..profile };
    let forces = |silence: u16, away: f32| {
        let (mut stage, mut wall) = (Stage::new(settings).unwrap(), Wall::new(1000.0));
        let mut go = |stage: &mut Stage, z: f32| {
            let tool = stage.sample(&at_height(z));
            stage.output(&wall.tick(&tool)).force_n.z
        };
        for at in 0..600_u16 {
            go(&mut stage, -1.0e-5 * f32::from(at));
        }
        for _ in 0..silence {
            stage.missed();
        }
        if silence > 0 {
            go(&mut stage, away - 0.006);
            for _ in 0..silence {
                stage.missed();
            }
        }
        for _ in 0..20 {
            go(&mut stage, -0.006);
        }
        // Out again at 0.1 m/s.
        (0..60_u16).map(|at| go(&mut stage, 1.0e-4 * f32::from(at) - 0.006)).collect::<Vec<f32>>()
    };
    let (whole, silent) = (forces(0, 0.0), forces(150, 0.05));
    for (at, (one, other)) in whole.iter().zip(&silent).enumerate() {
        assert!(
            (-0.01..0.5).contains(&(one - other)),
            "tick {at}: {one} N, after silences {other} N"
        );
    }
}

/// Energy that the coupling stored meanwhile is no debt either; the proxy stays where the last reported force
/// has left it.
// REQ-STG-09
#[test]
fn answers_that_are_lost_are_no_debt() {
    let forces = |lost: core::ops::Range<u16>, is_told: bool| {
        let profile = StageSettings::for_device(Device::Omega);
        let settings = StageSettings { max_force_n: f32::INFINITY, ..profile };
        let (mut stage, mut wall) = (Stage::new(settings).unwrap(), Wall::new(1000.0));
        let tick = |tick: u16| {
            let tool = stage.sample(&at_height(-1.0e-4 * f32::from(tick)));
            let answer = wall.tick(&tool);
            if !lost.contains(&tick) {
                stage.output(&answer).force_n.z
            } else if is_told {
                stage.missed().force_n.z
            } else {
                0.0
            }
        };
        (0..320).map(tick).collect::<Vec<f32>>()
    };
    let whole = forces(0..0, true);
    for is_told in [true, false] {
        let holed = forces(300..310, is_told);
        for (at, (one, other)) in whole.iter().zip(&holed).enumerate().skip(310) {
            assert!((one - other).abs() < 0.05 * one, "{at}: {one} N, {other} N, {is_told}");
        }
    }
}

/// An answer that comes a call late is shown, but not booked.
// REQ-STG-10
#[test]
fn answers_that_are_late_are_shown() {
    let forces = |is_late: bool| {
        let mut stage = Stage::new(StageSettings::for_device(Device::Omega)).unwrap();
        let mut wall = Wall::new(1000.0);
        let tick = |tick: u16| {
            let tool = stage.sample(&at_height(-2.0e-5 * f32::from(tick)));
            let answer = wall.tick(&tool);
            if is_late {
                stage.missed();
            }
            stage.output(&answer).force_n.z
        };
        (0..400).map(tick).collect::<Vec<f32>>()
    };
    for (at, (one, other)) in forces(false).iter().zip(forces(true)).enumerate().skip(150) {
        assert!((one - other).abs() < 0.02 * one, "{at}: {one} N, late {other} N");
    }
}
