//! Where results go: folders that are taken, refused or full, and readers that have gone away.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::io::Write;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;
use std::process::{Command, Stdio};

use chaincell_tests::files::{bake, content, names, scratch, text};
use chaincell_tests::process::{SHORT, unshared};
use chaincell_tests::{Running, chaincell, run};

use super::place::Place;

const FILES: [&str; 9] = [
    "cells_final.csv",
    "final.vtu",
    "force.csv",
    "force.svg",
    "force_depth.svg",
    "model.chaincell",
    "picture.png",
    "session.trace",
    "summary.json",
];

#[test]
fn a_folder_with_content_is_kept_unless_forced() {
    let place = Place::new();
    let out = place.folder.path().join("a/b");
    run(place.run_into(&out)).with(0);
    assert_eq!(names(&out), FILES);
    place.refuses_into(&out, &[], &["--out", "not empty", "--force"]);
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    std::fs::write(out.join("cells_99.csv"), "of an earlier run").unwrap();
    run([&place.run_into(&out)[..], &["--force"]].concat()).with(0);
    assert_eq!(std::fs::read(out.join("notes.txt")).unwrap(), b"mine");
    assert!(!out.join("cells_99.csv").exists());
}

#[test]
fn a_refused_run_makes_no_folder_and_a_forced_one_removes_nothing() {
    let place = Place::new();
    let out = place.folder.path().join("out");
    place.refuses_into(&out, &["--contact", "0"], &["node 0 is fixed"]);
    assert!(!out.exists());
    run(place.run_into(&out)).with(0);
    place.refuses_into(&out, &["--force", "--sweeps", "0"], &["--sweeps"]);
    place.refuses_into(&out, &["--force", "--snapshot-ticks", "7"], &["--snapshot-ticks"]);
}

#[test]
fn places_where_no_folder_can_be() {
    let place = Place::new();
    let file = place.folder.path().join("file");
    std::fs::write(&file, "mine").unwrap();
    place.refuses_into(&file, &[], &["cannot create folder", text(&file)]);
    let there = ["cannot create folder", text(&file), "a file is there: name a folder"];
    place.refuses_into(&file, &["--force"], &there);
    place.refuses_into(&file.join("below"), &[], &["cannot create folder", text(&file)]);
    place.refuses_into(Path::new("/proc/none"), &[], &["cannot create folder /proc/none"]);
    place.refuses_into(Path::new(""), &[], &["--out <DIR>"]);
    let model = text(&place.model);
    let scene = chaincell_tests::scene("places");
    for command in [&["serve", model][..], &["cosim", model, "--seconds", "0.02"]] {
        let args = [command, &["--scene", &scene, "--out", text(&file)]].concat();
        assert!(run(args).with(2).err.contains("cannot create folder"));
    }
}

#[test]
fn a_model_in_an_impossible_place() {
    let place = Place::new();
    let folder = place.folder.path();
    let before = content(folder);
    for output in [folder.join("none/model"), folder.to_owned(), "/proc/none".into()] {
        let ended = run(["bake", "plane:3x3x0.01", "-o", text(&output)]).with(2);
        assert!(ended.err.contains("cannot write"), "{}", ended.err);
    }
    assert!(content(folder) == before);
}

#[test]
fn a_model_never_takes_the_place_of_a_device_or_a_socket() {
    let folder = scratch();
    let socket = folder.path().join("socket");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    let ended = run(["bake", "plane:3x3x0.01", "-o", text(&socket)]).with(2);
    assert!(ended.err.contains(text(&socket)), "{}", ended.err);
    assert!(std::fs::symlink_metadata(&socket).unwrap().file_type().is_socket());
    let device = folder.path().join("device");
    // What /dev/full is, in a place of its own.
    let made = Command::new("mknod").args([text(&device), "c", "1", "7"]).output();
    if !made.is_ok_and(|made| made.status.success()) {
        println!("SKIPPED the device: no right to make one");
        return;
    }
    run(["bake", "plane:3x3x0.01", "-o", text(&device)]).with(2);
    assert!(std::fs::symlink_metadata(&device).unwrap().file_type().is_char_device());
    assert_eq!(names(folder.path()), ["device", "socket"]);
}

