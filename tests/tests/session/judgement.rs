//! What `serve`, `control` and `cosim` say when their own figures are not to be trusted, with the words that name the
//! remedy, in text and in JSON; what `control` writes, and the page that each of them names at its end.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;
use std::time::Duration;

use chaincell_client::{Client, Options, ToolPose};
use chaincell_tests::files::text;
use chaincell_tests::outsider::Outsider;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::remark::{row, says};
use chaincell_tests::{Running, run, turn};
use serde_json::{Value, json};

/// How often a session that the machine disturbed is tried again.
const ATTEMPTS: usize = 5;
/// Ticks of a press, and the time that one may take on a machine at work.
const TICKS: u16 = 200;
const WAIT_NS: u64 = 20_000_000_000;
/// Without watchdog and ramp the answered force is the tissue's own, however late a pose comes.
const AT_ONCE: [&str; 4] = ["--watchdog-ms", "0", "--ramp-ms", "0"];

/// A session of `serve` whose every pose is answered before the next one: its text, or the line of its JSON.
fn served(place: &Place, options: &[&str], pose: impl Fn(f32) -> [f32; 3]) -> String {
    let ticks = TICKS.to_string();
    let plain = ["--ticks", &ticks, "--budget-us", "off"];
    let server = place.serve(&[options, &plain, &AT_ONCE].concat());
    let scene = Some(place.scene.clone());
    let mut client =
        Client::open(&Options { scene, watchdog_ms: 0, ramp_ms: 0, ..Options::default() }).unwrap();
    for tick in 0..TICKS {
        let at = pose(f32::from(tick) / f32::from(TICKS));
        let pose = ToolPose::at(at.into(), u32::from(tick > 0));
        client.step(&[pose], WAIT_NS).unwrap();
        // A server drops poses beyond 2,000 a second.
        std::thread::sleep(Duration::from_millis(1));
    }
    drop(client);
    server.end(SHORT).with(0).out
}

/// From above the middle of the top, at 40 mm, down by this depth.
fn down(depth_m: f32) -> impl Fn(f32) -> [f32; 3] {
    move |share| [0.0, 0.0, 0.045 - share * depth_m]
}

fn judgement(out: &str) -> Value {
    let json: Value = serde_json::from_str(out.lines().last().unwrap()).unwrap();
    json["judgement"].clone()
}

#[test]
fn serve_judges_depth_mesh_and_pace() {
    let _turn = turn();
    let place = Place::on_surface("judge-serve");
    let said = served(&place, &["--contact", "probe:0.004"], down(0.03));
    says(
        &said,
        "depth",
        &["asked 2", "held back at ", "press less deep", "larger tool", "info --probe RADIUS"],
    );
    says(&said, "mesh", &["for a radius of 4.00 mm", "% off", "--fill ", "make that 14 %"]);
    says(&said, "pace", &["1 kHz on this machine"]);
    assert_eq!((row(&said, "contact"), row(&said, "place")), (None, None), "{said}");
    let judgement = judgement(&served(&place, &["--contact", "probe:0.004", "--json"], down(0.03)));
    let held = &judgement["held_back"][0];
    assert!(
        held["reached_m"].as_f64().unwrap() < 0.6 * held["asked_m"].as_f64().unwrap(),
        "{judgement}"
    );
    assert!(
        judgement["mesh"]["force_error"] == 0.32 && judgement["pace"]["load_p50"].is_f64(),
        "{judgement}"
    );
}

#[test]
fn serve_judges_a_tool_beside_the_body_and_a_corner() {
    let _turn = turn();
    let place = Place::on_surface("judge-beside");
    let away = |share: f32| [0.0, 0.0, 0.3 - 0.01 * share];
    let said = served(&place, &["--contact", "probe:0.004"], away);
    says(
        &said,
        "contact",
        &["the tool never touched the body; bring it nearer", "chaincell info MODEL"],
    );
    let found = judgement(&served(&place, &["--contact", "probe:0.004", "--json"], away));
    assert_eq!(found["untouched_tools"], json!([0]));
    // Held cells by default are those of a corner.
    let auto = ["--contact", "auto"];
    let said = served(&place, &auto, down(0.0));
    says(&said, "place", &["at a corner or an edge", "--contact cells:SELECTOR"]);
    let found = judgement(&served(&place, &[&auto[..], &["--json"]].concat(), down(0.0)));
    assert!(found["corner_deg"].as_f64().unwrap() > 40.0, "{found}");
}

