//! `chaincell identify`: parameters of a body from its own curves, and what it refuses.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

use std::fmt::Write as _;
use std::path::Path;

use chaincell_tests::{Ended, files, run};

use super::quick::real;

const MESH: &str = "box:5x5x4x0.01";
const CONTACT: &str = "cells:box:-0.011,0.011,-0.011,0.011,0.029,0.031";

/// A curve of `run` itself: the tool goes up in small steps and rests at each.
fn curve(place: &Path) -> String {
    let options = ["--stiffness-n-per-m", "42", "--alpha", "0.05"];
    let model = files::bake(place, MESH, &options);
    let (path, out) = (place.join("path.csv"), place.join("run"));
    let (steps, rest) = (24_u64, 40_u64);
    let rows = (0..=steps * rest).map(|tick| {
        let step = tick.div_ceil(rest);
        (tick, [0.0, 0.0, 5e-4 * step as f32], 1)
    });
    files::write_path(&path, rows);
    let args = ["run", files::text(&model), "--path", files::text(&path), "--out"];
    let scene = [files::text(&out), "--contact", CONTACT, "--sweeps", "16"];
    run([&args[..], &scene[..]].concat()).with(0);
    let forces = files::Table::read(&out.join("force.csv"));
    let mut text = String::from("displacement_m,force_n\n");
    for step in 1..=steps {
        let row = &forces.rows[(step * rest) as usize];
        // A ripple of two percent stands for noise.
        let force = -row[3] * (1.0 + 0.02 * (2.7 * step as f64).sin());
        let _ = writeln!(text, "{},{force}", 5e-4 * step as f64);
    }
    text
}

/// Runs `identify` in a folder on one target.
fn identify(place: &Path, target: &str, options: &[&str]) -> Ended {
    let file = place.join("target.csv");
    std::fs::write(&file, target).unwrap();
    let (model, out) = (place.join("found.chaincell"), place.join("out"));
    let args = ["identify", MESH, "--target", files::text(&file), "-o", files::text(&model)];
    let mut all = [&args[..], &["--out", files::text(&out)], options].concat();
    for (option, otherwise) in [("--contact", CONTACT), ("--direction", "0,0,1")] {
        if !options.contains(&option) {
            all.extend([option, otherwise]);
        }
    }
    run(all)
}

#[test]
fn a_curve_gives_back_the_model_it_came_from() {
    let place = files::scratch();
    let target = curve(place.path());
    let found = identify(place.path(), &target, &["--json"]).with(0).json();
    let (k, alpha) = (real(&found, "/parameters/0/value"), real(&found, "/parameters/1/value"));
    assert!((k / 42.0 - 1.0).abs() < 0.05 && (alpha / 0.05 - 1.0).abs() < 0.05, "{found}");
    assert_eq!(found["parameters"][0]["determined"], true);
    assert_eq!(
        (real(&found, "/targets/0/rows"), real(&found, "/targets/0/rows_held_out")),
        (19.0, 5.0)
    );
    assert!(
        real(&found, "/targets/0/rms_residual_held_out") > 0.0
            && real(&found, "/evaluations") > 10.0
    );
    // The model holds what was found.
    let model = place.path().join("found.chaincell");
    let info = run(["info", files::text(&model), "--json"]).with(0).json();
    assert!((real(&info, "/stiffness_n_per_m") / k - 1.0).abs() < 1e-6, "{info}");
    assert!((real(&info, "/alpha") / alpha - 1.0).abs() < 1e-6, "{info}");
    let out = place.path().join("out");
    let residuals = std::fs::read_to_string(out.join("residuals.csv")).unwrap();
    assert_eq!(residuals.lines().count(), 25);
    for name in ["identified.json", "target1_force_displacement_fit.png"] {
        assert!(std::fs::metadata(out.join(name)).unwrap().len() > 100, "{name}");
    }
    let again = identify(place.path(), &target, &[]).with(2);
    assert!(again.err.contains("--force"), "{}", again.err);
    let said = identify(place.path(), &target, &["--force", "--group", "all=box:-1,1,-1,1,-1,1"]);
    assert!(said.with(0).out.contains("stiffness_n_per_m of all"));
}

/// A body of 5,000 Pa and 4 J/m^2 under a blade, and a search that begins elsewhere.
#[test]
fn a_blade_gives_back_the_toughness() {
    let place = files::scratch();
    let (mesh, blade) = ("box:9x7x5x0.005", "blade:0.06/0,0,0.7071068,0.7071068");
    let body = |young_pa: &'static str, toughness: &'static str| {
        let tissue =
            ["--young-pa", young_pa, "--poisson", "0.3", "--cuttable", "--cut-spare", "0.5"];
        [&tissue[..], &["--toughness-j-per-m2", toughness]].concat()
    };
    // Cut it.
    let model = files::bake(place.path(), mesh, &body("5000", "4"));
    let out = place.path().join("cut");
    let motion = ["--motion=press", "--touch-m=0,0,0.02", "--direction=0,0,-1", "--depth-m=0.01"];
    let scene = ["--tool", blade, "--seconds=1", "--sweeps=8", "--picture=off", "--out"];
    let args = [&["run", files::text(&model)][..], &motion, &scene, &[files::text(&out)]].concat();
    run(args).with(0);
    // Every tenth tick of the way in.
    let (forces, path) =
        ["force.csv", "path.csv"].map(|name| files::Table::read(&out.join(name))).into();
    let mut target = String::from("displacement_m,force_n\n");
    let mut deepest_m = 0.0;
    for (force, pose) in forces.rows.iter().zip(&path.rows) {
        let depth_m = 0.02 - pose[3];
        if depth_m > deepest_m + 4e-4 {
            deepest_m = depth_m;
            let _ = writeln!(target, "{depth_m},{}", force[3]);
        }
    }
    // Find it.
    let file = place.path().join("target.csv");
    std::fs::write(&file, target).unwrap();
    let (found, out) = (place.path().join("found.chaincell"), place.path().join("out"));
    let files =
        ["--target", files::text(&file), "-o", files::text(&found), "--out", files::text(&out)];
    let tool = ["--contact", blade, "--probe-at", "0,0,0.02", "--direction", "0,0,-1"];
    let args =
        [&["identify", mesh][..], &files, &tool, &body("5000", "40"), &["--fit", "toughness"]];
    let found = run([&args.concat()[..], &["--json"]].concat()).with(0).json();
    let toughness = &found["parameters"][1];
    assert_eq!(toughness["parameter"], "toughness_j_per_m2");
    let value = real(toughness, "/value");
    assert!((value / 4.0 - 1.0).abs() < 0.05, "{found}");
    assert_eq!(
        (&toughness["determined"], real(&found, "/blade_length_m")),
        (&true.into(), 0.06_f32.into())
    );
}

