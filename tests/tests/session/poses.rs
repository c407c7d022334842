//! Poses in every order and wait mode, how often states are sent, and the limits of a scene's services.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::time::Instant;

use chaincell_host::session::ipc::services::{Domain, SceneServices};
use chaincell_host::session::loops::floor;
use chaincell_host::session::loops::wait::Wait;
use chaincell_kernel::trace::{Reader, Record};
use chaincell_tests::files::{scratch, text};
use chaincell_tests::outsider::{Force, Outsider, Pose, Viewer};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, turn};
use iceoryx2::prelude::PortFactory;

/// A server that ends after a number of ticks, takes no silence for one, and makes all sweeps of each tick.
fn serve(place: &Place, ticks: &str, options: &[&str]) -> Running {
    let always = ["--watchdog-ms", "0", "--budget-us", "off", "--json", "--ticks", ticks];
    place.serve(&[&always, options].concat())
}

/// Sends poses with these ticks at once; the answers.
fn answers(outsider: &Outsider, sent: &[u64], count: usize) -> Vec<Force> {
    sent.iter().for_each(|&tick| outsider.send(Pose { tick, ..Pose::default() }));
    (0..count).map(|_| outsider.receive()).collect()
}

#[test]
fn every_pose_is_answered_in_every_wait_mode() {
    let _turn = turn();
    for wait in ["hybrid", "spin", "event"] {
        let place = Place::new("wait");
        let server = serve(&place, "300", &["--wait", wait]);
        let control = &mut place.control(&["--wait", wait, "--seconds", "0.3"]);
        let control = Running::start(control).end(SHORT).with(0).json();
        let served = server.end(SHORT).with(0).json();
        let counts = ["ticks_sent", "ticks_answered", "foreign_answers"];
        let counts = counts.map(|name| control[name].as_u64());
        assert_eq!(counts, [Some(300), Some(300), Some(0)], "{wait}");
        let counts = ["ticks_executed", "publishers", "sends_failed"];
        let counts = counts.map(|name| served[name].as_u64());
        assert_eq!(counts, [Some(300), Some(1), Some(0)], "{wait}");
        assert_eq!(served["state_hash"], control["state_hash"], "{wait}");
    }
}

#[test]
fn repeated_and_backward_ticks_are_counted_and_not_executed() {
    let _turn = turn();
    let place = Place::new("repeated");
    let server = serve(&place, "4", &["--hash-every", "3"]);
    let outsider = Outsider::join(&place.scene, true);
    let answers = answers(&outsider, &[7, 8, 8, 1, 0, 9, 20], 4);
    let found: Vec<(u64, bool)> =
        answers.iter().map(|answer| (answer.tick, answer.state_hash != 0)).collect();
    assert_eq!(found, [(7, false), (8, false), (9, true), (20, false)]);
    let served = server.end(SHORT).with(0).json();
    assert_eq!((&served["ticks_executed"], &served["poses_repeated"]), (&4.into(), &3.into()));
}

#[test]
fn a_bad_tick_is_counted_and_locks_nobody_out() {
    let _turn = turn();
    for (sent, executed) in [
        (&[5, u64::MAX, 6, u64::MAX, u64::MAX, 7][..], [5, 6, 7]),
        (&[u64::MAX, 0, 1, 2], [u64::MAX, 1, 2]),
        (&[5, 1 << 40, (1 << 40) + 1, (1 << 40) + 2], [5, (1 << 40) + 1, (1 << 40) + 2]),
    ] {
        let place = Place::new("bad-tick");
        let server = serve(&place, "3", &[]);
        let outsider = Outsider::join(&place.scene, true);
        let answers = answers(&outsider, sent, 3);
        assert!(answers.iter().map(|answer| answer.tick).eq(executed), "{answers:?}");
        let served = server.end(SHORT).with(0).json();
        let refused = sent.len() as u64 - 3;
        let counts = ["poses_refused", "poses_repeated"].map(|name| served[name].as_u64());
        assert_eq!(counts, [Some(refused), Some(0)], "{sent:?}");
    }
}

#[test]
fn a_bad_sample_is_recorded_bit_for_bit() {
    let _turn = turn();
    let place = Place::new("bad-bits");
    let trace = place.file("a.trace");
    let server = serve(&place, "1", &["--record", text(&trace)]);
    let position_m = [f32::NAN, 0.0, f32::INFINITY];
    let outsider = Outsider::join(&place.scene, true);
    outsider.send(Pose { tick: 3, position_m, engaged: 77 });
    assert_eq!(outsider.receive().tick, 3);
    server.end(SHORT).with(0);
    let bytes = std::fs::read(trace).unwrap();
    let mut kept = Vec::new();
    let read = Reader::open(&bytes).unwrap().records(|_, record: &Record| {
        let position_m: [f32; 3] = record.sample.position_m.into();
        kept.push((position_m.map(f32::to_bits), record.sample.engaged));
        Ok::<(), ()>(())
    });
    read.unwrap();
    assert_eq!(kept, [(position_m.map(f32::to_bits), 77)]);
}

#[test]
fn states_are_sent_no_more_often_than_asked() {
    let _turn = turn();
    let (place, begun) = (Place::new("states"), Instant::now());
    let server = serve(&place, "300", &["--state-hz", "20"]);
    let _viewer = Viewer::join(&place.scene);
    let control = &mut place.control(&["--seconds", "0.3"]);
    Running::start(control).end(SHORT).with(0);
    let served = server.end(SHORT).with(0).json();
    let most = begun.elapsed().as_secs_f64() * 20.0 + 1.0;
    let sent = served["states_sent"].as_u64().unwrap();
    assert!(sent >= 2 && sent as f64 <= most, "{sent} states, at most {most}");
}

#[test]
fn limits_are_those_of_the_contract() {
    let folder = scratch();
    let domain = Domain { prefix: None, root: Some(folder.path().to_owned()) };
    let scene = SceneServices::open(Some("limits"), &domain).unwrap();
    for limits in [scene.tools.static_config(), scene.forces.static_config()] {
        assert_eq!((limits.history_size(), limits.subscriber_max_buffer_size()), (0, 1024));
        assert!(limits.has_safe_overflow());
        assert_eq!((limits.max_publishers(), limits.max_subscribers()), (2, 8));
    }
}

#[test]
fn the_floor_is_measured_in_every_wait_mode() {
    let _turn = turn();
    let folder = scratch();
    let domain = Domain { prefix: None, root: Some(folder.path().to_owned()) };
    for wait in [Wait::Hybrid, Wait::Spin, Wait::Event] {
        let floor = floor::measure(wait, false, 50, &domain).unwrap();
        assert!(floor.run.round_trip_ns.p50 > 0);
        assert!(floor.run.round_trip_ns.max >= floor.run.round_trip_ns.p9999);
    }
}
