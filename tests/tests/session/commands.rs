//! States and commands of `serve` as processes and outside programs see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::time::Duration;

use chaincell_tests::files::{Table, play, summary, text, write_path};
use chaincell_tests::outsider::{Commander, Order, Outsider, Pose, Reply, Row, Viewer};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};

/// Flag of the safe state.
const SAFE_STATE: u32 = 16;

/// A server to which no silence counts as one, and whose forces are published as they are.
fn serve(place: &Place, options: &[&str]) -> Running {
    place.serve(&[&["--watchdog-ms", "0", "--ramp-ms", "0", "--json"], options].concat())
}

fn pose(tick: u64) -> Pose {
    Pose { tick, position_m: [0.0, 0.001, -0.0003 * tick as f32], engaged: u32::from(tick > 0) }
}

fn assert_is(rows: &[Row], cells: &Table) {
    let ids: Vec<u64> = rows.iter().map(|row| u64::from(row.node)).collect();
    assert_eq!(ids, cells.whole("node"));
    for (row, at) in rows.iter().zip(cells.vectors("x_m")) {
        for (here, there) in row.position_m.map(f64::from).into_iter().zip(at) {
            // The table has nine digits, the state a float.
            assert!((here - there).abs() <= 1e-7 * there.abs(), "node {}", row.node);
        }
    }
}

#[test]
fn two_viewers_see_what_an_offline_run_of_the_same_poses_writes() {
    let _turn = turn();
    let place = Place::new("viewers");
    let serve = serve(&place, &["--ticks", "61", "--budget-us", "off"]);
    let viewers = [Viewer::join(&place.scene), Viewer::join(&place.scene)];
    for viewer in &viewers {
        // A viewer that joins sees the state at once, without any pose.
        let (stamp, rows) = viewer.after(0);
        assert_eq!((stamp.tick, stamp.ticks_answered, stamp.nodes, rows.len()), (0, 0, 81, 81));
        assert_eq!(rows[80].position_m, [0.04, 0.04, 0.0]);
    }
    let outsider = Outsider::join(&place.scene, true);
    let hash = outsider.play(0..60, pose)[59].state_hash;
    let path = place.file("path.csv");
    write_path(&path, (0..60).map(|tick| (tick, pose(tick).position_m, pose(tick).engaged)));
    let offline = place.file("offline");
    play(&place.model, &path, &offline, &["--contact", "40"]).with(0);
    let cells = Table::read(&offline.join("cells_final.csv"));
    for viewer in &viewers {
        let (stamp, rows) = viewer.after(60);
        assert_eq!((stamp.tick, stamp.state_hash), (59, hash));
        assert_is(&rows, &cells);
        assert!(viewer.try_receive().is_none(), "a state that nothing has changed");
    }
    // The command of users sees the same.
    let csv = place.file("now.csv");
    let args = ["state", "--scene", &place.scene, "--once", "--json", "--csv", text(&csv)];
    let seen = run(args).with(0).json();
    assert_eq!(seen["state_hash"], summary(&offline)["state_hash"]);
    assert_eq!((&seen["nodes"], &seen["ticks_answered"]), (&81.into(), &60.into()));
    let found = Table::read(&csv);
    assert_eq!(found.header, cells.header);
    assert_eq!(found.whole("node"), cells.whole("node"));
    outsider.send(pose(60));
    let served = serve.end(SHORT).with(0).json();
    assert!(served["states_sent"].as_u64().unwrap() >= 3, "{served}");
}

#[test]
fn a_session_with_commands_is_replayed_to_the_same_bits() {
    let _turn = turn();
    let place = Place::new("commands");
    let out = place.file("out");
    let serve = serve(&place, &["--ticks", "120", "--out", text(&out)]);
    let rest = place.command(&["reset"]).with(0).json();
    assert_eq!((&rest["tick"], &rest["ticks_answered"]), (&0.into(), &0.into()));
    let outsider = Outsider::join(&place.scene, true);
    let press = |from: u64, to: u64| outsider.play(from..to, pose);
    let pressed = press(0, 40);
    assert!(pressed[39].force_n[2].abs() > 0.0);
    place.command(&["pause"]).with(0);
    let paused = press(40, 50);
    for answer in &paused {
        assert_eq!((answer.force_n, answer.flags), ([0.0; 3], SAFE_STATE));
        assert_eq!(answer.state_hash, pressed[39].state_hash, "a cell has moved");
    }
    for set in ["sweeps=9", "max_tool_step_m=0.002", "unloading=retreat", "max_force_n=0.05"] {
        place.command(&["set", set]).with(0);
    }
    let resumed = place.command(&["resume"]).with(0).json();
    assert_eq!((&resumed["tick"], &resumed["ticks_answered"]), (&49.into(), &50.into()));
    let limited = press(50, 80);
    assert!(limited.iter().all(|answer| answer.force_n[2].abs() <= 0.0501));
    assert!(
        limited[29].flags & SAFE_STATE == 0 && limited[29].state_hash != pressed[39].state_hash
    );
    let reset = place.command(&["reset"]).with(0).json();
    assert_eq!(reset["state_hash"], rest["state_hash"]);
    let last = press(80, 120).last().unwrap().state_hash;
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&served["commands_done"], &served["ticks_paused"]), (&8.into(), &10.into()));
    assert_eq!(served["state_hash"], format!("{last:016x}"));
    let trace = out.join("session.trace");
    let args = ["replay", text(&trace), "--model", text(&place.model), "--json"];
    let replayed = run(args).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    assert_eq!((&replayed["ticks"], &replayed["commands"]), (&120.into(), &8.into()));
    assert_eq!(replayed["hashes_compared"], 128);
    assert_eq!(summary(&out)["sweeps_per_tick"], 4, "what the session began with");
}

