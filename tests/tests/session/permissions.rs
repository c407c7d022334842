//! Who may connect to a scene, and what a message can't do.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use chaincell_tests::files::{content, text};
use chaincell_tests::outsider::tools::Poses;
use chaincell_tests::outsider::{Commander, Order, Outsider, Pose, Reply, Viewer};
use chaincell_tests::place::Place;
use chaincell_tests::process::{SHORT, copied};
use chaincell_tests::{Running, chaincell, run, turn};
use iceoryx2::prelude::*;

/// User and group that own nothing.
const NOBODY: u32 = 65_534;
/// Reading, writing or executing by anybody but the owner.
const FOREIGN: u32 = 0o077;

/// `chaincell` with a umask that takes no right from anybody.
fn with_open_umask(args: &[&str]) -> Command {
    let mut shell = Command::new("sh");
    shell.args(["-c", "umask 000; exec \"$0\" \"$@\""]).arg(chaincell().get_program()).args(args);
    shell.env_remove("CHAINCELL_LOG").env_remove("IOX2_LOG_LEVEL");
    shell
}

fn serve_args<'a>(place: &'a Place, options: &[&'a str]) -> Vec<&'a str> {
    let args = ["serve", text(&place.model), "--scene", &place.scene, "--contact", "40", "--json"];
    [&args, options].concat()
}

/// Files of iceoryx2 that a process has open or mapped.
fn shared_files(pid: u32) -> BTreeSet<PathBuf> {
    let open = fs::read_dir(format!("/proc/{pid}/fd")).unwrap();
    let open = open.filter_map(|entry| fs::read_link(entry.unwrap().path()).ok());
    let maps = fs::read_to_string(format!("/proc/{pid}/maps")).unwrap();
    let mapped = maps.lines().filter_map(|line| line.split_whitespace().nth(5).map(PathBuf::from));
    let all = open.chain(mapped);
    all.filter(|path| path.starts_with("/dev/shm") || path.starts_with("/tmp/iceoryx2")).collect()
}

// REQ-COS-07
#[test]
fn every_file_of_a_scene_is_its_owners_alone() {
    let _turn = turn();
    let place = Place::new("owner");
    let mut serve = Running::start(&mut with_open_umask(&serve_args(&place, &[])));
    serve.wait_for_line("ready");
    let seconds = ["control", "--scene", &place.scene, "--seconds", "60"];
    let control = Running::start(&mut with_open_umask(&seconds));
    let viewer = Viewer::join(&place.scene);
    Outsider::join(&place.scene, false).after(100);
    let _ = viewer.after(100);
    let files: BTreeSet<PathBuf> =
        [serve.id(), control.id()].into_iter().flat_map(shared_files).collect();
    let user = fs::metadata(&place.model).unwrap().uid();
    for kind in ["data", "connection", "dynamic", "service"] {
        assert!(
            files.iter().any(|path| path.extension().is_some_and(|found| found == kind)),
            "no file of the kind {kind}: {files:?}"
        );
    }
    for path in &files {
        let found = fs::metadata(path).unwrap();
        assert_eq!(found.mode() & FOREIGN, 0, "{}: {:o}", path.display(), found.mode());
        assert_eq!(found.uid(), user, "{}", path.display());
        assert!(!found.file_type().is_socket() && !found.file_type().is_fifo());
    }
    for folder in ["", "nodes", "services"] {
        let found = fs::metadata(Path::new("/tmp/iceoryx2").join(folder)).unwrap();
        assert_eq!(found.mode() & 0o027, 0, "{folder}: {:o}", found.mode());
        assert_eq!(found.uid(), user);
    }
    // The one word that is open to all counts nodes, and no running program has it.
    for entry in fs::read_dir("/dev/shm").unwrap() {
        let path = entry.unwrap().path();
        let Ok(found) = fs::metadata(&path) else { continue };
        let ours = found.uid() == user && text(&path).contains("/iox2_");
        if ours && found.mode() & FOREIGN != 0 {
            assert!(text(&path).ends_with(".global_mgmt"), "{}", path.display());
            assert!(found.len() <= 16 && !files.contains(&path));
        }
    }
    control.interrupt().with(130);
    serve.interrupt().with(130);
}

/// A copy of the command and of the model that everybody may read.
fn readable_by_all(place: &Place) -> (PathBuf, PathBuf) {
    let (program, model) = (copied(place.folder.path()), place.model.clone());
    for (path, mode) in [(place.folder.path(), 0o755), (&program, 0o755), (&model, 0o644)] {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }
    (program, model)
}

/// Runs a program as a user that owns nothing.
pub(super) fn as_nobody(program: &Path, args: &[&str]) -> chaincell_tests::Ended {
    let mut command = Command::new(program);
    command.args(args).uid(NOBODY).gid(NOBODY).current_dir("/");
    Running::start(&mut command).end(SHORT)
}

// REQ-COS-07
#[test]
fn another_user_is_refused_and_disturbs_nothing() {
    if !rustix::process::geteuid().is_root() {
        println!("SKIPPED another_user_is_refused_and_disturbs_nothing: not root");
        return;
    }
    let _turn = turn();
    let place = Place::new("nobody");
    let (program, model) = readable_by_all(&place);
    let serve = place.serve(&["--ticks", "3000", "--json"]);
    let control = Running::start(&mut place.control(&["--seconds", "3"]));
    Outsider::join(&place.scene, false).after(100);
    let scene = ["--scene", &place.scene];
    for args in [
        &["control", "--seconds", "0.1"][..],
        &["serve", text(&model), "--seconds", "0.1"],
        &["state", "--once"],
        &["command", "pause"],
    ] {
        let (name, options) = args.split_first().unwrap();
        let args = [&[*name], &scene[..], options].concat();
        let ended = as_nobody(&program, &args).with(2);
        for part in ["/tmp/iceoryx2", "only its owner may connect"] {
            assert!(ended.err.contains(part), "{args:?}: {}", ended.err);
        }
    }
    // Nor by hand: no message can be read or written, no file replaced.
    let by_hand = "for f in /dev/shm/iox2_*.data /dev/shm/iox2_*.connection \
                   /dev/shm/iox2_*.dynamic /tmp/iceoryx2 /tmp/iceoryx2/*; do \
                   if [ -r $f ] || [ -w $f ]; then echo \"open: $f\"; fi; done; \
                   mv /tmp/iceoryx2 /tmp/iceoryx2-taken 2>/dev/null && echo moved; true";
    let ended = as_nobody(Path::new("/bin/sh"), &["-c", by_hand]).with(0);
    assert_eq!(ended.out, "", "{}", ended.out);
    let sent = control.end(SHORT).with(0).json();
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&sent["ticks_answered"], &served["ticks_executed"]), (&3000.into(), &3000.into()));
    for key in ["poses_refused", "poses_repeated", "commands_done", "commands_refused"] {
        assert_eq!(served[key], 0, "{key}");
    }
    assert_eq!(served["publishers"], 1);
}

