//! Servers that are killed and started again while a client presses.

use std::thread;
use std::time::{Duration, Instant};

use chaincell_client::{Answer, Client, Flags, Notes, Options, Outcome};
use chaincell_tests::files::text;
use chaincell_tests::place::Place;
use chaincell_tests::{run, turn};
use rustix::process::Signal;

use super::{SOME_N, answered, options, pose, press, size_n};

/// Silence after which the force falls \[ms\]: no busy machine is silent for as long.
const WATCHDOG_MS: u32 = 2_000;
/// Time in which it falls and rises \[ms\].
const RAMP_MS: u32 = 1_000;
/// Longest wait in a step \[ns\]: a millisecond, as a device has it.
const MS_NS: u64 = 1_000_000;
/// More steps than anything here takes.
const STEPS_MAX: usize = 20_000;

/// A tick after a millisecond: poses beyond the rate are not carried out.
#[track_caller]
fn paced(client: &mut Client) -> Answer {
    thread::sleep(Duration::from_nanos(MS_NS));
    answered(client, &[pose(200)])
}

/// The answer of a press whose force has risen as far as it does.
#[track_caller]
fn pressed(client: &mut Client) -> Answer {
    press(client, 0..=200);
    let mut rising = (0..STEPS_MAX).map(|_| paced(client));
    let answer = rising.find(|answer| answer.notes == Notes::default()).unwrap();
    assert!(size_n(&answer) > SOME_N, "{answer:?}");
    answer
}

#[test]
fn a_killed_server_lets_the_force_fall_and_the_next_one_is_told_of() {
    let _turn = turn();
    let place = Place::new("client-killed");
    let trace = place.folder.path().join("killed.trace");
    let mut serve = place.serve(&["--record", text(&trace), "--record-ticks", "100000"]);
    let shaped = Options { watchdog_ms: WATCHDOG_MS, ramp_ms: RAMP_MS, ..options(&place) };
    let mut client = Client::open(&shaped).unwrap();
    let before = pressed(&mut client);
    let begun = Instant::now();
    serve.kill();
    // A machine that took long to end the process has used up the watchdog's time.
    let is_slow = begun.elapsed() > Duration::from_millis(u64::from(WATCHDOG_MS) / 2);
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
    pressed(&mut client);
    let (silences, foreign, _) = client.counts().unwrap();
    assert_eq!((silences, foreign), (1, 0));
    serve.interrupt().with(130);
}

#[test]
fn a_server_that_stands_still_lets_the_force_fall_without_a_jump() {
    let _turn = turn();
    let place = Place::new("client-stands");
    let serve = place.serve(&["--watchdog-ms", "0", "--ramp-ms", "0"]);
    let shaped = Options { watchdog_ms: WATCHDOG_MS, ramp_ms: RAMP_MS, ..options(&place) };
    let mut client = Client::open(&shaped).unwrap();
    let largest_n = size_n(&pressed(&mut client));
    serve.signal(Signal::STOP);
    let (mut silent, mut last_n, mut step_n) = (0, largest_n, 0.0_f64);
    let (mut stepped, mut longest) = (Instant::now(), Duration::ZERO);
    for _ in 0..STEPS_MAX {
        let (outcome, answer) = client.step(&[pose(200)], MS_NS).unwrap();
        longest = longest.max(stepped.elapsed());
        stepped = Instant::now();
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
        let answer = paced(&mut client);
        longest = longest.max(stepped.elapsed());
        stepped = Instant::now();
        step_n = step_n.max((size_n(&answer) - last_n).abs());
        last_n = size_n(&answer);
    }
    // The force moves by the clock: a machine that stands still makes a step of it.
    if longest < Duration::from_millis(u64::from(RAMP_MS) / 10) {
        assert!(step_n < 0.2 * largest_n, "{step_n} N in a step of {largest_n} N");
    } else {
        println!("SKIPPED the fall of the force without a jump: the machine stood for {longest:?}");
    }
    serve.interrupt().with(130);
}
