//! Whatever is sent to a server of two tools behind stages, its session is played again to the same bits.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::time::Duration;

use chaincell_tests::files::text;
use chaincell_tests::outsider::tools::{Poses, ToolPose, ToolsOutsider};
use chaincell_tests::outsider::{Commander, Order};
use chaincell_tests::place::Place;
use chaincell_tests::{Running, run, turn};
use rustix::process::Signal;

/// Messages of a session.
const TICKS: u64 = 700;
/// Each of the two tools.
const TOOL: &str = "--tool=sphere:0.008";
/// Heights of the tools: at the body's top a sphere's centre is here \[m\].
const TOUCH_M: f32 = 0.048;

/// Numbers without a pattern (SplitMix64).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// True once in N times.
    fn once_in(&mut self, times: u64) -> bool {
        self.next().is_multiple_of(times)
    }

    /// From -1 to 1.
    fn share(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.next() as usize % all.len()]
    }
}

/// A number of a pose where it is wrong.
const WRONG: [f32; 7] = [2.0e3, -999.0, 1.0e30, f32::NAN, f32::INFINITY, f32::MAX, 1.0e-40];

fn pose(chance: &mut Chance, tick: u64, number: u32) -> ToolPose {
    let side = if number == 0 { -0.015 } else { 0.015 };
    let depth_m = 0.006 * (tick as f32 / 100.0).sin().abs() + 0.0005 * chance.share();
    let mut position_m = [side, 0.002, TOUCH_M - depth_m];
    if chance.once_in(40) {
        position_m[chance.next() as usize % 3] = chance.one_of(&WRONG);
    }
    let engaged = if chance.once_in(60) { chance.one_of(&[0, 2, u16::MAX]) } else { 1 };
    // Ignored by these tools, but a bad one makes the sample a bad one.
    let opening_turns_q16 = if tick % 170 == 9 { 40_000 } else { u16::from(tick % 70 == 5) };
    let orientation = if chance.once_in(80) {
        [0.0, 0.0, 0.0, chance.one_of(&WRONG)]
    } else {
        [0.0, 0.0, 0.0, 1.0]
    };
    let reserved = u32::from(chance.once_in(200));
    let engaged = engaged * u16::from(tick > 3);
    ToolPose { number, engaged, opening_turns_q16, position_m, orientation, reserved }
}

fn message(chance: &mut Chance, tick: u64) -> Poses {
    let mut poses = Poses { tick, send_ns: chance.next() >> 20, tools: 2, ..Poses::default() };
    (poses.each[0], poses.each[1]) = (pose(chance, tick, 0), pose(chance, tick, 1));
    if chance.once_in(50) {
        poses.tools = chance.one_of(&[0, 1, 3, 9, u32::MAX]);
    }
    if chance.once_in(50) {
        poses.each[1].number = chance.one_of(&[0, 2, 7, u32::MAX]);
    }
    poses
}

fn order(chance: &mut Chance) -> Order {
    let (kind, parameter, value) = chance.one_of(&[
        (1, 0, 0.0),
        (2, 0, 0.0),
        (3, 0, 0.0),
        (3, 0, 0.0),
        (4, 1, 2.0),
        (4, 2, 1.5),
        (5, 1, 0.0),
        (6, 1, 4.0e-45),
        (9, 0, f32::NAN),
        (9, 0, 20.0),
        (10, 0, f32::INFINITY),
    ]);
    let order = Order { kind, parameter, value, ..Order::default() };
    if kind != 10 {
        return order;
    }
    // On the top of the body, or beside it.
    let [x, y] = [0.03 * chance.share(), 0.03 * chance.share()];
    let z = if chance.once_in(4) { chance.one_of(&WRONG) } else { 0.04 };
    Order { point_m: [x, y, z], radius_m: 0.006 + 0.003 * chance.share(), ..order }
}

/// Sends a session's messages, in bursts now and then, with commands and silences between them.
fn send(server: &Running, scene: &str, chance: &mut Chance) {
    let (outsider, commander) = (ToolsOutsider::join(scene), Commander::join(scene));
    let mut tick = 0;
    while tick < TICKS {
        if chance.once_in(25) {
            let _ = commander.order(order(chance));
        }
        let burst = if chance.once_in(30) { 12 } else { 1 };
        let stops = burst > 1;
        if stops {
            server.signal(Signal::STOP);
            std::thread::sleep(Duration::from_millis(20));
        }
        for _ in 0..burst {
            tick += if chance.once_in(50) { 40 } else { 1 };
            outsider.send(message(chance, tick));
        }
        if stops {
            server.signal(Signal::CONT);
        }
        std::thread::sleep(Duration::from_micros(if chance.once_in(100) { 60_000 } else { 700 }));
    }
    // Resumed: the last answers are those of ticks.
    let _ = commander.order(Order { kind: 3, ..Order::default() });
    outsider.send(message(&mut Chance(0), tick + 1));
    std::thread::sleep(Duration::from_millis(100));
}

#[test]
fn whatever_is_sent_to_two_staged_tools_is_played_again() {
    let _turn = turn();
    let sessions = if std::env::var_os("CHAINCELL_SLOW").is_some() { 40 } else { 4 };
    let place = Place::on_surface("whatever");
    for seed in 0..sessions {
        let device = ["premium", "touch", "omega", "falcon"][seed as usize % 4];
        let trace = place.file(&format!("{seed}.trace"));
        let options = ["--device", device, "--record", text(&trace), "--hash-every", "1"];
        let server = place.serve(&[&options[..], &[TOOL, TOOL, "--json"]].concat());
        send(&server, &place.scene, &mut Chance(seed));
        let served = server.interrupt().with(130).json();
        let replayed = run(["replay", text(&trace), "--model", text(&place.model), "--json"]);
        let replayed = replayed.with(0).json();
        assert_eq!(replayed["ticks"], served["ticks_executed"], "{device}, seed {seed}");
        assert_eq!(replayed["state_hash"], served["state_hash"], "{device}, seed {seed}");
        assert!(served["ticks_executed"].as_u64().unwrap() > TICKS / 2, "{served}");
    }
}
