//! Server and controller over real shared memory, with a linear spring for a tissue.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::ffi::OsString;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chaincell_host::cosim::control::{ControlOptions, ControlRun, control};
use chaincell_host::cosim::floor;
use chaincell_host::cosim::names::unique_scene;
use chaincell_host::cosim::orchestra::{CosimOptions, cosim};
use chaincell_host::cosim::payload::{ToolForce, ToolPose};
use chaincell_host::cosim::record::Recorder;
use chaincell_host::cosim::serve::{Ending, ServeOptions, ServeReport, Server, serve};
use chaincell_host::cosim::services::{Domain, Ports, Scene};
use chaincell_host::cosim::tissue::TissueEngine;
use chaincell_host::cosim::wait::Wait;
use chaincell_host::terminal;
use chaincell_kernel::sample::{Flags, TickOutput, ToolSample};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::{
    BackpressureStrategy, Config, NodeBuilder, Path, PortFactory, SemanticString, ipc,
};
use nalgebra::Vector3;

/// Longest wait for anything that must happen.
const LIMIT: Duration = Duration::from_secs(20);
/// Stiffness of the spring [N/m].
const SPRING_N_PER_M: f32 = 100.0;

/// A linear spring; its hash is made of all ticks so far.
#[derive(Default)]
struct Spring {
    hash: u64,
}

impl TissueEngine for Spring {
    fn tick(&mut self, sample: &ToolSample) -> TickOutput {
        let bits = sample.position_m.map(f32::to_bits);
        for word in [bits.x, bits.y, bits.z, sample.engaged] {
            self.hash = (self.hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3) + 1;
        }
        TickOutput {
            force_n: -SPRING_N_PER_M * sample.position_m,
            energy_j: 0.5,
            contacts: sample.engaged,
            flags: Flags::default(),
        }
    }

    fn state_hash(&mut self) -> u64 {
        self.hash
    }
}

/// A scene of its own, in folders of its own, so that tests never meet.
fn options() -> (tempfile::TempDir, ServeOptions) {
    let root = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        scene: Some(unique_scene("test")),
        domain: Domain { prefix: None, root: Some(root.path().to_owned()) },
        seconds: Some(LIMIT.as_secs_f64()),
        // A busy machine's pauses are no silence of the controller.
        watchdog_ms: 0,
        realtime: false,
        ..ServeOptions::default()
    };
    (root, options)
}

fn control_options(options: &ServeOptions) -> ControlOptions {
    ControlOptions {
        scene: options.scene.clone(),
        domain: options.domain.clone(),
        wait: options.wait,
        realtime: false,
        ends_with_parent: options.ends_with_parent,
        ..ControlOptions::default()
    }
}

fn start_server(options: &ServeOptions) -> JoinHandle<(ServeReport, Recorder)> {
    let options = options.clone();
    std::thread::spawn(move || {
        let mut recorder = Recorder::with_capacity(1000);
        let server = Server::open(&options).unwrap();
        let report = server.run(&mut Spring::default(), &mut recorder).unwrap();
        (report, recorder)
    })
}

fn pose(tick: u64) -> ToolPose {
    ToolPose { tick, position_m: [0.001 * tick as f32, 0.0, -0.002 * tick as f32], engaged: 1 }
}

fn poses(ticks: std::ops::Range<u64>) -> Vec<ToolPose> {
    ticks.map(pose).collect()
}

fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < LIMIT, "{what}: not within {LIMIT:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A controller of another make, which may send whatever it likes.
struct Sender {
    scene: Scene,
    ports: Ports<ToolForce, ToolPose>,
}

impl Sender {
    fn new(options: &ServeOptions) -> Self {
        let scene = Scene::open(options.scene.as_deref(), &options.domain).unwrap();
        let ports = scene.control_ports(false).unwrap();
        wait_until("a server", || scene.is_served());
        Self { scene, ports }
    }

    fn send(&self, ticks: &[u64]) {
        for tick in ticks {
            self.ports.publisher.send_copy(pose(*tick)).unwrap();
        }
    }

    fn answers(&self, count: usize) -> Vec<ToolForce> {
        let mut answers = Vec::new();
        wait_until("answers", || {
            while let Some(sample) = self.ports.subscriber.receive().unwrap() {
                answers.push(*sample);
            }
            answers.len() >= count
        });
        answers
    }
}

fn ticks_of(answers: &[ToolForce]) -> Vec<u64> {
    answers.iter().map(|force| force.tick).collect()
}

