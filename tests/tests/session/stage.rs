//! The output stage in `serve`: what a device is given, and sessions behind it once more.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::PathBuf;
use std::time::Duration;

use chaincell_tests::files::{Table, play, summary, text, write_path};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};

/// A stiff plane and a path that presses its middle by 20 mm to some newtons, and holds.
fn place(test: &str, ticks: u64) -> (Place, PathBuf) {
    let place = Place::stiff(test);
    let path = place.file("press.csv");
    let row = |tick: u64| (tick, [0.0, 0.0, -1e-4 * tick.min(200) as f32], u32::from(tick > 0));
    write_path(&path, (0..ticks).map(row));
    (place, path)
}

/// Serves `ticks` ticks of the path behind a stage, and what `beside` does meanwhile.
fn session(test: &str, ticks: u64, stage: &[&str], beside: impl Fn(&str)) -> (Place, PathBuf) {
    let (place, path) = place(test, ticks);
    let out = place.file("out");
    let count = ticks.to_string();
    let own = ["--ticks", &count, "--out", text(&out), "--json"];
    let serve = place.serve(&[&own[..], stage].concat());
    let control = Running::start(&mut place.control(&["--path", text(&path)]));
    beside(&place.scene);
    control.end(SHORT).with(0);
    serve.end(SHORT).with(0);
    (place, out)
}

// REQ-STG-08
#[test]
fn a_device_gets_no_more_than_its_stage_allows_and_the_session_is_replayed() {
    let _turn = turn();
    let stage = ["--device", "omega", "--max-device-force-n", "1", "--max-slew-n-per-s", "20"];
    let (_place, out) = session("staged", 600, &stage, |_| {});
    let forces = Table::read(&out.join("force.csv")).vectors("fx_n");
    let size = |f: [f64; 3]| f.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = forces.iter().map(|&f| size(f)).fold(0.0, f64::max);
    assert!((0.1..=1.0).contains(&largest), "{largest}");
    let steps = forces
        .windows(2)
        .map(|pair| size(std::array::from_fn(|axis| pair[1][axis] - pair[0][axis])));
    let step = steps.fold(0.0, f64::max);
    let found = summary(&out);
    // A server that its machine keeps waiting takes the force away between two ticks.
    match found["flag_ticks"]["late"].as_u64() {
        None => assert!(largest >= 0.99 && (0.005..=0.020_001).contains(&step), "{largest} {step}"),
        Some(late) => println!("SKIPPED the force and its steps: {late} ticks late"),
    }
    assert_eq!(found["stage"]["device"], "omega");
    assert_eq!(found["stage"]["max_device_force_n"], 1.0);
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    // A late tick has no hash.
    let hashes = 600 - found["ticks_late"].as_u64().unwrap();
    assert_eq!((&replayed["ticks"], &replayed["hashes_compared"]), (&600.into(), &hashes.into()));
    assert_eq!(replayed["state_hash"], found["state_hash"]);
    // Without its coupling the tissue comes to another state: the stage is part of the session.
    let path = out.join("path.csv");
    let again = out.with_file_name("again");
    let model = out.join("model.chaincell");
    let held = ["--contact", "40", "--force"];
    let plain = ["run", text(&model), "--path", text(&path), "--out", text(&again)];
    let plain = [&plain[..], &held].concat();
    run(&plain).with(0);
    assert_ne!(summary(&again)["state_hash"], found["state_hash"]);
    run([&plain[..], &stage].concat()).with(0);
    assert_eq!(summary(&again)["state_hash"], found["state_hash"]);
}

// REQ-STG-08
#[test]
fn pauses_and_resets_are_replayed_behind_a_stage() {
    let _turn = turn();
    let stage = ["--coupling", "500:0.5", "--passivity", "0.2"];
    let (_place, out) = session("staged-commands", 1500, &stage, |scene| {
        for command in ["pause", "resume", "reset"] {
            std::thread::sleep(Duration::from_millis(150));
            run(["command", "--scene", scene, command]).with(0);
        }
    });
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!((&replayed["ticks"], &replayed["commands"]), (&1500.into(), &3.into()));
    assert_eq!(replayed["state_hash"], summary(&out)["state_hash"]);
}

#[test]
fn a_stage_that_goes_by_positions_is_refused_with_a_current() {
    let (place, path) = place("staged-current", 10);
    let out = place.file("out");
    let options = ["--drive", "current", "--device", "touch"];
    let refused = play(&place.model, &path, &out, &options).with(2);
    assert!(refused.err.contains("--drive current") && refused.err.contains("--coupling none"));
    let limits = ["--drive", "current", "--max-device-force-n", "2"];
    play(&place.model, &path, &out, &limits).with(0);
}
