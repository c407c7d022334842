//! Sessions that are followed in another place, over streams that are cut, damaged or late.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs::OpenOptions;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use chaincell_client::{Client, Options, Role};
use chaincell_host::remote::frame::{Ask, Frame};
use chaincell_kernel::trace::RECORD_BYTES;
use chaincell_tests::files::{bake, text};
use chaincell_tests::outsider::{Outsider, Pose, Viewer};
use chaincell_tests::page::Page;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Ended, Running, chaincell, run, scene, turn};

use rustix::process::{Pid, Signal, kill_process};

use super::view::view_of;

/// Ticks that are played at a time.
const TICKS: u64 = 150;
/// Headers of TCP and IP with time stamps, for each frame of ten ticks \[bytes a tick\].
const TCP_BYTES: f64 = 5.2;

fn pose(tick: u64) -> Pose {
    let depth_m = 0.004 * (0.05 * tick as f32).sin().abs();
    Pose { tick, position_m: [0.0002, 0.001, -depth_m], engaged: u32::from(tick > 0) }
}

/// A server that records to `session`, and a hand.
fn session(place: &Place) -> (Running, PathBuf, Outsider) {
    session_in(place, "session")
}

/// The same with a folder of this name.
fn session_in(place: &Place, name: &str) -> (Running, PathBuf, Outsider) {
    let out = place.file(name);
    let options = ["--watchdog-ms", "0", "--device", "touch", "--json", "--out", text(&out)];
    let server = place.serve(&options);
    (server, out, Outsider::join(&place.scene, true))
}

/// A mirror that listens, and its address.
fn listening(session: &Path) -> (Running, String) {
    let listen = ["mirror", text(session), "--listen", "127.0.0.1:0"];
    let mut mirror = Running::chaincell(listen);
    mirror.wait_for_line("ready");
    let first = mirror.lines().next().unwrap().to_owned();
    let address = first.rsplit_once("tcp:").unwrap().1.to_owned();
    (mirror, address)
}

fn follower(source: &str, options: &[&str]) -> Running {
    let mut follower = Running::chaincell([&["follow", source, "--json"], options].concat());
    follower.wait_for_line("ready");
    follower
}

/// The ticks of a follower's report, whose last state is that of the server's.
#[track_caller]
fn same(followed: Ended, served: &serde_json::Value) -> u64 {
    let report = followed.with(0).json();
    assert_eq!(report["state_hash"], served["state_hash"], "{report}");
    assert_eq!(report["has_ended"], true, "{report}");
    assert!(report["hashes_compared"].as_u64().unwrap() > 0, "{report}");
    assert!(report["largest_lag_ticks"].is_u64(), "{report}");
    report["ticks"].as_u64().unwrap()
}

#[test]
fn a_session_is_followed_in_three_ways_to_the_same_bits() {
    let _turn = turn();
    let place = Place::new("mirror");
    let (server, out, outsider) = session(&place);
    let (mirror, address) = listening(&out);
    // One shows it to viewers, one records, one gets it from a program.
    let (far, trace) = (scene("mirror-far"), place.file("followed.trace"));
    let shown = follower(&format!("tcp:{address}"), &["--scene", &far]);
    let recorded = follower(text(&out), &["--record", text(&trace)]);
    let chaincell_path = chaincell().get_program().to_owned();
    let words = ["follow", "--json", "--", text(Path::new(&chaincell_path)), "mirror", text(&out)];
    let mut by_program = Running::chaincell(words);
    by_program.wait_for_line("ready");
    // The tissue moves, a command sets it, and viewers of the other scene see the same state.
    let viewer = Viewer::join(&far);
    let (view, page) = view_of(&place.model, &far, &[]);
    let mut page = Page::open(&page);
    page.status("live");
    let by_client = Options { role: Role::Viewer, scene: Some(far.clone()), ..Options::default() };
    let mut by_client = Client::open(&by_client).unwrap();
    by_client.state().unwrap();
    outsider.play(0..TICKS, pose);
    place.command(&["set", "sweeps=3"]).with(0);
    let told = outsider.play(TICKS..2 * TICKS, pose);
    let start = Instant::now();
    let (header, nodes) = loop {
        let state = viewer.after(0);
        if state.0.tick == 2 * TICKS - 1 {
            break state;
        }
        assert!(start.elapsed() < SHORT, "{:?}", state.0);
    };
    let state_hash = told.last().unwrap().state_hash;
    assert_eq!((header.state_hash, nodes.len()), (state_hash, 81));
    assert_eq!(page.frame(|frame| frame.tick == 2 * TICKS - 1).hash, state_hash);
    while by_client.state().unwrap().is_none_or(|view| view.header().state_hash != state_hash) {
        assert!(start.elapsed() < SHORT, "the client saw another last state");
        thread::sleep(Duration::from_millis(1));
    }
    view.interrupt().with(0);
    // All end with the session.
    let served = server.interrupt().with(130).json();
    for followed in [shown, recorded, by_program] {
        assert_eq!(same(followed.end(SHORT), &served), 2 * TICKS);
    }
    mirror.interrupt().with(130);
    let replayed = run(["replay", text(&trace), "--model", text(&place.model), "--json"]).with(0);
    assert_eq!(replayed.json()["state_hash"], served["state_hash"]);
    assert_eq!(replayed.json()["commands"], 1);
}