/// A tick of so many sweeps takes longer than a millisecond anywhere.
#[test]
fn serve_judges_a_body_too_slow_to_feel() {
    let _turn = turn();
    let place = Place::on_surface("judge-slow");
    let slow = ["--contact", "auto", "--sweeps", "300"];
    let said = served(&place, &slow, down(0.0));
    says(&said, "pace", &["does NOT fit 1 kHz", "take a faster "]);
}

#[test]
fn control_judges_a_tool_beside_the_body() {
    let _turn = turn();
    let place = Place::on_surface("judge-control");
    let ticks = ["--contact", "probe:0.004", "--ticks", "100"];
    let away = ["--touch-m", "0,0,0.3"];
    let rest = ["--seconds", "0.1", "--late-share", "off"];
    let press = |from: &[&str], more: &[&str]| {
        let server = place.serve(&ticks);
        let said =
            run([&["control", "--scene", &place.scene], from, &rest[..], more].concat()).with(0);
        server.end(SHORT).with(0);
        said.out
    };
    let said = press(&away, &[]);
    says(
        &said,
        "contact",
        &["the tool never touched the body", "--model MODEL --contact probe:RADIUS"],
    );
    let model = ["--model", place.model.to_str().unwrap(), "--contact", "probe:0.004"];
    let said = press(&away, &model);
    says(
        &said,
        "contact",
        &["the tool never touched the body", "bring it nearer", "chaincell info MODEL"],
    );
    assert_eq!(judgement(&press(&away, &["--json"]))["untouched_tools"], json!([0]));
    let inside = ["--touch-m", "0,0,0.005", "--depth-m", "0.001"];
    says(&press(&inside, &[]), "contact", &["it began inside the body", "begin outside"]);
}

/// The page that a command names at its end opens as it is printed.
#[track_caller]
fn page_opens(place: &Place, said: &str) {
    let named = row(said, "view").unwrap_or_default();
    let args = named.strip_prefix("chaincell view").map(str::split_whitespace);
    let page = place.file("page.html");
    let html = ["--html", text(&page)];
    run(["view"].into_iter().chain(args.unwrap()).chain(html)).with(0);
    assert!(std::fs::metadata(&page).unwrap().len() > 100_000, "{named}");
    std::fs::remove_file(&page).unwrap();
}

#[test]
fn control_writes_the_curve_of_its_press() {
    let _turn = turn();
    let place = Place::on_surface("judge-curve");
    let (out, served) = (place.file("out"), place.file("served"));
    let contact = ["--contact", "probe:0.004"];
    let ends = ["--ticks", "200", "--out", text(&served)];
    let server = place.serve(&[&contact[..], &ends, &AT_ONCE].concat());
    let model = place.model.to_str().unwrap();
    let press = ["control", "--scene", &place.scene, "--model", model, "--depth-m", "0.003"];
    let ends = ["--seconds", "0.2", "--late-share", "off", "--out", text(&out)];
    let press = [&press[..], &contact, &ends, &AT_ONCE].concat();
    let said = run(&press).with(0).out;
    let of_server = server.end(SHORT).with(0).out;
    let read = |folder: &Path, file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
    assert_eq!(read(&out, "force.csv"), read(&served, "force.csv"));
    assert_eq!(read(&out, "path.csv").lines().count(), 201);
    assert!(read(&out, "force.svg").contains("Force on the tool over time"));
    assert!(read(&out, "force_depth.svg").contains("Force on the tool over depth"));
    let summary: Value = serde_json::from_str(&read(&out, "summary.json")).unwrap();
    assert!(summary["ticks_answered"] == 200 && summary["judgement"].is_object(), "{summary}");
    says(&said, "results", &[text(&out)]);
    page_opens(&place, &said);
    page_opens(&place, &of_server);
    // Earlier results stay.
    let refused = run(&press).with(2).err;
    assert!(refused.contains("is not empty") && refused.contains("--force"), "{refused}");
    let refused = run([&press[..], &["--force", "--repeat", "2"]].concat()).with(2).err;
    assert!(refused.contains("leave --repeat 2 out"), "{refused}");
    assert!(out.join("force.csv").exists());
}