fn assert_spring(run: &ControlRun, sent: &[ToolPose]) {
    let ticks: Vec<u64> = sent.iter().map(|pose| pose.tick).collect();
    assert_eq!(ticks_of(&run.forces), ticks);
    for (force, pose) in run.forces.iter().zip(sent) {
        let wanted = -SPRING_N_PER_M * Vector3::from(pose.position_m);
        assert_eq!(Vector3::from(force.force_n), wanted);
        assert_eq!((force.contacts, force.flags, force.reserved), (1, 0, 0));
    }
}

#[test]
fn every_pose_is_answered_in_order_in_every_wait_mode() {
    for wait in [Wait::Hybrid, Wait::Spin, Wait::Event] {
        let (_root, mut options) = options();
        options.wait = wait;
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
        let kept: Vec<ToolPose> = recorder.rows().iter().map(|(pose, _)| *pose).collect();
        assert_eq!(kept, sent);
        let answers: Vec<ToolForce> = recorder.rows().iter().map(|(_, force)| *force).collect();
        assert_eq!(answers, run.forces);
    }
}

#[test]
fn repeated_and_backward_ticks_are_counted_and_not_executed() {
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
fn a_bad_sample_reaches_the_tissue_bit_for_bit() {
    let (_root, mut options) = options();
    options.ticks = Some(1);
    let server = start_server(&options);
    let sender = Sender::new(&options);
    let bad = ToolPose { tick: 3, position_m: [f32::NAN, 0.0, f32::INFINITY], engaged: 77 };
    sender.ports.publisher.send_copy(bad).unwrap();
    let (_, recorder) = server.join().unwrap();
    let kept = recorder.rows()[0].0;
    let bits = |pose: ToolPose| (pose.position_m.map(f32::to_bits), pose.engaged);
    assert_eq!(bits(kept), bits(bad));
}

#[test]
fn the_watchdog_publishes_once_and_never_ticks() {
    let (_root, mut options) = options();
    options.ticks = Some(3);
    options.watchdog_ms = 100;
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
    assert_eq!(stale.force_n, [0.0; 3]);
    assert_eq!(stale.flags, Flags::STALE.0 + Flags::SAFE_STATE.0);
    assert_eq!(stale.state_hash, last.state_hash);
    assert_eq!((ticks_of(&late), late[0].flags), (vec![3], 0));
    assert_eq!((report.watchdog_fired, report.ticks_executed), (1, 3));
}

#[test]
fn a_second_server_is_refused_until_the_first_has_ended() {
    let (_root, options) = options();
    let first = Server::open(&options).unwrap();
    let refusal = Server::open(&options).unwrap_err();
    assert_eq!(refusal.exit_code(), 2);
    let text = refusal.to_string();
    assert!(text.contains("running chaincell serve") && text.contains("--scene"), "{text}");
    assert!(text.contains(&std::process::id().to_string()), "{text}");
    drop(first);
    Server::open(&options).unwrap();
}

#[test]
fn a_second_controller_is_refused_until_the_first_has_ended() {
    let (_root, options) = options();
    let _server = Server::open(&options).unwrap();
    let first = Sender::new(&options);
    let refusal = control(&poses(0..3), &control_options(&options)).unwrap_err();
    assert_eq!(refusal.exit_code(), 2);
    assert!(refusal.to_string().contains("running chaincell control"), "{refusal}");
    drop(first);
    let second = Scene::open(options.scene.as_deref(), &options.domain).unwrap();
    second.control_ports(false).unwrap();
}

#[test]
fn a_missing_server_is_an_error_that_names_the_remedy() {
    let (_root, options) = options();
    let control_options = ControlOptions { wait_for_server_s: 0.05, ..control_options(&options) };
    let error = control(&poses(0..3), &control_options).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("start chaincell serve"), "{error}");
    let unordered = [pose(3), pose(3)];
    let error = control(&unordered, &control_options).unwrap_err();
    assert!(error.to_string().contains("tick 3 follows tick 3"), "{error}");
}

fn foreign_publisher(scene: &Scene) -> Publisher<ipc::Service, ToolPose, ()> {
    scene
        .pose
        .publisher_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .unwrap()
}

