//! Sessions that are sent over zenoh on this machine, while they are recorded and messages are lost.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failing helper fails its test"
)]

#[cfg(feature = "tls")]
mod certificates;
mod session;
mod sides;
#[cfg(feature = "tls")]
mod tls;

use std::path::Path;
use std::time::Duration;

use chaincell_host::remote::frame::{Ask, Frame};
use chaincell_host::remote::place::Place;
use chaincell_kernel::trace::RECORD_BYTES;
use chaincell_link::page;
use chaincell_link::sequence::Sequence;

use session::{Session, fake};
use sides::{Followed, Follower, Network, until};

/// Ticks that are played at a time.
const TICKS: u64 = 60;

/// Ticks that were followed to the same bits, until the end.
#[track_caller]
fn same(followed: Followed, state_hash: &str) -> u64 {
    let report = followed.expect("it was followed");
    assert_eq!(report.state_hash, state_hash, "{report:?}");
    assert!(report.has_ended && !report.was_killed, "{report:?}");
    assert!(report.first_difference.is_none(), "{report:?}");
    u64::from(report.ticks)
}

/// Every record stands in the frames of a receiver once, as it stands in the trace, and then its end.
#[track_caller]
fn whole(frames: &[Frame], session: &Path) {
    let mut records = Vec::new();
    for frame in frames {
        if let Frame::Records { first, bytes, .. } = frame {
            assert_eq!(*first as usize, records.len() / RECORD_BYTES);
            records.extend(bytes);
        }
    }
    let trace = std::fs::read(session.join("session.trace")).unwrap();
    assert!(trace.ends_with(&records) && !records.is_empty());
    let Frame::Begun(begun) = &frames[0] else { panic!("{:?}", frames[0]) };
    assert_eq!(begun.len() + records.len(), trace.len());
    assert!(matches!(frames.last(), Some(Frame::End { is_whole: true, .. })));
}

#[test]
fn a_growing_session_is_followed_to_the_same_bits() {
    let Some(network) = Network::new("a_growing_session_is_followed_to_the_same_bits") else {
        return;
    };
    let mut session = Session::begin();
    // It waits for a sender.
    let follower = Follower::of(&network, "left");
    let _sender = network.send(session.folder(), "left", &[]);
    for played in 1..=3 {
        session.play(TICKS);
        follower.wait_for_ticks(played * TICKS);
    }
    let (_folder, state_hash) = session.end();
    assert_eq!(same(follower.end(), &state_hash), 3 * TICKS);
}

#[test]
fn one_that_comes_late_begins_from_the_newest_snapshot() {
    let Some(network) = Network::new("one_that_comes_late_begins_from_the_newest_snapshot") else {
        return;
    };
    let mut session = Session::begin();
    session.play(TICKS);
    session.snapshot();
    session.play(10);
    let _sender = network.send(session.folder(), "left", &[]);
    let late = Follower::of(&network, "left");
    late.wait_for_ticks(10);
    session.play(TICKS);
    let (_folder, state_hash) = session.end();
    assert_eq!(same(late.end(), &state_hash), TICKS + 10);
    // The end is there for one that comes after it.
    let last = Follower::of(&network, "left");
    assert_eq!(same(last.end(), &state_hash), TICKS + 10);
}

#[test]
fn what_is_lost_on_the_way_is_asked_for() {
    let Some(network) = Network::new("what_is_lost_on_the_way_is_asked_for") else { return };
    let mut session = Session::begin();
    // Of ten messages a second, or more, four come.
    let lossy = session.folder().join("lossy.json5");
    let rule = "{ messages: ['put'], flows: ['egress'], rules: [{ key_expr: 'chaincell/*/records', freq: 4.0 }] }";
    std::fs::write(&lossy, format!("{{ downsampling: [{rule}] }}")).unwrap();
    let config = lossy.to_str().unwrap();
    let _sender = network.send(session.folder(), "left", &["--config", config]);
    let receiver = network.receive("left", &[]);
    let asked = until("it asks five times", || {
        session.play(2);
        std::thread::sleep(Duration::from_millis(20));
        receiver.times_asked() >= 5
    });
    let (folder, _) = session.end();
    assert!(asked);
    whole(&receiver.frames(), folder.path());
}

#[test]
fn a_router_stands_between_and_is_started_again() {
    let Some(mut network) = Network::new("a_router_stands_between_and_is_started_again") else {
        return;
    };
    network.start_router();
    let mut session = Session::begin();
    let _sender = network.send(session.folder(), "left", &[]);
    let followers = [(); 2].map(|()| Follower::of(&network, "left"));
    session.play(TICKS);
    followers.iter().for_each(|follower| follower.wait_for_ticks(TICKS));
    network.end_router();
    session.play(TICKS);
    network.start_router();
    followers.iter().for_each(|follower| follower.wait_for_ticks(2 * TICKS));
    session.play(TICKS);
    let (_folder, state_hash) = session.end();
    for follower in followers {
        assert_eq!(same(follower.end(), &state_hash), 3 * TICKS);
    }
}

