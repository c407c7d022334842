//! What is refused, with which kind, and what the text says.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use chaincell_client::services::{Domain, SceneServices, subscriber};
use chaincell_client::{Client, Error, Kind, Options, Role, ToolPose};
use chaincell_tests::files::text;
use chaincell_tests::outsider::{OtherPoses, OtherService};
use chaincell_tests::place::Place;
use chaincell_tests::{run, turn};

use super::{answered, options, pose, press, viewer};

#[track_caller]
fn refusal(options: &Options) -> Error {
    Client::open(&Options { server_wait_ns: 1_000_000, ..options.clone() }).unwrap_err()
}

#[track_caller]
fn says(error: &Error, kind: Kind, parts: &[&str]) {
    assert_eq!(error.kind(), kind, "{error}");
    for part in parts {
        assert!(error.to_string().contains(part), "no {part}: {error}");
    }
}

#[test]
fn a_scene_without_a_server_is_none() {
    let place = Place::new("client-nobody");
    let error = refusal(&options(&place));
    says(&error, Kind::NoServer, &["no server on scene", &place.scene, "chaincell serve"]);
    let viewer = Options { role: Role::Viewer, ..options(&place) };
    says(&refusal(&viewer), Kind::NoServer, &["no server"]);
}

/// A server takes up its ports one after the other; a pose sent before the last of them would be lost.
#[test]
fn a_server_that_hears_no_tools_yet_is_none() {
    let place = Place::new("client-early");
    let scene = SceneServices::open(Some(&place.scene), &Domain::default()).unwrap();
    let _forces = scene.publisher(&scene.forces, "early", "serve").unwrap();
    assert!(!scene.is_served());
    says(&refusal(&options(&place)), Kind::NoServer, &["no server"]);
    let tools = subscriber(&scene.tools, "early").unwrap();
    let mut client = Client::open(&options(&place)).unwrap();
    client.send(&[pose(0)]).unwrap();
    assert_eq!(tools.receive().unwrap().unwrap().tick, 1);
}

#[test]
fn a_scene_of_another_version_is_refused_with_both() {
    let place = Place::new("client-version");
    let other = OtherService::<OtherPoses>::create(&place.scene, "tools").unwrap();
    let error = refusal(&options(&place));
    says(&error, Kind::Version, &["chaincell.ToolPoses.v2 of 344 bytes", "of another release"]);
    drop(other);
    says(&refusal(&options(&place)), Kind::NoServer, &[]);
}

#[test]
fn a_scene_has_one_controller_and_many_viewers() {
    let _turn = turn();
    let place = Place::new("client-two");
    let serve = place.serve(&["--json"]);
    let mut first = Client::open(&options(&place)).unwrap();
    press(&mut first, 0..=10);
    says(
        &refusal(&options(&place)),
        Kind::Taken,
        &["has a running chaincell control", "another scene"],
    );
    let control = run(["control", "--scene", &place.scene, "--seconds", "0.1"]).with(2);
    assert!(control.err.contains("has a running chaincell control"), "{}", control.err);
    let viewers = [viewer(&place), viewer(&place)];
    press(&mut first, 11..=20);
    drop(first);
    let mut second = Client::open(&options(&place)).unwrap();
    press(&mut second, 0..=9);
    drop((second, viewers));
    let served = serve.interrupt().with(130).json();
    assert_eq!((&served["ticks_executed"], &served["publishers"]), (&31.into(), &2.into()));
}

#[test]
fn more_programs_than_there_are_places_for_are_refused() {
    let _turn = turn();
    let place = Place::new("client-full");
    let serve = place.serve(&[]);
    let mut viewers = Vec::new();
    let error = loop {
        assert!(viewers.len() < 64);
        match Client::open(&Options { role: Role::Viewer, ..options(&place) }) {
            Ok(viewer) => viewers.push(viewer),
            Err(error) => break error,
        }
    };
    says(&error, Kind::Full, &["no place left: at most 20 programs", "end one"]);
    assert_eq!(viewers.len(), 19, "20 programs with the server");
    drop(viewers);
    viewer(&place);
    serve.interrupt().with(130);
}

#[test]
fn a_folder_that_others_may_write_is_refused() {
    let place = Place::new("client-rights");
    let root = place.folder.path().join("open");
    fs::create_dir(&root).unwrap();
    fs::set_permissions(&root, fs::Permissions::from_mode(0o777)).unwrap();
    let domain = Domain { root: Some(root.clone()), ..Domain::default() };
    let error = refusal(&Options { domain, ..options(&place) });
    says(&error, Kind::Permission, &["chmod 700", text(&root)]);
}

#[test]
fn names_and_options_that_cannot_be_are_refused() {
    for scene in ["", "a b", "a/b", "tools"] {
        let options = Options { scene: Some(scene.into()), ..Options::default() };
        says(&refusal(&options), Kind::Argument, &["`scene`", "give 1 to 64"]);
    }
    says(
        &refusal(&Options { watchdog_ms: 60_001, ..Options::default() }),
        Kind::Argument,
        &["60000"],
    );
    says(&refusal(&Options { ramp_ms: 60_001, ..Options::default() }), Kind::Argument, &["60000"]);
}

#[test]
fn a_pose_that_is_none_is_not_sent_and_the_session_goes_on() {
    let _turn = turn();
    let place = Place::new("client-nan");
    let serve = place.serve(&["--watchdog-ms", "0", "--ramp-ms", "0", "--json"]);
    let mut client = Client::open(&options(&place)).unwrap();
    let last = press(&mut client, 0..=20).pop().unwrap();
    let bad = ToolPose { position_m: [0.0, f32::NAN, 0.0].into(), ..pose(21) };
    says(&client.step(&[bad], 0).unwrap_err(), Kind::Pose, &["tool 0", "not finite", "metres"]);
    let half = ToolPose { engaged: 2, ..pose(21) };
    says(&client.send(&[half]).unwrap_err(), Kind::Pose, &["tool 0", "`engaged`", "give 1"]);
    says(&client.send(&[pose(21), bad]).unwrap_err(), Kind::Pose, &["tool 1"]);
    says(&client.step(&[], 0).unwrap_err(), Kind::Pose, &["1 to 8"]);
    let next = answered(&mut client, &[pose(21)]);
    assert_eq!((next.tick, next.answers), (last.tick + 1, last.answers + 1));
    drop(client);
    let served = serve.interrupt().with(130).json();
    assert_eq!((&served["ticks_executed"], &served["poses_missing"]), (&22.into(), &0.into()));
    assert_eq!(served["flag_ticks"].get("bad_sample"), None);
}
