//! Pins by command and by option, as outside programs and `chaincell command` see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::{is_hash, summary, text};
use chaincell_tests::outsider::{Commander, Order, Outsider, largest_step_n};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::remark::{row, says};
use chaincell_tests::{run, turn};

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
    let nobody = commander.order(Order { kind: 9, parameter: 7, value: 20.0, reserved: 0 });
    assert_eq!((nobody.result, nobody.reason), (1, 15), "{nobody:?}");
    let rigid = Order { kind: 8, parameter: 3, value: f32::INFINITY, reserved: 0 };
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
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!((&replayed["state_hash"], &replayed["commands"]), (&found["state_hash"], &2.into()));
    // The limit is watched at the tissue's side, and no page is named that would not play the pins.
    says(&ended.out, "stress", &["after von Mises", "above the limit of 1 Pa"]);
    assert!(found["stress"]["nodes_above"].as_u64().unwrap() > 0, "{found}");
    assert_eq!(ended.err.matches("above --stress-limit-pa 1").count(), 1, "{}", ended.err);
    assert_eq!(row(&ended.out, "view"), None, "{}", ended.out);
    let page = place.file("page.html");
    let refused = run(["view", text(&out), "--html", text(&page)]).with(2).err;
    assert!(refused.contains("sets pins"), "{refused}");
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
fn serve_names_no_page_of_a_session_that_begins_with_pins() {
    let _turn = turn();
    let place = Place::on_surface("pins-view");
    let out = place.file("out");
    let always = ["--contact", "probe:0.006", "--watchdog-ms", "0", "--ramp-ms", "0"];
    let options = ["--ticks", "20", "--out", text(&out), "--pin", "0.02,0.02,0.04,0.006"];
    let serve = place.serve(&[&always[..], &options].concat());
    Outsider::join(&place.scene, true).play(0..20, pose);
    let said = serve.end(SHORT).with(0).out;
    assert!(row(&said, "verdict").is_some() && row(&said, "view").is_none(), "{said}");
}