// REQ-COS-07
#[test]
fn a_configuration_in_the_working_folder_changes_nothing() {
    let _turn = turn();
    let hostile = "[global]\nroot-path = '/tmp/chaincell-hostile'\nprefix = 'evil_'\n\
                   [defaults.publish-subscribe]\nmax-subscribers = 1\n";
    for text_of_file in [hostile, "][ no configuration"] {
        let place = Place::new("config");
        let cwd = place.folder.path();
        fs::create_dir(cwd.join("config")).unwrap();
        let file = cwd.join("config/iceoryx2.toml");
        fs::write(&file, text_of_file).unwrap();
        // A program that reads it is led astray, or fails.
        let read = Config::from_file(&FilePath::new(text(&file).as_bytes()).unwrap());
        let astray = read.map_or(String::new(), |config| config.global.root_path().to_string());
        assert_eq!(astray == "/tmp/chaincell-hostile", text_of_file == hostile, "{astray}");
        let mut command = chaincell();
        command.args(serve_args(&place, &["--ticks", "1"])).current_dir(cwd).env("HOME", cwd);
        let mut serve = Running::start(&mut command);
        serve.wait_for_line("ready");
        // A program with the built-in configuration meets it.
        let outsider = Outsider::join(&place.scene, true);
        outsider.send(Pose { tick: 7, ..Pose::default() });
        assert_eq!(outsider.receive().tick, 7);
        let ended = serve.end(SHORT).with(0);
        assert_eq!(ended.err, "");
        assert!(!Path::new("/tmp/chaincell-hostile").exists());
        let evil = fs::read_dir("/dev/shm").unwrap().map(|entry| entry.unwrap().file_name());
        assert!(evil.into_iter().all(|name| !name.to_string_lossy().starts_with("evil_")));
    }
}