#[test]
fn commands_that_mean_nothing_change_nothing_and_say_why() {
    let _turn = turn();
    let place = Place::new("refused");
    let serve = serve(&place, &["--ticks", "2"]);
    let commander = Commander::join(&place.scene);
    let rest = commander.order(Order { kind: 1, ..Order::default() });
    assert_eq!((rest.result, rest.reason), (0, 0));
    let set = |parameter, value| Order { kind: 4, parameter, value, ..Order::default() };
    for (order, reason) in [
        (Order::default(), 1),
        (Order { kind: 77, ..Order::default() }, 1),
        (Order { kind: 2, reserved: 1, ..Order::default() }, 1),
        (Order { kind: 1, parameter: 1, ..Order::default() }, 2),
        (set(9, 1.0), 2),
        (set(1, 0.0), 3),
        (set(1, 1001.0), 3),
        (set(1, 2.5), 3),
        (set(2, f32::NAN), 3),
        (set(3, f32::INFINITY), 3),
        (set(4, 3.0), 3),
        (set(5, 0.1), 4),
    ] {
        let wanted = Reply { result: 1, reason, ..rest };
        assert_eq!(commander.order(order), wanted, "{order:?}");
    }
    let refused = place.command(&["set", "step=0.1"]).with(2);
    assert!(refused.err.contains("start it again"), "{}", refused.err);
    let outsider = Outsider::join(&place.scene, true);
    outsider.send(pose(0));
    assert_eq!(outsider.receive().flags & SAFE_STATE, 0);
    outsider.send(pose(1));
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&served["commands_done"], &served["commands_refused"]), (&1.into(), &12.into()));
}

#[test]
fn sweeps_stay_where_time_depends_on_them() {
    let _turn = turn();
    let place = Place::new("fixed");
    let serve = serve(&place, &["--scheme", "rkl2"]);
    let refused = place.command(&["set", "sweeps=9"]).with(2);
    assert!(refused.err.contains("reason 4"), "{}", refused.err);
    place.command(&["set", "max_force_n=off"]).with(0);
    serve.interrupt().with(130);
}

#[test]
fn without_a_server_both_say_what_to_start() {
    let place = Place::new("nobody");
    let refused = place.command(&["reset"]).with(2);
    assert!(refused.err.contains("start chaincell serve"), "{}", refused.err);
    let args = ["state", "--scene", &place.scene, "--once", "--wait-for-server-s", "0.2"];
    let refused = run(args).with(2);
    assert!(refused.err.contains("start chaincell serve"), "{}", refused.err);
    let refused = run(["serve", text(&place.model), "--state-hz", "1001"]).with(2);
    assert!(refused.err.contains("--state-hz 1001"), "{}", refused.err);
}

#[test]
fn states_that_are_off_are_not_sent() {
    let _turn = turn();
    let place = Place::new("off");
    let serve = serve(&place, &["--state-hz", "0"]);
    let refused = run(["state", "--scene", &place.scene]).with(2);
    assert!(refused.err.contains("--state-hz above 0"), "{}", refused.err);
    serve.interrupt().with(130);
}

/// Started first, it sees the states of the server that comes.
#[test]
fn a_viewer_waits_for_a_server_that_is_starting() {
    let _turn = turn();
    let place = Place::new("waits");
    let mut viewer = Running::chaincell(["state", "--scene", &place.scene, "--once", "--json"]);
    std::thread::sleep(Duration::from_millis(500));
    assert!(viewer.is_running());
    let serve = place.serve(&[]);
    let outsider = Outsider::join(&place.scene, true);
    let mut tick = 0;
    while viewer.is_running() {
        outsider.send(Pose { tick, ..Pose::default() });
        tick += 1;
        std::thread::sleep(Duration::from_millis(1));
        assert!(tick < 20_000, "no end of the viewer");
    }
    assert!(viewer.end(SHORT).with(0).json()["nodes"].as_u64() > Some(0));
    serve.interrupt().with(130);
    let args = ["state", "--scene", &place.scene, "--wait-for-server-s"];
    let refused = run([&args[..], &["0.2"]].concat()).with(2);
    assert!(refused.err.contains("no states on"), "{}", refused.err);
    run([&args[..], &["nan"]].concat()).with(2);
}
