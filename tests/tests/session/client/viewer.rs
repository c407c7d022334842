//! States and commands beside the loop.

use chaincell_client::payload::{CommandMessage, NodePosition};
use chaincell_client::viewed::View;
use chaincell_client::{Client, Command, Kind, ToolPose};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::turn;

use super::{SOME_N, WAIT_NS, answered, options, pose, press, size_n, viewer};

/// The next of what a viewer looks at.
#[track_caller]
fn next<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let start = std::time::Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < SHORT, "nothing within {SHORT:?}");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

#[test]
fn a_state_lies_in_shared_memory_until_it_is_given_back() {
    let _turn = turn();
    let place = Place::new("client-state");
    let serve = place.serve(&["--state-hz", "1000", "--watchdog-ms", "0", "--ramp-ms", "0"]);
    let (mut viewer, mut client) = (viewer(&place), Client::open(&options(&place)).unwrap());
    // The first look joins; a state may be there at once.
    drop(viewer.state().unwrap());
    let last = press(&mut client, 0..=40).pop().unwrap();
    let state = |viewer: &mut Client, hash: u64| -> View<NodePosition> {
        next(|| viewer.state().unwrap().filter(|view| view.header().state_hash == hash))
    };
    let pressed = state(&mut viewer, last.state_hash);
    assert_eq!((pressed.header().nodes, pressed.rows().len()), (81, 81));
    assert!(pressed.rows().iter().zip(0..).all(|(row, node)| row.node == node));
    let middle = pressed.rows()[40].position_m;
    assert!((middle[2] + 0.0117).abs() < 1e-3, "{middle:?}");
    // What is held stays as it is while further states come.
    let released = answered(&mut client, &[ToolPose::AWAY]);
    let after = state(&mut viewer, released.state_hash);
    assert_eq!(pressed.rows()[40].position_m, middle);
    assert_ne!(after.rows()[40].position_m, middle);
    drop((pressed, after));
    assert_eq!(viewer.step(&[pose(0)], 0).unwrap_err().kind(), Kind::Viewer);
    serve.interrupt().with(130);
}

#[test]
fn commands_are_carried_out_or_refused_with_the_reason() {
    let _turn = turn();
    let place = Place::new("client-command");
    let serve = place.serve(&["--watchdog-ms", "0", "--ramp-ms", "0", "--json"]);
    let (mut viewer, mut client) = (viewer(&place), Client::open(&options(&place)).unwrap());
    press(&mut client, 0..=40);
    viewer.command(&Command::Pause, WAIT_NS).unwrap();
    assert_eq!(size_n(&answered(&mut client, &[pose(40)])), 0.0, "paused");
    viewer.command(&Command::Resume, WAIT_NS).unwrap();
    assert!(size_n(&answered(&mut client, &[pose(40)])) > SOME_N);
    let reply = viewer.command(&Command::Sweeps(3), WAIT_NS).unwrap();
    assert_eq!((reply.ticks_answered, reply.result), (43, 0));
    let error = viewer.command(&Command::Grip { tool: 0 }, WAIT_NS).unwrap_err();
    assert_eq!(error.kind(), Kind::Refused);
    assert!(error.to_string().contains("nothing can be gripped here"), "{error}");
    let odd = CommandMessage { kind: 99, ..CommandMessage::default() };
    let reply = viewer.ask(odd, WAIT_NS).unwrap();
    assert_eq!((reply.result, reply.reason), (1, 1));
    let served = serve.interrupt().with(130).json();
    assert_eq!((&served["commands_done"], &served["commands_refused"]), (&3.into(), &2.into()));
    // Nobody replies any more.
    let error = viewer.command(&Command::Reset, 5_000_000).unwrap_err();
    assert_eq!(error.kind(), Kind::NoReply);
    assert!(error.to_string().contains("not known"), "{error}");
}

/// The stage has not seen how deep the tool went meanwhile: its ramp begins anew.
#[test]
fn after_a_pause_the_force_of_the_stage_rises_along_its_ramp() {
    let _turn = turn();
    let place = Place::new("client-resume");
    let plain = ["--watchdog-ms", "0", "--ramp-ms", "0"];
    let serve = place.serve(&[&plain[..], &["--device", "omega"]].concat());
    let (mut viewer, mut client) = (viewer(&place), Client::open(&options(&place)).unwrap());
    press(&mut client, 0..=10);
    viewer.command(&Command::Pause, WAIT_NS).unwrap();
    press(&mut client, 11..=40);
    viewer.command(&Command::Resume, WAIT_NS).unwrap();
    let risen = press(&mut client, 41..=190);
    let whole_n = size_n(&risen[149]);
    assert!(whole_n > SOME_N, "{whole_n}");
    // In the first ticks the coupling's spring is as long as the way of the pause.
    for (ticks, answer) in (10..).zip(&risen[9..80]) {
        let most_n = (0.01 * f64::from(ticks) + 0.2) * whole_n;
        assert!(size_n(answer) <= most_n, "after {ticks} ticks: {} N", size_n(answer));
    }
    serve.interrupt().with(130);
}
