//! What `bake` and `run` say when their own figures are not to be trusted, with the words that name the remedy: in
//! text and in JSON.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::{Path, PathBuf};

use chaincell_tests::files::{bake, scratch, summary, text};
use chaincell_tests::remark::{row, says};
use chaincell_tests::run;
use serde_json::Value;

/// Tissue whose top, at 40 mm, has edges of 10 mm; and the folder for its results.
fn body() -> (tempfile::TempDir, PathBuf) {
    let folder = scratch();
    let model = bake(folder.path(), "box:7x7x5x0.01", &["--young-pa", "5000"]);
    (folder, model)
}

/// A press of the built-in motion: its text, and its judgement.
#[track_caller]
fn pressed(model: &Path, folder: &Path, options: &[&str]) -> (String, Value) {
    let out = folder.join("out");
    let args = [
        "run",
        text(model),
        "--motion",
        "press",
        "--seconds",
        "0.2",
        "--out",
        text(&out),
        "--force",
    ];
    let said = run([&args, options].concat()).with(0).out;
    let judgement = summary(&out)["judgement"].clone();
    let json = run([&args[..], &["--json"], options].concat()).with(0).json();
    for name in ["mesh", "held_back", "untouched_tools", "corner_deg"] {
        assert_eq!(
            json["judgement"][name], judgement[name],
            "{name} of --json and of summary.json"
        );
    }
    (said, judgement)
}

/// From above the middle of the top, beginning at this height.
fn above(place: &str) -> [&str; 3] {
    ["--touch-m", place, "--direction=0,0,-1"]
}

#[test]
fn a_surface_in_another_unit_is_refused_with_the_option() {
    let folder = scratch();
    let metres = folder.path().join("metres.stl");
    run(["convert", "box:5x5x5x0.02", text(&metres)]).with(0);
    let in_mm = |line: &str| match line.strip_prefix("vertex ") {
        Some(places) => {
            let places = places.split(' ').map(|place| place.parse::<f64>().unwrap() * 1000.0);
            places.fold(String::from("vertex"), |line, place| format!("{line} {place}"))
        }
        None => line.to_owned(),
    };
    let surface = folder.path().join("surface.stl");
    let lines = std::fs::read_to_string(&metres).unwrap();
    std::fs::write(
        &surface,
        lines.lines().map(|line| in_mm(line.trim()) + "\n").collect::<String>(),
    )
    .unwrap();
    let model = folder.path().join("model.chaincell");
    let bake =
        |options: &[&str]| run([&["bake", text(&surface), "-o", text(&model)], options].concat());
    let unit = "coordinates read as m; --units mm reads them as mm";
    let err = bake(&["--fill", "0.02", "--young-pa", "5000"]).with(2).err;
    assert!(err.contains(unit) && !model.exists(), "{err}");
    // Whoever obeys the other words of the refusal gets the note.
    let ended = bake(&["--fill", "20", "--young-pa", "5000"]).with(0);
    assert!(ended.err.contains(unit), "{}", ended.err);
    let json = bake(&["--fill", "20", "--young-pa", "5000", "--json"]).with(0);
    assert!(json.err.contains(unit) && json.json()["judgement"].is_object(), "{json:?}");
    let good = bake(&["--fill", "0.02", "--young-pa", "5000", "--units", "mm"]).with(0);
    assert!(!good.err.contains("--units"), "{}", good.err);
}

#[test]
fn bake_judges_mesh_corner_and_pace() {
    let folder = scratch();
    let model = folder.path().join("model.chaincell");
    let args = ["bake", "box:7x7x5x0.01", "--young-pa", "5000", "-o", text(&model)];
    let said = run(args).with(0).out;
    says(
        &said,
        "mesh",
        &["edges of 1", "for a sphere of 2", "the force is within 14 %", "up to 32 % off"],
    );
    says(
        &said,
        "place",
        &["at a corner", "bends by 55 degrees", "--contact cells:SELECTOR", "--touch-m"],
    );
    says(&said, "pace", &["1 kHz on this machine", "a tick of 4 sweeps takes", "its millisecond"]);
    let judgement = &run([&args[..], &["--json"]].concat()).with(0).json()["judgement"];
    let is_real = |value: &Value| value.as_f64().is_some_and(|value| value > 0.0);
    assert!(is_real(&judgement["mesh"]["edge_m"]) && judgement["mesh"]["radius_m"].is_null());
    assert!(is_real(&judgement["pace"]["load_p50"]) && judgement["pace"]["sweeps_max"] == 4);
    assert!((judgement["corner_deg"].as_f64().unwrap() - 55.0).abs() < 1.0);
    let held = run([&args[..], &["--fix", "box:-9,9,-9,9,-9,9"]].concat()).with(0).err;
    assert!(held.contains("every cell is fixed, nothing moves; --fix fewer nodes"), "{held}");
    // The organ is round.
    let round = ["bake", "organ:500", "--young-pa", "5000", "-o", text(&model)];
    let said = run(round).with(0).out;
    assert_eq!(row(&said, "place"), None, "{said}");
}

