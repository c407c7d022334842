//! The report command, on generated bodies.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

use chaincell_tests::{files, run, turn};
use serde_json::Value;

use super::quick::{interrupted, quick, real};

/// No figure of the report is beyond what a measurement can give.
fn finite(value: &Value, place: &str) {
    match value {
        Value::Number(number) => {
            let size = number.as_f64().unwrap().abs();
            assert!(size < 1e15, "{place}: {number}");
        }
        Value::Array(all) => all.iter().for_each(|value| finite(value, place)),
        Value::Object(all) => {
            all.iter().for_each(|(key, value)| finite(value, &format!("{place}/{key}")));
        }
        _ => {}
    }
}

/// Held cells under a hand that moves: every row has a time and a finite error at that setting.
fn hand(found: &Value) {
    let rows = found["hand"].as_array().unwrap();
    for motion in ["straight at 80 mm/s", "circles with tremor"] {
        for scheme in ["track", "track without a coarse level"] {
            let of = |row: &&Value| {
                let named = row["motion"].as_str().unwrap().starts_with(motion);
                named && row["scheme"] == scheme
            };
            let rows: Vec<&Value> = rows.iter().filter(of).collect();
            let sweeps: Vec<u64> = rows.iter().map(|row| row["sweeps"].as_u64().unwrap()).collect();
            assert_eq!(sweeps, [1, 2, 4, 8], "{motion}, {scheme}");
            for row in &rows {
                assert!(real(row, "/tick_ns/p50") > 0.0 && real(row, "/own_sweeps") > 0.0, "{row}");
                assert!(real(row, "/main_sweeps") > 0.0, "{row}");
                let [median, largest] =
                    ["median", "largest"].map(|of| real(row, &format!("/force/{of}")));
                assert!(0.0 < median && median <= largest && largest < 10.0, "{row}");
                assert!((0.0..=1.0).contains(&real(row, "/snaps/share")), "{row}");
            }
            let error = |at: usize| real(rows[at], "/force/largest");
            assert!(error(3) < 0.5 * error(0), "{motion}, {scheme}: {} {}", error(0), error(3));
        }
    }
}

#[test]
fn a_quick_report_has_its_figures_and_files() {
    let place = files::scratch();
    let out = place.path().join("report");
    let _turn = turn();
    let found = quick("report", &out).with(0).json();
    for path in ["/sweep/scalar_ns", "/sweep/simd_ns"] {
        assert!(real(&found, path) > 0.0, "{path}");
    }
    // The worst case is one: every link is outside its band.
    assert_eq!(real(&found, "/sweep/taut_links"), real(&found, "/sweep/links"));
    for body in ["slab", "block"] {
        let of = |what: &str| real(&found, &format!("/press/{body}/{what}"));
        assert!((2.0..3000.0).contains(&of("sweeps")) && of("ms") > 0.0);
        assert!(of("off_minimum") < 0.05, "{body}: {}", of("off_minimum"));
    }
    assert!(real(&found, "/track/sweeps") >= 1.0);
    let rows = found["rows"].as_array().unwrap();
    let row = |scene: &str, scheme: &str, sweeps: u64| {
        let is = |row: &&Value| {
            row["scene"] == scene && row["scheme"] == scheme && row["sweeps"] == sweeps
        };
        rows.iter().find(is).unwrap_or_else(|| panic!("{scene} {scheme} {sweeps}"))
    };
    // More sweeps are nearer to the exact minimum, and 100 ms after the press nearly there.
    let after = |sweeps| real(row("plane8", "track", sweeps), "/after_100ms/field");
    assert!(after(16) < after(1) && after(16) < 1e-3, "{} {}", after(16), after(1));
    assert!(real(row("organ", "track", 16), "/largest/field") > 0.0);
    assert_eq!(found["reference"], false);
    assert!(real(&found, "/seconds") > 0.0);
    let tools = found["tools"].as_array().unwrap();
    assert!(tools.iter().all(|row| real(row, "/force/largest") < 10.0), "{tools:?}");
    assert!(tools.iter().all(|row| real(row, "/force/median") <= real(row, "/force/p90")));
    hand(&found);
    // A ratio without a base is no number.
    finite(&found, "");
    let text = std::fs::read_to_string(out.join("REPORT.md")).unwrap();
    assert!(text.contains("generated organ") && text.contains("| track | 16 |"), "{text}");
    for head in ["## A hand that moves", "left out as snaps [%]", "largest in snaps [%]"] {
        assert!(text.contains(head), "{head} in {text}");
    }
    assert!(text.contains("## Model error\n\nSKIPPED"), "{text}");
    for tool in ["held cells", "moving probe", "load"] {
        assert!(text.contains(&format!("| {tool}")), "{tool} in {text}");
    }
    assert!(text.contains("Measured in ") && !text.contains(" 1 sweeps"), "{text}");
    for name in [
        "field.png",
        "field.svg",
        "force.png",
        "press.csv",
        "settle.csv",
        "tools.csv",
        "hand.csv",
        "hand_1.png",
        "time.csv",
    ] {
        assert!(std::fs::metadata(out.join(format!("report_{name}"))).unwrap().len() > 100);
    }
    let again = quick("report", &out).with(2);
    assert!(again.err.contains("--force"), "{}", again.err);
}

/// What was measured so far is written, and the exit code says that it is not all.
#[test]
fn an_interrupted_report_is_written_as_far_as_it_got() {
    let place = files::scratch();
    let out = place.path().join("report");
    let ended = interrupted("report", &out);
    assert!(ended.json().get("press").is_some() && out.join("REPORT.md").is_file());
    assert_eq!(ended.json()["tools"].as_array().map(Vec::len), Some(0), "{}", ended.out);
}

#[test]
fn reference_data_that_is_not_there_is_named() {
    let ended = run(["report", "--quick", "--json", "--reference", "no-such-folder"]).with(2);
    assert!(ended.err.contains("no-such-folder"), "{}", ended.err);
}
