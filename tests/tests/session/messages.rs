//! Poses and answers as programs of others see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeSet;
use std::time::Duration;

use chaincell_tests::outsider::tools::{
    Forces, Poses, ToolForce, ToolPose, ToolsOutsider, UNKNOWN_N, one_tool,
};
use chaincell_tests::outsider::{RELEASE_FIRST, SAFE, STALE, size};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, turn};

/// Ticks of a press.
const TICKS: u64 = 40;

/// A server to which no silence counts as one, and whose forces are published as they are.
fn serve(place: &Place, options: &[&str]) -> Running {
    place.serve(&[&["--watchdog-ms", "0", "--ramp-ms", "0", "--json"], options].concat())
}

fn position_m(tick: u64) -> [f32; 3] {
    [0.0, 0.001, -0.0003 * tick.min(TICKS) as f32]
}

/// A press from the first tick on, its tool released in that one.
fn poses(tick: u64) -> Poses {
    one_tool(tick, position_m(tick), u32::from(tick > 0))
}

/// Press and release, with another tool in front that this release does not have.
#[test]
fn a_tool_that_was_not_chosen_changes_no_bit() {
    let _turn = turn();
    let place = Place::new("another-tool");
    let last = 2 * TICKS;
    let ticks = (last + 1).to_string();
    let options = ["--ticks", &ticks, "--budget-us", "off"];
    let mut alone: Vec<Forces> = Vec::new();
    let mut sessions = BTreeSet::new();
    for with_another in [false, true] {
        let server = serve(&place, &options);
        let outsider = ToolsOutsider::join(&place.scene);
        for tick in 0..=last {
            let mut sent = poses(tick);
            sent.each[0].engaged = u16::from(tick > 0 && tick < last);
            if with_another {
                sent.each.swap(0, 1);
                sent.each[0] = ToolPose { number: 3, ..ToolPose::default() };
                sent.tools = 2;
            }
            outsider.send(sent);
            let mut found = outsider.receive();
            sessions.insert(found.session_id);
            (found.session_id, found.step_ns) = (0, 0);
            if with_another {
                let none = ToolForce {
                    number: 3,
                    flags: SAFE,
                    force_error_n: UNKNOWN_N,
                    torque_error_n_m: UNKNOWN_N,
                    ..ToolForce::default()
                };
                assert_eq!((found.tools, found.each[0]), (2, none));
                found.each[0] = ToolForce::default();
                found.each.swap(0, 1);
                found.tools = 1;
                assert_eq!(found, alone[tick as usize]);
                continue;
            }
            let Forces { tick: of, force_tick, send_ns, sweeps, tools, reserved, .. } = found;
            assert_eq!((of, force_tick, send_ns, sweeps), (tick, tick, 1000 * tick, 4));
            assert_eq!((tools, reserved), (1, 0));
            let tool = ToolForce { torque_n_m: [0.0; 3], flags: found.flags, ..found.each[0] };
            assert_eq!((found.each[0], tool.number), (tool, 0));
            assert_eq!(found.each[1..], [ToolForce::default(); 7]);
            alone.push(found);
        }
        server.end(SHORT).with(0);
    }
    let force_n = |tick: usize| alone[tick].each[0].force_n;
    assert!(size(force_n(60)) > 0.0 && force_n(80) == [0.0; 3]);
    assert!(sessions.len() == 2 && !sessions.contains(&0), "{sessions:?}");
}

