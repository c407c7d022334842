//! `serve` and `control` as processes of their own, and other programs that join, leave or send
//! poses uninvited.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::PathBuf;
use std::time::Duration;

use chaincell_tests::files::{Table, is_hash, play, summary, text, write_path};
use chaincell_tests::outsider::{Outsider, Pose};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Ended, Running, run, turn};

/// A controller on the place's scene, to its end.
#[track_caller]
fn control(place: &Place, options: &[&str]) -> Ended {
    Running::start(&mut place.control(options)).end(SHORT)
}

/// Depth of the plane's middle [m] at a tick of a slow wave.
fn depth_m(tick: u64) -> f32 {
    0.01 * (1.0 - (tick as f32 * 0.01).cos())
}

#[test]
fn every_pose_of_a_path_is_answered() {
    let _turn = turn();
    let place = Place::new("path");
    let (path, out) = (place.file("path.csv"), place.file("out"));
    let rows = (0..500)
        .map(|tick| (tick, [0.0, 0.0, -depth_m(tick)], u32::from((1..400).contains(&tick))));
    write_path(&path, rows);
    // All sweeps of every tick, as offline.
    let options = ["--ticks", "500", "--out", text(&out), "--json", "--budget-us", "off"];
    let serve = place.serve(&options);
    let control = control(&place, &["--path", text(&path)]).with(0).json();
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&control["ticks_sent"], &control["ticks_answered"]), (&500.into(), &500.into()));
    assert_eq!((&control["foreign_answers"], &control["sends_failed"]), (&0.into(), &0.into()));
    assert_eq!(served["ticks_executed"], 500);
    assert_eq!(served["ended_by"], "ticks");
    assert!(is_hash(&served["state_hash"]));
    assert_eq!(served["state_hash"], control["state_hash"]);
    assert_eq!(summary(&out)["state_hash"], served["state_hash"]);
    // Offline the same path gives the same, bit for bit.
    let offline = place.file("offline");
    play(&place.model, &path, &offline, &["--contact", "40"]).with(0);
    let force = |folder: &PathBuf| std::fs::read(folder.join("force.csv")).unwrap();
    assert!(force(&out) == force(&offline));
    assert_eq!(summary(&offline)["state_hash"], served["state_hash"]);
}

#[test]
fn one_server_after_the_other_but_never_two() {
    let _turn = turn();
    let place = Place::new("servers");
    let mut first = place.serve(&["--json"]);
    let out = place.file("out");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("force.csv"), "of an earlier run").unwrap();
    let args = ["serve", text(&place.model), "--scene", &place.scene, "--out", text(&out)];
    let second = run([&args[..], &["--force"]].concat()).with(2);
    assert_eq!(std::fs::read(out.join("force.csv")).unwrap(), b"of an earlier run");
    for part in [&place.scene, "has a running chaincell serve", "--scene NAME"] {
        assert!(second.err.contains(part), "{}", second.err);
    }
    assert!(!second.out.contains("ready"));
    assert!(first.is_running());
    let control = control(&place, &["--seconds", "0.2"]).with(0).json();
    assert_eq!(control["ticks_answered"], 200, "the first server was not disturbed");
    assert_eq!(first.interrupt().with(130).json()["ticks_executed"], 200);
    place.serve(&[]).interrupt().with(130);
    // Another scene is another matter.
    let (one, two) = (Place::new("one"), Place::new("two"));
    let servers = [one.serve(&[]), two.serve(&[])];
    for server in servers {
        server.interrupt().with(130);
    }
}

#[test]
fn control_without_a_server() {
    let place = Place::new("nobody");
    let ended = control(&place, &["--wait-for-server-s", "1"]).with(2);
    for part in ["no server", &place.scene, "chaincell serve", "--wait-for-server-s"] {
        assert!(ended.err.contains(part), "{}", ended.err);
    }
    let waiting = Running::start(&mut place.control(&["--wait-for-server-s", "60"]));
    // The services exist: it is waiting.
    let _outsider = Outsider::join(&place.scene, false);
    waiting.interrupt().with(130);
}

#[test]
fn a_second_control_is_refused_and_the_first_goes_on() {
    let _turn = turn();
    let place = Place::new("controls");
    let serve = place.serve(&["--json"]);
    let outsider = Outsider::join(&place.scene, false);
    let first = Running::start(&mut place.control(&["--seconds", "60"]));
    let seen = outsider.after(100);
    let second = control(&place, &["--seconds", "0.1"]).with(2);
    assert!(second.err.contains("has a running chaincell control"), "{}", second.err);
    assert!(second.err.contains("--scene NAME"), "{}", second.err);
    outsider.after(seen + 100);
    let first = first.interrupt().with(130).json();
    assert_eq!(first["ticks_answered"], first["ticks_sent"]);
    let served = serve.interrupt().with(130).json();
    assert_eq!(served["ticks_executed"], first["ticks_sent"]);
    assert_eq!((&served["publishers"], &served["poses_refused"]), (&1.into(), &0.into()));
}

#[test]
fn readers_that_join_and_leave_cost_no_answer() {
    let _turn = turn();
    let place = Place::new("readers");
    // With a hash in every answer.
    let serve = place.serve(&["--ticks", "2000", "--json", "--budget-us", "off"]);
    let always = Outsider::join(&place.scene, false);
    let control = Running::start(&mut place.control(&["--seconds", "2"]));
    let mut ticks = Vec::new();
    while ticks.len() < 2000 {
        let answer = always.receive();
        if answer.flags & 4 != 0 {
            continue;
        }
        assert_ne!(answer.state_hash, 0);
        if answer.tick % 500 == 250 {
            let brief = Outsider::join(&place.scene, false);
            assert!(brief.receive().tick >= answer.tick, "no history");
        }
        ticks.push(answer.tick);
    }
    assert!(ticks.into_iter().eq(0..2000), "each answer once and in order");
    assert_eq!(control.end(SHORT).with(0).json()["ticks_answered"], 2000);
    let served = serve.end(SHORT).with(0).json();
    assert!(served["peers"]["joins"].as_u64().unwrap() >= 4, "{}", served["peers"]);
}

