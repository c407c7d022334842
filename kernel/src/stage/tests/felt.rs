//! The ledger follows what the device felt: wrong poses, withheld forces, other limits.

use super::{Wall, at_height};
use crate::contact::pose::ToolPose;
use crate::number::cell::dot;
use crate::stage::{Device, Stage, StageSettings};
use crate::tick::sample::{Flags, TickOutput};
use std::vec::Vec;

/// A tick of a wall of 1 kN/m with the stage.
fn tick(stage: &mut Stage, wall: &mut Wall, sample: &ToolPose) -> TickOutput {
    let tool = stage.sample(sample);
    let answer = if tool.is_good() { wall.tick(&tool) } else { TickOutput::NONE };
    stage.output(&answer)
}

/// A stage after a press of 6 mm into a wall within 300 ticks.
fn pressed(device: Device) -> (Stage, Wall, TickOutput) {
    let mut stage = Stage::new(StageSettings::for_device(device)).unwrap();
    let (mut wall, mut last) = (Wall::new(1000.0), TickOutput::NONE);
    for at in 0..=300_u16 {
        let height = 5.0e-3 - 11.0e-3 * f32::from(at) / 300.0;
        last = tick(&mut stage, &mut wall, &at_height(height));
    }
    (stage, wall, last)
}

fn size(output: &TickOutput) -> f32 {
    dot(output.force_n.into(), output.force_n.into()).sqrt()
}

// REQ-STG-15
#[test]
fn wrong_poses_keep_the_force_and_never_raise_it() {
    for device in [Device::Touch, Device::Premium, Device::Omega] {
        for wrong_m in [300.0, 1.0, 0.05, -2.0, f32::MAX] {
            for count in 1..=15 {
                let (mut stage, mut wall, before) = pressed(device);
                for _ in 0..count {
                    let output = tick(&mut stage, &mut wall, &at_height(wrong_m));
                    assert!(output.flags.contains(Flags::BAD_SAMPLE));
                    assert_eq!(output.force_n, before.force_n, "{device:?} {wrong_m}");
                }
                for _ in 0..100 {
                    let output = tick(&mut stage, &mut wall, &at_height(-6.0e-3));
                    assert!(!output.flags.contains(Flags::BAD_SAMPLE), "{device:?} {wrong_m}");
                    assert!(size(&output) <= 1.2 * size(&before), "{device:?} {wrong_m}");
                    assert!(size(&output) >= 0.8 * size(&before), "{device:?} {wrong_m}");
                }
            }
        }
    }
}

/// The frame changes for good: the force goes to 0 and returns from there as after engaging.
#[test]
fn a_device_that_is_elsewhere_takes_hold_anew() {
    let (mut stage, mut wall, before) = pressed(Device::Premium);
    let (mut sizes, mut released) = (Vec::new(), 0);
    for _ in 0..200 {
        let tool = stage.sample(&at_height(-0.03));
        released += u32::from(tool.engaged == 0);
        let answer = if tool.is_good() { wall.tick(&tool) } else { TickOutput::NONE };
        sizes.push(size(&stage.output(&answer)));
    }
    assert_eq!(released, 1);
    let first = sizes.iter().position(|&n| n == 0.0).unwrap();
    assert!(sizes[..first].iter().all(|&n| n <= size(&before)));
    assert!(sizes[first..].windows(2).all(|two| two[1] - two[0] <= 0.5), "{sizes:?}");
}

/// 18 mm in four ticks of 1 ms: the path is unknown, and the ramp starts anew.
// REQ-STG-15
#[test]
fn lost_samples_give_the_hand_their_time() {
    let (mut stage, mut wall, before) = pressed(Device::Premium);
    stage.skipped(3);
    let output = tick(&mut stage, &mut wall, &at_height(-0.024));
    assert!(!output.flags.contains(Flags::BAD_SAMPLE) && size(&output) <= size(&before));
    assert!(stage.share() <= 0.01, "{}", stage.share());
    let output = tick(&mut stage, &mut wall, &at_height(-0.006));
    assert!(output.flags.contains(Flags::BAD_SAMPLE));
}

// REQ-STG-17
#[test]
fn no_force_is_above_the_tissues_own_limit() {
    let (mut stage, mut wall, before) = pressed(Device::Premium);
    assert!(size(&before) > 2.0);
    stage.limit_force(0.5);
    let sizes: Vec<f32> =
        (0..60).map(|_| size(&tick(&mut stage, &mut wall, &at_height(-6.0e-3)))).collect();
    assert!(sizes[10..].iter().all(|&n| n <= 0.5 && n > 0.4), "{sizes:?}");
    stage.limit_force(f32::INFINITY);
    let raised: Vec<f32> =
        (0..60).map(|_| size(&tick(&mut stage, &mut wall, &at_height(-6.0e-3)))).collect();
    assert!(raised.windows(2).all(|two| two[1] - two[0] <= 0.2201), "{raised:?}");
    assert!(raised[59] > 2.0, "{raised:?}");
}

/// After a force that the device did not feel the ramp starts at 0, and that force is not booked.
// REQ-STG-16
#[test]
fn what_was_not_felt_is_not_booked() {
    let (mut stage, mut wall, before) = pressed(Device::Premium);
    let mut booked = Vec::new();
    for at in 0..100_u16 {
        stage.restart_ramp();
        let height = -6.0e-3 - 2.0e-4 * f32::from(at);
        let output = tick(&mut stage, &mut wall, &at_height(height));
        assert!(size(&output) <= 0.02 * size(&before) * f32::from(at + 1));
        booked.push(stage.observer.hand_j());
    }
    let (least, most) = booked.iter().fold((f32::MAX, f32::MIN), |(a, b), &j| (a.min(j), b.max(j)));
    assert!(most - least < 1.0e-4, "{least} to {most} J");
}