/// Takes turns on one scene; the ramp is half a second long, so that each of its steps is seen.
// REQ-COS-04, REQ-COS-11
#[test]
fn one_publisher_is_in_charge_and_the_next_one_feels_no_jump() {
    let _turn = turn();
    let place = Place::new("in-charge");
    let options = ["--watchdog-ms", "0", "--ramp-ms", "500", "--json", "--budget-us", "off"];
    let server = place.serve(&options);
    let [first, second] = [(); 2].map(|()| ToolsOutsider::join(&place.scene));
    let mut tick = 0;
    let held_n = loop {
        first.send(poses(tick));
        let forces = first.receive();
        assert_eq!(forces.tick, tick, "the second publisher was answered");
        tick += 1;
        std::thread::sleep(Duration::from_millis(1));
        if tick > 700 {
            break size(forces.each[0].force_n);
        }
        second.send(poses(1_000_000 + tick));
    };
    assert!(held_n > 0.001, "{held_n} N");
    drop(first);
    while second.try_receive().is_some() {}
    let mut shown = vec![held_n];
    for at in 0..900 {
        // Another publisher releases first; the force falls. Then it presses.
        let [x, y, z] = position_m(TICKS);
        let part = (at.clamp(200, 800) - 200) as f64 / 600.0;
        let pose_m = [x, y, part as f32 * z];
        second.send(one_tool(2_000_000 + at, pose_m, u32::from(at > 200)));
        let forces = second.receive();
        assert_eq!(forces.tick, 2_000_000 + at);
        shown.push(size(forces.each[0].force_n));
        std::thread::sleep(Duration::from_millis(1));
    }
    let steps = shown.windows(2).map(|pair| (pair[1] - pair[0]).abs() / held_n).enumerate();
    let most = steps.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!(most.1 < 0.03, "{most:?}");
    assert!(shown[200] < 0.8 * held_n && shown[900] > 0.9 * held_n, "{shown:?}");
    // The second is in charge, and a third is not listened to.
    let third = ToolsOutsider::join(&place.scene);
    (1..=20).for_each(|tick| third.send(poses(tick)));
    second.send(poses(2_000_900));
    assert_eq!(second.receive().tick, 2_000_900);
    drop(second);
    while third.try_receive().is_some() {}
    third.send(poses(30));
    let again = third.receive();
    let is_first = again.tick <= 30 && again.flags & RELEASE_FIRST != 0;
    assert!(is_first && size(again.each[0].force_n) > 0.9 * held_n, "no jump: {again:?}");
    let served = server.interrupt().with(130).json();
    assert_eq!(served["publishers"], 3);
    assert!(served["poses_refused"].as_u64().unwrap() >= 700, "{served}");
}

#[test]
fn the_force_falls_in_a_tick_that_does_not_end() {
    let _turn = turn();
    let place = Place::new("falling");
    let server = place.serve(&["--inject", "sweep:1000@40", "--json"]);
    let outsider = ToolsOutsider::join(&place.scene);
    let last = loop_of_answers(&outsider);
    outsider.send(poses(TICKS));
    let mut falling = vec![last];
    while falling.last().unwrap().flags & SAFE == 0 {
        let found = outsider.receive();
        let size_n = |forces: &Forces| size(forces.each[0].force_n);
        assert!(size_n(&found) < size_n(falling.last().unwrap()), "{found:?}");
        let zero = if size_n(&found) == 0.0 { SAFE } else { 0 };
        let mut wanted = Forces { flags: STALE + zero, step_ns: 0, sweeps: 0, ..last };
        wanted.each[0].force_n = found.each[0].force_n;
        wanted.each[0].flags = wanted.flags;
        assert_eq!(found, wanted);
        falling.push(found);
    }
    assert!(falling.len() > 10, "{} messages", falling.len());
    assert_eq!(outsider.receive().tick, TICKS);
    server.interrupt().with(130);
}

/// Presses as fast as answers come; the last answer that shows a force.
fn loop_of_answers(outsider: &ToolsOutsider) -> Forces {
    let mut last = Forces::default();
    for tick in 0..TICKS {
        outsider.send(poses(tick));
        last = loop {
            let found = outsider.receive();
            if found.tick == tick && found.flags & STALE == 0 {
                break found;
            }
        };
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(size(last.each[0].force_n) > 0.0);
    last
}
