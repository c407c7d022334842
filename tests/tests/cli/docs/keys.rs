//! `host/REFERENCE.md` names every key that the commands print, in the row of its command.

use chaincell_tests::files::{bake, scratch, text};
use chaincell_tests::place::Place;
use chaincell_tests::{Running, process::SHORT, run, turn};
use serde_json::Value;

use super::reference::{reference, rows};

/// The rows of keys that several commands have.
const SHARED: [&str; 2] = ["several commands", "parameters in force"];

/// Keys of an object, those of its objects apart.
fn keys(what: &str, object: &Value) -> Vec<(String, String)> {
    let object = object.as_object().unwrap();
    object.keys().map(|key| (what.to_owned(), key.clone())).collect()
}

#[test]
fn the_reference_names_every_key() {
    let _turn = turn();
    let place = Place::new("keys");
    let model = place.model.to_str().unwrap();
    let out = place.folder.path().join("out");
    let session = out.to_str().unwrap();
    let mut found = keys("info", &run(["info", model, "--json"]).with(0).json());
    let folder = scratch();
    let body = ["--young-pa", "5000"];
    let body = bake(folder.path(), "box:4x4x3x0.01", &body);
    let of_probe = run(["info", text(&body), "--probe", "0.01", "--json"]).with(0).json();
    found.extend(keys("info --probe", &of_probe["probe"]));
    let touching = Place::on_surface("keys-contacts");
    let server = touching.serve(&["--contact", "probe:0.006"]);
    let contacts = run(["contacts", "--scene", &touching.scene, "--once", "--json"]);
    found.extend(keys("contacts", &contacts.with(0).json()));
    server.interrupt().with(130);
    let serve = place.serve(&["--ticks", "200", "--json", "--late-share", "off"]);
    let control =
        ["control", "--scene", &place.scene, "--seconds", "0.1", "--wait-for-server-s", "10"];
    let control = || run(control.iter().chain(&["--json", "--late-share", "off"]));
    found.extend(keys("control", &control().with(0).json()));
    let state = run(["state", "--scene", &place.scene, "--once", "--json"]);
    found.extend(keys("state", &state.with(0).json()));
    let command = run(["command", "--scene", &place.scene, "--json", "reset"]);
    found.extend(keys("command", &command.with(0).json()));
    control().with(0);
    found.extend(keys("serve", &serve.end(SHORT).with(0).json()));
    let cosim = ["cosim", model, "--contact", "40", "--seconds", "0.2", "--out", session, "--json"];
    let cosim = Running::chaincell([&cosim[..], &["--late-share", "off"]].concat()).end(SHORT);
    found.extend(keys("cosim", &cosim.with(0).json()));
    let path = out.join("path.csv");
    let offline = place.folder.path().join("offline");
    let files = ["--path", path.to_str().unwrap(), "--out", offline.to_str().unwrap()];
    let run = run(["run", model, "--contact", "40", "--recorded", "--json"].iter().chain(&files));
    found.extend(keys("run", &run.with(0).json()));
    let named = rows(&reference(), "command");
    let is_named = |what: &str, key: &str| {
        let cells = named.get(what).into_iter().chain(SHARED.map(|row| &named[row]));
        cells.flat_map(|cell| cell.split([' ', ',', ';', ':'])).any(|word| word == key)
    };
    let missing: Vec<_> = found.iter().filter(|(what, key)| !is_named(what, key)).collect();
    assert!(missing.is_empty(), "host/REFERENCE.md does not name {missing:?}");
    assert!(found.len() > 100, "only {} keys were seen", found.len());
}