/// Passes a mirror's bytes on, and cuts the connection after so many each time; then it holds. Returns its
/// address.
fn relay(to: String, cuts: Vec<usize>) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        let mut cuts = cuts.into_iter();
        for follower in listener.incoming() {
            let (mut follower, mut mirror) = (follower.unwrap(), TcpStream::connect(&to).unwrap());
            let (mut asked, mut asks) =
                (follower.try_clone().unwrap(), mirror.try_clone().unwrap());
            thread::spawn(move || std::io::copy(&mut asked, &mut asks));
            let mut left = cuts.next().unwrap_or(usize::MAX);
            let mut bytes = [0; 512];
            while let Ok(read @ 1..) = mirror.read(&mut bytes) {
                let passed = read.min(left);
                if follower.write_all(&bytes[..passed]).is_err() || passed < read {
                    break;
                }
                left -= passed;
            }
            let _ = (follower.shutdown(Shutdown::Both), mirror.shutdown(Shutdown::Both));
        }
    });
    address
}

#[test]
fn whatever_is_cut_is_asked_for_again() {
    let _turn = turn();
    let place = Place::new("mirror-cut");
    let (server, out, outsider) = session(&place);
    let (_mirror, address) = listening(&out);
    let model_bytes = place.model.metadata().unwrap().len() as usize;
    // Wherever a cut falls: within the head, within frames.
    let cuts = vec![model_bytes + 3_000, 5, 700, 1_203];
    let followed = follower(&format!("tcp:{}", relay(address, cuts)), &[]);
    outsider.play(0..TICKS, pose);
    thread::sleep(Duration::from_millis(300));
    outsider.play(TICKS..3 * TICKS, pose);
    let served = server.interrupt().with(130).json();
    let ended = followed.end(SHORT);
    assert_eq!(ended.json()["cuts"], 4, "{ended:#?}");
    assert_eq!(same(ended, &served), 3 * TICKS);
}

#[test]
fn one_that_comes_late_begins_from_the_newest_snapshot_in_a_pause_too() {
    let _turn = turn();
    let place = Place::new("mirror-late");
    let (server, out, outsider) = session(&place);
    outsider.play(0..TICKS, pose);
    place.command(&["snapshot"]).with(0);
    outsider.play(TICKS..TICKS + 20, pose);
    place.command(&["pause"]).with(0);
    outsider.play(TICKS + 20..TICKS + 30, pose);
    place.command(&["snapshot"]).with(0);
    let trace = place.file("late.trace");
    let late = follower(text(&out), &["--record", text(&trace)]);
    outsider.play(TICKS + 30..TICKS + 40, pose);
    place.command(&["resume"]).with(0);
    outsider.play(TICKS + 40..2 * TICKS, pose);
    // Its trace is followed too.
    let next = follower(text(&trace), &["--model", text(&place.model)]);
    let served = server.interrupt().with(130).json();
    let ticks = same(late.end(SHORT), &served);
    assert_eq!(ticks, TICKS - 30);
    assert_eq!(same(next.end(SHORT), &served), ticks);
    let replayed = run(["replay", text(&trace), "--model", text(&place.model), "--json"]).with(0);
    assert_eq!(replayed.json()["state_hash"], served["state_hash"]);
}

#[test]
fn a_late_follower_gets_a_snapshot_from_the_server_of_the_scene() {
    let _turn = turn();
    let place = Place::new("mirror-later");
    let (server, out, outsider) = session(&place);
    let ticks = 2_100;
    outsider.play(0..ticks, pose);
    let program = chaincell().get_program().to_owned();
    let mirror = [text(Path::new(&program)), "mirror", &place.scene];
    let mut late = Running::chaincell([&["follow", "--json", "--"], &mirror[..]].concat());
    late.wait_for_line("ready");
    // Cut off before the first record behind the snapshot, it goes on there.
    let (mirror, address) = listening(&out);
    let mut cut = follower(&format!("tcp:{address}"), &[]);
    drop(mirror);
    let again = Running::chaincell(["mirror", text(&out), "--listen", &address]);
    cut.notes_until("note: connected again");
    outsider.play(ticks..ticks + 50, pose);
    let served = server.interrupt().with(130).json();
    for followed in [late, cut] {
        assert_eq!(same(followed.end(SHORT), &served), 50);
    }
    again.interrupt().with(130);
}

