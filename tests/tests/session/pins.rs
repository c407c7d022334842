//! Pins by command and by option, as outside programs and `chaincell command` see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::array;
use std::path::Path;

use chaincell_tests::files::{Table, is_hash, summary, text};
use chaincell_tests::outsider::{
    Commander, Order, Outsider, Pose, Row, Viewer, largest_step_n, size,
};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::remark::{row, says};
use chaincell_tests::{chaincell, run, turn};

use crate::dragging::{DEEP, pose, serve};

/// A grip drags the tissue along, a pin takes the place of the grip, and is released: replayed to the same bits.
#[test]
fn a_pin_by_command_takes_over_from_a_grip() {
    let _turn = turn();
    let place = Place::on_surface("pins");
    let out = place.file("out");
    let pinned = ["--pin", "0.02,0.02,0.04,0.006,50"];
    let options = ["--ticks", "300", "--out", text(&out)];
    let serve = serve(&place, &[&options[..], &pinned].concat());
    let outsider = Outsider::join(&place.scene, true);
    outsider.play(0..DEEP + 1, pose);
    place.command(&["grip"]).with(0);
    let dragged = outsider.play(DEEP + 1..160, pose);
    let set = place.command(&["pin"]).with(0);
    assert_eq!(set.json()["pin"], 1);
    place.command(&["let-go", "--ticks", "40"]).with(0);
    let passed = outsider.play(160..220, pose);
    let commander = Commander::join(&place.scene);
    let nobody = commander.order(Order { kind: 9, parameter: 7, value: 20.0, ..Order::default() });
    assert_eq!((nobody.result, nobody.reason), (1, 15), "{nobody:?}");
    let rigid = Order { kind: 8, parameter: 3, value: f32::INFINITY, ..Order::default() };
    assert_eq!(commander.order(rigid).reason, 9);
    assert_eq!(commander.order(Order { parameter: 0, value: -1.0, ..rigid }).reason, 3);
    // The first pin is that of the option.
    place.command(&["unpin", "1", "--ticks", "40"]).with(0);
    let released = outsider.play(220..300, pose);
    let last = [&dragged[dragged.len() - 1..], &passed, &released].concat();
    let (largest_n, step_n) = (dragged.last().unwrap().force_n[0].abs(), largest_step_n(&last));
    assert!(step_n < 0.2 * f64::from(largest_n), "a step of {step_n} N of {largest_n} N");
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&served["commands_done"], &served["commands_refused"]), (&4.into(), &3.into()));
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    assert_eq!((&replayed["commands"], &replayed["hashes_compared"]), (&5.into(), &305.into()));
}

/// Middle of the top, beside which the sphere presses \[m\].
const TOP_M: [f32; 3] = [0.0, 0.0, 0.04];

/// A pin under the sphere.
const UNDER: Order = Order {
    kind: 10,
    parameter: 0,
    value: f32::INFINITY,
    reserved: 0,
    point_m: [0.0, 0.002, 0.04],
    radius_m: 0.008,
};

/// Distance of a node from the middle of the top \[m\].
fn from_top_m(node: &Row) -> f64 {
    size(array::from_fn(|axis| node.position_m[axis] - TOP_M[axis]))
}

/// Places that cannot be are refused with the remedy, and the state stays as it is. Returns the number that the server
/// refused.
#[track_caller]
fn refuses_bad_places(place: &Place, state_hash: u64) -> u64 {
    for (at, remedy) in [
        ("nan,0,0.04,0.008", "as in 0,0,0.04,0.006"),
        ("0,0,0.04,-0.008", "the radius of a pin must be above 0"),
        ("0,0,0.4,0.008", "move the point, or take a larger radius"),
    ] {
        let refused = place.command(&["pin", "--at", at]).with(2).err;
        assert!(refused.contains(remedy), "{at}: {refused}");
    }
    let both = place.command(&["pin", "--at", "0,0,0.04,0.008", "--tool", "0"]).with(2).err;
    assert!(both.contains("cannot be used with"), "{both}");
    // As messages, of which the last one releases a pin and has a place.
    let commander = Commander::join(&place.scene);
    let bad = [
        (Order { point_m: [0.0, f32::NAN, 0.04], ..UNDER }, 18),
        (Order { radius_m: -0.008, ..UNDER }, 19),
        (Order { radius_m: f32::NAN, ..UNDER }, 19),
        (Order { value: f32::NAN, ..UNDER }, 3),
        (Order { value: 1.0e-9, ..UNDER }, 3),
        (Order { parameter: 1, ..UNDER }, 2),
        (Order { point_m: [0.0, 0.002, 0.4], ..UNDER }, 17),
        (Order { kind: 9, value: 20.0, ..UNDER }, 3),
    ];
    for (order, reason) in bad {
        let reply = commander.order(order);
        let found = (reply.result, reply.reason, reply.state_hash);
        assert_eq!(found, (1, reason, state_hash), "{order:?}");
    }
    // One place of the command line came as far as the server.
    1 + bad.len() as u64
}

