//! What the tests of the co-simulation share: a spring for a tissue, scenes of their own.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::tissue::TissueEngine;
use chaincell_host::session::ipc::names::unique_scene;
use chaincell_host::session::ipc::services::{Domain, Ports, SceneServices};
use chaincell_host::session::ipc::tools::{ToolForces, ToolPoses};
use chaincell_host::session::loops::control::{ControlOptions, ControlRun};
use chaincell_host::session::loops::record::Recorder;
use chaincell_host::session::loops::serve::{ServeOptions, ServeReport, Server};
use chaincell_kernel::{Budget, TickOutput, ToolPose};
use chaincell_tests::outsider::{LATE, SAFE};
use nalgebra::Vector3;

/// Longest wait for anything that must happen.
pub const LIMIT: Duration = Duration::from_secs(60);
/// Stiffness of the spring [N/m].
pub const SPRING_N_PER_M: f32 = 100.0;

/// A linear spring; its hash is made of all ticks so far.
#[derive(Default)]
pub struct Spring {
    pub hash: u64,
}

impl TissueEngine for Spring {
    fn tick_by(&mut self, poses: &[ToolPose], _budget: Budget<'_>) -> TickOutput {
        let sample = poses.first().unwrap();
        let bits = sample.position_m.map(f32::to_bits);
        for word in [bits.x, bits.y, bits.z, sample.engaged] {
            self.hash = (self.hash ^ u64::from(word)).wrapping_mul(0x0000_0100_0000_01b3) + 1;
        }
        TickOutput {
            force_n: -SPRING_N_PER_M * sample.position_m,
            energy_j: 0.5,
            contacts: sample.engaged,
            ..TickOutput::NONE
        }
    }

    fn state_hash(&mut self) -> u64 {
        self.hash
    }
}

/// A scene of its own, in folders of its own, so that tests never meet.
pub fn options() -> (tempfile::TempDir, ServeOptions) {
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

pub fn control_options(options: &ServeOptions) -> ControlOptions {
    ControlOptions {
        scene: options.scene.clone(),
        domain: options.domain.clone(),
        wait: options.wait,
        realtime: false,
        ends_with_parent: options.ends_with_parent,
        ..ControlOptions::default()
    }
}

pub fn start_server(options: &ServeOptions) -> JoinHandle<(ServeReport, Recorder)> {
    let options = options.clone();
    std::thread::spawn(move || {
        let mut recorder = Recorder::with_capacity(1000);
        let server = Server::open(&options).unwrap();
        let report = server.run(&mut Spring::default(), &mut recorder).unwrap();
        (report, recorder)
    })
}

pub fn pose(tick: u64) -> Pose {
    let position_m = [0.001 * tick as f32, 0.0, -0.002 * tick as f32];
    Pose { tick, position_m, engaged: 0, sweeps: None }
}

/// A pose as a message.
pub fn message(pose: Pose) -> ToolPoses {
    ToolPoses::of(pose.tick, 0, &[pose.into()])
}

pub fn poses(ticks: std::ops::Range<u64>) -> Vec<Pose> {
    ticks.map(pose).collect()
}

pub fn wait_until(what: &str, mut done: impl FnMut() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < LIMIT, "{what}: not within {LIMIT:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A controller of another make, which may send whatever it likes.
pub struct Sender {
    // It holds the node of the ports.
    _scene: SceneServices,
    pub ports: Ports<ToolForces, ToolPoses>,
}

impl Sender {
    pub fn new(options: &ServeOptions) -> Self {
        let scene = SceneServices::open(options.scene.as_deref(), &options.domain).unwrap();
        let ports = scene.control_ports(false).unwrap();
        wait_until("a server", || scene.is_served());
        Self { _scene: scene, ports }
    }

    pub fn send(&self, ticks: &[u64]) {
        for tick in ticks {
            self.ports.publisher.send_copy(message(pose(*tick))).unwrap();
        }
    }

    pub fn answers(&self, count: usize) -> Vec<ToolForces> {
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

pub fn ticks_of(answers: &[ToolForces]) -> Vec<u64> {
    answers.iter().map(|force| force.tick).collect()
}

/// Every pose has its answer, which is the spring's force. Where the machine kept the server waiting
/// for so long that the force was an old one, it is 0 and says so.
#[track_caller]
pub fn assert_spring(run: &ControlRun, sent: &[Pose]) {
    let ticks: Vec<u64> = sent.iter().map(|pose| pose.tick).collect();
    assert!(run.forces.iter().map(|force| force.tick).eq(ticks));
    for (force, pose) in run.forces.iter().zip(sent) {
        let (wanted, flags) = match force.flags & LATE {
            0 => (-SPRING_N_PER_M * Vector3::from(pose.position_m), 0),
            _ => (Vector3::zeros(), LATE | SAFE),
        };
        assert_eq!((Vector3::from(force.force_n), force.flags), (wanted, flags), "{pose:?}");
        assert_eq!(force.contacts, 0);
    }
    let in_time = run.forces.iter().filter(|force| force.flags == 0).count();
    assert!(in_time > 0, "none of {} in time", sent.len());
    if 2 * in_time <= sent.len() {
        println!(
            "SKIPPED most forces: the machine kept the server waiting, {in_time} were in time"
        );
    }
}