#[test]
fn poses_of_a_second_live_publisher_are_not_executed() {
    let (_root, mut options) = options();
    options.ticks = Some(30);
    let server = start_server(&options);
    let sender = Sender::new(&options);
    sender.send(&[10, 11]);
    assert_eq!(ticks_of(&sender.answers(2)), [10, 11]);
    let scene = Scene::open(options.scene.as_deref(), &options.domain).unwrap();
    let second = foreign_publisher(&scene);
    let third = sender.scene.pose.publisher_builder().create();
    assert!(third.is_err(), "two places only");
    for tick in 12..32 {
        second.send_copy(pose(1)).unwrap();
        sender.send(&[tick]);
        assert_eq!(ticks_of(&sender.answers(1)), [tick], "the second publisher was answered");
    }
    let listener = scene.force.subscriber_builder().create().unwrap();
    drop(sender);
    // A new publisher starts a new sequence, below the old one's ticks.
    let mut tick = 1;
    wait_until("the second publisher's turn", || {
        tick += 1;
        second.send_copy(pose(tick)).unwrap();
        listener.receive().unwrap().is_some_and(|force| force.tick < 10)
    });
    wait_until("the server's end", || {
        tick += 1;
        second.send_copy(pose(tick)).unwrap();
        server.is_finished()
    });
    let (report, _) = server.join().unwrap();
    assert_eq!((report.ticks_executed, report.publishers), (30, 2));
    assert!(report.poses_refused >= 1, "{report:?}");
}

#[test]
fn type_names_and_limits_are_those_of_the_contract() {
    let (_root, options) = options();
    let scene = Scene::open(options.scene.as_deref(), &options.domain).unwrap();
    for (limits, name, bytes) in [
        (scene.pose.static_config(), "chaincell.ToolPose.v1", 24),
        (scene.force.static_config(), "chaincell.ToolForce.v1", 48),
    ] {
        let payload = limits.message_type_details().payload;
        assert_eq!(payload.type_name().to_string(), name);
        assert_eq!(payload.size(), bytes);
        assert_eq!(limits.history_size(), 0);
        assert_eq!(limits.subscriber_max_buffer_size(), 1024);
        assert!(limits.has_safe_overflow());
    }
}

/// A child process, killed at the latest when the test ends.
struct Killed(Child);

impl Killed {
    fn now(mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// The next program to open the scene clears up; the test's folder goes with its last files.
    fn for_good(self, options: &ServeOptions) {
        self.now();
        drop(Scene::open(options.scene.as_deref(), &options.domain).unwrap());
    }
}

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Arguments that make this test executable play one side.
fn child_args(child: &str, options: &ServeOptions, ticks: u64) -> Vec<OsString> {
    let root = options.domain.root.as_ref().unwrap().display();
    let scene = options.scene.as_ref().unwrap();
    let play = format!("play={scene}={root}={ticks}");
    ["--exact", child, "--nocapture", "--test-threads=2", &play].map(OsString::from).to_vec()
}

fn start_child(child: &str, options: &ServeOptions, ticks: u64) -> Killed {
    let child = Command::new(std::env::current_exe().unwrap())
        .args(child_args(child, options, ticks))
        .stdout(Stdio::null())
        .spawn();
    Killed(child.unwrap())
}

/// What the arguments ask this process to play, if it is such a child.
fn child_options() -> Option<(ServeOptions, u64)> {
    let args: Vec<String> = std::env::args().collect();
    let mut parts = args.iter().find_map(|arg| arg.strip_prefix("play="))?.split('=');
    let (scene, root, ticks) = (parts.next()?, parts.next()?, parts.next()?);
    let ticks = ticks.parse().ok()?;
    let options = ServeOptions {
        scene: Some(scene.to_owned()),
        domain: Domain { prefix: None, root: Some(root.into()) },
        ticks: Some(ticks),
        seconds: Some(LIMIT.as_secs_f64()),
        realtime: false,
        ends_with_parent: true,
        ..ServeOptions::default()
    };
    Some((options, ticks))
}

#[test]
fn child_serve() {
    let Some((options, _)) = child_options() else { return };
    let report = serve(&mut Spring::default(), &options, &mut Recorder::default()).unwrap();
    terminal::say(serde_json::to_string(&report).unwrap()).unwrap();
    std::process::exit(0);
}

#[test]
fn child_control() {
    let Some((options, ticks)) = child_options() else { return };
    let run = control(&poses(0..ticks), &control_options(&options)).unwrap();
    terminal::say(serde_json::to_string(&run.report).unwrap()).unwrap();
    std::process::exit(0);
}

#[test]
fn a_killed_server_is_replaced_without_clearing_up_by_hand() {
    let (_root, options) = options();
    let sent = poses(0..50);
    for _ in 0..4 {
        let server = start_child("child_serve", &options, 1_000_000);
        let run = control(&sent, &control_options(&options)).unwrap();
        assert_spring(&run, &sent);
        server.now();
    }
    start_child("child_serve", &options, 1_000_000).for_good(&options);
}

#[test]
fn a_killed_controller_is_replaced_while_the_server_runs_on() {
    let (_root, mut options) = options();
    options.seconds = Some(2.0 * LIMIT.as_secs_f64());
    options.ticks = None;
    let server = start_child("child_serve", &options, 1_000_000);
    {
        let watcher = Scene::open(options.scene.as_deref(), &options.domain).unwrap();
        wait_until("the server", || watcher.is_served());
        let listener = watcher.force.subscriber_builder().create().unwrap();
        for _ in 0..4 {
            let controller = start_child("child_control", &options, 1_000_000);
            wait_until("answers", || listener.receive().unwrap().is_some());
            controller.now();
            while listener.receive().unwrap().is_some() {}
        }
    }
    let sent = poses(0..50);
    let run = control(&sent, &control_options(&options)).unwrap();
    assert_spring(&run, &sent);
    server.for_good(&options);
}

#[test]
fn a_service_with_other_limits_is_refused_with_the_remedy() {
    let (_root, options) = options();
    drop(Scene::open(options.scene.as_deref(), &options.domain).unwrap());
    let mut config = Config::default();
    let root = options.domain.root.as_ref().unwrap();
    let root = Path::new(root.as_os_str().as_encoded_bytes()).unwrap();
    config.global.set_root_path(&root);
    let node = NodeBuilder::new().config(&config).create::<ipc::Service>();
    let node = node.unwrap();
    let name = format!("chaincell/{}/pose", options.scene.as_ref().unwrap());
    let _small = node
        .service_builder(&name.as_str().try_into().unwrap())
        .publish_subscribe::<ToolPose>()
        .create()
        .unwrap();
    let error = Server::open(&options).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("start chaincell serve first"), "{error}");
}

