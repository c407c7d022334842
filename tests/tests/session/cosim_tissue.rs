//! `cosim --tissue`: the default organ of another tissue, in both processes and in the replay.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use chaincell_host::bake::ORGAN_SIZE;
use chaincell_host::bake::tissue::KnownTissue;
use chaincell_tests::files::{bake, scratch, text};
use chaincell_tests::{run, turn};
use serde_json::Value;

/// Runs a session of a second of the organ of a tissue; returns its summary.
#[track_caller]
fn session(tissue: &str, out: &Path) -> Value {
    let args = ["cosim", "--tissue", tissue, "--seconds", "1", "--late-share", "off", "--json"];
    let found = run([&args[..], &["--out", text(out)]].concat()).with(0).json();
    assert_eq!((&found["ticks_sent"], &found["ticks_answered"]), (&1000.into(), &1000.into()));
    assert_eq!(found["state_hash"], found["replay_state_hash"]);
    found
}

/// The served model, which the session's folder holds, is the one that a bake makes of the same tissue.
#[test]
fn the_organ_is_made_of_the_tissue() {
    let _turn = turn();
    let folder = scratch();
    let out = folder.path().join("out");
    let found = session("muscle", &out);
    let spec = format!("organ:{ORGAN_SIZE}");
    let baked = bake(folder.path(), &spec, &["--tissue", "muscle"]);
    assert!(
        std::fs::read(out.join("model.chaincell")).unwrap() == std::fs::read(baked).unwrap(),
        "another model was served"
    );
    assert!(found["relaxed_j"].as_f64().unwrap() > 0.0, "{found}");
}

/// The tissue of a file reaches the session too, and one without branches relaxes nothing.
#[test]
fn the_organ_is_made_of_a_table() {
    let _turn = turn();
    let folder = scratch();
    let table = folder.path().join("own.csv");
    let liver = KnownTissue::find("liver").unwrap();
    std::fs::write(&table, KnownTissue { young_pa: 8000.0, ..liver }.table()).unwrap();
    let out = folder.path().join("out");
    let found = session(&format!("{}:liver", text(&table)), &out);
    let model = out.join("model.chaincell");
    let young_pa = run(["info", text(&model), "--json"]).with(0).json()["young_pa"].as_f64();
    assert!((young_pa.unwrap() - 8000.0).abs() < 1.0, "{young_pa:?}");
    assert!(found["relaxed_j"].is_null(), "{found}");
}

#[test]
fn a_tissue_beside_a_model_is_refused() {
    // A cosim holds the scene without a name, until it is refused too.
    let _turn = turn();
    let folder = scratch();
    let model = bake(folder.path(), "box:4x4x3x0.01", &["--young-pa", "5000"]);
    let out = folder.path().join("out");
    let args = ["cosim", "--out", text(&out), "--tissue"];
    for (rest, parts) in [
        (
            &["cervix", text(&model)][..],
            ["--tissue cervix: ", "bake its mesh with bake --tissue cervix"],
        ),
        (&["stone"], ["--tissue stone: there is none", "muscle, muscle_3"]),
        (&["none.csv:liver"], ["none.csv", "cannot read tissues"]),
    ] {
        let why = run([&args[..], rest].concat()).with(2).err;
        assert!(parts.iter().all(|part| why.contains(part)), "{rest:?}: {why}");
    }
    assert!(!out.exists());
}
