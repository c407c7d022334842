//! `--pin` of a run: the pin bears the press, and is in its files and its trace.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_tests::files::{Table, bake, scratch, text};
use chaincell_tests::{Ended, run};

/// A press of the built-in motion.
fn press(model: &Path, out: &Path, options: &[&str]) -> Ended {
    let args = ["run", text(model), "--motion", "press", "--seconds", "0.1", "--out", text(out)];
    let always = ["--depth-m", "0.004", "--force", "--json", "--picture", "off"];
    let place = ["--touch-m=0,0,0.0381", "--direction=0,0,-1"];
    run([&args[..], &always, &place, options].concat())
}

#[test]
fn a_pinned_run_has_the_forces_of_its_pins_and_is_replayed() {
    let folder = scratch();
    let model = bake(folder.path(), "box:9x9x4x0.01", &["--young-pa", "5000"]);
    let out = folder.path().join("out");
    let tool = ["--tool", "sphere:0.008"];
    let free = press(&model, &out, &tool).with(0).json();
    assert!(free.get("pins").is_none() && !out.join("pins.csv").exists(), "{free}");
    let again = folder.path().join("again.csv");
    let replay = ["replay", text(&out), "--pin-forces", text(&again), "--json"];
    assert!(run(replay).with(0).err.contains("the table of --pin-forces is empty"));
    assert!(Table::read(&again).rows.is_empty());
    let pins = ["--pin", "0.012,0,0.03,0.006", "--pin", "-0.02,0,0.03,0.006,30"];
    let pinned = press(&model, &out, &[&tool[..], &pins].concat()).with(0).json();
    assert_ne!(pinned["state_hash"], free["state_hash"]);
    let largest_n = |at: usize| pinned["pins"][at]["largest_force_n"].as_f64().unwrap();
    assert!(largest_n(0) > 0.01 && largest_n(1) > 1e-5, "{pinned}");
    let stiffness = pinned["pins"][1]["stiffness_n_per_m"].as_f64().unwrap();
    assert!((stiffness - 30.0).abs() < 1e-3, "{pinned}");
    let rows = Table::read(&out.join("pins.csv"));
    assert_eq!(rows.whole("pin").len(), 2 * pinned["ticks"].as_u64().unwrap() as usize);
    let forces = rows.vectors("fx_n");
    let norm = |force: &[f64; 3]| force.iter().map(|x| x * x).sum::<f64>().sqrt();
    let largest = forces.iter().step_by(2).map(norm).fold(0.0, f64::max);
    assert!((largest - largest_n(0)).abs() < 1e-5 * largest, "{largest} {pinned}");
    let replayed = run(replay).with(0).json();
    assert_eq!(replayed["state_hash"], pinned["state_hash"]);
    // A replay has the same forces, bit for bit.
    assert_eq!(replayed["pins"], pinned["pins"]);
    let read = |path: &Path| std::fs::read(path).unwrap();
    assert!(read(&again) == read(&out.join("pins.csv")), "the forces of pins differ");
    let own = out.join("session.trace");
    let refused = run(["replay", text(&out), "--pin-forces", text(&own)]).with(2).err;
    assert!(refused.contains("it is the input"), "{refused}");
    let other = out.join("summary.json");
    let refused = run(["replay", text(&out), "--pin-forces", text(&other)]).with(2).err;
    assert!(refused.contains("no table of pins"), "{refused}");
    assert_eq!(replayed["commands"], 2);
    let page = out.join("page.html");
    run(["view", text(&out), "--html", text(&page)]).with(0);
    for (options, wanted) in [
        (&["--pin", "0,0,0.03"][..], "as in 0,0,0.04,0.006"),
        (&["--pin", "0,0,0.03,0"], "must be above 0"),
        (&["--pin", "0,0,0.03,0.01,-3"], "at least 1e-6 N/m"),
        (&["--pin", "0,0,0.3,0.01"], "move the point, or take a larger radius"),
        (&["--pin", "0,0,0.03,9", "--pin", "0,0,0.03,9"], "take a smaller radius"),
    ] {
        let err = press(&model, &out, &[&tool[..], options].concat()).with(2).err;
        assert!(err.contains(wanted), "{options:?}: {err}");
    }
    let err = press(&model, &out, &pins[..2]).with(2).err;
    assert!(err.contains("pass --contact probe:RADIUS or --tool"), "{err}");
}
