//! Snapshots by command, and sessions that go on from them, as outside programs see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use chaincell_tests::files::text;
use chaincell_tests::outsider::{
    Commander, Force, Order, Outsider, Pose, RELEASE_FIRST, Reply, Viewer,
};
use chaincell_tests::place::Place;
use chaincell_tests::process::{SHORT, unshared};
use chaincell_tests::{Running, run, turn};

/// The last tick before the snapshot.
const TICK: u64 = 79;

/// Ticks make all their sweeps, and an output stage stands before the device.
fn serve(place: &Place, options: &[&str]) -> Running {
    let always = ["--watchdog-ms", "0", "--ramp-ms", "0", "--json", "--budget-us", "off"];
    place.serve(&[&always[..], &["--device", "touch"], options].concat())
}

/// A press that goes on and on.
fn pose(tick: u64) -> Pose {
    let depth_m = 0.0001 * tick as f32;
    Pose { tick, position_m: [0.0002, 0.001, -depth_m], engaged: u32::from(tick > 0) }
}

/// What the tissue and the stage did.
fn done(answers: &[Force]) -> Vec<(u64, [u32; 3], u64, u32)> {
    let of = |force: &Force| {
        (force.tick, force.force_n.map(f32::to_bits), force.state_hash, force.flags)
    };
    answers.iter().map(of).collect()
}

fn beside(folder: &Path, tick: u64) -> PathBuf {
    folder.join(format!("session.trace.{tick}.snapshot"))
}

