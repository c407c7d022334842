//! Tests of a receiver's sequence: messages that come late, twice, not at all, or from another session.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use super::*;

const BEGUN: &[u8] = b"a header";

/// A record whose checksum is its number in a session.
fn record(session: u32, index: u32) -> [u8; RECORD_BYTES] {
    let mut record = [0; RECORD_BYTES];
    record[..4].copy_from_slice(&index.to_le_bytes());
    record[RECORD_BYTES - 4..].copy_from_slice(&seal(session, index + 1).to_le_bytes());
    record
}

/// What identifies a session up to a record.
fn seal(session: u32, next: u32) -> u32 {
    if next == 0 { seal_of_begun(BEGUN) } else { session << 16 | next }
}

fn records(session: u32, first: u32, end: u32) -> Frame {
    let bytes = (first..end).flat_map(|index| record(session, index)).collect();
    Frame::Records { first, newest: end, bytes }
}

fn message(session: u32, first: u32, end: u32) -> Message {
    Message { seal: seal(session, first), frame: records(session, first, end) }
}

fn alive(session: u32, newest: u32) -> Message {
    Message { seal: seal(session, newest), frame: Frame::Alive { newest } }
}

/// A receiver that has the first four records of session 1.
fn at_four() -> Sequence {
    Sequence::new(&Ask { goes_on: Some((seal(1, 4), 4)), ..Ask::default() })
}

#[test]
fn messages_that_come_in_order_pass() {
    let mut sequence = at_four();
    for (first, end) in [(4, 5), (5, 9), (9, 10)] {
        assert_eq!(sequence.hear(message(1, first, end)), Heard::Next(records(1, first, end)));
    }
    assert_eq!(sequence.hear(alive(1, 10)), Heard::Next(Frame::Alive { newest: 10 }));
    assert_eq!(sequence.ask().goes_on, Some((seal(1, 10), 10)));
}

#[test]
fn what_is_missing_is_asked_for_and_then_the_rest_passes() {
    let mut sequence = at_four();
    assert_eq!(sequence.hear(message(1, 6, 8)), Heard::Missing);
    assert_eq!(sequence.hear(alive(1, 8)), Heard::Missing);
    assert_eq!(sequence.ask().goes_on, Some((seal(1, 4), 4)));
    // The answer begins as a stream does, which is known here.
    assert!(sequence.answer(Frame::Begun(BEGUN.into())).is_empty());
    assert_eq!(sequence.answer(records(1, 4, 7)), [records(1, 4, 7)]);
    // Of two answers to the same question the second has nothing new, of one that lost a frame the rest is none.
    assert!(sequence.answer(records(1, 4, 7)).is_empty());
    assert!(sequence.answer(records(1, 8, 9)).is_empty());
    assert!(sequence.answer(Frame::Alive { newest: 9 }).is_empty());
    // What waited meanwhile is old, or new in part.
    assert_eq!(sequence.hear(message(1, 5, 7)), Heard::Old);
    assert_eq!(sequence.hear(message(1, 6, 9)), Heard::Next(records(1, 7, 9)));
}

#[test]
fn another_session_is_noticed_wherever_it_stands() {
    for other in [message(2, 4, 6), message(2, 2, 6), message(2, 9, 11), alive(2, 4), alive(2, 2)] {
        let mut sequence = at_four();
        assert_eq!(sequence.hear(other.clone()), Heard::Missing, "{other:?}");
        assert_eq!(sequence.ask().goes_on, Some((seal(1, 4), 4)));
    }
    let refused = Frame::Refused("another session".into());
    assert_eq!(at_four().answer(refused.clone()), [refused]);
}

#[test]
fn one_that_begins_holds_all_until_it_knows_its_place() {
    let (begun, model) = (Frame::Begun(BEGUN.into()), Frame::Model(vec![1; 10]));
    let start = Frame::Start { records: 3, seal: seal(1, 3), last_tick: 2, snapshot: vec![2; 10] };
    let ask = Ask { model: Some(7), ..Ask::default() };
    let mut sequence = Sequence::new(&ask);
    assert_eq!(sequence.hear(message(1, 0, 3)), Heard::Missing);
    // An answer breaks off, and is asked for anew.
    for frame in [&begun, &model] {
        assert!(sequence.answer(frame.clone()).is_empty());
    }
    assert_eq!(sequence.ask(), ask);
    for frame in [&begun, &model, &start] {
        assert!(sequence.answer(frame.clone()).is_empty());
    }
    let all = [begun.clone(), model.clone(), start, records(1, 3, 5)];
    assert_eq!(sequence.answer(records(1, 3, 5)), all);
    assert_eq!(sequence.ask().goes_on, Some((seal(1, 5), 5)));
    // Without a snapshot and without a record.
    let mut sequence = Sequence::new(&ask);
    assert!(sequence.answer(begun.clone()).is_empty());
    let alive = Frame::Alive { newest: 0 };
    assert_eq!(sequence.answer(alive.clone()), [begun.clone(), alive]);
    assert_eq!(sequence.hear(message(1, 0, 2)), Heard::Next(records(1, 0, 2)));
    // Without a beginning.
    assert!(Sequence::new(&ask).answer(records(1, 0, 2)).is_empty());
    // Snapshot after the last record, and the end.
    let mut sequence = Sequence::new(&ask);
    let end = Frame::End { newest: 0, is_whole: true };
    assert!(sequence.answer(begun.clone()).is_empty());
    assert_eq!(sequence.answer(end.clone()), [begun, end]);
}

#[test]
fn damaged_records_do_not_pass() {
    let mut sequence = at_four();
    let empty = Frame::Records { first: 4, newest: 4, bytes: vec![] };
    assert_eq!(sequence.hear(Message { seal: seal(1, 4), frame: empty }), Heard::Old);
    let far = Frame::Records { first: u32::MAX, newest: 3, bytes: vec![0; 96] };
    assert_eq!(sequence.hear(Message { seal: 0, frame: far.clone() }), Heard::Missing);
    assert!(sequence.answer(far).is_empty());
    let strange = Message { seal: 0, frame: Frame::Model(vec![1]) };
    assert_eq!(sequence.hear(strange), Heard::Old);
}