#[test]
fn an_existing_model_is_replaced_whole() {
    let folder = scratch();
    let model = bake(folder.path(), "plane:5x5x0.01", &[]);
    let first = std::fs::read(&model).unwrap();
    run(["bake", "plane:5x5x0.01", "-o", text(&model), "--alpha", "2"]).with(2);
    assert_eq!(std::fs::read(&model).unwrap(), first);
    bake(folder.path(), "plane:7x7x0.01", &[]);
    assert_ne!(std::fs::read(&model).unwrap(), first);
    bake(folder.path(), "plane:5x5x0.01", &[]);
    assert_eq!(std::fs::read(&model).unwrap(), first, "the same mesh gives the same image");
}

/// Runs a shell script with the binary as `$0` and the arguments as `$@`.
fn script(text: &str, args: &[&str]) -> chaincell_tests::Ended {
    let binary = chaincell().get_program().to_owned();
    Running::start(Command::new("sh").args(["-c", text]).arg(binary).args(args)).end(SHORT)
}

#[test]
fn files_that_cannot_grow_leave_nothing_half_written() {
    let place = Place::new();
    let folder = place.folder.path();
    let before = content(folder);
    // A limit of a few hundred bytes a file stands in for a full disk.
    let limited = "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\"";
    let large = folder.join("large.chaincell");
    let ended = script(limited, &["bake", "plane:30x30x0.01", "-o", text(&large)]).with(2);
    assert!(ended.err.contains("cannot write") && ended.err.contains(text(&large)));
    assert!(content(folder) == before, "a part of the model was left behind");
    let out = folder.join("out");
    let ended = script(limited, &place.run_into(&out)).with(2);
    assert!(ended.err.contains("cannot write"), "{}", ended.err);
    for name in names(&out) {
        assert!(FILES.contains(&name.as_str()), "{name} was left behind");
    }
}

#[test]
fn a_full_file_system() {
    let folder = scratch();
    let lines = "mkdir disk && mount -t tmpfs -o size=16k none disk || exit 99; \
        \"$chaincell\" \"$@\"; code=$?; ls -A disk; exit $code";
    let bake = ["bake", "plane:40x40x0.01", "-o", "disk/model.chaincell"];
    let Some(mut command) = unshared("a_full_file_system", folder.path(), lines) else { return };
    let ended = Running::start(command.args(bake)).end(SHORT).with(2);
    assert!(ended.err.contains("cannot write disk/model.chaincell"), "{}", ended.err);
    assert_eq!(ended.out, "", "left behind");
}

/// Standard output whose reader has gone away.
fn closed_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

#[test]
fn a_reader_that_has_gone_away_is_no_error() {
    let place = Place::new();
    let (out, other) = (place.folder.path().join("out"), place.folder.path().join("other"));
    let run_args = place.run_into(&out);
    let model = text(&place.model);
    for args in [
        &["info", model][..],
        &["info", model, "--json"],
        &["bake", "plane:3x3x0.01", "-o", text(&other)],
        &run_args,
        &["--help"],
    ] {
        let ended = chaincell().args(args).stdin(Stdio::null()).stdout(closed_pipe()).output();
        let ended = ended.unwrap();
        let err = String::from_utf8_lossy(&ended.stderr);
        assert!(!err.contains("panicked"), "{args:?}: {err}");
        assert_eq!(ended.status.code(), Some(0), "{args:?}: {err}");
    }
    assert_eq!(names(&out), FILES);
    // With nobody to hear of it the exit code still tells.
    let mut command = chaincell();
    command.args(["info", "none"]).stdin(Stdio::null());
    let status = command.stdout(closed_pipe()).stderr(closed_pipe()).status().unwrap();
    assert_eq!(status.code(), Some(2));
}

#[test]
fn a_full_standard_output_is_an_error() {
    let place = Place::new();
    let mut full = match std::fs::OpenOptions::new().write(true).open("/dev/full") {
        Ok(full) if (&full).write_all(b"x").is_err() => full,
        _ => {
            println!("SKIPPED a_full_standard_output_is_an_error: no /dev/full");
            return;
        }
    };
    full.flush().unwrap();
    let mut command = chaincell();
    let ended = command.args(["info", text(&place.model)]).stdout(full).output().unwrap();
    let err = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(2), "{err}");
    assert!(err.contains("standard output") && !err.contains("panicked"), "{err}");
}
