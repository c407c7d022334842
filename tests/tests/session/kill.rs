//! A server killed with SIGKILL at any moment loses no tick that was answered.
//!
//! Plain `cargo test` kills 15 servers, 200 with `CHAINCELL_SLOW=1`.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::time::{Duration, Instant};

use chaincell_kernel::trace::{End, RECORD_BYTES, Reader, Record, header_bytes};
use chaincell_tests::files::{text, write_path};
use chaincell_tests::outsider::{Outsider, Pose};
use chaincell_tests::place::Place;
use chaincell_tests::process::{SHORT, unshared};
use chaincell_tests::{Ended, Running, run, turn};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Servers that are killed.
const KILLS: u64 = 15;
/// In the slow suite.
const KILLS_SLOW: u64 = 200;
/// Longest life of a server after its first pose \[us\].
const LIFE_US: u64 = 30_000;
/// Poses that wait for the server at a time.
const BURST: u64 = 8;

fn pose(tick: u64) -> Pose {
    let depth_m = -0.0002 * (tick % 97) as f32;
    Pose { tick, position_m: [0.0, 0.001, depth_m], engaged: u32::from(tick % 97 < 80) }
}

/// Ticks with their hashes, as answered until the server is killed, and after.
fn answered(outsider: &Outsider, serve: &mut Running, life: Duration) -> Vec<(u64, u64)> {
    let mut seen = Vec::new();
    let (start, mut sent) = (Instant::now(), 0);
    let take = |seen: &mut Vec<(u64, u64)>| {
        while let Some(force) = outsider.try_receive() {
            seen.push((force.tick, force.state_hash));
        }
    };
    while start.elapsed() < life {
        if sent < seen.len() as u64 + BURST {
            outsider.send(pose(sent));
            sent += 1;
        }
        take(&mut seen);
    }
    serve.kill();
    // What lies in shared memory was answered too.
    take(&mut seen);
    seen
}

/// Ticks with their hashes, as recorded, and how they end.
fn recorded(trace: &Path) -> (Vec<(u64, u64)>, End) {
    let bytes = std::fs::read(trace).unwrap();
    let mut found = Vec::new();
    let end = Reader::open(&bytes).unwrap().records(|_, record: &Record| {
        assert_eq!(record.sample.position_m.z.to_bits(), pose(record.tick).position_m[2].to_bits());
        found.push((record.tick, record.state_hash.unwrap()));
        Ok::<(), ()>(())
    });
    (found, end.unwrap())
}

/// A kill hits the moment between an answer and its record in one case of many; a reader that looks
/// as soon as the answer is there sees it often.
#[test]
fn an_answer_that_is_seen_has_its_record_in_the_file() {
    let _turn = turn();
    let place = Place::new("first");
    let trace = place.file("first.trace");
    let record = ["--record", text(&trace), "--record-ticks", "3000", "--watchdog-ms", "0"];
    let loop_options = ["--wait", "spin", "--ticks", "3000", "--max-pose-hz", "0"];
    let serve = place.serve(&[&record[..], &loop_options].concat());
    let outsider = Outsider::join(&place.scene, true);
    let file = File::open(&trace).unwrap();
    let mut bytes = [0; RECORD_BYTES];
    for tick in 0..3000 {
        outsider.send(pose(tick));
        let start = Instant::now();
        let answer = loop {
            if let Some(force) = outsider.try_receive() {
                break force;
            }
            assert!(start.elapsed() < SHORT, "no answer to tick {tick}");
        };
        let place = header_bytes(1) as u64 + tick * RECORD_BYTES as u64;
        file.read_exact_at(&mut bytes, place).unwrap();
        let hash = u64::from_le_bytes(*bytes[24..].first_chunk().unwrap());
        let checksum = u32::from_le_bytes(*bytes[44..].first_chunk().unwrap());
        assert_eq!(
            (answer.tick, answer.state_hash),
            (tick, hash),
            "answered before it is recorded"
        );
        assert_ne!(checksum, 0, "tick {tick} is not finished");
    }
    serve.end(SHORT).with(0);
}

// REQ-COS-06
#[test]
fn no_answered_tick_is_lost_to_a_kill() {
    let _turn = turn();
    let slow = std::env::var_os("CHAINCELL_SLOW").is_some();
    let kills = if slow { KILLS_SLOW } else { KILLS };
    if !slow {
        println!("SKIPPED {} of {KILLS_SLOW} kills: CHAINCELL_SLOW is not set", KILLS_SLOW - KILLS);
    }
    let mut place = Place::new("kill");
    let scene = place.scene.clone();
    let (mut ticks, mut unanswered, mut cut) = (0, 0, 0);
    let mut random = Pcg64::seed_from_u64(20);
    for kill in 0..kills {
        place.scene = format!("{scene}-{kill}");
        let out = place.file(&format!("out{kill}"));
        let options = [
            "--out",
            text(&out),
            "--record-ticks",
            "20000",
            "--watchdog-ms",
            "0",
            "--budget-us",
            "off",
        ];
        let mut serve = place.serve(&options);
        let outsider = Outsider::join(&place.scene, true);
        let life = Duration::from_micros(random.next_u64() % LIFE_US);
        let seen = answered(&outsider, &mut serve, life);
        drop(serve);
        let (found, end) = recorded(&out.join("session.trace"));
        assert!(matches!(end, End::Complete | End::Cut(_)), "kill {kill}: {end}");
        assert_eq!(found[..seen.len().min(found.len())], seen, "kill {kill}");
        ticks += seen.len();
        unanswered += found.len() - seen.len();
        cut += u64::from(end != End::Complete);
        if found.is_empty() {
            continue;
        }
        let replayed = run(["replay", text(&out), "--json"]).with(0).json();
        assert_eq!(replayed["ticks"], found.len());
        assert_eq!(replayed["state_hash"], format!("{:016x}", found[found.len() - 1].1));
        std::fs::remove_dir_all(out).unwrap();
    }
    println!(
        "{kills} kills: {ticks} answered ticks, none lost; {unanswered} recorded without an \
         answer, {cut} records cut"
    );
    assert!(ticks > 0, "no server answered before its end");
}

