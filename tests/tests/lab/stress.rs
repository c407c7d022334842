//! The stress command: the quick suite once, by the binary.
//!
//! `CHAINCELL_SLOW=1` adds the drift over 10^8 ticks.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeSet;
use std::time::Duration;

use chaincell_tests::{Ended, Running, chaincell, files, run};
use serde_json::Value;

/// A build with checks on a busy machine takes its time.
const LONG: Duration = Duration::from_secs(600);
/// The drift over 10^8 ticks.
const SLOW: Duration = Duration::from_secs(4 * 3600);

fn stress(arguments: &[&str], life: Duration) -> Ended {
    Running::start(chaincell().arg("stress").args(arguments)).end(life)
}

/// Names of the cases that `--list` prints.
fn listed(arguments: &[&str]) -> Vec<String> {
    let text = stress(&[&["--list"], arguments].concat(), LONG).with(0).out;
    text.lines().map(|line| line.split_whitespace().next().unwrap().to_owned()).collect()
}

// REQ-HRD-01, REQ-HRD-02
#[test]
fn the_quick_suite_is_ok_and_has_every_case_that_is_listed() {
    let place = files::scratch();
    let out = place.path().join("stress");
    let ended = stress(&["--quick", "--json", "--out", files::text(&out)], LONG).with(0);
    let suite = ended.json();
    let names = listed(&[]);
    assert!(names.len() >= 25, "{names:?}");
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
    let cases = suite["cases"].as_array().unwrap();
    let found: Vec<&str> = cases.iter().map(|case| case["name"].as_str().unwrap()).collect();
    assert_eq!(found, names);
    for case in cases {
        assert_eq!(case["ok"], true, "{case}");
        assert!(case["checks"].as_str().unwrap().len() > 10, "{case}");
        let figures = case["figures"].as_object().unwrap();
        assert!(figures.len() > 1 && figures.values().all(Value::is_number), "{case}");
        for ratio in ["force_over_bound", "energy_over_bound", "coordinate_over_k"] {
            let value = figures.get(ratio).and_then(Value::as_f64).unwrap_or_default();
            assert!((0.0..=1.0001).contains(&value), "{ratio}: {case}");
        }
    }
    assert_eq!((&suite["ok"], &suite["failed"]), (&Value::Bool(true), &0.into()));
    assert_eq!(suite["done"], cases.len());
    let figure = |case: &str, name: &str| {
        let case = cases.iter().find(|of| of["name"] == case).unwrap();
        case["figures"].get(name).and_then(Value::as_f64)
    };
    // The hard cases are hard: K, the bounds of force and energy are nearly reached.
    assert_eq!(figure("k-reached-and-left", "coordinate_over_k"), Some(1.0));
    assert!(figure("teleport-cells", "force_over_bound").unwrap() > 0.5);
    assert_eq!(figure("drift", "ticks_each"), Some(1e5));
    // The same figures as a table that a terminal of 100 columns shows.
    let table = std::fs::read_to_string(out.join("stress.txt")).unwrap();
    let head = table.split("Refused").next().unwrap();
    assert!(head.lines().all(|line| line.chars().count() <= 100), "{head}");
    for name in &names {
        assert!(table.lines().any(|line| line.starts_with(&format!("{name} "))), "{name}");
    }
    let kept: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("stress.json")).unwrap()).unwrap();
    assert_eq!(kept, suite);
}

#[test]
fn cases_are_chosen_by_name_and_unknown_ones_refused() {
    let names = listed(&["--only", "teleport", "--only", "valence"]);
    assert_eq!(names, ["valence-3-to-200", "teleport-cells"]);
    let suite = stress(&["--quick", "--json", "--only", "non-finite"], LONG).with(0).json();
    assert_eq!(suite["cases"].as_array().unwrap().len(), 1);
    let refused = run(["stress", "--only", "nothing-like-it"]).with(2);
    assert!(refused.err.contains("--list"), "{}", refused.err);
    run(["stress", "--quick", "--slow"]).with(2);
}

// REQ-HRD-02
#[test]
fn long_slow_drift() {
    if std::env::var_os("CHAINCELL_SLOW").is_none() {
        println!("SKIPPED long_slow_drift: CHAINCELL_SLOW is not set");
        return;
    }
    let suite = stress(&["--slow", "--json", "--only", "drift"], SLOW).with(0).json();
    assert_eq!(suite["cases"][0]["figures"]["ticks_each"], 1e8);
}