#[test]
fn a_session_is_named_by_the_scene_of_its_server() {
    let _turn = turn();
    let place = Place::new("mirror-named");
    let (server, _, outsider) = session(&place);
    let scene = Path::new(&place.scene);
    let (mirror, address) = listening(scene);
    let by_mirror = follower(&format!("tcp:{address}"), &[]);
    let at_once = follower(&place.scene, &[]);
    outsider.play(0..TICKS, pose);
    let served = server.interrupt().with(130).json();
    for followed in [by_mirror, at_once] {
        assert_eq!(same(followed.end(SHORT), &served), TICKS);
    }
    mirror.interrupt().with(130);
    // A program that finds none ends its follower.
    let program = chaincell().get_program().to_owned();
    let alone = ["follow", "--", text(Path::new(&program)), "mirror", &place.scene];
    run(alone).with(2);
    // The name goes with the server; one that records nothing has none.
    let unrecorded = place.serve(&["--watchdog-ms", "0"]);
    let ended = run(["mirror", &place.scene]).with(2);
    assert!(ended.err.contains("no server records on a scene of this name"), "{}", ended.err);
    unrecorded.interrupt().with(130);
}

/// A follower whose connection breaks does not ask for ever where its program says that there is no session.
#[test]
fn a_program_that_has_no_session_any_more_ends_its_follower() {
    let _turn = turn();
    let place = Place::new("mirror-gone");
    let (server, _, outsider) = session(&place);
    let script = place.file("once");
    let once = format!(
        "#!/bin/sh\nif [ -e {0}.pid ]; then exit 2; fi\necho $$ > {0}.pid\nexec {1} mirror {2} \"$@\"\n",
        text(&script),
        text(Path::new(&chaincell().get_program())),
        place.scene
    );
    std::fs::write(&script, once).unwrap();
    let mut follower = Running::chaincell(["follow", "--", "sh", text(&script)]);
    follower.wait_for_line("ready");
    outsider.play(0..TICKS, pose);
    let pid = std::fs::read_to_string(script.with_extension("pid")).unwrap();
    kill_process(Pid::from_raw(pid.trim().parse().unwrap()).unwrap(), Signal::KILL).unwrap();
    let ended = follower.end(SHORT).with(2);
    assert!(ended.err.contains("ended with exit code 2"), "{}", ended.err);
    server.interrupt().with(130);
}

/// Letters of any language in a path, and a server that stands still while late followers come.
#[test]
fn a_late_follower_of_a_server_that_stands_begins_without_a_snapshot() {
    let _turn = turn();
    let place = Place::new("mirror-stands");
    let (server, _, outsider) = session_in(&place, "sitzung ä\n2");
    let ticks = 2_100;
    outsider.play(0..ticks, pose);
    server.signal(Signal::STOP);
    let mut followers: Vec<Running> =
        (0..3).map(|_| Running::chaincell(["follow", &place.scene, "--json"])).collect();
    for follower in &mut followers {
        follower.wait_for_line("ready");
    }
    server.signal(Signal::CONT);
    outsider.play(ticks..ticks + 50, pose);
    let served = server.interrupt().with(130).json();
    for follower in followers {
        same(follower.end(SHORT), &served);
    }
}

#[test]
fn of_a_killed_server_all_whole_records_are_followed() {
    let _turn = turn();
    let place = Place::new("mirror-killed");
    let (mut server, out, outsider) = session(&place);
    let followed = follower(text(&out), &[]);
    let told = outsider.play(0..TICKS, pose);
    server.kill();
    let report = followed.end(SHORT).with(0).json();
    assert_eq!(report["ticks"], TICKS);
    assert_eq!(report["state_hash"], format!("{:016x}", told.last().unwrap().state_hash));
}

