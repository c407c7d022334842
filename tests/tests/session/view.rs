//! Pages on a running scene: they see its state and change nothing, are told of a server that is killed and of
//! another model, and command it only where they may.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::text;
use chaincell_tests::outsider::{Outsider, Pose, Viewer};
use chaincell_tests::page::Page;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};

/// A server to which no silence counts as one.
const PATIENT: [&str; 3] = ["--watchdog-ms", "0", "--json"];

/// `chaincell view` on a place's scene, and its address.
fn view(place: &Place, options: &[&str]) -> (Running, String) {
    let args = ["view", text(&place.model), "--scene", &place.scene, "--no-open"];
    let mut view = Running::chaincell([&args, options].concat());
    view.wait_for_line("Ctrl-C ends it");
    let address = view.lines().find(|line| line.starts_with("http://")).unwrap().to_owned();
    (view, address)
}

/// A pose over the middle of the plane, a little lower with every tick.
fn pose(tick: u64) -> Pose {
    Pose { tick, position_m: [0.04, 0.04, -1e-5 * tick as f32], engaged: 1 }
}

#[test]
fn a_page_sees_the_scene_and_a_killed_server_that_comes_back() {
    let _turn = turn();
    let place = Place::new("view");
    let mut serve = place.serve(&PATIENT);
    let (view, address) = view(&place, &[]);
    let mut page = Page::open(&address);
    page.status("live");
    let outsider = Outsider::join(&place.scene, true);
    let rows = Viewer::join(&place.scene);
    let last = outsider.play(1..201, pose).pop().unwrap();
    let frame = page.frame(|frame| frame.tick == 200);
    assert_eq!((frame.hash, frame.tool), (last.state_hash, (pose(200).position_m, last.force_n)));
    assert!(frame.sweeps > 0 && frame.points.last() == Some(&200), "{frame:?}");
    assert!(frame.points.windows(2).all(|pair| pair[0] < pair[1]), "{:?}", frame.points);
    // The same positions, in the order of the image.
    let (stamp, rows) = rows.after(200);
    assert_eq!((stamp.tick, stamp.model_checksum), (200, frame.checksum));
    let sorted = |mut positions: Vec<[u32; 3]>| {
        positions.sort_unstable();
        positions
    };
    let shown = frame.positions_m.iter().map(|at| at.map(f32::to_bits)).collect();
    let sent = rows.iter().map(|row| row.position_m.map(f32::to_bits)).collect();
    assert_eq!(sorted(shown), sorted(sent));
    // A page that joins sees the last state, though nothing moves.
    assert_eq!(Page::open(&address).frame(|_| true), frame);
    serve.kill();
    assert!(page.status("gone").contains("was killed"));
    assert_eq!(Page::open(&address).frame(|_| true), frame);
    let serve = place.serve(&PATIENT);
    page.status("live");
    let again = Outsider::join(&place.scene, true);
    again.play(1..51, pose);
    page.frame(|frame| frame.tick == 50);
    assert_eq!(serve.interrupt().with(130).json()["poses_missing"], 0);
    assert_eq!(view.interrupt().with(0).err, "");
}

#[test]
fn another_model_is_refused_at_the_start_and_later() {
    let _turn = turn();
    let (place, other) = (Place::new("view-model"), Place::stiff("view-other"));
    let mut serve = place.serve(&PATIENT);
    let args = ["view", text(&other.model), "--scene", &place.scene, "--no-open"];
    let refused = run(args).with(2);
    for part in ["another model", "with the model file of chaincell serve"] {
        assert!(refused.err.contains(part), "{}", refused.err);
    }
    let (_view, address) = view(&place, &[]);
    let mut page = Page::open(&address);
    page.status("live");
    serve.kill();
    page.status("gone");
    let served = Place { scene: place.scene.clone(), ..other };
    let _serve = served.serve(&PATIENT);
    assert!(page.status("other_model").contains("another model"));
}

#[test]
fn a_page_commands_the_scene_only_where_it_may() {
    let _turn = turn();
    let place = Place::new("view-commands");
    let serve = place.serve(&PATIENT);
    let (_looking, only_looks) = view(&place, &[]);
    let mut page = Page::open(&only_looks);
    page.say(r#"{"do":"pause"}"#);
    let answer = page.text("done");
    assert!(answer["done"] == false && answer["text"].as_str().unwrap().contains("--commands"));
    let (_commanding, commands) = view(&place, &["--commands"]);
    let mut page = Page::open(&commands);
    let mut ask = |order: &str| {
        page.say(order);
        page.text("done")
    };
    for order in [
        r#"{"do":"set","name":"sweeps","value":3}"#,
        r#"{"do":"pause"}"#,
        r#"{"do":"resume"}"#,
        r#"{"do":"reset"}"#,
    ] {
        assert_eq!(ask(order)["done"], true, "{order}");
    }
    assert_eq!(ask(r#"{"do":"pause"}"#)["done"], true);
    // No state comes in a pause, and its force of 0 is shown all the same.
    // It stays until its poses are seen: those of a controller that leaves at once can be lost to viewers.
    let controller = Outsider::join(&place.scene, true);
    controller.play(1..3, pose);
    page.frame(|frame| frame.tool == (pose(2).position_m, [0.0; 3]));
    drop(controller);
    let mut ask = |order: &str| {
        page.say(order);
        page.text("done")
    };
    for (order, part) in [
        (r#"{"do":"set","name":"sweeps","value":0}"#, "out of range"),
        (r#"{"do":"snapshot"}"#, "no such command"),
        ("pause", "no such command"),
    ] {
        let answer = ask(order);
        assert!(
            answer["done"] == false && answer["text"].as_str().unwrap().contains(part),
            "{answer}"
        );
    }
    let served = serve.interrupt().with(130).json();
    assert_eq!((&served["commands_done"], &served["commands_refused"]), (&5.into(), &1.into()));
}

#[test]
fn cosim_shows_its_session_and_ends_when_the_page_is_closed() {
    let _turn = turn();
    let args = ["cosim", "--view", "--no-open", "--seconds", "3", "--late-share", "off", "--json"];
    let scene = chaincell_tests::scene("view-cosim");
    let mut cosim = Running::chaincell([&args[..], &["--scene", &scene]].concat());
    let notes = cosim.notes_until("the session begins when this page is open");
    let address = notes.iter().find(|line| line.starts_with("http://")).unwrap();
    let mut page = Page::open(address);
    page.frame(|frame| {
        assert!(frame.points.len() <= 64);
        frame.tick >= 1000 && frame.tool.1 != [0.0; 3]
    });
    let ended = page.status("ended");
    assert!(ended.contains("3000 of 3000 ticks answered"), "{ended}");
    drop(page);
    let summary = cosim.end(SHORT).with(0).json();
    assert_eq!(
        (&summary["ticks_answered"], &summary["ticks_unanswered"]),
        (&3000.into(), &0.into())
    );
    let refused = run(["cosim", "--port", "1", "--seconds", "3"]).with(2);
    assert!(refused.err.contains("--port") && refused.err.contains("--view"), "{}", refused.err);
}
