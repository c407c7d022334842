//! Pins by command and by option, as outside programs and `chaincell command` see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::text;
use chaincell_tests::outsider::{Commander, Order, Outsider, largest_step_n};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
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
