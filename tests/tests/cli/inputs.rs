//! No command removes or replaces a file that it reads, by whatever name it is given, or waits for one that
//! has no end.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use chaincell_tests::files::{bake, content, scratch, summary, text};
use chaincell_tests::{Ended, chaincell, run};

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

/// A named pipe into which nobody writes, a device without end and a folder are refused at once, wherever a
/// file is read; what a shell pipes into the command is read.
#[test]
fn what_is_no_file_is_refused_and_what_is_piped_is_read() {
    let (folder, model, out) = place();
    let pipe = folder.path().join("pipe");
    let mode = rustix::fs::Mode::RWXU;
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
    let (model, path, trace) = (text(&model), out.join("path.csv"), out.join("session.trace"));
    let other = folder.path().join("other");
    for (input, kind) in [
        (text(&pipe), "it is a named pipe: give a file"),
        ("/dev/zero", "it is a device: give a file"),
        (text(&out), "it is a folder: give a file"),
    ] {
        let of_file = format!("file:{input}");
        let cells = format!("cells:{of_file}");
        let baked = ["bake", "plane:5x5x0.01", "-o", text(&other)];
        for args in [
            &["info", input][..],
            &["serve", input],
            &["cosim", input],
            &["serve", model, "--restore", input],
            &["serve", model, "--contact", &cells],
            &["run", input, "--motion", "press", "--out", text(&other)],
            &["run", model, "--path", input, "--out", text(&other)],
            &["control", "--settings", input],
            &["control", "--path", input],
            &["replay", input, "--model", model],
            &["replay", text(&trace), "--model", input],
            &[&baked[..], &["--alpha", &of_file]].concat(),
            &[&baked[..], &["--fix", &of_file]].concat(),
            &["convert", input, text(&other)],
        ] {
            // A folder of results can be replayed.
            if args.starts_with(&["replay", text(&out)]) {
                continue;
            }
            let err = run(args).with(2).err;
            assert!(err.contains(kind) && err.contains(input), "{args:?}: {err}");
        }
        assert!(!other.exists(), "{input}");
    }
    for read in ["--path /dev/stdin < $0", "--path /dev/stdin < <(cat $0)", "--path <(cat $0)"] {
        let script = format!("exec $1 run $2 {read} --out $3 --force");
        let mut shell = Command::new("bash");
        shell.args(["-c", &script, text(&path)]).arg(chaincell().get_program());
        let ended = shell.args([model, text(&other)]).output().unwrap();
        assert!(ended.status.success(), "{read}: {}", String::from_utf8_lossy(&ended.stderr));
        assert_eq!(summary(&other)["state_hash"], summary(&out)["state_hash"], "{read}");
    }
}