/// The file, once its writer has it.
fn written(path: &Path) {
    let start = Instant::now();
    while !path.is_file() {
        assert!(start.elapsed() < SHORT, "no {}", path.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

// REQ-COS-11
#[test]
fn a_session_goes_on_from_a_snapshot_and_has_no_force_until_a_release() {
    let _turn = turn();
    let place = Place::new("snapshot");
    let [first, second] = ["first", "second"].map(|name| place.file(name));
    let mut killed = serve(&place, &["--out", text(&first)]);
    let outsider = Outsider::join(&place.scene, true);
    outsider.play(0..TICK + 1, pose);
    place.command(&["set", "sweeps=3"]).with(0);
    let told = place.command(&["snapshot"]).with(0).json();
    assert_eq!(told["tick"], TICK);
    let wanted = outsider.play(TICK + 1..140, pose);
    assert!(wanted.last().unwrap().force_n[2] > 0.01, "{wanted:?}");
    written(&beside(&first, TICK));
    killed.kill();
    let from = beside(&first, TICK);
    let ticks = ["--ticks", "60", "--out", text(&second), "--restore", text(&from)];
    let restored = serve(&place, &ticks);
    let found = outsider.play(TICK + 1..140, pose);
    let hashes = |of: &[Force]| of.iter().map(|force| force.state_hash).collect::<Vec<_>>();
    assert_eq!(hashes(&found), hashes(&wanted));
    // The device felt nothing since the snapshot.
    let is_withheld = |of: &Force| of.force_n == [0.0; 3] && of.flags & RELEASE_FIRST != 0;
    assert!(found.iter().all(is_withheld), "{found:?}");
    let served = restored.end(SHORT).with(0).json();
    // Its own trace begins with a copy.
    let replayed = run(["replay", text(&second), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    assert_eq!(replayed["ticks"], 60);
    let later = run(["replay", text(&first), "--from", "79", "--json"]).with(0).json();
    assert_eq!((&later["state_hash"], &later["ticks"]), (&replayed["state_hash"], &60.into()));
    let whole = run(["replay", text(&first), "--json"]).with(0).json();
    assert_eq!((&whole["state_hash"], &whole["ticks"]), (&replayed["state_hash"], &140.into()));
}

/// The snapshot that a trace begins from is kept, whatever is saved behind it at the same tick.
#[test]
fn a_restored_session_is_saved_again_before_its_first_pose() {
    let _turn = turn();
    let place = Place::new("snapshot-again");
    let [first, second, third] = ["first", "second", "third"].map(|name| place.file(name));
    let served = serve(&place, &["--ticks", "80", "--out", text(&first)]);
    // Ahead of all else: this trace begins at rest, whatever becomes of the file.
    place.command(&["snapshot"]).with(0);
    place.command(&["set", "sweeps=3"]).with(0);
    place.command(&["snapshot"]).with(0);
    let outsider = Outsider::join(&place.scene, true);
    outsider.play(0..TICK, pose);
    let told = place.command(&["snapshot"]).with(0).json();
    assert_eq!(told["tick"], TICK - 1);
    outsider.play(TICK..TICK + 1, pose);
    served.end(SHORT).with(0);
    run(["replay", text(&first)]).with(0);
    let from = run(["replay", text(&first), "--from", "0"]).with(0);
    assert!(from.out.contains("80 ticks"), "{}", from.out);
    let file = beside(&first, TICK - 1);
    let ticks = ["--ticks", "20", "--out", text(&second), "--restore", text(&file)];
    let restored = serve(&place, &ticks);
    place.command(&["set", "sweeps=2"]).with(0);
    let told = place.command(&["snapshot"]).with(0).json();
    assert_eq!(told["tick"], TICK - 1, "the last tick before it");
    let wanted = outsider.play(TICK..TICK + 20, pose);
    assert_ne!(wanted[0].flags & RELEASE_FIRST, 0);
    restored.end(SHORT).with(0);
    run(["replay", text(&second)]).with(0);
    run(["replay", text(&second), "--from", "78"]).with(0);
    // The controller in charge is still known.
    let file = beside(&second, TICK - 1);
    let ticks = ["--ticks", "20", "--out", text(&third), "--restore", text(&file)];
    let restored = serve(&place, &ticks);
    let state = Viewer::join(&place.scene).after(0).0;
    assert_eq!((state.tick, state.ticks_answered), (TICK - 1, 0));
    assert_eq!(done(&outsider.play(TICK..TICK + 20, pose)), done(&wanted));
    restored.end(SHORT).with(0);
    run(["replay", text(&third)]).with(0);
}

#[test]
fn another_controller_releases_first() {
    let _turn = turn();
    let place = Place::new("snapshot-other");
    let out = place.file("out");
    let first = serve(&place, &["--ticks", "90", "--out", text(&out)]);
    let outsider = Outsider::join(&place.scene, true);
    outsider.play(0..TICK + 1, pose);
    place.command(&["snapshot"]).with(0);
    outsider.play(TICK + 1..90, pose);
    first.end(SHORT).with(0);
    drop(outsider);
    let from = beside(&out, TICK);
    let second = serve(&place, &["--ticks", "3", "--restore", text(&from)]);
    let other = Outsider::join(&place.scene, true);
    let flags: Vec<u32> = other.play(80..81, pose).iter().map(|force| force.flags).collect();
    assert!(flags[0] & RELEASE_FIRST != 0, "{flags:?}");
    other.send(Pose { engaged: 0, ..pose(81) });
    let _ = other.receive();
    other.send(pose(82));
    assert_eq!(other.receive().flags & RELEASE_FIRST, 0);
    second.end(SHORT).with(0);
}

#[test]
fn what_cannot_go_on_is_told_and_nothing_is_lost() {
    let _turn = turn();
    let place = Place::new("snapshot-refused");
    let out = place.file("out");
    // Without a trace there is no place.
    let unrecorded = serve(&place, &["--ticks", "1"]);
    let commander = Commander::join(&place.scene);
    let asked = |parameter| Order { kind: 7, parameter, ..Order::default() };
    let refused = |reply: Reply| (reply.result, reply.reason);
    assert_eq!(refused(commander.order(asked(0))), (1, 11));
    assert_eq!(refused(commander.order(asked(5))), (1, 2));
    let told = place.command(&["snapshot"]).with(2).err;
    assert!(told.contains("--record"), "{told}");
    let outsider = Outsider::join(&place.scene, true);
    outsider.play(0..1, pose);
    unrecorded.end(SHORT).with(0);
    let recorded = serve(&place, &["--ticks", "6", "--out", text(&out)]);
    outsider.play(1..6, pose);
    place.command(&["snapshot"]).with(0);
    outsider.play(6..7, pose);
    recorded.end(SHORT).with(0);
    let file = beside(&out, 5);
    let trace = out.join("session.trace");
    let whole = std::fs::read(&trace).unwrap();
    let start = |more: &[&str]| {
        let args = ["serve", text(&place.model), "--scene", &place.scene, "--contact", "40"];
        let ended = run([&args[..], &["--restore", text(&file), "--ticks", "1"], more].concat());
        assert_eq!(std::fs::read(&trace).unwrap(), whole);
        ended.with(2).err
    };
    assert!(start(&["--budget-us", "off"]).contains("other options"), "another stage");
    let [budget, stage] = [["--budget-us", "off"], ["--device", "omega"]];
    assert!(start(&[budget, stage].concat()).contains("other options"), "another device");
    // A folder is in the place of the copy that stands beside its trace.
    let unwritten = place.file("unwritten.trace");
    std::fs::create_dir(place.file("unwritten.trace.start.snapshot")).unwrap();
    let same = ["--watchdog-ms", "0", "--ramp-ms", "0", "--budget-us", "off", "--device", "touch"];
    let told = start(&[&same[..], &["--record", text(&unwritten)]].concat());
    assert!(told.contains("unwritten.trace.start.snapshot: it is there and no file"), "{told}");
    assert!(!unwritten.exists());
    let from = |tick: &str| run(["replay", text(&out), "--from", tick]).with(2).err;
    assert!(from("3").contains("snapshots after the ticks 5"), "{}", from("3"));
    std::fs::write(&file, b"CHAINSES but nothing else").unwrap();
    assert!(
        from("5").contains("another version") || from("5").contains("damaged"),
        "{}",
        from("5")
    );
    std::fs::remove_file(&file).unwrap();
    assert!(from("5").contains("session.trace.5.snapshot"), "{}", from("5"));
}

#[test]
fn a_session_without_a_tick_is_told_as_such() {
    let _turn = turn();
    let place = Place::new("snapshot-unused");
    let out = place.file("out");
    let served = serve(&place, &["--out", text(&out)]);
    place.command(&["snapshot"]).with(0);
    served.interrupt().with(130);
    let replay = |more: &[&str]| run([&["replay", text(&out)], more].concat()).with(2).err;
    assert!(replay(&[]).contains("it holds no tick"), "{}", replay(&[]));
    let from = replay(&["--from", "0"]);
    assert!(from.contains("no tick stands behind the snapshot"), "{from}");
}

/// The reply waits for the file: a disk that is full is an error of the command, and one without it means
/// that the file is there.
#[test]
fn a_snapshot_that_cannot_be_written_is_refused() {
    let _turn = turn();
    let place = Place::new("full-disk");
    let lines = format!(
        "mount -t tmpfs -o size=1m none disk || exit 99
        \"$chaincell\" serve {} --scene {} --contact 40 --late-share off --record disk/a.trace --record-ticks 10 > out 2> err & s=$!
        until grep -q ready out; do sleep 0.01; done
        dd if=/dev/zero of=disk/fill bs=4k 2> /dev/null
        \"$chaincell\" command --scene {1} snapshot; echo $?; ls disk
        rm disk/fill
        \"$chaincell\" command --scene {1} snapshot > /dev/null; echo $?; ls disk
        kill -INT $s; wait $s; echo $?",
        text(&place.model),
        place.scene
    );
    std::fs::create_dir(place.file("disk")).unwrap();
    let Some(mut command) = unshared("a full disk", place.folder.path(), &lines) else { return };
    let ended = Running::start(&mut command).end(SHORT);
    let said: Vec<&str> = ended.out.split_whitespace().collect();
    let wanted = ["2", "a.trace", "fill", "0", "a.trace", "a.trace.0.snapshot", "130"];
    assert_eq!(said, wanted, "{ended:?}");
    assert!(ended.err.contains("(reason 13): the snapshot could not be written"), "{}", ended.err);
}
