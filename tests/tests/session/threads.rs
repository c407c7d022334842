//! Server and controller over real shared memory, with a linear spring for a tissue.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::time::{Duration, Instant};

use chaincell_host::engine::motion::Pose;
use chaincell_host::session::ipc::services::SceneServices;
use chaincell_host::session::ipc::state::StateReader;
use chaincell_host::session::ipc::tools::{TickForce, ToolForces, ToolPoses};
use chaincell_host::session::loops::control::{ControlOptions, control};
use chaincell_host::session::loops::floor;
use chaincell_host::session::loops::record::{Recorder, Row};
use chaincell_host::session::loops::serve::{Ending, ServeOptions, Server};
use chaincell_host::session::loops::wait::Wait;
use chaincell_kernel::Flags;
use chaincell_tests::turn;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{BackpressureStrategy, PortFactory, ipc_threadsafe};

use nalgebra::Vector3;

use super::spring::*;

#[test]
fn every_pose_is_answered_in_order_in_every_wait_mode() {
    let _turn = turn();
    for wait in [Wait::Hybrid, Wait::Spin, Wait::Event] {
        let (_root, mut options) = options();
        options.wait = wait;
        // What is published is the tissue's own force from the first message on.
        options.ramp_ms = 0;
        options.ticks = Some(300);
        let server = start_server(&options);
        let sent = poses(5..305);
        let run = control(&sent, &control_options(&options)).unwrap();
        let (report, recorder) = server.join().unwrap();
        assert_spring(&run, &sent);
        assert_eq!(run.report.ticks_sent, 300);
        assert_eq!(run.report.ticks_answered, 300);
        assert_eq!(run.report.foreign_answers, 0);
        assert_eq!(run.report.state_hash, report.state_hash);
        assert_eq!(report.ticks_executed, 300);
        assert_eq!(report.ended_by, Ending::Ticks);
        assert_eq!((report.publishers, report.sends_failed), (1, 0));
        let kept: Vec<Pose> = recorder.rows().iter().map(|row| row.pose).collect();
        assert_eq!(kept, sent);
        let answers: Vec<TickForce> = recorder.rows().iter().map(|row| row.force).collect();
        assert_eq!(answers, run.forces);
    }
}

#[test]
fn repeated_and_backward_ticks_are_counted_and_not_executed() {
    let _turn = turn();
    let (_root, mut options) = options();
    options.ticks = Some(4);
    options.hash_every = 3;
    let server = start_server(&options);
    let sender = Sender::new(&options);
    sender.send(&[7, 8, 8, 1, 0, 9, 20]);
    let answers = sender.answers(4);
    assert_eq!(ticks_of(&answers), [7, 8, 9, 20]);
    let hashed: Vec<bool> = answers.iter().map(|force| force.state_hash != 0).collect();
    assert_eq!(hashed, [false, false, true, false]);
    let (report, _) = server.join().unwrap();
    assert_eq!((report.ticks_executed, report.poses_repeated), (4, 3));
}

#[test]
fn a_bad_tick_is_counted_and_locks_nobody_out() {
    let _turn = turn();
    for (sent, executed) in [
        (&[5, u64::MAX, 6, u64::MAX, u64::MAX, 7][..], [5, 6, 7]),
        (&[u64::MAX, 0, 1, 2], [u64::MAX, 1, 2]),
        (&[5, 1 << 40, (1 << 40) + 1, (1 << 40) + 2], [5, (1 << 40) + 1, (1 << 40) + 2]),
    ] {
        let (_root, mut options) = options();
        options.ticks = Some(3);
        let server = start_server(&options);
        let sender = Sender::new(&options);
        sender.send(sent);
        assert_eq!(ticks_of(&sender.answers(3)), executed);
        let (report, _) = server.join().unwrap();
        let refused = sent.len() as u64 - 3;
        assert_eq!((report.poses_refused, report.poses_repeated), (refused, 0), "{sent:?}");
    }
}

#[test]
fn a_bad_sample_reaches_the_tissue_bit_for_bit() {
    let _turn = turn();
    let (_root, mut options) = options();
    options.ticks = Some(1);
    let server = start_server(&options);
    let sender = Sender::new(&options);
    let position_m = [f32::NAN, 0.0, f32::INFINITY];
    let bad = Pose { tick: 3, position_m, engaged: 77, sweeps: None };
    sender.ports.publisher.send_copy(message(bad)).unwrap();
    let (_, recorder) = server.join().unwrap();
    let kept = recorder.rows()[0].pose;
    let bits = |pose: Pose| (pose.position_m.map(f32::to_bits), pose.engaged);
    assert_eq!(bits(kept), bits(bad));
}

