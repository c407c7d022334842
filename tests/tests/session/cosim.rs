//! `cosim`: both processes, every tick answered, the replay the same; also with real anatomy.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::os::unix::process::CommandExt;
use std::path::Path;
use std::time::{Duration, Instant};

use chaincell_host::bake::ORGAN_SIZE;
use chaincell_tests::files::{Table, bake, is_hash, scratch, summary, text};
use chaincell_tests::outsider::Outsider;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, chaincell, run, scene, turn};
use serde_json::Value;

/// What every session of so many ticks says when all went well.
#[track_caller]
fn check_summary(found: &Value, ticks: u64) {
    assert_eq!(found["ticks_sent"], ticks);
    assert_eq!(found["ticks_answered"], ticks);
    assert!(found["missed_deadlines"].as_u64().unwrap() <= ticks);
    for figures in ["step_ns", "round_trip_ns", "floor_wakeup_ns", "floor_round_trip_ns"] {
        let figure = |name: &str| found[figures][name].as_u64().unwrap();
        let ascending = ["p50", "p99", "p999", "p9999", "max"].map(figure);
        assert!(ascending.is_sorted() && ascending[4] > 0, "{figures}: {ascending:?}");
    }
    assert!(is_hash(&found["state_hash"]));
    assert_eq!(found["state_hash"], found["replay_state_hash"]);
    assert_eq!(found["interrupted"], false);
}

#[test]
fn the_organ_without_a_model() {
    let _turn = turn();
    let ended = run(["cosim", "--seconds", "2", "--json", "--late-share", "off"]).with(0);
    let found: Value = serde_json::from_str(&ended.out).expect("one object and nothing else");
    check_summary(&found, 2000);
    let cells = found["cells"].as_u64().unwrap();
    assert!(cells.abs_diff(ORGAN_SIZE as u64) <= ORGAN_SIZE as u64 / 50, "{cells}");
    let readme = include_str!("../../../README.md");
    assert!(readme.contains(&format!("\norgan: {cells} cells, ")), "README has another size");
    let error = &found["force_error"];
    let share = |of: &str| error[of].as_f64().unwrap();
    assert!(0.0 < share("median") && share("median") <= share("p99"), "{error}");
    assert!(share("p99") < 1.0 && error["ticks"].as_u64().unwrap() > 50, "{error}");
    assert_eq!(error["sweeps"], 64);
}

// REQ-COS-12
#[test]
fn a_session_is_replayed_by_run() {
    let _turn = turn();
    let folder = scratch();
    let body = ["--alpha", "0.03", "--stiffness-n-per-m", "40"];
    let model = bake(folder.path(), "box:9x9x5x0.01", &body);
    let (out, again) = (folder.path().join("out"), folder.path().join("again"));
    let how =
        ["--sweeps", "3", "--unloading", "retreat", "--max-force-n", "0.5", "--precision", "fixed"];
    let late = ["--late-share", "off"];
    let args = ["cosim", text(&model), "--seconds", "1", "--out", text(&out), "--json"];
    let ended = run([&args[..], &how, &late].concat()).with(0);
    check_summary(&ended.json(), 1000);
    let copied = out.join("model.chaincell");
    assert_eq!(std::fs::read(&copied).unwrap(), std::fs::read(&model).unwrap());
    assert_eq!(summary(&out)["state_hash"], ended.json()["state_hash"]);
    assert_eq!(Table::read(&out.join("path.csv")).header, "tick,x_m,y_m,z_m,engaged,sweeps");
    assert_eq!(Table::read(&out.join("path.csv")).rows.len(), 1000);
    replay(&out, &again, &how);
    let found = run(["replay", text(&out), "--json"]).with(0).json();
    // A late tick has no hash.
    let hashes = 1000 - ended.json()["ticks_late"].as_u64().unwrap();
    assert_eq!((&found["ticks"], &found["hashes_compared"]), (&1000.into(), &hashes.into()));
    assert_eq!(
        (&found["state_hash"], &found["precision"]),
        (&ended.json()["state_hash"], &"fixed".into())
    );
    // The session's folder is not taken a second time.
    let second = run(args).with(2);
    assert!(second.err.contains("not empty") && second.err.contains("--force"));
}

/// Tools and a delay that is measured are in the trace alone: the second run is the same.
// REQ-COS-12
#[test]
fn tools_and_a_measured_delay_are_replayed() {
    let _turn = turn();
    let folder = scratch();
    let model = bake(folder.path(), "box:7x7x5x0.01", &["--young-pa", "5000"]);
    for how in [
        &["--contact", "probe:0.012"][..],
        &["--tool", "sphere:0.012", "--tool", "capsule:0.01,0.005", "--friction", "0.3"],
        &["--device", "omega", "--delay-ticks", "auto"],
    ] {
        let args = ["cosim", text(&model), "--seconds", "1", "--json", "--late-share", "off"];
        let found = run([&args[..], how].concat()).with(0).json();
        check_summary(&found, 1000);
        // A server that was kept waiting finds the tool inside, where it does not touch.
        let late = found["ticks_late"].as_u64().unwrap();
        if late > 0 && found["never_touched"]["is_inside"] == true {
            println!("SKIPPED the touch of {how:?}: the machine was late, {late} ticks");
        } else {
            assert_eq!(found["never_touched"], Value::Null, "{how:?}");
        }
    }
}

