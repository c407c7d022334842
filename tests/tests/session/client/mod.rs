//! The client library against real servers: forces, faults, refusals, what viewers see.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod faults;
mod refusals;
mod session;
mod viewer;

use chaincell_client::{Answer, Client, Options, Outcome, Role, ToolPose};
use chaincell_tests::place::Place;

/// Longest wait for an answer \[ns\]: another process may have the core.
const WAIT_NS: u64 = 20_000_000_000;
/// Less than the press pushes back with \[N\].
const SOME_N: f64 = 0.004;
/// Ticks of a press.
const TICKS: u64 = 40;

/// On the place's scene, with no watchdog and no ramp: what is shown is what was answered.
fn options(place: &Place) -> Options {
    let scene = Some(place.scene.clone());
    Options { scene, watchdog_ms: 0, ramp_ms: 0, ..Options::default() }
}

fn viewer(place: &Place) -> Client {
    Client::open(&Options { role: Role::Viewer, ..options(place) }).unwrap()
}

/// Into the plane's middle, released in tick 0.
fn pose(tick: u64) -> ToolPose {
    ToolPose::at([0.0, 0.001, -0.0003 * tick.min(TICKS) as f32].into(), u32::from(tick > 0))
}

/// A tick that is answered.
#[track_caller]
fn answered(client: &mut Client, poses: &[ToolPose]) -> Answer {
    let (outcome, answer) = client.step(poses, WAIT_NS).unwrap();
    assert_eq!(outcome, Outcome::Answered);
    answer
}

fn press(client: &mut Client, ticks: std::ops::RangeInclusive<u64>) -> Vec<Answer> {
    ticks.map(|tick| answered(client, &[pose(tick)])).collect()
}

fn size_n(answer: &Answer) -> f64 {
    answer.tools[0].force_n.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt()
}
