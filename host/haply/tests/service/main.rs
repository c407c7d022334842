//! The program against a mock of the Haply service and a real `chaincell serve`.
//!
//! Messages are counted, no time is. On a machine that has no time for the program or the mock, the program doubts, and
//! the force is off; each such run says so.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

mod mock;

use std::process::Command;
use std::time::Duration;

use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Ended, Running, turn};
use mock::{Act, Mock};

/// Most messages of a force in 20 ms, one a millisecond.
const OFF_MESSAGES: usize = 20;
/// A message by which the program has joined its scene.
const STARTED: usize = 20;
/// Time between two messages from which on the program may doubt: most of its 8 ms.
const LATE: Duration = Duration::from_millis(5);
/// What the press pushes back with at least \[N\].
const SOME_N: f64 = 0.05;

/// Height of the device in message n: 12 mm down and up again, twice a second \[m\].
fn height_m(message: usize) -> f32 {
    0.006 * ((message as f32 * std::f32::consts::TAU / 500.0).cos() - 1.0)
}

fn press(message: usize) -> Act {
    Act::At(height_m(message))
}

fn program(address: &str, scene: &str, options: &[&str]) -> Running {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chaincell-haply"));
    command.args(["--service", address, "--scene", scene, "--json"]).args(options);
    Running::start(&mut command)
}

/// True where no doubt has kept the force off; else a line says so.
fn was_calm(test: &str, ended: &Ended) -> bool {
    let doubts = &ended.json()["doubts"];
    let is_calm = doubts.as_object().unwrap().is_empty();
    if !is_calm {
        println!("SKIPPED the size of the force in {test}: the machine was late, {doubts}");
    }
    is_calm
}

fn count(ended: &Ended, key: &str) -> u64 {
    ended.json()[key].as_u64().unwrap()
}

#[test]
fn every_pose_of_ten_seconds_is_answered_or_said() {
    let _turn = turn();
    let place = Place::stiff("haply-press");
    let trace = place.file("haply.trace");
    let record = trace.to_str().unwrap();
    let serve = place.serve(&["--budget-us", "off", "--json", "--record", record]);
    let mock = Mock::start(press);
    let ended = program(&mock.address, &place.scene, &["--seconds", "10", "--max-force-n", "1.5"]);
    let ended = ended.end(SHORT).with(0);
    let seen = mock.seen();
    let served = serve.interrupt().with(130).json();
    // Counts of three programs agree.
    assert_eq!(count(&ended, "forces_sent") as usize, seen.forces_n.len());
    assert_eq!(count(&ended, "poses"), count(&ended, "states"));
    assert_eq!(count(&ended, "poses"), count(&ended, "answered") + count(&ended, "late"));
    assert_eq!(served["ticks_executed"], ended.json()["poses"]);
    assert_eq!(ended.json()["ended_by"], "time up");
    // Off before the first answer and at the end, and never above its limit.
    assert!(seen.forces_n[..100].iter().all(|force_n| *force_n == 0.0));
    assert!(seen.forces_n.iter().all(|force_n| *force_n <= 1.5 + 1e-6));
    assert!(seen.was_closed && seen.forces_n.last() == Some(&0.0));
    let poses = count(&ended, "poses");
    println!(
        "{poses} poses in 10 s, {} answered, {} late",
        count(&ended, "answered"),
        count(&ended, "late")
    );
    if was_calm("every_pose_of_ten_seconds_is_answered_or_said", &ended) {
        // One in a millisecond, and half of it on a machine with other work.
        assert!(poses > 5_000, "{poses}");
        let largest_n = seen.forces_n.iter().fold(0.0f64, |a, b| a.max(*b));
        assert!(largest_n > SOME_N, "{largest_n} N: {ended:?}");
    }
    chaincell_tests::run(["replay", record, "--model", place.model.to_str().unwrap()]).with(0);
}

