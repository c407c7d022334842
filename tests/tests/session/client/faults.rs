//! Servers that are killed and started again while a client presses.

use std::time::{Duration, Instant};

use chaincell_client::{Client, Flags, Notes, Options, Outcome};
use chaincell_tests::files::text;
use chaincell_tests::place::Place;
use chaincell_tests::{run, turn};
use rustix::process::Signal;

use super::{SOME_N, WAIT_NS, options, pose, press, size_n};

/// Longest wait in a step \[ns\]: a millisecond, as a device has it.
const MS_NS: u64 = 1_000_000;
/// More steps than anything here takes.
const STEPS_MAX: usize = 20_000;

#[test]
fn a_killed_server_lets_the_force_fall_and_the_next_one_is_told_of() {
    let _turn = turn();
    let place = Place::new("client-killed");
    let trace = place.folder.path().join("killed.trace");
    let mut serve = place.serve(&["--record", text(&trace), "--record-ticks", "100000"]);
    let shaped = Options { watchdog_ms: 200, ramp_ms: 20, ..options(&place) };
    let mut client = Client::open(&shaped).unwrap();
    let before = press(&mut client, 0..=200).pop().unwrap();
    assert!(size_n(&before) > SOME_N && before.notes == Notes::default(), "{before:?}");
    let begun = Instant::now();
    serve.kill();
    // A machine that took long to end the process has used up the watchdog's time.
    let is_slow = begun.elapsed() > Duration::from_millis(150);
    let (mut last_n, mut outcomes) = (size_n(&before), Vec::new());
    for step in 0..STEPS_MAX {
        let (outcome, answer) = client.step(&[pose(200)], MS_NS).unwrap();
        // What was under way may still have come.
        assert!(outcome != Outcome::Answered || step < 3);
        assert!(outcomes.is_empty() || size_n(&answer) <= last_n, "the force never rises");
        assert_eq!(outcome == Outcome::Silent, answer.notes.contains(Notes::SILENT));
        (last_n, _) = (size_n(&answer), outcomes.push(outcome));
        if last_n == 0.0 {
            break;
        }
    }
    let held = outcomes.iter().filter(|outcome| **outcome == Outcome::NoAnswer).count();
    let fell = outcomes.iter().filter(|outcome| **outcome == Outcome::Silent).count();
    let has_held = held >= 10 || is_slow;
    assert!(last_n == 0.0 && has_held && fell >= 10, "{held} held, {fell} fell, {last_n} N");
    // The session is unharmed up to the kill.
    run(["replay", text(&trace), "--model", text(&place.model)]).with(0);

    let serve = place.serve(&["--json"]);
    let mut steps = (0..STEPS_MAX).map(|_| client.step(&[pose(200)], MS_NS).unwrap());
    let (_, first) = steps.find(|(outcome, _)| *outcome == Outcome::Answered).unwrap();
    assert!(first.session_id != before.session_id && first.session_id != 0);
    assert!(first.notes.contains(Notes::NEW_SESSION), "{first:?}");
    assert!(Flags(first.flags).contains(Flags::RELEASE_FIRST), "{first:?}");
    assert_eq!(size_n(&first), 0.0, "until the tool was released");
    drop(steps);
    assert!(press(&mut client, 0..=0)[0].notes.contains(Notes::NEW_SESSION), "once more");
    let after = press(&mut client, 1..=200).pop().unwrap();
    assert!(size_n(&after) > SOME_N && after.notes == Notes::default(), "{after:?}");
    let (silences, foreign, _) = client.counts().unwrap();
    assert_eq!((silences, foreign), (1, 0));
    serve.interrupt().with(130);
}

#[test]
fn a_server_that_stands_still_lets_the_force_fall_without_a_jump() {
    let _turn = turn();
    let place = Place::new("client-stands");
    let serve = place.serve(&["--watchdog-ms", "0", "--ramp-ms", "0"]);
    // The force falls by the clock: a step of a fifth is one of 80 ms, which no busy machine makes.
    let shaped = Options { watchdog_ms: 100, ramp_ms: 400, ..options(&place) };
    let mut client = Client::open(&shaped).unwrap();
    press(&mut client, 0..=200);
    let largest_n = size_n(&client.shown().unwrap());
    serve.signal(Signal::STOP);
    let (mut silent, mut last_n, mut step_n) = (0, largest_n, 0.0_f64);
    for _ in 0..STEPS_MAX {
        let (outcome, answer) = client.step(&[pose(200)], MS_NS).unwrap();
        silent += usize::from(outcome == Outcome::Silent);
        step_n = step_n.max((size_n(&answer) - last_n).abs());
        last_n = size_n(&answer);
        if size_n(&answer) == 0.0 {
            break;
        }
    }
    assert!(silent >= 10, "{silent}");
    assert_eq!(size_n(&client.shown().unwrap()), 0.0);
    serve.signal(Signal::CONT);
    while last_n < 0.9 * largest_n {
        let (outcome, answer) = client.step(&[pose(200)], WAIT_NS).unwrap();
        assert_eq!(outcome, Outcome::Answered);
        step_n = step_n.max((size_n(&answer) - last_n).abs());
        last_n = size_n(&answer);
    }
    assert!(step_n < 0.2 * largest_n, "{step_n} N in a step of {largest_n} N");
    serve.interrupt().with(130);
}