#[test]
fn bad_input_is_named_and_nothing_is_written() {
    let place = files::scratch();
    let good = "displacement_m,force_n\n0.001,0.1\n0.002,0.2\n0.003,0.3\n0.004,0.4\n0.005,0.5\n";
    let refused = |target: &str, options: &[&str], part: &str| {
        let ended = identify(place.path(), target, options).with(2);
        assert!(ended.err.contains(part), "{part}: {}", ended.err);
        assert!(!place.path().join("found.chaincell").exists());
    };
    refused("time,force\n", &[], "target.csv:1: the header is `time,force`");
    refused(&good.replace("0.003,0.3", "0.003,x"), &[], "target.csv:4: field force_n `x`");
    refused(&good.replace("0.003,0.3", "0.001,0.3"), &[], "target.csv:4: field displacement_m");
    refused(&good.replace("displacement_m", "time_s"), &[], "--displacement-m");
    refused(good, &["--direction", "0,0,0"], "--direction 0,0,0");
    refused(good, &["--group", "a=group:none"], "no group 'none'");
    refused(good, &["--group", "nodes:1"], "NAME=SELECTOR");
    refused(good, &["--group", "a=nodes:1,2", "--group", "b=nodes:2"], "node 2 is in a already");
    refused(good, &["--group", "a=nodes:1", "--group", "a=nodes:2"], "given twice");
    refused(good, &["--bounds", "alpha=0,2"], "--bounds alpha=0,2");
    refused(good, &["--bounds", "stiffness_n_per_m=5"], "give NAME=LOW,HIGH");
    refused(good, &["--hold-out", "0.9"], "--hold-out 0.9");
    refused(&good.replace("0.005", "50"), &[], "beyond the body's size");
    refused(good, &["--contact", "nodes:0"], "node 0 is fixed");
    refused(good, &["--contact", "probe:x"], "--contact probe:x: give the radius");
    refused(good, &["--probe-at", "0,0,0"], "--probe-at 0,0,0: there is no probe");
    refused(good, &["--contact", "probe:0.004", "--probe-at", "0,0"], "--probe-at 0,0: give three");
    refused(good, &["--fit", "stiffening"], "--fit: all that it names");
    let shapes = ["--young-pa", "5000"];
    let with = |more: &[&'static str]| [&shapes[..], more].concat();
    refused(good, &with(&["--fit", "half-width"]), "--fit: there is no band");
    refused(good, &with(&["--fit", "thickness"]), "--fit: thickness is that of a generated slab");
    refused(good, &with(&["--fit", "offset"]), "--fit: offset is where a probe met");
    refused(good, &with(&["--bounds", "young_pa=5,1"]), "--bounds young_pa=5,1");
    refused(good, &with(&["--fit", "toughness"]), "--fit: toughness is what a blade feels");
    refused(good, &with(&["--contact", "blade:0.06"]), "a blade cuts: add --cuttable");
    let values = place.path().join("toughness.txt");
    std::fs::write(&values, format!("2 {}", "8 ".repeat(99))).unwrap();
    let toughness = format!("file:{}", files::text(&values));
    let blade = ["--cuttable", "--contact", "blade:0.06", "--fit", "toughness"];
    let each = [&shapes[..], &blade, &["--toughness-j-per-m2", &toughness]].concat();
    refused(good, &each, "--fit: toughness is looked for as one value of the whole body");
    let two = "blade:0.06+sphere:0.01";
    refused(good, &with(&["--cuttable", "--contact", two]), "part 1 is a blade");
    refused(good, &["--direction", "0,0,1", "--direction", "0,1,0"], "2 of them for 1 targets");
    let quartiles = "displacement_m,force_n,q25_n,q75_n\n0.001,0.1,0.2,0.3\n0.002,0.2,0.1,0.3\n\
        0.003,0.3,0.2,0.4\n0.004,0.4,0.3,0.5\n0.005,0.5,0.4,0.6\n";
    refused(quartiles, &[], "target.csv:2: fields q25_n 0.2");
    let model = files::bake(place.path(), MESH, &[]);
    let file = place.path().join("target.csv");
    let args = ["identify", files::text(&model), "--target", files::text(&file)];
    let out = place.path().join("other");
    let ended = run([&args[..], &["-o", "x.chaincell", "--out", files::text(&out)]].concat());
    assert!(ended.with(2).err.contains("a baked model; give the mesh"));
}