/// Poses with more behind them, under the same type name.
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[type_name("chaincell.ToolPoses.v2")]
#[repr(C)]
struct LongPoses {
    words: [u64; 64],
}

/// A command with more behind it, under the same type name.
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[type_name("chaincell.Command.v2")]
#[repr(C)]
struct LongOrder {
    words: [u32; 1024],
}

/// The command of the releases before, without a place.
#[derive(Debug, Clone, Copy, ZeroCopySend)]
#[type_name("chaincell.Command.v1")]
#[repr(C)]
struct OldOrder {
    words: [u32; 4],
}

fn node() -> Node<ipc::Service> {
    NodeBuilder::new()
        .config(&Config::default())
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .unwrap()
}

fn service_name(place: &Place, topic: &str) -> ServiceName {
    format!("chaincell/{}/{topic}", place.scene).as_str().try_into().unwrap()
}

// REQ-COS-07
#[test]
fn messages_of_other_sizes_are_refused() {
    let _turn = turn();
    let place = Place::new("sizes");
    let serve = place.serve(&["--ticks", "1", "--json"]);
    let node = node();
    for topic in ["tools", "forces", "state"] {
        let service = || node.service_builder(&service_name(&place, topic));
        assert_eq!(service().publish_subscribe::<Poses>().open().is_ok(), topic == "tools");
        assert!(service().publish_subscribe::<LongPoses>().open().is_err(), "{topic}");
        assert!(service().publish_subscribe::<[Poses]>().open().is_err(), "{topic}");
        assert!(service().publish_subscribe::<[u8]>().open().is_err(), "{topic}");
        assert!(service().publish_subscribe::<u64>().open().is_err(), "{topic}");
    }
    let command = || node.service_builder(&service_name(&place, "command"));
    assert!(command().request_response::<Order, Reply>().open().is_ok());
    assert!(command().request_response::<Order, LongOrder>().open().is_err());
    assert!(command().request_response::<LongOrder, Reply>().open().is_err());
    assert!(command().request_response::<OldOrder, Reply>().open().is_err());
    assert!(command().request_response::<[Order], [u64]>().open().is_err());
    assert!(command().request_response::<[u8], [u8]>().open().is_err());
    let outsider = Outsider::join(&place.scene, true);
    outsider.send(Pose { tick: 1, ..Pose::default() });
    assert_eq!(outsider.receive().tick, 1);
    assert_eq!(serve.end(SHORT).with(0).json()["ticks_executed"], 1);
}

/// A program of a release before holds the service of commands: the refusal names both types and what to end.
// REQ-COS-07
#[test]
fn commands_of_another_release_are_refused_with_both_names() {
    let place = Place::new("old-command");
    let node = node();
    let old = node.service_builder(&service_name(&place, "command"));
    let _old = old.request_response::<OldOrder, Reply>().create().unwrap();
    let scene = ["--scene", &place.scene];
    let serve = ["serve", text(&place.model), "--contact", "40"];
    for refused in [
        run([&["command"], &scene[..], &["reset"]].concat()).with(2).err,
        run([&serve[..], &scene].concat()).with(2).err,
    ] {
        for part in [
            "carries chaincell.Command.v1 of 16 bytes",
            "speaks chaincell.Command.v2 of 32 bytes",
            "of another release",
        ] {
            assert!(refused.contains(part), "no {part}: {refused}");
        }
    }
}

// REQ-COS-07
#[test]
fn poses_beyond_the_rate_are_counted_and_not_executed() {
    let _turn = turn();
    let place = Place::new("rate");
    // A token a second: what is executed is the bucket and a few more.
    let args = ["--watchdog-ms", "0", "--json", "--max-pose-hz", "1"];
    let serve = place.serve(&args);
    let outsider = Outsider::join(&place.scene, true);
    let mut answered = 0;
    let began = std::time::Instant::now();
    for tick in 1..=1000 {
        outsider.send(Pose { tick, ..Pose::default() });
        assert_eq!(outsider.receive().tick, tick);
        answered += 1;
    }
    for tick in 1001..=2000 {
        outsider.send(Pose { tick, ..Pose::default() });
    }
    // The queue holds 1,024, so that none was lost on the way.
    std::thread::sleep(Duration::from_millis(500));
    while outsider.try_receive().is_some() {
        answered += 1;
    }
    let refilled = began.elapsed().as_secs() + 1;
    let served = serve.interrupt().with(130).json();
    let count = |key: &str| served[key].as_u64().unwrap();
    assert_eq!(count("ticks_executed") + count("poses_throttled"), 2000);
    assert_eq!(count("ticks_executed"), answered);
    assert!((1024..=1024 + refilled).contains(&answered), "{answered}");
    let bad = run(serve_args(&place, &["--max-pose-hz", "1000001"])).with(2);
    assert!(bad.err.contains("--max-pose-hz"), "{}", bad.err);
}

