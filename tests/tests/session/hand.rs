//! A modelled hand on a served tissue, in real time, under the loads that make answers late: what it
//! gets out of nothing.
//!
//! The handle (100 g, 30 um) moves under the newest force that has arrived, in a hand that presses,
//! holds and comes back. After a silence of 20 ms its force falls to 0 within 20 ms, and comes back
//! as slowly. Where this process itself is late it makes up for the ticks it missed, as a controller
//! does: their poses leave at once. `cargo test -p chaincell-tests --test session hand --
//! --nocapture | grep HAND` prints the table.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::time::{Duration, Instant};

use chaincell_kernel::ToolPose;
use chaincell_tests::closed_loop::{Choice, handle};
use chaincell_tests::files::{bake, scratch};
use chaincell_tests::handle::{Hand, Moving, TICK_S};
use chaincell_tests::outsider::{Force, LATE, Outsider, Pose, STALE};
use chaincell_tests::place::Place;
use chaincell_tests::{scene, turn};
use nalgebra::{Rotation3, Vector3};
use rustix::process::Signal;

/// Place of the Premium, 100 g, in the list of devices.
const PREMIUM: usize = 1;
/// Most energy that may be made in a cycle [J].
const MADE_MAX_J: f64 = 1e-3;
/// Ticks of a cycle of approach, press, hold and retreat: five seconds.
const CYCLE: u64 = 5000;

/// Ticks of silence that the handle bears, and ticks in which its force falls and comes back.
const RAMP: u32 = 20;
/// Tick of the first cycle in which a stop or a burst begins.
const DISTURBED: u64 = 2000;

/// What makes answers late.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Load {
    None,
    /// Sweeps that take long, as `--inject` has it.
    Sweeps(&'static str),
    /// So many poses held back and sent at once.
    Burst(u64),
    /// The server stands still for so many ticks.
    Stop(u64),
}

const LOADS: [Load; 9] = [
    Load::None,
    Load::Sweeps("sweep:0.3"),
    Load::Sweeps("sweep:0.8"),
    Load::Sweeps("sweep:1.5"),
    Load::Sweeps("sweep:3"),
    Load::Sweeps("sweep:3@2000"),
    Load::Burst(30),
    Load::Stop(200),
    Load::Stop(1500),
];

/// The force at the handle: the newest message, but for silences.
#[derive(Default)]
struct Grip {
    silent: u32,
    /// Ticks of the ramp that are done, of [`RAMP`].
    done: u32,
}

impl Grip {
    fn shown(&mut self, heard: bool, force_n: Vector3<f32>) -> Vector3<f32> {
        self.silent = if heard { 0 } else { self.silent + 1 };
        self.done = match self.silent > RAMP {
            true => self.done.saturating_sub(1),
            false => (self.done + 1).min(RAMP),
        };
        force_n * (self.done as f32 / RAMP as f32)
    }
}

/// Where the hand wants to be at a tick of its cycle, below the start [m]; it takes hold well before
/// it presses, so that the ramp of engaging is over.
fn depth_m(tick: u64) -> f64 {
    let at = tick as f64 / CYCLE as f64;
    let smooth = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    0.02 * (smooth((at - 0.1) / 0.15) - smooth((at - 0.7) / 0.15))
}

/// What a session of the hand gave.
struct Session {
    /// Most energy made in a cycle [J].
    made_j: f64,
    most_n: f64,
    late: usize,
    answers: usize,
}

