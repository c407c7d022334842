//! Quick runs of a command on generated bodies, whatever reference data the tests have.
#![allow(clippy::panic, reason = "a failing helper fails its test")]

use std::path::Path;
use std::time::Duration;

use chaincell_tests::{Ended, Running, chaincell, files};
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

/// A run that is interrupted once its folder is there.
pub fn interrupted(command: &str, out: &Path) -> Ended {
    let running = start(command, out);
    while !out.is_dir() {
        std::thread::sleep(Duration::from_millis(2));
    }
    running.interrupt().with(130)
}