#[test]
fn ten_follow_at_a_time() {
    let Some(network) = Network::new("ten_follow_at_a_time") else { return };
    let mut session = Session::begin();
    let _sender = network.send(session.folder(), "left", &[]);
    session.play(TICKS);
    let followers: Vec<Follower> = (0..10).map(|_| Follower::of(&network, "left")).collect();
    followers.iter().for_each(|follower| follower.wait_for_ticks(TICKS));
    session.play(TICKS);
    let (_folder, state_hash) = session.end();
    for follower in followers {
        assert_eq!(same(follower.end(), &state_hash), 2 * TICKS);
    }
}

#[test]
fn a_sender_that_is_killed_is_started_again() {
    let Some(network) = Network::new("a_sender_that_is_killed_is_started_again") else { return };
    let mut session = Session::begin();
    let sender = network.send(session.folder(), "left", &[]);
    let follower = Follower::of(&network, "left");
    session.play(TICKS);
    follower.wait_for_ticks(TICKS);
    drop(sender);
    session.play(TICKS);
    let _again = network.send(session.folder(), "left", &[]);
    follower.wait_for_ticks(2 * TICKS);
    session.play(TICKS);
    let (_folder, state_hash) = session.end();
    assert_eq!(same(follower.end(), &state_hash), 3 * TICKS);
}

#[test]
fn another_session_of_the_same_name_is_refused() {
    let Some(network) = Network::new("another_session_of_the_same_name_is_refused") else { return };
    let (mut session, mut other) = (Session::begin(), Session::begin());
    let sender = network.send(session.folder(), "left", &[]);
    let follower = Follower::of(&network, "left");
    session.play(TICKS);
    follower.wait_for_ticks(TICKS);
    drop(sender);
    // The same header, and other poses.
    other.play_from(0.003, 2 * TICKS);
    let _sender = network.send(other.folder(), "left", &[]);
    let why = follower.end().expect_err("it is another session");
    assert!(why.contains("another session"), "{why}");
}

#[test]
fn an_answer_has_a_bounded_length() {
    let (folder, trace) = fake(40_000);
    let place = Place::find(folder.path(), None).unwrap();
    let mut sequence = Sequence::new(&Ask { model: Some(0), ..Ask::default() });
    let (mut pages, mut bytes, mut is_whole) = (0, 0, false);
    while !is_whole {
        pages += 1;
        let ask = sequence.ask();
        page::answer(&place, &ask, |frame| {
            is_whole = page::is_up_to_date(frame);
            for frame in sequence.answer(frame.clone()) {
                match frame {
                    Frame::Records { bytes: records, .. } => bytes += records.len(),
                    Frame::Begun(begun) => bytes += begun.len(),
                    _ => {}
                }
            }
            Ok(())
        })
        .unwrap();
    }
    assert_eq!((pages, bytes), (2, trace.len()));
}

#[test]
fn what_cannot_be_sent_or_received_is_named() {
    let (folder, _trace) = fake(3);
    let session = folder.path().to_str().unwrap();
    for (args, part) in [
        (vec!["send", session, "--name", "a/b"], "the name `a/b`"),
        (vec!["send", session, "--name", "a", "--listen", "tcp/0.0.0.0:7447"], "--open-to-network"),
        (vec!["send", "/no/such/session", "--name", "a"], "/no/such/session"),
        (vec!["send", session, "--name", "a", "--config", "/no/such/config"], "/no/such/config"),
        (vec!["send", session, "--name", "a", "--listen", "tcp/127.0.0.1:nowhere"], "nowhere"),
        (vec!["send", session, "--name", "a", "--listen", "udp/127.0.0.1:1"], "--features tls"),
        (vec!["send", session, "--name", "a", "--connect", "udp/127.0.0.1:1"], "--features tls"),
        (vec!["receive", "a", "--connect", "udp/127.0.0.1:1"], "udp/127.0.0.1:1"),
        (vec!["receive", "a b"], "the name `a b`"),
        (vec!["receive", "a", "--goes-on", "3"], "SEAL:RECORD"),
    ] {
        let (code, err) = sides::ended(&args);
        assert_eq!(code, Some(2), "{args:?}: {err}");
        assert!(err.contains(part), "{args:?}: {err}");
    }
}