#[test]
fn an_interrupted_control_writes_what_was_answered() {
    let _turn = turn();
    let place = Place::on_surface("judge-early");
    let out = place.file("out");
    let server = place.serve(&["--contact", "auto", "--ticks", "1000000"]);
    let args = ["control", "--scene", &place.scene, "--seconds", "60", "--out", text(&out)];
    let control = Running::chaincell(args);
    Outsider::join(&place.scene, false).after(100);
    let said = control.interrupt().with(130).err;
    server.interrupt().with(130);
    assert!(said.contains("the results so far are in"), "{said}");
    let ticks = |file: &str| -> Vec<u64> {
        let text = std::fs::read_to_string(out.join(file)).unwrap();
        text.lines().skip(1).map(|row| row.split(',').next().unwrap().parse().unwrap()).collect()
    };
    let (sent, answered) = (ticks("path.csv"), ticks("force.csv"));
    assert!(answered.len() > 100 && sent.last() == answered.last(), "{sent:?} {answered:?}");
}

#[test]
fn serve_and_cosim_name_a_page_that_opens() {
    let _turn = turn();
    let place = Place::on_surface("judge-view");
    let auto = ["--contact", "auto"];
    page_opens(&place, &served(&place, &auto, down(0.0)));
    let trace = place.file("a.trace");
    page_opens(
        &place,
        &served(&place, &[&auto[..], &["--record", text(&trace)]].concat(), down(0.0)),
    );
    let session = ["cosim", text(&place.model), "--seconds", "0.1", "--late-share", "off"];
    page_opens(&place, &run(session).with(0).out);
    let control = ["control", "--scene", &place.scene, "--seconds", "0.1", "--late-share", "off"];
    let server = place.serve(&["--contact", "auto", "--ticks", "100"]);
    let said = run(control).with(0).out;
    server.end(SHORT).with(0);
    says(&said, "view", &["chaincell view DIR, of `serve --out DIR`"]);
}

#[test]
fn control_without_a_server_says_at_once_what_it_waits_for() {
    let _turn = turn();
    let place = Place::new("judge-wait");
    let args = ["control", "--scene", &place.scene, "--seconds", "0.1", "--late-share", "off"];
    let long = ["--wait-for-server-s", "100"];
    let mut control = Running::chaincell([&args[..], &long].concat());
    control.notes_until(&format!(
        "waiting for a server on scene {}, at most 100 s: start chaincell serve with the same --scene",
        place.scene
    ));
    let server = place.serve(&["--ticks", "100"]);
    control.end(SHORT).with(0);
    server.end(SHORT).with(0);
    let refused = run([&args[..], &["--wait-for-server-s", "0.1"]].concat()).with(2).err;
    assert!(
        refused.contains("no server on") && refused.contains("--wait-for-server-s"),
        "{refused}"
    );
}

#[test]
fn cosim_judges_depth_mesh_and_corner() {
    let _turn = turn();
    let place = Place::on_surface("judge-cosim");
    let model = place.model.to_str().unwrap();
    let args =
        ["cosim", model, "--seconds", "0.2", "--late-share", "off", "--contact", "probe:0.004"];
    let deep = [&args[..], &["--depth-m", "0.03"]].concat();
    // Where the machine kept the server waiting the tool is inside when it is served again, and does not touch.
    let judged = |more: &[&str]| {
        let session = |_| run([&deep[..], more].concat()).with(0).out;
        let was_served = |out: &String| !out.contains("late on") && !out.contains("\"late\":");
        (0..ATTEMPTS).map(session).find(was_served)
    };
    let (Some(said), Some(json)) = (judged(&[]), judged(&["--json"])) else {
        println!(
            "SKIPPED the judgement of cosim: {ATTEMPTS} times the machine kept the server waiting"
        );
        return;
    };
    says(
        &said,
        "depth",
        &["asked ", "held back at ", "press less deep", "larger tool", "info --probe RADIUS"],
    );
    says(&said, "mesh", &["for a radius of 4.00 mm", "% off", "--fill ", "make that 14 %"]);
    says(&said, "place", &["at a corner or an edge", "--touch-m and --direction"]);
    says(&said, "pace", &["1 kHz on this machine"]);
    let found: Value = serde_json::from_str(&json).unwrap();
    let found = &found["judgement"];
    assert!(
        found["held_back"][0]["asked_m"].as_f64() > found["held_back"][0]["reached_m"].as_f64(),
        "{found}"
    );
    assert!(
        found["mesh"]["force_error"] == 0.32 && found["corner_deg"].as_f64().unwrap() > 40.0,
        "{found}"
    );
    assert!(found["pace"]["load_p50"].is_f64(), "{found}");
}