#[test]
fn without_a_ramp_the_watchdog_publishes_once_and_never_ticks() {
    let _turn = turn();
    let (_root, mut options) = options();
    options.ticks = Some(3);
    options.watchdog_ms = 100;
    options.ramp_ms = 0;
    let server = start_server(&options);
    let sender = Sender::new(&options);
    let silence = Duration::from_millis(u64::from(5 * options.watchdog_ms));
    std::thread::sleep(silence);
    sender.send(&[1, 2]);
    let answers = sender.answers(3);
    std::thread::sleep(silence);
    sender.send(&[3]);
    let late = sender.answers(1);
    let (report, _) = server.join().unwrap();
    assert_eq!(ticks_of(&answers), [1, 2, 2]);
    let (last, stale) = (answers[1], answers[2]);
    assert_eq!(stale.each[0].force_n, [0.0; 3]);
    assert_eq!(stale.flags, Flags::STALE.0 + Flags::SAFE_STATE.0);
    assert_eq!(stale.state_hash, last.state_hash);
    assert_eq!((ticks_of(&late), late[0].flags), (vec![3], 0));
    assert_eq!((report.watchdog_fired, report.ticks_executed), (1, 3));
}

#[test]
fn the_watchdog_lets_the_force_fall_and_rise_and_never_ticks() {
    let _turn = turn();
    let (_root, mut options) = options();
    options.ticks = Some(83);
    options.watchdog_ms = 100;
    options.ramp_ms = 40;
    let server = start_server(&options);
    let sender = Sender::new(&options);
    sender.send(&[400, 401, 402]);
    let last = sender.answers(3)[2];
    let mut falling = Vec::new();
    wait_until("force 0", || {
        while let Some(sample) = sender.ports.subscriber.receive().unwrap() {
            falling.push(*sample);
        }
        falling.last().is_some_and(|force: &ToolForces| force.each[0].force_n == [0.0; 3])
    });
    let size = |force: &ToolForces| Vector3::from(force.each[0].force_n).norm();
    let share_n = size(&last) / 40.0;
    assert!(falling.len() >= 40, "{}", falling.len());
    for (at, pair) in [&[last], &falling[..]].concat().windows(2).enumerate() {
        let step_n = size(&pair[0]) - size(&pair[1]);
        assert!(step_n > 0.0 && step_n <= 1.001 * share_n, "{at}: {step_n} N");
        let zero = if at + 1 == falling.len() { Flags::SAFE_STATE.0 } else { 0 };
        assert_eq!(pair[1].flags, Flags::STALE.0 + zero, "{at}");
        assert_eq!((pair[1].tick, pair[1].state_hash), (402, last.state_hash));
    }
    // A burst of poses makes no force by itself.
    let again: Vec<u64> = (403..483).collect();
    let mut before = ToolForces::default();
    for tick in &again {
        sender.send(&[*tick]);
        let answer = sender.answers(1)[0];
        let own_n = SPRING_N_PER_M * Vector3::from(pose(*tick).position_m).norm();
        assert!(size(&answer) <= own_n * 1.001);
        assert!(size(&answer) - size(&before) <= own_n / 40.0 + 0.3, "{tick}");
        assert_eq!((answer.tick, answer.flags), (*tick, 0));
        before = answer;
    }
    let (report, recorder) = server.join().unwrap();
    assert_eq!((report.watchdog_fired, report.ticks_executed), (1, 83));
    assert!(report.largest_force_step_n >= size(&last) / 2.0, "the first answer is no ramp");
    // What is kept is the tissue's own.
    for Row { pose, force, .. } in recorder.rows() {
        assert_eq!(Vector3::from(force.force_n), -SPRING_N_PER_M * Vector3::from(pose.position_m));
    }
}

#[test]
fn a_second_server_is_refused_until_the_first_has_ended() {
    let _turn = turn();
    let (_root, options) = options();
    let first = Server::open(&options).unwrap();
    let refusal = Server::open(&options).unwrap_err();
    assert_eq!(refusal.exit_code(), 2);
    let text = refusal.to_string();
    assert!(text.contains("running chaincell serve") && text.contains("`scene`"), "{text}");
    assert!(text.contains(&std::process::id().to_string()), "{text}");
    drop(first);
    Server::open(&options).unwrap();
}

#[test]
fn a_second_controller_is_refused_until_the_first_has_ended() {
    let _turn = turn();
    let (_root, options) = options();
    let _server = Server::open(&options).unwrap();
    let first = Sender::new(&options);
    let refusal = control(&poses(0..3), &control_options(&options)).unwrap_err();
    assert_eq!(refusal.exit_code(), 2);
    assert!(refusal.to_string().contains("running chaincell control"), "{refusal}");
    drop(first);
    let second = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
    second.control_ports(false).unwrap();
}