#[test]
fn run_judges_depth_and_mesh() {
    let (folder, model) = body();
    let deep =
        [&above("0,0,0.045")[..], &["--contact", "probe:0.004", "--depth-m", "0.03"]].concat();
    let (said, judgement) = pressed(&model, folder.path(), &deep);
    says(
        &said,
        "depth",
        &["asked 2", "held back at ", "press less deep", "larger tool", "info --probe RADIUS"],
    );
    says(&said, "mesh", &["for a radius of 4.00 mm", "% off", "--fill ", "make that 14 %"]);
    assert_eq!(row(&said, "place"), None, "a press that was placed: {said}");
    let held = &judgement["held_back"][0];
    let (asked_m, reached_m) =
        (held["asked_m"].as_f64().unwrap(), held["reached_m"].as_f64().unwrap());
    assert!(held["tool"] == 0 && asked_m > 0.02 && reached_m < 0.6 * asked_m, "{judgement}");
    let mesh = &judgement["mesh"];
    assert!(
        mesh["edge_m"].as_f64() > mesh["radius_m"].as_f64() && mesh["force_error"] == 0.32,
        "{judgement}"
    );
    // A shallow press of a large tool.
    let shallow =
        [&above("0,0,0.066")[..], &["--contact", "probe:0.025", "--depth-m", "0.005"]].concat();
    let (said, judgement) = pressed(&model, folder.path(), &shallow);
    assert_eq!(row(&said, "depth"), None, "{said}");
    says(&said, "mesh", &["the force is within 10 %"]);
    assert_eq!(judgement["held_back"], serde_json::json!([]));
}

#[test]
fn run_judges_tools_beside_the_body() {
    let (folder, model) = body();
    let tools = [
        &above("0,0,0.051")[..],
        &["--tool", "sphere:0.01", "--tool", "sphere:0.01", "--depth-m", "0.005"],
    ]
    .concat();
    let (said, judgement) = pressed(&model, folder.path(), &tools);
    says(
        &said,
        "contact",
        &["tool 1 never touched the body", "bring it nearer", "chaincell info MODEL"],
    );
    assert_eq!(judgement["untouched_tools"], serde_json::json!([1]));
    let beside =
        [&above("0,0,0.3")[..], &["--contact", "probe:0.01", "--depth-m", "0.004"]].concat();
    let (said, judgement) = pressed(&model, folder.path(), &beside);
    says(&said, "contact", &["the tool never touched the body: nearest 2", "bring it nearer"]);
    assert_eq!(judgement["untouched_tools"], serde_json::json!([0]));
    // From inside down through the bottom, at 0: its middle is outside at the end, a part of it is not.
    let through =
        [&above("0,0,0.02")[..], &["--contact", "probe:0.015", "--depth-m", "0.03"]].concat();
    let (said, _) = pressed(&model, folder.path(), &through);
    says(
        &said,
        "contact",
        &["nearest 0.0 mm at tick ", "inside the body", "begin outside of the body"],
    );
}

#[test]
fn a_depth_in_millimetres_is_refused() {
    let (folder, model) = body();
    let out = folder.path().join("out");
    let args = ["run", text(&model), "--motion", "press", "--depth-m", "10", "--out", text(&out)];
    let why = run(args).with(2).err;
    assert!(why.contains("--depth-m 10.0: 10.0 m into a body of 60.0 mm"), "{why}");
    assert!(why.contains("give the depth in metres") && !out.exists(), "{why}");
}

#[test]
fn run_judges_a_default_contact_at_a_corner() {
    let (folder, model) = body();
    let (said, judgement) = pressed(&model, folder.path(), &["--depth-m", "0.003"]);
    says(
        &said,
        "place",
        &["at a corner or an edge", "--contact cells:SELECTOR", "--touch-m and --direction"],
    );
    assert!(judgement["corner_deg"].as_f64().unwrap() > 40.0);
    let (said, judgement) =
        pressed(&model, folder.path(), &["--contact", "cells:122", "--depth-m", "0.003"]);
    assert_eq!(row(&said, "place"), None, "{said}");
    assert_eq!(judgement["corner_deg"], Value::Null);
}

/// A tick of so many sweeps takes longer than a millisecond anywhere.
#[test]
fn run_judges_a_body_too_slow_to_feel() {
    let (folder, model) = body();
    let slow = ["--depth-m", "0.003", "--sweeps", "400", "--seconds", "0.02"];
    let out = folder.path().join("out");
    let args = ["run", text(&model), "--motion", "press", "--out", text(&out)];
    let said = run([&args[..], &slow].concat()).with(0).out;
    says(&said, "pace", &["does NOT fit 1 kHz", "times its millisecond", "take a faster "]);
    let pace = &summary(&out)["judgement"]["pace"];
    assert!(pace["load_p50"].as_f64().unwrap() > 1.0, "{pace}");
    assert!(pace["cells_fitting"].as_u64().unwrap() < 245, "{pace}");
}
