//! No command removes or replaces a file that it reads, by whatever name it is given.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs;
use std::path::{Path, PathBuf};

use chaincell_tests::files::{bake, content, scratch, text};
use chaincell_tests::{Ended, run};

/// A folder with a baked plane, and the results of a run in `out`.
fn place() -> (tempfile::TempDir, PathBuf, PathBuf) {
    let folder = scratch();
    let model = bake(folder.path(), "plane:5x5x0.01", &["--alpha", "0.02"]);
    let out = folder.path().join("out");
    let ran = ["run", text(&model), "--motion", "press", "--out", text(&out)];
    run(ran).with(0);
    (folder, model, out)
}

#[track_caller]
fn refused(ended: Ended) {
    let ended = ended.with(2);
    assert!(ended.err.contains("it is the input"), "{}", ended.err);
}

#[test]
fn a_run_keeps_the_path_that_it_reads_in_its_own_folder() {
    let (folder, model, out) = place();
    let (model, path) = (text(&model), out.join("path.csv"));
    let before = content(&out);
    let (beside, linked, hard) = (
        folder.path().join("link.csv"),
        folder.path().join("linked"),
        folder.path().join("hard.csv"),
    );
    std::os::unix::fs::symlink(&path, &beside).unwrap();
    std::os::unix::fs::symlink(&out, &linked).unwrap();
    fs::hard_link(&path, &hard).unwrap();
    let roundabout = out.join("../out/./path.csv");
    for name in [&path, &beside, &hard, &roundabout, &linked.join("path.csv")] {
        for to in [&out, &linked, &out.join("../out")] {
            refused(run(["run", model, "--path", text(name), "--out", text(to), "--force"]));
            assert_eq!(content(&out), before);
        }
    }
    let own_model = out.join("model.chaincell");
    let again = ["run", text(&own_model), "--path", text(&hard)];
    refused(run([&again[..], &["--out", text(&out), "--force"]].concat()));
    assert_eq!(content(&out), before);
    // A link to the input may go: the input is elsewhere.
    let other = folder.path().join("other");
    fs::create_dir(&other).unwrap();
    std::os::unix::fs::symlink(&path, other.join("path.csv")).unwrap();
    let to_other = ["--path", text(&path), "--out", text(&other), "--force"];
    run([&["run", model][..], &to_other].concat()).with(0);
    assert_eq!(content(&out), before);
}

#[test]
fn no_output_stands_in_the_place_of_an_input() {
    let (folder, model, out) = place();
    let (model, trace, path) = (text(&model), out.join("session.trace"), out.join("path.csv"));
    let before = content(&out);
    let second = folder.path().join("second");
    let to = |place: &Path| {
        let args = ["run", model, "--path", text(&path), "--out", text(&second), "--force"];
        run([&args[..], &["--trace", text(place)]].concat())
    };
    refused(to(&path));
    let own = out.join("model.chaincell");
    let serve = |options: &[&str]| {
        let scene = chaincell_tests::scene("inputs");
        let args = ["serve", text(&own), "--scene", &scene, "--seconds", "0.1"];
        run([&args[..], options].concat())
    };
    refused(serve(&["--out", text(&out), "--force"]));
    refused(serve(&["--record", text(&out.join("model.chaincell")), "--force"]));
    refused(run(["cosim", text(&out.join("model.chaincell")), "--out", text(&out), "--force"]));
    assert_eq!(content(&out), before);
    run(["replay", text(&trace)]).with(0);
}