#[test]
fn a_missing_server_is_an_error_that_names_the_remedy() {
    let _turn = turn();
    let (_root, options) = options();
    let control_options = ControlOptions { wait_for_server_s: 0.05, ..control_options(&options) };
    let error = control(&poses(0..3), &control_options).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("start chaincell serve"), "{error}");
    let unordered = [pose(3), pose(3)];
    let error = control(&unordered, &control_options).unwrap_err();
    assert!(error.to_string().contains("tick 3 follows tick 3"), "{error}");
}

fn foreign_publisher(scene: &SceneServices) -> Publisher<ipc_threadsafe::Service, ToolPoses, ()> {
    scene
        .tools
        .publisher_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .unwrap()
}

#[test]
fn poses_of_a_second_live_publisher_are_not_executed() {
    let _turn = turn();
    let (_root, mut options) = options();
    options.ticks = Some(30);
    let server = start_server(&options);
    let sender = Sender::new(&options);
    sender.send(&[10, 11]);
    assert_eq!(ticks_of(&sender.answers(2)), [10, 11]);
    let scene = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
    let second = foreign_publisher(&scene);
    let third = sender.scene.tools.publisher_builder().create();
    assert!(third.is_err(), "two places only");
    for tick in 12..32 {
        second.send_copy(message(pose(1))).unwrap();
        sender.send(&[tick]);
        assert_eq!(ticks_of(&sender.answers(1)), [tick], "the second publisher was answered");
    }
    let listener = scene.forces.subscriber_builder().create().unwrap();
    drop(sender);
    // A new publisher starts a new sequence, below the old one's ticks.
    let mut tick = 1;
    wait_until("the second publisher's turn", || {
        tick += 1;
        second.send_copy(message(pose(tick))).unwrap();
        listener.receive().unwrap().is_some_and(|force| force.tick < 10)
    });
    wait_until("the server's end", || {
        tick += 1;
        second.send_copy(message(pose(tick))).unwrap();
        server.is_finished()
    });
    let (report, _) = server.join().unwrap();
    assert_eq!((report.ticks_executed, report.publishers), (30, 2));
    assert!(report.poses_refused >= 1, "{report:?}");
}

#[test]
fn states_are_sent_no_more_often_than_asked() {
    let _turn = turn();
    let (_root, options) = options();
    let hz = 20;
    let begun = Instant::now();
    let server = Server::open(&options).unwrap().with_state(3, hz).unwrap();
    let scene = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
    let reader = StateReader::open(&scene).unwrap();
    let served_options = ServeOptions { ticks: Some(300), ..options.clone() };
    drop(server);
    let server = std::thread::spawn(move || {
        let server = Server::open(&served_options).unwrap().with_state(3, hz).unwrap();
        server.run(&mut Spring::default(), &mut Recorder::default()).unwrap()
    });
    let run = control(&poses(0..300), &control_options(&options)).unwrap();
    let report = server.join().unwrap();
    assert_eq!(run.report.ticks_answered, 300);
    let most = begun.elapsed().as_secs_f64() * f64::from(hz) + 1.0;
    let sent = report.states_sent;
    assert!(sent >= 2 && sent as f64 <= most, "{sent} states, at most {most}");
    assert!(report.state_ns.max > 0);
    let details = reader.topic().static_config().message_type_details();
    assert_eq!(details.payload.type_name().to_string(), "chaincell.NodePosition.v1");
    assert_eq!(details.user_header.type_name().to_string(), "chaincell.State.v2");
    assert_eq!((details.payload.size(), details.user_header.size()), (16, 40));
}

#[test]
fn type_names_and_limits_are_those_of_the_contract() {
    let _turn = turn();
    let (_root, options) = options();
    let scene = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
    for (limits, name, bytes) in [
        (scene.tools.static_config(), "chaincell.ToolPoses.v2", 344),
        (scene.forces.static_config(), "chaincell.ToolForces.v2", 384),
    ] {
        let payload = limits.message_type_details().payload;
        assert_eq!(payload.type_name().to_string(), name);
        assert_eq!(payload.size(), bytes);
        assert_eq!(limits.history_size(), 0);
        assert_eq!(limits.subscriber_max_buffer_size(), 1024);
        assert!(limits.has_safe_overflow());
        assert_eq!((limits.max_publishers(), limits.max_subscribers()), (2, 8));
    }
}

#[test]
fn the_floor_is_measured_in_every_wait_mode() {
    let _turn = turn();
    for wait in [Wait::Hybrid, Wait::Spin, Wait::Event] {
        let (_root, options) = options();
        let floor = floor::measure(wait, false, 50, &options.domain).unwrap();
        assert!(floor.run.round_trip_ns.p50 > 0);
        assert!(floor.run.round_trip_ns.max >= floor.run.round_trip_ns.p9999);
    }
}