#[test]
fn the_first_tick_that_differs_is_named() {
    let _turn = turn();
    let place = Place::new("mirror-differs");
    let (server, out, outsider) = session(&place);
    outsider.play(0..TICKS, pose);
    server.interrupt().with(130);
    // The same records under a header of other settings, each sealed anew.
    let trace = std::fs::read(out.join("session.trace")).unwrap();
    let forged = forged(&trace);
    let place_of = place.file("forged.trace");
    std::fs::write(&place_of, forged).unwrap();
    let model = text(&place.model);
    let ended = run(["follow", text(&place_of), "--model", model, "--json"]).with(1);
    let report = ended.json();
    assert_eq!(report["first_difference"]["tick"], 40, "{report}");
    assert_eq!(report["ticks"], 41);
    assert!(ended.err.contains("tick 40 (record 40) is the first that differs"), "{}", ended.err);
}

/// The trace with another hash in tick 40.
fn forged(trace: &[u8]) -> Vec<u8> {
    use chaincell_kernel::trace::{Entry, Reader, Record};
    let reader = Reader::open(trace).unwrap();
    let mut forged = chaincell_host::files::recording::Recording::again(&reader).unwrap();
    let _ = reader.entries(|_, entry| {
        if let Entry::Tick(record) = entry {
            let state_hash = if record.tick == 40 { Some(1) } else { record.state_hash };
            forged.add(&Record { state_hash, ..*record });
        }
        Ok::<(), ()>(())
    });
    forged.bytes().to_vec()
}

#[test]
fn what_cannot_be_followed_is_named() {
    let _turn = turn();
    let place = Place::new("mirror-bad");
    let (server, out, outsider) = session(&place);
    outsider.play(0..TICKS, pose);
    // A second one on the scene of a server or of a follower.
    let far = scene("mirror-twice");
    let first = follower(text(&out), &["--scene", &far]);
    for (taken, by) in [(&far, "chaincell follow"), (&place.scene, "chaincell serve")] {
        let ended = run(["follow", text(&out), "--scene", taken]).with(2);
        assert!(ended.err.contains(by), "{}", ended.err);
    }
    // No server begins on its scene, and a controller finds none, even where viewers look.
    let _viewer = Viewer::join(&far);
    let serve = ["serve", text(&place.model), "--contact", "40", "--scene", &far];
    assert!(run(serve).with(2).err.contains("chaincell follow"));
    let control = ["control", "--scene", &far, "--model", text(&place.model), "--contact", "40"];
    let alone = run([&control[..], &["--wait-for-server-s", "0"]].concat()).with(2);
    assert!(alone.err.contains("no server"), "{}", alone.err);
    let served = server.interrupt().with(130).json();
    same(first.end(SHORT), &served);
    // Streams that are none, or end too early.
    let sent = Running::start(chaincell().args(["mirror", text(&out)])).end(SHORT);
    assert_eq!(sent.code, Some(0));
    for (bytes, part) in [
        (b"".to_vec(), "the stream ended"),
        (b"HTTP/1.1 404 Not Found".to_vec(), "no stream of chaincell mirror"),
        (b"CHAINMIR\x01\0\0\0\xff\xff\xff\xff\xff".to_vec(), "damaged"),
    ] {
        let ended = piped(&["follow", "-"], &bytes).with(2);
        assert!(ended.err.contains(part), "{}", ended.err);
    }
    // One that waits for a mirror ends by Ctrl-C.
    let wait = ["follow", "tcp:127.0.0.1:1", "--wait-for-server-s", "600"];
    let mut waiting = Running::chaincell(wait);
    let refused = "tcp:127.0.0.1:1: Connection refused (os error 111)";
    waiting.notes_until(&format!("note: {refused}; waiting for it"));
    assert!(waiting.interrupt().with(130).err.contains("interrupted"));
    // Files, sources, addresses.
    let none = place.file("none.trace");
    let other = place.file("alone").join("session.trace");
    std::fs::create_dir(place.file("alone")).unwrap();
    std::fs::copy(out.join("session.trace"), &other).unwrap();
    for name in ["foreign", "beside"] {
        std::fs::create_dir(place.file(name)).unwrap();
    }
    let foreign = bake(&place.file("foreign"), "plane:7x7x0.01", &[]);
    let beside = place.file("beside").join("session.trace");
    std::fs::copy(&other, &beside).unwrap();
    std::fs::copy(&foreign, beside.with_file_name("model.chaincell")).unwrap();
    let another = format!("{}: the session was recorded with the model of", text(&foreign));
    let at_once = ["mirror", text(&out), "--listen", "127.0.0.1:0", "--model"];
    for (args, part) in [
        (vec!["follow", text(&none)], "none.trace"),
        (vec!["follow", text(&place.model)], "trace"),
        (vec!["follow", text(&other)], "name the model with --model"),
        (vec!["follow", text(&beside)], "model.chaincell: the session was recorded with the model"),
        (vec!["mirror", text(&out), "--model", text(&foreign)], &another),
        ([&at_once[..], &[text(&foreign)]].concat(), &another),
        ([&at_once[..], &[text(&none)]].concat(), "none.trace: No such file"),
        ([&at_once[..], &[text(&other)]].concat(), "cannot send model"),
        (vec!["follow", "tcp:127.0.0.1:1", "--wait-for-server-s", "0"], "refused"),
        (vec!["follow", "--", "false"], "the stream ended"),
        (vec!["follow", "--", "/no/such/program"], "/no/such/program"),
        (vec!["follow"], "SOURCE"),
        (vec!["mirror", text(&none)], "none.trace"),
        (vec!["mirror", text(&out), "--listen", "0.0.0.0:0"], "--open-to-network"),
        (vec!["mirror", text(&out), "--goes-on", "1:3"], "another session"),
    ] {
        let ended = run(&args).with(2);
        assert!(ended.err.contains(part), "{args:?}: {}", ended.err);
    }
}

