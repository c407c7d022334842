//! The report command, on generated bodies.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

use chaincell_tests::{files, turn};
use serde_json::Value;

use super::quick::{quick, real};

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
    let rows = found["hand"]["rows"].as_array().unwrap();
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
                assert!(
                    real(row, "/tick_ns/p50") > 0.0 && real(row, "/link_sweeps") > 0.0,
                    "{row}"
                );
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

/// Verification cases of others: each body is near what the deck expects.
fn decks(found: &Value) {
    let rows = found["decks"]["traction"].as_array().unwrap();
    let small = |row: &&Value| real(row, "/expected/stress").abs() < 0.01;
    assert_eq!(rows.iter().filter(small).count(), 3);
    for row in rows {
        for strain in ["along", "across"] {
            let [shapes, closed] =
                ["shapes", "closed"].map(|of| real(row, &format!("/{of}/{strain}")));
            assert!((shapes - closed).abs() < 1e-7, "{row}");
        }
        // SOFA's own tolerance.
        let off = real(row, "/shapes/along") - real(row, "/expected/along");
        assert!(!small(&row) || off.abs() < 1e-4, "{row}");
    }
    for row in found["decks"]["beam"].as_array().unwrap() {
        let ratio = real(row, "/shapes_m") / real(row, "/expected_m");
        assert!((0.6..1.02).contains(&ratio), "{row}");
    }
    let steps = found["decks"]["steps"].as_array().unwrap();
    assert!(steps.len() == 4 && steps.iter().all(|row| real(row, "/steps") >= 1.0), "{steps:?}");
}

#[test]
fn a_quick_report_has_its_figures_and_files() {
    let place = files::scratch();
    let out = place.path().join("report");
    let _turn = turn();
    let found = quick("report", &out).with(0).json();
    assert_eq!(found["reference"], false);
    assert!(real(&found, "/seconds/sweeps") > 0.0);
    assert!(real(&found, "/hand/link_sweep_ns") > 0.0);
    let rows = found["sweeps"].as_array().unwrap();
    for material in ["shapes, nu 0.45", "links"] {
        let rows: Vec<&Value> = rows.iter().filter(|row| row["material"] == material).collect();
        assert_eq!(rows.len(), 2 * 3, "{material}");
        for of_motion in rows.chunks(3) {
            let error = |at: usize| real(of_motion[at], "/median");
            assert!(0.0 < error(2) && error(2) < error(0), "{of_motion:?}");
            let [peak_n, passes] = ["/peak_n", "/passes"].map(|of| real(of_motion[0], of));
            assert!(peak_n > 0.0 && passes > 0.0, "{of_motion:?}");
        }
    }
    let budget = found["budget"].as_array().unwrap();
    assert!(budget.len() == 5 && budget.iter().all(|row| real(row, "/p90") > 0.0), "{budget:?}");
    hand(&found);
    decks(&found);
    // A ratio without a base is no number.
    finite(&found, "");
    let text = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        text.contains("generated organ") && text.contains("<td>track</td><td class=\"number\">8<")
    );
    // It opens with what a budget buys.
    let first = text.find("<h2>What a budget buys</h2>").unwrap();
    assert!(first < text.find("<h2>What a sweep buys</h2>").unwrap());
    assert!(text.contains("On this machine a millisecond"), "{text}");
    for head in [
        "<h2>Verification cases of others<",
        "<h2>A hand that moves<",
        "left out as snaps [%]",
        "largest in snaps [%]",
    ] {
        assert!(text.contains(head), "{head} in {text}");
    }
    for tool in ["<h2>What a sweep buys<", "<td>held cells, 10 mm in 300 ms", "<td>ball, 10 mm"] {
        assert!(text.contains(tool), "{tool} in {text}");
    }
    assert!(text.contains("Computed in ") && !text.contains(" 1 sweeps"), "{text}");
    for name in [
        "decks.csv",
        "hand.csv",
        "sweeps.csv",
        "decks.png",
        "hand_1.png",
        "hand_1.svg",
        "sweeps_1.png",
    ] {
        assert!(std::fs::metadata(out.join(format!("report_{name}"))).unwrap().len() > 100);
    }
    let again = quick("report", &out).with(2);
    assert!(again.err.contains("--force"), "{}", again.err);
}