/// Replays a session's folder into another one and compares.
#[track_caller]
fn replay(session: &Path, out: &Path, how: &[&str]) {
    let (model, path) = (session.join("model.chaincell"), session.join("path.csv"));
    let args = ["run", text(&model), "--recorded", "--path", text(&path), "--out", text(out)];
    run([&args, how].concat()).with(0);
    let force = |folder: &Path| std::fs::read(folder.join("force.csv")).unwrap();
    assert!(force(session) == force(out), "the forces differ");
    assert_eq!(summary(session)["state_hash"], summary(out)["state_hash"]);
}

#[test]
fn the_reference_liver() {
    let Some(reference) = chaincell_tests::reference("the_reference_liver") else { return };
    let _turn = turn();
    let folder = scratch();
    let mesh = reference.join("meshes/liver_5762.msh41.msh");
    let sets = reference.join("meshes/liver_5762.sets.json");
    let fix = format!("file:{}#fixed", sets.display());
    let contact = format!("cells:file:{}#patch", sets.display());
    let model = bake(folder.path(), text(&mesh), &["--fix", &fix]);
    let out = folder.path().join("out");
    let how = ["--contact", &contact];
    let args = ["cosim", text(&model), "--seconds", "2", "--out", text(&out), "--json"];
    let ended = run([&args[..], &how, &["--late-share", "off"]].concat()).with(0);
    let found = ended.json();
    check_summary(&found, 2000);
    assert_eq!((&found["cells"], &found["links"]), (&5773.into(), &30358.into()));
    let force = Table::read(&out.join("force.csv"));
    assert_eq!(force.whole("contacts").into_iter().max(), Some(7));
    assert!(force.column("fz_n").iter().any(|force_n| force_n.abs() > 1e-3));
    replay(&out, &folder.path().join("again"), &how);
}

#[test]
fn ctrl_c_ends_a_session_with_its_results_so_far() {
    let _turn = turn();
    for to_group in [false, true] {
        let folder = scratch();
        let model = bake(folder.path(), "plane:21x21x0.01", &[]);
        let (out, name) = (folder.path().join("out"), scene("ctrl-c"));
        let args = ["cosim", text(&model), "--seconds", "30", "--scene", &name, "--json", "--out"];
        let mut command = chaincell();
        command.args(args).arg(&out).process_group(0);
        let cosim = Running::start(&mut command);
        Outsider::join(&name, false).after(300);
        // A terminal's Ctrl-C reaches the children too.
        let ended = if to_group { cosim.interrupt_group() } else { cosim.interrupt() };
        let ended = ended.with(130);
        let place = format!("interrupted; the results so far are in {}", text(&out));
        assert!(ended.err.contains(&place), "{}", ended.err);
        let found = ended.json();
        let ticks = found["ticks_answered"].as_u64().unwrap();
        assert!((300..30_000).contains(&ticks), "{ticks}");
        assert_eq!(found["interrupted"], true);
        assert_eq!(found["state_hash"], found["replay_state_hash"]);
        assert_eq!(Table::read(&out.join("force.csv")).rows.len() as u64, ticks);
        replay(&out, &folder.path().join("again"), &[]);
    }
}

#[test]
fn ctrl_c_before_the_first_tick() {
    let _turn = turn();
    let folder = scratch();
    let model = bake(folder.path(), "plane:9x9x0.01", &[]);
    let out = folder.path().join("out");
    let args = ["cosim", text(&model), "--seconds", "30", "--out", text(&out)];
    let mut cosim = Running::chaincell(args);
    // The heading stands before the machine's floor is measured.
    cosim.wait_for_line(&format!("{}: 81 cells, 144 links, 30 s at 1 kHz", text(&model)));
    let ended = cosim.interrupt().with(130);
    // Nothing is written yet, and nothing says that results are somewhere.
    let said = ended.err.trim();
    assert!(
        said.starts_with("chaincell: interrupted") && !said.contains("results so far"),
        "{said}"
    );
    assert!(
        said.contains("interrupted before there were results") && said.ends_with("holds none"),
        "{said}"
    );
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 0);
}

/// A session of a minute under way, and its two processes.
fn with_children(test: &str) -> (Place, Running, Vec<String>) {
    let place = Place::new(test);
    let args = ["cosim", text(&place.model), "--scene", &place.scene, "--seconds", "60"];
    let cosim = Running::chaincell(args);
    Outsider::join(&place.scene, false).after(100);
    let children = format!("/proc/{0}/task/{0}/children", cosim.id());
    let children = std::fs::read_to_string(children).unwrap();
    let children: Vec<String> = children.split_whitespace().map(str::to_owned).collect();
    assert_eq!(children.len(), 2);
    (place, cosim, children)
}

/// The command line of a process; empty where it has ended.
fn command_line(id: &str) -> String {
    std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default()
}

#[test]
fn a_killed_cosim_leaves_no_process_behind() {
    let _turn = turn();
    let (_place, cosim, children) = with_children("killed-cosim");
    drop(cosim);
    let start = Instant::now();
    while children.iter().any(|id| !command_line(id).is_empty()) {
        assert!(start.elapsed() < SHORT, "{children:?} run on");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn cosim_says_which_side_failed() {
    let _turn = turn();
    let (_place, cosim, children) = with_children("failed-side");
    let serve = children.iter().find(|id| command_line(id).contains("serve")).unwrap();
    let killed = std::process::Command::new("kill").args(["-KILL", serve]).status();
    assert!(killed.unwrap().success());
    let ended = cosim.end(SHORT);
    assert!(ended.code != Some(0) && ended.err.contains("chaincell serve ended"), "{ended:#?}");
}