#[test]
fn cosim_collects_both_reports_and_leaves_no_child() {
    let (_root, options) = options();
    let reports = cosim(&CosimOptions {
        serve_args: child_args("child_serve", &options, 200),
        control_args: child_args("child_control", &options, 200),
        motion_ms: 200,
        ready_s: LIMIT.as_secs(),
    })
    .unwrap();
    assert_eq!(reports.control.ticks_answered, 200);
    assert_eq!(reports.serve.ticks_executed, 200);
    assert_eq!(reports.serve.state_hash, reports.control.state_hash);
    assert!(!reports.interrupted);
}

#[test]
fn child_cosim() {
    let Some((options, ticks)) = child_options() else { return };
    let reports = cosim(&CosimOptions {
        serve_args: child_args("child_serve", &options, ticks),
        control_args: child_args("child_control", &options, ticks),
        motion_ms: ticks,
        ready_s: LIMIT.as_secs(),
    });
    panic!("a cosim that should have been killed has ended: {reports:?}");
}

#[test]
fn a_killed_cosim_leaves_no_process_behind() {
    let (_root, options) = options();
    let watcher = Scene::open(options.scene.as_deref(), &options.domain).unwrap();
    let listener = watcher.force.subscriber_builder().create().unwrap();
    let parent = start_child("child_cosim", &options, 1_000_000);
    wait_until("answers", || listener.receive().unwrap().is_some());
    parent.now();
    // Opening the scene clears up after processes that are dead, and only after those.
    wait_until("both children's end", || {
        let scene = Scene::open(options.scene.as_deref(), &options.domain).unwrap();
        scene.pose.dynamic_config().number_of_publishers() == 0 && !scene.is_served()
    });
}

#[test]
fn cosim_says_which_side_failed() {
    let (_root, options) = options();
    let _other = Server::open(&options).unwrap();
    let error = cosim(&CosimOptions {
        serve_args: child_args("child_serve", &options, 200),
        control_args: child_args("child_control", &options, 200),
        motion_ms: 200,
        ready_s: LIMIT.as_secs(),
    })
    .unwrap_err();
    assert!(error.to_string().contains("chaincell serve ended"), "{error}");
}

#[test]
fn the_floor_is_measured_in_every_wait_mode() {
    for wait in [Wait::Hybrid, Wait::Spin, Wait::Event] {
        let (_root, options) = options();
        let floor = floor::measure(wait, false, 50, &options.domain).unwrap();
        assert!(floor.floor_round_trip_ns.p50 > 0);
        assert!(floor.floor_round_trip_ns.max >= floor.floor_round_trip_ns.p9999);
    }
}
