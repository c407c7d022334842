//! Quick runs of a command on generated bodies, whatever reference data the tests have.
#![allow(clippy::panic, reason = "a failing helper fails its test")]

use std::path::Path;
use std::time::Duration;

use chaincell_tests::{Ended, Running, chaincell, files, run};
use serde_json::Value;

/// A build with checks on a busy machine takes its time.
const LONG: Duration = Duration::from_secs(600);

/// A number of a report.
pub fn real(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {value}"))
}

fn start(command: &str, out: &Path) -> Running {
    let arguments = [command, "--quick", "--json", "--out", files::text(out)];
    Running::start(chaincell().env_remove("CHAINCELL_REFERENCE").args(arguments))
}

/// A run to its end.
pub fn quick(command: &str, out: &Path) -> Ended {
    start(command, out).end(LONG)
}

/// What was computed until an interrupt is written, and the exit code says that it is not all: `last` is
/// missing.
fn interrupted(command: &str, last: &str) {
    let place = files::scratch();
    let out = place.path().join(command);
    let running = start(command, &out);
    while !out.is_dir() {
        std::thread::sleep(Duration::from_millis(2));
    }
    let ended = running.interrupt().with(130);
    assert_eq!(ended.json()["interrupted"], true);
    assert!(ended.json().get(last).is_none(), "{}", ended.out);
    for ending in ["html", "json"] {
        assert!(out.join(format!("{command}.{ending}")).is_file(), "{command}.{ending}");
    }
}

#[test]
fn an_interrupted_command_writes_as_far_as_it_got() {
    interrupted("paper", "liver");
    interrupted("report", "hand");
}

#[test]
fn reference_data_that_is_not_there_is_named() {
    for command in ["paper", "report"] {
        let ended = run([command, "--quick", "--json", "--reference", "no-such-folder"]).with(2);
        assert!(ended.err.contains("no-such-folder"), "{}", ended.err);
    }
}
