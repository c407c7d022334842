//! Server and controller as processes of their own: killed, restarted, refused.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::ffi::OsString;
use std::process::{Child, Command, Stdio};

use chaincell_host::error::Result;
use chaincell_host::session::ipc::services::{Domain, SceneServices};
use chaincell_host::session::ipc::tools::ToolPoses;
use chaincell_host::session::loops::control::control;
use chaincell_host::session::loops::record::Recorder;
use chaincell_host::session::loops::serve::{ServeOptions, Server, serve};
use chaincell_host::session::supervise::{CosimOptions, CosimReports, cosim};
use chaincell_host::terminal;
use chaincell_tests::turn;
use iceoryx2::prelude::{Config, NodeBuilder, Path, PortFactory, SemanticString, ipc};

use super::spring::*;

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
        drop(SceneServices::open(options.scene.as_deref(), &options.domain).unwrap());
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
    let (_, module) = module_path!().split_once("::").unwrap();
    let child = &format!("{module}::{child}");
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
        // The forces compared are the tissue's own.
        ramp_ms: 0,
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
    let _turn = turn();
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
    let _turn = turn();
    let (_root, mut options) = options();
    options.seconds = Some(2.0 * LIMIT.as_secs_f64());
    options.ticks = None;
    let server = start_child("child_serve", &options, 1_000_000);
    {
        let watcher = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
        wait_until("the server", || watcher.is_served());
        let listener = watcher.forces.subscriber_builder().create().unwrap();
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

/// Both sides as children of this test, so many ticks long.
fn both(options: &ServeOptions, ticks: u64) -> Result<CosimReports> {
    let options = CosimOptions {
        program: std::env::current_exe().unwrap(),
        serve_args: child_args("child_serve", options, ticks),
        control_args: child_args("child_control", options, ticks),
        motion_ms: ticks,
        ready_s: LIMIT.as_secs(),
    };
    cosim(&options, |_| {})
}

#[test]
fn cosim_collects_both_reports_and_leaves_no_child() {
    let _turn = turn();
    let (_root, options) = options();
    let reports = both(&options, 200).unwrap();
    assert_eq!(reports.control.ticks_answered, 200);
    assert_eq!(reports.serve.ticks_executed, 200);
    assert_eq!(reports.serve.state_hash, reports.control.state_hash);
    assert!(!reports.interrupted);
}

#[test]
fn child_cosim() {
    let Some((options, ticks)) = child_options() else { return };
    let reports = both(&options, ticks);
    panic!("a cosim that should have been killed has ended: {reports:?}");
}

#[test]
fn a_killed_cosim_leaves_no_process_behind() {
    let _turn = turn();
    let (_root, options) = options();
    let watcher = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
    let listener = watcher.forces.subscriber_builder().create().unwrap();
    let parent = start_child("child_cosim", &options, 1_000_000);
    wait_until("answers", || listener.receive().unwrap().is_some());
    parent.now();
    // Opening the scene clears up after processes that are dead, and only after those.
    wait_until("both children's end", || {
        let scene = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
        scene.tools.dynamic_config().number_of_publishers() == 0 && !scene.is_served()
    });
}

#[test]
fn cosim_says_which_side_failed() {
    let _turn = turn();
    let (_root, options) = options();
    let _other = Server::open(&options).unwrap();
    let error = both(&options, 200).unwrap_err();
    assert!(error.to_string().contains("chaincell serve ended"), "{error}");
}