/// `chaincell` with these bytes on its standard input.
fn piped(args: &[&str], bytes: &[u8]) -> Ended {
    let mut command = chaincell();
    let command =
        command.args(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let _ = child.stdin.take().unwrap().write_all(bytes);
    let output = child.wait_with_output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ended { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

#[test]
fn a_stream_that_cannot_be_written_is_an_error_and_one_that_nobody_reads_is_none() {
    let place = Place::new("mirror-full");
    let out = place.file("session");
    let press = ["run", text(&place.model), "--motion", "press", "--seconds", "0.2"];
    run([&press[..], &["--picture", "off", "--out", text(&out)]].concat()).with(0);
    let mirror = || {
        let mut command = chaincell();
        command.args(["mirror", text(&out)]);
        command
    };
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let said = mirror().stdout(full).output().unwrap();
    let err = String::from_utf8(said.stderr).unwrap();
    assert_eq!(said.status.code(), Some(2), "{err}");
    assert!(err.contains("cannot be written"), "{err}");
    // The reading end of a pipe is closed.
    let mut ended = mirror().stdout(Stdio::piped()).spawn().unwrap();
    drop(ended.stdout.take());
    assert_eq!(ended.wait().unwrap().code(), Some(0));
}

/// A tool that moves and turns in every tick, every hash recorded, sent every 10 ms.
#[test]
fn a_tick_of_a_tool_takes_at_most_60_bytes_packed() {
    use std::fmt::Write as _;
    let place = Place::new("mirror-packed");
    let (path, out) = (place.file("turns.csv"), place.file("turned"));
    let mut rows = String::from("tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged\n");
    for tick in 0..TICKS {
        let (of, turn) = (pose(tick), 0.003 * tick as f32);
        let ([x, y, z], [sin, cos]) = (of.position_m, [turn.sin(), turn.cos()]);
        writeln!(rows, "{tick},0,{x},{y},{z},{},{sin},0,{},{}", 0.7 * cos, 0.714 * cos, of.engaged)
            .unwrap();
    }
    std::fs::write(&path, rows).unwrap();
    let model = place.file("box.chaincell");
    run(["bake", "box:7x7x5x0.01", "--young-pa", "5000", "-o", text(&model)]).with(0);
    let tool = ["--tool", "capsule:0.005,0.004", "--path", text(&path), "--out", text(&out)];
    run([&["run", text(&model), "--picture", "off"][..], &tool].concat()).with(0);
    // The records of each 10 ticks in a frame: the pose and the tick.
    let trace = std::fs::read(out.join("session.trace")).unwrap();
    let records = &trace[trace.len() - (2 * TICKS as usize) * RECORD_BYTES..];
    let sent = |packed: bool| {
        let ask = Ask { packed, ..Ask::default() };
        let mut bytes = Vec::new();
        for (first, ticks) in (0..).step_by(20).zip(records.chunks(20 * RECORD_BYTES)) {
            let frame = Frame::Records { first, newest: first + 20, bytes: ticks.to_vec() };
            let begin = bytes.len();
            ask.write(&frame, &mut bytes).unwrap();
            assert_eq!(Frame::read(&mut &bytes[begin..]).unwrap(), frame);
        }
        bytes.len() as f64 / TICKS as f64
    };
    let (packed, plain) = (sent(true), sent(false));
    println!("bytes a tick of a tool that turns: {packed:.1} packed, {plain:.1} plain");
    assert!(packed <= 60.0 - TCP_BYTES && plain > 96.0, "{packed} packed, {plain} plain");
}
