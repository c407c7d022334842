//! What `info --probe` says, against presses of `run`.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_tests::files::{Table, bake, scratch, text};
use chaincell_tests::run;
use serde_json::Value;

const BOX: &str = "box:7x7x5x0.01";

fn probe(model: &Path, radius_m: &str) -> Value {
    let args = ["info", text(model), "--probe", radius_m, "--json"];
    run(args).with(0).json()["probe"].clone()
}

/// Force \[N\] and flags in the middle of the hold of a press to this depth.
fn hold(model: &Path, out: &Path, radius_m: &str, depth_m: f64) -> (f64, u64) {
    let (contact, depth) = (format!("probe:{radius_m}"), depth_m.to_string());
    let args = ["run", text(model), "--motion", "press", "--seconds", "1", "--contact", &contact];
    let args = [&args[..], &["--depth-m", &depth, "--out", text(out), "--force"]].concat();
    run(args).with(0);
    let table = Table::read(&out.join("force.csv"));
    let force_n = table.vectors("fx_n")[570].iter().map(|x| x * x).sum::<f64>().sqrt();
    (force_n, table.whole("flags")[570])
}

/// Shallower nothing is shortened; deeper the sphere stays behind, and the force does not fall.
#[test]
fn the_depth_at_which_a_probe_is_held_back_is_that_of_a_press() {
    let folder = scratch();
    let options = ["--young-pa", "5000"];
    let model = bake(folder.path(), BOX, &options);
    let out = folder.path().join("out");
    let found = probe(&model, "0.004");
    let depth_m = found["behind_depth_m"].as_f64().unwrap();
    let force_n = found["behind_force_n"].as_f64().unwrap();
    assert_eq!(found["behind_by"], "depth");
    assert!(depth_m > 0.002 && depth_m < found["pressed_m"].as_f64().unwrap(), "{found}");
    assert!(found["behind_least_force_n"].as_f64().unwrap() > 0.9 * force_n, "{found}");
    assert_eq!(found["lost_depth_m"], Value::Null);
    // The hand trembles by a hundredth of the depth.
    let (shallow_n, flags) = hold(&model, &out, "0.004", 0.9 * depth_m);
    assert!(flags & 1 == 0 && shallow_n < force_n, "{shallow_n} N, flags {flags}");
    for times in [1.2, 1.8] {
        let (deep_n, flags) = hold(&model, &out, "0.004", times * depth_m);
        assert_eq!(flags & 1, 1, "{times}");
        assert!((deep_n / force_n - 1.0).abs() < 0.1, "{times}: {deep_n} N, {force_n} N");
    }
}

#[test]
fn samples_and_stiffness_are_those_of_the_triangles() {
    let folder = scratch();
    let options = ["--young-pa", "5000"];
    let model = bake(folder.path(), BOX, &options);
    // Triangles of two edges of 10 mm, or of three of 14 mm where a cube is cut: areas of 50 mm2 and
    // 87 mm2 at most. Samples stand 0.45 radii apart at most.
    let found = probe(&model, "0.004");
    assert_eq!(found["samples_per_side"], serde_json::json!([4, 4]), "{found}");
    assert_eq!(probe(&model, "0.02")["samples_per_side"], serde_json::json!([2, 2]));
    // 6 to 20 times E a / h: E a / h is 5000 Pa x 50 mm2 / 11.4 mm = 22 N/m.
    let [least, most] = [0, 1].map(|at| found["contact_stiffness_n_per_m"][at].as_f64().unwrap());
    assert!(least > 0.99 * 6.0 * 21.9 && most < 1.01 * 6.0 * 21.9, "{found}");
}

#[test]
fn an_image_without_a_contact_surface_says_what_to_do() {
    let folder = scratch();
    let model = bake(folder.path(), BOX, &["--contact-surface", "no"]);
    let err = run(["info", text(&model), "--probe", "0.004"]).with(2).err;
    assert!(err.contains("--probe 0.004") && err.contains("--contact-surface yes"), "{err}");
    for radius_m in ["0", "-1", "nan", "1000"] {
        let err = run(["info", text(&model), "--probe", radius_m]).with(2).err;
        assert!(err.contains("--probe") && err.contains("above 0 and at most"), "{err}");
    }
}