#[test]
fn poses_of_another_program_drive_the_tissue() {
    let _turn = turn();
    let place = Place::new("foreign");
    let out = place.file("out");
    let silence = ["--watchdog-ms", "1000", "--ramp-ms", "0", "--budget-us", "off"];
    let serve = place.serve(&[&silence[..], &["--out", text(&out), "--json"]].concat());
    let outsider = Outsider::join(&place.scene, true);
    let pose = |tick: u64, z: f32| {
        let engaged = u32::from(tick > 10);
        Pose { tick, position_m: [0.0, 0.0, z], engaged }
    };
    // Two poses lost after 11, two repeated, one bad.
    let ticks = [10, 11, 14, 14, 13, 15, 16];
    for (at, tick) in ticks.into_iter().enumerate() {
        let z = if tick == 15 { f32::NAN } else { -0.002 * at as f32 };
        outsider.send(pose(tick, z));
    }
    let answers: Vec<_> = (0..5).map(|_| outsider.receive()).collect();
    let flags: Vec<(u64, u32)> = answers.iter().map(|force| (force.tick, force.flags)).collect();
    assert_eq!(flags, [(10, 0), (11, 0), (14, 0), (15, 2), (16, 0)]);
    assert!(answers[4].force_n[2] > 0.0 && answers[4].contacts == 1);
    // Silence: force 0 once, the last tick again, the tissue as it was.
    let stale = outsider.receive();
    assert_eq!((stale.tick, stale.flags, stale.force_n), (16, 4 + 16, [0.0; 3]));
    assert_eq!(stale.state_hash, answers[4].state_hash);
    std::thread::sleep(Duration::from_millis(150));
    assert_eq!(outsider.try_receive(), None, "without a pose nothing happens");
    outsider.send(pose(17, -0.012));
    let next = outsider.receive();
    assert_eq!((next.tick, next.flags, next.contacts), (17, 0, 1));
    let served = serve.interrupt().with(130).json();
    assert_eq!((&served["ticks_executed"], &served["poses_repeated"]), (&6.into(), &2.into()));
    assert_eq!(served["state_hash"], format!("{:016x}", next.state_hash));
    // What was recorded replays to the same bits.
    let again = place.file("again");
    let options = ["--recorded", "--contact", "40"];
    play(&place.model, &out.join("path.csv"), &again, &options).with(0);
    assert_eq!(summary(&again)["state_hash"], served["state_hash"]);
}

#[test]
fn ctrl_c_ends_both_sides_with_what_they_have() {
    let _turn = turn();
    let place = Place::new("ctrl-c");
    let out = place.file("out");
    let serve = place.serve(&["--out", text(&out), "--json"]);
    let outsider = Outsider::join(&place.scene, false);
    let control = Running::start(&mut place.control(&["--seconds", "60"]));
    outsider.after(200);
    let control = control.interrupt().with(130).json();
    let sent = control["ticks_sent"].as_u64().unwrap();
    assert!((200..60_000).contains(&sent), "{sent}");
    assert_eq!((&control["ticks_answered"], &control["interrupted"]), (&sent.into(), &true.into()));
    let served = serve.interrupt().with(130).json();
    assert_eq!(
        (&served["ticks_executed"], &served["ended_by"]),
        (&sent.into(), &"interrupt".into())
    );
    assert_eq!(Table::read(&out.join("force.csv")).rows.len() as u64, sent);
    assert_eq!(Table::read(&out.join("path.csv")).rows.len() as u64, sent);
    assert_eq!(summary(&out)["state_hash"], served["state_hash"]);
}

#[test]
fn ctrl_c_on_an_idle_server_with_results() {
    let place = Place::new("idle");
    let out = place.file("out");
    let serve = place.serve(&["--out", text(&out), "--record-ticks", "10"]);
    serve.interrupt().with(130);
    assert_eq!(Table::read(&out.join("force.csv")).rows.len(), 0);
    assert_eq!(summary(&out)["ticks_executed"], 0);
}

#[test]
fn ctrl_c_on_a_run_keeps_whole_files() {
    let place = Place::new("run");
    let path = place.file("path.csv");
    write_path(&path, (0..2_000_000).map(|tick| (tick, [0.0; 3], 1)));
    let out = place.file("out");
    let args = ["run", text(&place.model), "--path", text(&path), "--out", text(&out)];
    let options = ["--sweeps", "1000", "--snapshot-ticks", "0"];
    let mut running = Running::chaincell([&args[..], &options].concat());
    // The first tick was taken.
    while !out.join("cells_0.csv").exists() {
        assert!(running.is_running());
        std::thread::sleep(Duration::from_millis(5));
    }
    let ended = running.interrupt().with(130);
    assert!(ended.err.contains("the results so far are in "), "{}", ended.err);
    let ticks = Table::read(&out.join("force.csv")).rows.len() as u64;
    assert!((1..2_000_000).contains(&ticks));
    let found = summary(&out);
    assert_eq!((&found["ticks"], &found["interrupted"]), (&ticks.into(), &true.into()));
    assert_eq!(Table::read(&out.join("cells_final.csv")).rows.len(), 81);
    assert!(std::fs::read_to_string(out.join("final.vtu")).unwrap().ends_with("</VTKFile>\n"));
}
