//! Server and controller over real shared memory, with a linear spring for a tissue.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::time::Instant;

use chaincell_host::engine::motion::Pose;
use chaincell_host::session::ipc::services::SceneServices;
use chaincell_host::session::ipc::state::StateReader;
use chaincell_host::session::ipc::tools::{TickForce, ToolPoses};
use chaincell_host::session::loops::control::control;
use chaincell_host::session::loops::floor;
use chaincell_host::session::loops::record::Recorder;
use chaincell_host::session::loops::serve::{Ending, ServeOptions, Server};
use chaincell_host::session::loops::wait::Wait;
use chaincell_tests::turn;
use iceoryx2::prelude::{Config, NodeBuilder, Path, PortFactory, SemanticString, ipc};

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
fn a_service_with_other_limits_is_refused_with_the_remedy() {
    let _turn = turn();
    let (_root, options) = options();
    drop(SceneServices::open(options.scene.as_deref(), &options.domain).unwrap());
    let mut config = Config::default();
    let root = options.domain.root.as_ref().unwrap();
    let root = Path::new(root.as_os_str().as_encoded_bytes()).unwrap();
    config.global.set_root_path(&root);
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>();
    let node = node.unwrap();
    let name = format!("chaincell/{}/tools", options.scene.as_ref().unwrap());
    let _small = node
        .service_builder(&name.as_str().try_into().unwrap())
        .publish_subscribe::<ToolPoses>()
        .create()
        .unwrap();
    let error = Server::open(&options).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("start chaincell serve first"), "{error}");
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