/// What is left of a killed session is not overwritten unasked, and is again where it is.
// REQ-COS-06
#[test]
fn a_killed_session_keeps_its_place_and_a_new_one_begins_by_force() {
    let _turn = turn();
    let place = Place::new("again");
    let out = place.file("out");
    let options = ["--out", text(&out), "--record-ticks", "500", "--watchdog-ms", "0"];
    let mut serve = place.serve(&options);
    // Another one on the same folder, on a scene of its own.
    let other = chaincell_tests::scene("other");
    let model = text(&place.model);
    let second = ["serve", model, "--scene", &other, "--out", text(&out), "--force"];
    let refused = run(second).with(2);
    assert!(refused.err.contains("another run is recording to it"), "{}", refused.err);
    let outsider = Outsider::join(&place.scene, true);
    outsider.send(pose(0));
    assert_eq!(outsider.receive().tick, 0);
    serve.kill();
    assert_eq!(run(["replay", text(&out), "--json"]).with(0).json()["ticks"], 1);
    let refused = run(["serve", model, "--scene", &other, "--out", text(&out)]).with(2);
    assert!(refused.err.contains("not empty"), "{}", refused.err);
    let serve = place.serve(&[&options[..], &["--force", "--ticks", "1"]].concat());
    let outsider = Outsider::join(&place.scene, true);
    outsider.send(pose(0));
    serve.end(SHORT).with(0);
    let trace = out.join("session.trace");
    assert_eq!(
        std::fs::metadata(&trace).unwrap().len() as usize,
        header_bytes(1) + RECORD_BYTES,
        "not cut to its length"
    );
}

#[test]
fn ticks_beyond_the_room_are_told_and_what_was_kept_is_replayed() {
    let _turn = turn();
    let place = Place::new("beyond");
    let trace = place.file("a.trace");
    let record = ["--record", text(&trace), "--record-ticks", "30", "--ticks", "40", "--json"];
    let all = ["--watchdog-ms", "0", "--budget-us", "off", "--late-share", "off"];
    let serve = place.serve(&[&record[..], &all].concat());
    let outsider = Outsider::join(&place.scene, true);
    (0..40).for_each(|tick| outsider.send(pose(tick)));
    let ended = serve.end(SHORT).with(0);
    let report = ended.json();
    let counts = (&report["ticks_recorded"], &report["ticks_unrecorded"]);
    assert_eq!(counts, (&30.into(), &10.into()));
    assert!(ended.err.contains("WARNING: the last 10 of 40 ticks are NOT recorded"), "{ended:?}");
    // The model is the only other file in the folder, and beside the trace.
    assert_eq!(run(["replay", text(&trace), "--json"]).with(0).json()["ticks"], 30);
    let moved = place.file("moved");
    std::fs::rename(&place.model, &moved).unwrap();
    let refused = run(["replay", text(&trace)]).with(2);
    assert!(refused.err.contains("name the model of the recording with --model"), "{refused:?}");
    run(["replay", text(&trace), "--model", text(&moved)]).with(0);
}

/// How a command ends on a disk of 1 MB, named `disk`, that has an earlier result in `disk/out`;
/// and that result alone is there then. `None` without the right to mount such a disk.
fn on_a_small_disk(place: &Place, arguments: &[&str]) -> Option<Ended> {
    let lines = "mount -t tmpfs -o size=1m none disk 2>/dev/null || exit 99; mkdir disk/out; \
        echo earlier > disk/out/force.csv; \"$chaincell\" \"$@\"; code=$?; \
        [ \"$(find disk -type f)\" = disk/out/force.csv ] || exit 98; exit $code";
    let _ = std::fs::create_dir(place.file("disk"));
    let mut command = unshared("a disk without room", place.folder.path(), lines)?;
    let ended = Running::start(command.args(arguments)).end(SHORT);
    assert_ne!(ended.code, Some(98), "earlier results are gone, or something is left: {ended:?}");
    Some(ended)
}

#[test]
fn a_disk_without_room_is_told_before_the_run() {
    let place = Place::new("room");
    let path = place.file("long.csv");
    write_path(&path, (0..30_000).map(|tick| (tick, [0.0; 3], 0)));
    let (model, path, scene) = (text(&place.model), text(&path), place.scene.as_str());
    let out = ["--out", "disk/out", "--force"];
    let serve = ["serve", model, "--scene", scene];
    let commands = [
        ([&serve[..], &["--record", "disk/a.trace"]].concat(), "--record disk/a.trace: ", "29.0"),
        ([&serve[..], &out].concat(), "--out disk/out/session.trace: ", "29.0"),
        ([&["run", model, "--path", path][..], &out].concat(), "--out disk/out/session", "1.4"),
        ([&["cosim", model, "--seconds", "30"][..], &out].concat(), "--out disk/out/se", "1.6"),
    ];
    for (arguments, option, room_mb) in commands {
        let Some(ended) = on_a_small_disk(&place, &arguments) else { return };
        let ended = ended.with(2);
        for wanted in [option, &format!("no room for the trace, {room_mb} MB"), "--record-ticks"] {
            assert!(ended.err.contains(wanted), "wanted `{wanted}`, got {}", ended.err);
        }
        assert!(!ended.out.contains("ready"), "{ended:?}");
    }
}