/// Everything that the messages' numbers can say.
fn hostile_session(scene: &str) {
    let commander = Commander::join(scene);
    let outsider = Outsider::join(scene, true);
    let path = u32::from_le_bytes(*b"/etc");
    for kind in [0, 1, 2, 3, 4, 5, 10, path, u32::MAX] {
        for (parameter, value) in
            [(0, 0.0), (1, f32::NAN), (2, f32::INFINITY), (4, -1.0), (path, f32::from_bits(path))]
        {
            let order = Order { kind, parameter, value, ..Order::default() };
            let _ = commander.order(order);
            let _ = commander.order(Order { point_m: [value; 3], radius_m: value, ..order });
        }
        let order = Order { kind, parameter: 1, value: 3.0, reserved: path, ..Order::default() };
        let _ = commander.order(order);
    }
    let _ = commander.order(Order { kind: 3, ..Order::default() });
    let bits = f32::from_bits(path);
    for (tick, z, engaged) in
        [(1, f32::NAN, 1), (2, f32::MAX, 1), (3, bits, path), (4, 0.0, 7), (5, 1e30, 1)]
    {
        outsider.send(Pose { tick, position_m: [z, bits, z], engaged });
        assert_eq!(outsider.receive().tick, tick);
        // Refused: its tick is far beyond the last one.
        outsider.send(Pose { tick: u64::MAX, position_m: [z, bits, z], engaged });
    }
}

/// Files that a process has open, but for those of iceoryx2.
fn own_files(pid: u32) -> BTreeSet<PathBuf> {
    let open = fs::read_dir(format!("/proc/{pid}/fd")).unwrap();
    let open = open.filter_map(|entry| fs::read_link(entry.unwrap().path()).ok());
    open.filter(|path| path.is_file())
        .filter(|path| !path.starts_with("/dev/shm") && !path.starts_with("/tmp/iceoryx2"))
        .collect()
}

// REQ-COS-07
#[test]
fn no_message_reaches_a_file() {
    let _turn = turn();
    let mut results = Vec::new();
    for hostile in [false, true] {
        let place = Place::new("files");
        let cwd = place.folder.path().join("cwd");
        fs::create_dir(&cwd).unwrap();
        let mut command = chaincell();
        let args = serve_args(&place, &["--out", "out", "--watchdog-ms", "0"]);
        command.args(args).current_dir(&cwd);
        let mut serve = Running::start(&mut command);
        serve.wait_for_line("ready");
        let model = fs::read(&place.model).unwrap();
        let names = |folder: &Path| -> BTreeSet<PathBuf> {
            let paths = content(folder).into_iter().map(|(path, _)| path);
            paths.map(|path| path.strip_prefix(folder).unwrap().to_owned()).collect()
        };
        let (open, before) = (own_files(serve.id()), names(&cwd));
        let beside = names(place.folder.path());
        if hostile {
            hostile_session(&place.scene);
        } else {
            let outsider = Outsider::join(&place.scene, true);
            outsider.send(Pose { tick: 1, ..Pose::default() });
            assert_eq!(outsider.receive().tick, 1);
        }
        assert_eq!(own_files(serve.id()), open, "no file was opened");
        assert_eq!(names(&cwd), before, "no file was made");
        assert_eq!(names(place.folder.path()), beside);
        assert_eq!(fs::read(&place.model).unwrap(), model);
        let served = serve.interrupt().with(130).json();
        if hostile {
            let refused = served["commands_refused"].as_u64().unwrap();
            assert!(refused > 20, "{refused}");
        }
        results.push(names(&cwd));
    }
    assert_eq!(results[0], results[1], "a hostile session leaves the files of any other");
}
