//! The built-in press.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::engine::motion::{Press, TICKS_MIN};

fn press(ticks: u64) -> Press {
    Press::new([0.1, 0.0, 0.2], [0.0, 0.0, -2.0], 0.01, ticks).unwrap()
}

#[test]
fn the_tool_holds_from_the_touch_to_the_end_of_the_retreat() {
    for ticks in [TICKS_MIN, 1000, 10_000] {
        let poses = press(ticks).poses();
        assert_eq!(poses.len() as u64, ticks);
        let engaged: Vec<u32> = poses.iter().map(|pose| pose.engaged).collect();
        let first = engaged.iter().position(|held| *held == 1).unwrap();
        assert_eq!(poses[first].position_m, [0.1, 0.0, 0.2]);
        assert_eq!(*engaged.last().unwrap(), 0);
        let changes = engaged.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert_eq!(changes, 2);
        assert_eq!(poses.last().unwrap().position_m, [0.1, 0.0, 0.2]);
    }
}

#[test]
fn the_motion_is_smooth_and_reaches_its_depth() {
    let poses = press(10_000).poses();
    let deepest = poses.iter().map(|pose| 0.2 - pose.position_m[2]);
    let deepest = deepest.fold(0.0_f32, f32::max);
    assert!((0.01..0.0102).contains(&deepest), "{deepest}");
    for pair in poses.windows(2) {
        for axis in 0..3 {
            let step = (pair[1].position_m[axis] - pair[0].position_m[axis]).abs();
            assert!(step < 5e-5, "tick {}: {step} m", pair[1].tick);
        }
    }
}

#[test]
fn bad_presses_are_refused() {
    let touch = [0.0; 3];
    let along = [0.0, 0.0, 1.0];
    for bad in [
        Press::new(touch, [0.0; 3], 0.01, 1000),
        Press::new(touch, [f64::NAN, 0.0, 0.0], 0.01, 1000),
        Press::new(touch, along, 0.0, 1000),
        Press::new(touch, along, f64::NAN, 1000),
        Press::new(touch, along, 0.01, TICKS_MIN - 1),
    ] {
        assert_eq!(bad.unwrap_err().exit_code(), 2);
    }
}