/// Plays so many cycles against `serve` with these options.
fn session(load: Load, stiffness_n_per_m: f64, cycles: u64) -> Session {
    let folder = scratch();
    let stiff = ["--alpha", "0", "--stiffness-n-per-m", "1000"];
    let model = bake(folder.path(), "plane:9x9x0.01", &stiff);
    let place = Place { folder, model, scene: scene("hand") };
    let slow = match load {
        Load::Sweeps(sweeps) => vec!["--inject", sweeps],
        _ => vec![],
    };
    let serve = place.serve(&[&["--json", "--device", "premium"][..], &slow].concat());
    let outsider = Outsider::join(&place.scene, true);
    let mut moving = Moving::new(handle(PREMIUM, Rotation3::identity()), Vector3::zeros());
    let coupling = Choice::of(PREMIUM, 0).coupling_n_per_m();
    let mut last = Force::default();
    let mut of = Session { made_j: 0.0, most_n: 0.0, late: 0, answers: 0 };
    let (mut got_before_j, mut stored_before_j) = (0.0, 0.0);
    let (mut grip, mut held_back) = (Grip::default(), Vec::new());
    let start = Instant::now();
    for tick in 0..cycles * CYCLE {
        let due = start + Duration::from_secs_f64(TICK_S * tick as f64);
        while Instant::now() < due {
            std::thread::sleep(
                due.saturating_duration_since(Instant::now()).min(Duration::from_micros(200)),
            );
        }
        let mut heard = false;
        while let Some(force) = outsider.try_receive() {
            heard = true;
            of.answers += usize::from(force.flags & STALE == 0);
            of.late += usize::from(force.flags & LATE != 0);
            last = force;
        }
        let force_n = grip.shown(heard, Vector3::from(last.force_n));
        of.most_n = of.most_n.max(f64::from(force_n.norm()));
        let at = Vector3::new(0.0, 0.0, -depth_m(tick % CYCLE));
        let hand = Hand { stiffness_n_per_m, damping_n_s_per_m: 0.5, holds: true, at };
        moving.tick(force_n, &hand);
        let got_j = moving.port_j - moving.lost_j;
        of.made_j = of.made_j.max(got_j - got_before_j - stored_before_j);
        if tick % CYCLE == CYCLE - 1 {
            let coupling_j = 0.5 * f64::from(force_n.norm_squared()) / coupling;
            (got_before_j, stored_before_j) = (got_j, f64::from(last.energy_j) + coupling_j);
        }
        let ToolPose { position_m, engaged, .. } = moving.sample(tick % CYCLE >= 100);
        held_back.push(Pose { tick, position_m: position_m.into(), engaged });
        let since = tick.wrapping_sub(DISTURBED);
        match load {
            Load::Burst(poses) if since < poses => continue,
            Load::Stop(_) if since == 0 => serve.signal(Signal::STOP),
            Load::Stop(ticks) if since == ticks => serve.signal(Signal::CONT),
            _ => {}
        }
        held_back.drain(..).for_each(|pose| outsider.send(pose));
    }
    serve.interrupt().with(130);
    of
}

/// The first that is within the bound, or the last one.
fn least_enough(made_j: impl Iterator<Item = f64>) -> f64 {
    let mut last_j = f64::INFINITY;
    for made_j in made_j {
        last_j = made_j;
        if made_j <= MADE_MAX_J {
            break;
        }
    }
    last_j
}

// REQ-COS-10
#[test]
fn no_load_gives_a_hand_energy_out_of_nothing() {
    let _turn = turn();
    let is_long = std::env::var_os("CHAINCELL_SLOW").is_some();
    let cycles = if is_long { 2 } else { 1 };
    let hands: &[f64] = if is_long { &[50.0, 100.0, 300.0, 1000.0] } else { &[100.0] };
    let mut most_j: f64 = 0.0;
    for load in LOADS {
        for &hand in hands {
            // A machine that is busy with something else is given another try.
            let tries = std::iter::repeat_with(|| session(load, hand, cycles)).take(3);
            let made_j = tries.map(|of| {
                println!(
                    "HAND | {load:?} | {hand} N/m | made {:.2e} J | force up to {:.2} N | {} of {} \
                     late |",
                    of.made_j, of.most_n, of.late, of.answers
                );
                of.made_j
            });
            most_j = most_j.max(least_enough(made_j));
        }
    }
    assert!(most_j <= MADE_MAX_J, "{most_j} J");
}
