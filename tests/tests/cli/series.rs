//! Snapshots of `run` as a series of bodies for `ParaView`.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_tests::files::{array, bake, names, scratch, summary, text};
use chaincell_tests::lattice::positions;
use chaincell_tests::run;

use super::run::check_vtu;

/// Time \[s\] and file of each row of a collection.
fn rows(file: &Path) -> Vec<(f64, String)> {
    let collection = std::fs::read_to_string(file).unwrap();
    assert!(collection.contains("<VTKFile type=\"Collection\""));
    let value = |row: &str, name: &str| {
        row.split(&format!("{name}=\"")).nth(1).unwrap().split('"').next().unwrap().to_owned()
    };
    let rows = collection.lines().filter(|row| row.starts_with("<DataSet "));
    rows.map(|row| (value(row, "timestep").parse().unwrap(), value(row, "file"))).collect()
}

#[test]
fn every_snapshot_is_a_body_in_time() {
    for (spec, elements, corners) in [("plane:4x5x0.01", 24, 3), ("box:3x3x4x0.01", 60, 4)] {
        let folder = scratch();
        let model = bake(folder.path(), spec, &[]);
        let out = folder.path().join("out");
        let args = ["run", text(&model), "--motion", "press", "--seconds", "0.2"];
        let which = ["--snapshot-every", "80", "--snapshot-ticks", "7,80", "--out", text(&out)];
        run([&args[..], &which].concat()).with(0);
        let found = rows(&out.join("series.pvd"));
        let ticks = [0, 7, 80, 160];
        let expected = ticks.map(|tick| (f64::from(tick) / 1000.0, format!("state_{tick}.vtu")));
        assert_eq!(found, expected);
        let of_bodies = names(&out).into_iter().filter(|name| name.starts_with("state_"));
        assert_eq!(of_bodies.count(), ticks.len());
        assert_eq!(summary(&out)["snapshot_ticks"], serde_json::json!(ticks));
        for tick in ticks {
            let file = out.join(format!("state_{tick}.vtu"));
            check_vtu(&file, elements, corners);
            let vtu = std::fs::read_to_string(&file).unwrap();
            let nodes = array(&vtu, "node");
            let places = array(&vtu, "position_m");
            let moved = array(&vtu, "displacement_m");
            let at = positions(&out.join(format!("cells_{tick}.csv")));
            for (point, node) in nodes.iter().enumerate() {
                assert_eq!(places[3 * point..3 * point + 3], at[*node as usize], "tick {tick}");
            }
            let farthest = moved.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            assert_eq!(farthest > 1e-3, tick >= 80, "tick {tick}: {farthest} m");
        }
    }
}

#[test]
fn counts_that_are_none_or_too_many_are_refused() {
    let folder = scratch();
    let model = bake(folder.path(), "plane:3x3x0.01", &[]);
    let out = folder.path().join("out");
    let ran = |options: &[&str]| {
        let args = ["run", text(&model), "--motion", "press", "--out", text(&out)];
        run([&args, options].concat())
    };
    for (options, named) in [
        (&["--snapshot-every", "0"][..], "--snapshot-every"),
        (&["--snapshot-every", "9"], "1112 snapshots: at most 1000"),
        (&["--snapshot-every", "9"], "--snapshot-every 10 or more"),
        (
            &["--snapshot-ticks", "10000"],
            "--snapshot-ticks 10000: the path has the ticks 0 to 9999",
        ),
    ] {
        let err = ran(options).with(2).err;
        assert!(err.contains(named), "{options:?}: {err}");
    }
    assert!(!out.exists());
    // Of an earlier run nothing stays.
    ran(&["--seconds", "0.05", "--snapshot-every", "25"]).with(0);
    assert!(names(&out).contains(&"state_25.vtu".to_owned()));
    ran(&["--seconds", "0.05", "--force"]).with(0);
    assert!(names(&out).iter().all(|name| !name.starts_with("state_") && name != "series.pvd"));
}