/// The surface under the sphere is pinned before a press, stays where it is, and is released: played again to the same
/// bits from the trace, and from the stream of a mirror.
#[test]
fn a_place_is_pinned_in_a_running_session() {
    let _turn = turn();
    let place = Place::on_surface("pins-at");
    let out = place.file("out");
    let options = ["--ticks", "301", "--out", text(&out), "--state-hz", "1000"];
    let serve = serve(&place, &options);
    let viewer = Viewer::join(&place.scene);
    let (_, rest) = viewer.after(0);
    let top = rest.iter().position(|node| from_top_m(node) < 1.0e-5).unwrap();
    let moved_m = |ticks_answered| from_top_m(&viewer.after(ticks_answered).1[top]);
    let press = |tick: u64| Pose { tick, ..pose(tick.min(DEEP)) };
    let outsider = Outsider::join(&place.scene, true);
    let away = outsider.play(0..6, press)[5];
    let refused = refuses_bad_places(&place, away.state_hash);
    let set = place.command(&["pin", "--at", "0,0.002,0.04,0.008"]).with(0).json();
    assert_eq!((&set["pin"], &set["tick"]), (&0.into(), &5.into()));
    let held = outsider.play(6..140, press);
    let held_m = moved_m(140);
    place.command(&["unpin", "0", "--ticks", "40"]).with(0);
    let released = outsider.play(140..300, press);
    let free_m = moved_m(300);
    outsider.play(300..301, press);
    // The pin bears the press, and its release is no jump.
    let [held_n, free_n] = [&held, &released].map(|seen| size(seen.last().unwrap().force_n));
    assert!(held_m < 0.5 * free_m && free_m > 2.0e-4, "{held_m} m held, {free_m} m free");
    assert!(held_n > 1.1 * free_n && free_n > 0.0, "{held_n} N held, {free_n} N free");
    let step_n = largest_step_n(&[&held[held.len() - 1..], &released].concat());
    assert!(step_n < 0.2 * held_n, "a step of {step_n} N of {held_n} N");
    let served = serve.end(SHORT).with(0).json();
    assert_eq!(
        (&served["commands_done"], &served["commands_refused"]),
        (&2.into(), &refused.into())
    );
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    assert_eq!((&replayed["commands"], &replayed["hashes_compared"]), (&2.into(), &303.into()));
    let program = chaincell().get_program().to_owned();
    let mirrored = [text(Path::new(&program)), "mirror", text(&out)];
    let followed = run([&["follow", "--json", "--"], &mirrored[..]].concat()).with(0).json();
    assert_eq!(followed["state_hash"], served["state_hash"]);
}

/// The tissue's side of `cosim` sets them once, and the replay sets them again from the trace.
#[test]
fn pins_and_a_stress_limit_of_cosim_are_those_of_its_session() {
    let _turn = turn();
    let place = Place::on_surface("pins-cosim");
    let out = place.file("out");
    let args = ["cosim", text(&place.model), "--seconds", "0.3", "--late-share", "off"];
    let (probe, to) = (["--contact", "probe:0.006"], ["--out", text(&out)]);
    let pins = ["--pin", "0.02,0.02,0.04,0.006,50", "--pin=-0.02,0.02,0.04,0.006"];
    let limit = ["--stress-limit-pa", "1"];
    let ended = run([&args[..], &probe, &to, &pins, &limit].concat()).with(0);
    let found = summary(&out);
    assert!(is_hash(&found["state_hash"]), "{found}");
    assert_eq!(found["state_hash"], found["replay_state_hash"]);
    let forces = place.file("forces.csv");
    let again = ["replay", text(&out), "--pin-forces", text(&forces), "--json"];
    let replayed = run(again).with(0).json();
    assert_eq!((&replayed["state_hash"], &replayed["commands"]), (&found["state_hash"], &2.into()));
    // Of each tick the force on both; the tool touches between them.
    let rows = Table::read(&forces);
    assert_eq!(rows.rows.len() as u64, 2 * found["ticks_answered"].as_u64().unwrap());
    for pin in &replayed["pins"].as_array().unwrap()[..] {
        assert!(pin["largest_force_n"].as_f64().unwrap() > 1.0e-4, "{replayed}");
    }
    // The limit is watched at the tissue's side, and a page plays the pins.
    says(&ended.out, "stress", &["after von Mises", "above the limit of 1 Pa"]);
    assert!(found["stress"]["nodes_above"].as_u64().unwrap() > 0, "{found}");
    assert_eq!(ended.err.matches("above --stress-limit-pa 1").count(), 1, "{}", ended.err);
    assert!(row(&ended.out, "view").is_some(), "{}", ended.out);
    let page = place.file("page.html");
    run(["view", text(&out), "--html", text(&page)]).with(0);
}

/// A session is refused before anything is measured, printed or written.
#[test]
fn cosim_refuses_pins_and_limits_that_the_body_does_not_take() {
    let _turn = turn();
    let place = Place::on_surface("pins-refused");
    let out = place.file("out");
    let args = ["cosim", text(&place.model), "--seconds", "0.2", "--out", text(&out)];
    let probe = ["--contact", "probe:0.006"];
    let beside = "--pin 0,0,0.4,0.006: no sample of the surface lies within the radius";
    for (options, wanted) in [
        ([&probe[..], &["--pin", "0,0,0.4,0.006"]].concat(), beside),
        (vec!["--pin", "0,0,0.04,0.006"], "pass --contact probe:RADIUS or --tool"),
        (vec!["--stress-limit-pa", "-1"], "--stress-limit-pa -1: must be above 0"),
    ] {
        let refused = run([&args[..], &options[..]].concat()).with(2);
        assert!(refused.err.contains(wanted), "{options:?}: {}", refused.err);
        assert!(refused.out.is_empty() && !out.exists(), "{options:?}: {}", refused.out);
    }
}

#[test]
fn serve_names_the_page_of_a_session_that_begins_with_pins() {
    let _turn = turn();
    let place = Place::on_surface("pins-view");
    let out = place.file("out");
    let always = ["--contact", "probe:0.006", "--watchdog-ms", "0", "--ramp-ms", "0"];
    let options = ["--ticks", "20", "--out", text(&out), "--pin", "0.02,0.02,0.04,0.006"];
    let serve = place.serve(&[&always[..], &options].concat());
    Outsider::join(&place.scene, true).play(0..20, pose);
    let said = serve.end(SHORT).with(0).out;
    assert!(row(&said, "verdict").is_some() && row(&said, "view").is_some(), "{said}");
}
