//! The delay of the loop, measured by `serve` from send times, as outside programs see it.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_host::session::timing::clock::now_ns;
use chaincell_kernel::trace::{Reader, Record};
use chaincell_tests::files::{text, write_path};
use chaincell_tests::outsider::tools::{Poses, ToolsOutsider, one_tool};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};

const TICKS: u64 = 300;
const MILLISECOND_NS: u64 = 1_000_000;

fn serve(place: &Place, trace: &Path, options: &[&str]) -> Running {
    let always = ["--watchdog-ms", "0", "--ramp-ms", "0", "--json", "--device", "omega"];
    let recorded = ["--record", text(trace), "--ticks", "300"];
    place.serve(&[&always[..], &recorded, options].concat())
}

fn position_m(tick: u64) -> [f32; 3] {
    [0.0, 0.001, -0.0001 * tick as f32]
}

/// A press whose poses were sent so long ago; a send time of 0 stays 0.
fn press(place: &Place, age_ns: Option<u64>) {
    let outsider = ToolsOutsider::join(&place.scene);
    for tick in 0..TICKS {
        let send_ns = age_ns.map_or(0, |age_ns| now_ns() - age_ns);
        outsider.send(Poses { send_ns, ..one_tool(tick, position_m(tick), u32::from(tick > 0)) });
        let _ = outsider.receive();
    }
}

/// The delays that the trace tells of, one a tick.
fn recorded(trace: &Path) -> Vec<Option<u16>> {
    let bytes = std::fs::read(trace).unwrap();
    let mut delays = Vec::new();
    let end = Reader::open(&bytes).unwrap().records(|_, record: &Record| {
        delays.push(record.delay_ticks);
        Ok::<(), ()>(())
    });
    end.unwrap();
    delays
}

/// Serves a press and replays it; gives the delays.
fn session(name: &str, options: &[&str], press: impl FnOnce(&Place)) -> Vec<Option<u16>> {
    let place = Place::new(name);
    let trace = place.file("a.trace");
    let server = serve(&place, &trace, options);
    press(&place);
    let served = server.end(SHORT).with(0).json();
    let model = ["--model", text(&place.model), "--json"];
    let replayed = run([&["replay", text(&trace)][..], &model].concat()).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    assert_eq!(replayed["ticks"], TICKS);
    recorded(&trace)
}

// REQ-STG-14
#[test]
fn poses_that_come_late_are_counted_recorded_and_replayed() {
    let _turn = turn();
    let auto = ["--delay-ticks", "auto"];
    let delays = session("delay", &auto, |place| press(place, Some(2 * MILLISECOND_NS)));
    // Twice the way of 2 ms, and something of its own.
    assert!(delays.iter().all(|delay| delay.is_some_and(|ticks| (5..=16).contains(&ticks))));
    // Half a millisecond is a tick of 2 kHz.
    let fast = ["--delay-ticks", "auto", "--device-hz", "2000"];
    let delays = session("delay-fast", &fast, |place| press(place, Some(2 * MILLISECOND_NS)));
    assert!(delays.iter().all(|delay| delay.is_some_and(|ticks| (9..=16).contains(&ticks))));
}

// REQ-STG-14
#[test]
fn other_clocks_and_poses_without_a_time_are_bounded() {
    let _turn = turn();
    let auto = ["--delay-ticks", "auto"];
    for (name, age_ns) in [("delay-zero", None), ("delay-old", Some(5_000 * MILLISECOND_NS))] {
        let delays = session(name, &auto, |place| press(place, age_ns));
        assert!(delays.iter().all(|&delay| delay == Some(16)), "{delays:?}");
    }
}

#[test]
fn a_delay_that_was_told_is_not_measured() {
    let _turn = turn();
    let told = ["--delay-ticks", "3"];
    let delays = session("delay-told", &told, |place| press(place, Some(2 * MILLISECOND_NS)));
    assert!(delays.len() as u64 == TICKS && delays.iter().all(Option::is_none));
    let place = Place::new("delay-offline");
    let [path, out] = ["p.csv", "out"].map(|name| place.file(name));
    write_path(&path, (0..3).map(|tick| (tick, [0.0; 3], 1)));
    let auto = ["--device", "omega", "--delay-ticks", "auto", "--contact", "40"];
    let offline = ["run", text(&place.model), "--path", text(&path), "--out", text(&out)];
    let why = run([&offline[..], &auto].concat()).with(2).err;
    assert!(why.contains("measured by serve and cosim"), "{why}");
}