#[test]
fn a_silent_service_gets_no_force_after_20_ms() {
    let _turn = turn();
    let place = Place::stiff("haply-silent");
    let serve = place.serve(&["--budget-us", "off"]);
    const SILENT: usize = 760;
    let mock = Mock::start(|message| if message < SILENT { press(message) } else { Act::Silence });
    let ended = program(&mock.address, &place.scene, &[]).end(SHORT).with(1);
    let seen = mock.seen();
    assert!(ended.err.contains("2 s without a good state"), "{}", ended.err);
    assert_eq!(seen.forces_n.last(), Some(&0.0));
    let later = &seen.forces_n[SILENT - 1..];
    let felt = later.iter().filter(|force_n| **force_n != 0.0).count();
    assert!(felt <= OFF_MESSAGES, "{felt} messages with a force: {later:?}");
    let zero = later.iter().position(|force_n| *force_n == 0.0).unwrap();
    assert!(later[zero..].iter().all(|force_n| *force_n == 0.0), "{later:?}");
    // In the middle of a press, unless the machine was late before.
    let doubts = ended.json()["doubts"].clone();
    let longest = seen.gaps[STARTED..SILENT].iter().max().unwrap();
    if doubts == serde_json::json!({"service_silent": 1}) && *longest < LATE {
        assert!(seen.forces_n[SILENT - 1] > SOME_N && felt > 2, "{later:?}");
    } else {
        println!("SKIPPED the fall of the force: the machine was late, {doubts}, {:?}", longest);
    }
    serve.interrupt().with(130);
}

#[test]
fn bad_messages_ctrl_c_and_a_cut_end_with_force_zero() {
    let _turn = turn();
    let place = Place::stiff("haply-ends");
    let serve = place.serve(&["--budget-us", "off"]);
    let scene = &place.scene;
    // From message 300 on no state; the last one is that of the end.
    let mock =
        Mock::start(
            |message| if message < 300 { press(message) } else { Act::Say("{\"inverse3\":7}") },
        );
    let ended = program(&mock.address, scene, &[]).end(SHORT).with(1);
    assert!(ended.err.contains("is it service 3.1 or newer?; force off"), "{}", ended.err);
    let seen = mock.seen();
    assert!(seen.forces_n[300 + OFF_MESSAGES..].iter().all(|force_n| *force_n == 0.0));
    assert!(seen.was_closed);
    // Ctrl-C.
    let mock = Mock::start(press);
    let mut haply = program(&mock.address, scene, &[]);
    haply.notes_until(&format!("chaincell-haply: device {} of {}", mock::DEVICE, mock.address));
    std::thread::sleep(Duration::from_millis(300));
    let ended = haply.interrupt().with(0);
    let seen = mock.seen();
    assert_eq!(ended.json()["ended_by"], "stopped");
    assert!(seen.was_closed && seen.forces_n.last() == Some(&0.0));
    // The service is gone.
    let mock = Mock::start(|message| if message < 300 { press(message) } else { Act::Cut });
    let ended = program(&mock.address, scene, &[]).end(SHORT).with(1);
    assert!(ended.err.contains("is it still running?"), "{}", ended.err);
    serve.interrupt().with(130);
}

#[test]
fn the_end_of_the_tissue_is_an_end() {
    let _turn = turn();
    let place = Place::stiff("haply-served");
    let serve = place.serve(&["--budget-us", "off", "--ticks", "300"]);
    let mock = Mock::start(press);
    let ended = program(&mock.address, &place.scene, &[]).end(SHORT).with(0);
    assert!(ended.json()["ended_by"].as_str().unwrap().contains("session has ended"));
    let seen = mock.seen();
    assert!(seen.was_closed && seen.forces_n.last() == Some(&0.0));
    serve.end(SHORT).with(0);
}

#[test]
fn a_refusal_names_the_place_and_the_remedy() {
    let refused = |address: &str, options: &[&str]| {
        program(address, "haply-nobody", options).end(SHORT).with(2).err
    };
    let nobody = refused("ws://127.0.0.1:1", &[]);
    assert!(nobody.contains("is the Haply service running?"), "{nobody}");
    assert!(nobody.contains("--service ws://"), "{nobody}");
    let options = [
        (&["--frame", "x,x,z"][..], "--frame x,x,z"),
        (&["--frame", "-x,y,z"], "mirrors the hand"),
        (&["--origin", "-1,2"], "--origin -1,2: give three numbers"),
        (&["--scale", "0"], "--scale 0"),
        (&["--max-force-n", "-1"], "--max-force-n -1"),
        (&["--seconds", "-1"], "--seconds -1"),
    ];
    for (options, text) in options {
        let said = refused("ws://127.0.0.1:1", options);
        assert!(said.contains(text), "{said}");
    }
    // A service without a device, without the device, and without a tissue.
    let mock = Mock::start(|_| Act::Say(r#"{"session_id":7,"inverse3":[]}"#));
    let said = refused(&mock.address, &[]);
    assert!(said.contains("it has: none") && said.contains("plug one in"), "{said}");
    let mock = Mock::start(press);
    let said = refused(&mock.address, &["--device", "A"]);
    assert!(said.contains("it has: 049D"), "{said}");
    let mock = Mock::start(press);
    let said = refused(&mock.address, &["--wait-for-server-s", "0"]);
    assert!(said.contains("chaincell serve"), "{said}");
}
