//! Pages on a running scene: they see its state and change nothing, are told of a server that is killed and of
//! another model, and command it only where they may.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs::{self, Permissions};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::Command;

use chaincell_tests::files::text;
use chaincell_tests::outsider::{Outsider, Pose, Viewer};
use chaincell_tests::page::Page;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, chaincell, run, turn};

use super::permissions::as_nobody;

/// A server to which no silence counts as one.
const PATIENT: [&str; 3] = ["--watchdog-ms", "0", "--json"];

/// `chaincell view` on a place's scene, and its address.
fn view(place: &Place, options: &[&str]) -> (Running, String) {
    view_of(&place.model, &place.scene, options)
}

/// `chaincell view` of a model on a scene, and its address.
pub(super) fn view_of(model: &Path, scene: &str, options: &[&str]) -> (Running, String) {
    let args = ["view", text(model), "--scene", scene, "--no-open"];
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

/// Bash: sends each argument after the first to the port that this names, and prints what comes.
const ASK: &str = r#"for request in "${@:2}"; do
    exec 3<>"/dev/tcp/127.0.0.1/$1"
    printf '%b' "$request" >&3
    cat <&3
    exec 3<&- 3>&-
done"#;
/// Bash: sends noise, halves of requests and nothing to the port, hundreds of times, also where the other end has
/// closed already.
const DISTURB: &str = r#"trap '' PIPE; for ((at = 0; at < 300; at++)); do
    exec 3<>"/dev/tcp/127.0.0.1/$1" || continue
    printf '%b' "${@:2 + at % 4:1}" >&3
    ((at % 40)) || sleep 0.1
    exec 3<&- 3>&-
done 2>/dev/null; exit 0"#;

// REQ-COS-07
#[test]
fn another_user_sees_an_empty_page_and_does_not_reach_the_scene() {
    if !rustix::process::geteuid().is_root() {
        println!("SKIPPED another_user_sees_an_empty_page_and_does_not_reach_the_scene: not root");
        return;
    }
    let _turn = turn();
    let place = Place::new("view-nobody");
    let serve = place.serve(&PATIENT);
    let (view, address) = view(&place, &["--commands"]);
    let mut page = Page::open(&address);
    page.status("live");
    let (host, token) = address.strip_prefix("http://").unwrap().split_once("/#").unwrap();
    let (_, port) = host.split_once(':').unwrap();
    // All that is known without the token: the port, and where the page's files are.
    let get = |path: &str, fields: &str| {
        format!("GET {path} HTTP/1.1\\r\\nHost: {host}\\r\\n{fields}\\r\\n")
    };
    let upgrade = format!(
        "Origin: http://{host}\\r\\nUpgrade: websocket\\r\\nConnection: Upgrade\\r\\nSec-WebSocket-Version: 13\\r\\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\\r\\nSec-WebSocket-Protocol: chaincell, {}\\r\\n",
        "0".repeat(token.len())
    );
    let requests =
        [get("/", ""), get("/model", ""), get("/kernel.wasm.gz", ""), get("/live", &upgrade)];
    let bash = Path::new("/bin/bash");
    let ask = ["-c", ASK, "bash", port].into_iter().chain(requests.iter().map(String::as_str));
    let told = as_nobody(bash, &ask.collect::<Vec<_>>()).with(0).out;
    assert_eq!(
        (told.matches("HTTP/1.1 200 ").count(), told.matches("HTTP/1.1 403 ").count()),
        (1, 3)
    );
    assert_eq!(told.matches("HTTP/1.1 ").count(), 4);
    let pid = view.id();
    let look = format!("cat /proc/{pid}/cmdline /proc/{pid}/environ; ls /proc/{pid}/fd; true");
    let seen = as_nobody(bash, &["-c", &look]).with(0).out;
    assert!(seen.contains("--scene") && !seen.contains(token) && !told.contains(token));
    // Every pose is answered meanwhile, and the page sees the last one.
    let half = &requests[3][..requests[3].len() / 2];
    let disturb = ["-c", DISTURB, "bash", port, half, "\\x00\\xff\\x16\\x03", "", &requests[3]];
    let outsider = Outsider::join(&place.scene, true);
    std::thread::scope(|scope| {
        let disturbed = scope.spawn(|| as_nobody(bash, &disturb));
        outsider.play(1..1001, pose);
        disturbed.join().unwrap().with(0);
    });
    page.frame(|frame| frame.tick == 1000);
    assert_eq!(Page::open(&address).frame(|_| true).tick, 1000);
    let served = serve.interrupt().with(130).json();
    let number = |key: &str| served[key].as_u64().unwrap();
    assert_eq!((number("ticks_executed"), number("poses_missing")), (1000, 0));
    assert_eq!((number("commands_done"), number("commands_refused")), (0, 0));
    assert_eq!(view.interrupt().with(0).err, "");
}

// REQ-COS-07
#[test]
fn the_file_that_forwards_the_browser_is_its_owners_alone() {
    let folder = tempfile::tempdir().unwrap();
    let (opener, named) = (folder.path().join("xdg-open"), folder.path().join("named"));
    let lines =
        format!("#!/bin/sh\nprintf %s \"$1\" >{0}.new && mv {0}.new {0}\n", named.display());
    fs::write(&opener, lines).unwrap();
    fs::set_permissions(&opener, Permissions::from_mode(0o755)).unwrap();
    let mut shell = Command::new("sh");
    shell.args(["-c", "umask 000; exec \"$0\" view"]).arg(chaincell().get_program());
    let path = format!("{}:{}", folder.path().display(), std::env::var("PATH").unwrap());
    let mut view = Running::start(shell.env("DISPLAY", ":9").env("PATH", path));
    view.wait_for_line("Ctrl-C ends it");
    while !named.exists() {
        assert!(view.is_running());
        std::thread::yield_now();
    }
    let file = PathBuf::from(fs::read_to_string(&named).unwrap());
    let address = view.lines().find(|line| line.starts_with("http://")).unwrap().to_owned();
    assert!(fs::read_to_string(&file).unwrap().contains(&address));
    let mode = fs::metadata(file.parent().unwrap()).unwrap().mode();
    assert_eq!(mode & 0o077, 0, "{mode:o}");
    view.interrupt().with(0);
    assert!(!file.exists());
}
