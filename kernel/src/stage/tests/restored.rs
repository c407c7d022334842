//! A stage that takes over the snapshot of one with other settings keeps its own limits.

use super::*;
use std::vec;

fn saved(stage: &Stage) -> Vec<u8> {
    let mut bytes = vec![0; stage.snapshot_bytes()];
    stage.save(&mut bytes).unwrap();
    bytes
}

/// One tick with the tissue's force `force_n` \[N\].
fn pushed(stage: &mut Stage, force_n: f32) -> TickOutput {
    stage.sample(&ToolPose::at(Vector3::zeros(), 1));
    let force_n = Vector3::new(0.0, 0.0, force_n);
    stage.output(&TickOutput { force_n, stiffness_n_per_m: 1.0, ..TickOutput::NONE })
}

#[test]
fn a_larger_force_is_shortened_at_once() {
    let mut strong =
        Stage::new(StageSettings { max_force_n: 12.0, ..StageSettings::NONE }).unwrap();
    assert!((0..3).map(|_| pushed(&mut strong, 10.0).force_n.z).all(|force| force > 9.9));
    let weak = StageSettings { max_force_n: 3.0, max_slew_n_per_s: 100.0, ..StageSettings::NONE };
    let mut weak = Stage::new(weak).unwrap();
    weak.restore(&saved(&strong)).unwrap();
    assert!(weak.missed().force_n.z <= 3.0);
    assert!(pushed(&mut weak, 10.0).force_n.z <= 3.0);
}

#[test]
fn the_ramp_is_as_long_as_its_own() {
    let mut quick = Stage::new(StageSettings::NONE).unwrap();
    pushed(&mut quick, 1.0);
    let mut slow = Stage::new(StageSettings { ramp_ticks: 10, ..StageSettings::NONE }).unwrap();
    slow.restore(&saved(&quick)).unwrap();
    assert!(pushed(&mut slow, 1.0).force_n.z < 0.5);
}
