//! Faults of a co-simulation, each injected into real processes: killed, stopped, cut off, lied to.
//!
//! Figures are printed as rows of a table: `cargo test -p chaincell-tests --test session faults --
//! --nocapture | grep FAULT`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

mod clock;
mod kill;
mod memory;
mod overload;
mod poses;
mod services;
mod stand_still;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use chaincell_tests::files::{text, write_path};
use chaincell_tests::outsider::{Force, LATE, Outsider, SAFE, STALE, largest_step_n, size};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Ended, Running};
use serde_json::Value;

/// Ticks in which the tool goes to its depth, and holds from then on.
const PRESS_TICKS: u64 = 200;
/// Part of the largest force that no step may reach: a ramp's own is a twentieth, what the tissue
/// does meanwhile comes on top.
const STEP_PART: f64 = 0.15;

/// Share of ticks late without a tissue from which on a machine says nothing of the tissue.
const BUSY: f64 = 0.02;

/// Whether the machine of a `cosim` was busy with something else, told as a row of the table.
fn is_busy(fault: &str, report: &Value) -> bool {
    let floor = report["verdict"]["floor_share"].as_f64().unwrap();
    if floor > BUSY {
        println!("SKIPPED | {fault} | the machine alone is late in {floor} of the ticks |");
    }
    floor > BUSY
}

/// A machine that is busy with something else is given another try.
const TRIES: usize = 3;

/// Whether one of a few tries holds; the last one says why not.
#[track_caller]
fn one_of_a_few<T>(mut attempt: impl FnMut() -> Result<T, String>) -> T {
    for _ in 1..TRIES {
        match attempt() {
            Ok(held) => return held,
            Err(why) => println!("another try: {why}"),
        }
    }
    attempt().unwrap_or_else(|why| panic!("{why}"))
}

/// A place with its server, which tells its figures, and a reader of the answers.
fn served(test: &str) -> (Place, Running, Outsider) {
    let place = Place::stiff(test);
    let serve = place.serve(&["--json"]);
    let outsider = Outsider::join(&place.scene, false);
    (place, serve, outsider)
}

/// Depth of the tool at a tick of [`hold`] \[m\].
fn depth_m(tick: u64) -> f32 {
    let share = (tick as f32 / PRESS_TICKS as f32).min(1.0);
    0.02 * share * share * (3.0 - 2.0 * share)
}

/// A path that presses and holds, a number of ticks long.
fn hold(place: &Place, ticks: u64) -> PathBuf {
    let path = place.file(&format!("hold{ticks}.csv"));
    let row = |tick: u64| (tick, [0.0, 0.0, -depth_m(tick)], u32::from(tick > 0));
    write_path(&path, (0..ticks).map(row));
    path
}

/// A controller on the place's scene.
fn control(place: &Place, options: &[&str]) -> Running {
    Running::start(&mut place.control(options))
}

/// A controller that presses, and holds for a number of ticks in all.
fn holding_control(place: &Place, ticks: u64) -> Running {
    control(place, &["--path", text(&hold(place, ticks))])
}

/// All messages until one of them is what is waited for, that one included.
#[track_caller]
fn until(outsider: &Outsider, mut done: impl FnMut(&Force) -> bool) -> Vec<Force> {
    let mut seen = Vec::new();
    loop {
        let force = outsider.receive();
        seen.push(force);
        if done(&force) {
            return seen;
        }
    }
}

/// A message, when it was looked for in vain for the last time, and when it was seen: it came in
/// between.
type Timed = (Instant, Instant, Force);

/// Takes what has arrived since the last look, and waits a little.
fn take(outsider: &Outsider, looked: &mut Instant, seen: &mut Vec<Timed>) {
    while let Some(force) = outsider.try_receive() {
        seen.push((*looked, Instant::now(), force));
    }
    *looked = Instant::now();
    std::thread::sleep(Duration::from_micros(100));
}

/// All messages with their times until one of them is what is waited for.
#[track_caller]
fn timed_until(outsider: &Outsider, done: impl Fn(&Force) -> bool) -> Vec<Timed> {
    let start = Instant::now();
    let (mut looked, mut seen) = (start, Vec::new());
    while !seen.last().is_some_and(|(_, _, force)| done(force)) {
        assert!(start.elapsed() < SHORT, "{} messages in {SHORT:?}", seen.len());
        take(outsider, &mut looked, &mut seen);
    }
    seen
}

/// Largest sum of the steps of the force between messages that came within a millisecond [N]. Where
/// the reader was kept waiting, and they may have come in a longer time, it is the sum a millisecond
/// of that.
fn largest_in_a_millisecond_n(seen: &[Timed]) -> f64 {
    let ms = |from: Instant, to: Instant| 1e3 * to.duration_since(from).as_secs_f64();
    let step_n = |pair: &[Timed]| largest_step_n(&[pair[0].2, pair[1].2]);
    let steps: Vec<(Instant, Instant, f64)> =
        seen.windows(2).map(|pair| (pair[1].0, pair[1].1, step_n(pair))).collect();
    let (mut first, mut sum_n, mut most_n) = (0, 0.0, 0.0_f64);
    for (_, at, step_n) in &steps {
        sum_n += step_n;
        while ms(steps[first].1, *at) > 1.0 {
            sum_n -= steps[first].2;
            first += 1;
        }
        most_n = most_n.max(sum_n / ms(steps[first].0, *at).max(1.0));
    }
    most_n
}

/// How a process ended, and all messages until then.
#[track_caller]
fn until_end(mut process: Running, outsider: &Outsider) -> (Ended, Vec<Force>) {
    let mut seen = Vec::new();
    while process.is_running() {
        seen.extend(std::iter::from_fn(|| outsider.try_receive()));
        std::thread::sleep(Duration::from_micros(500));
    }
    let ended = process.end(SHORT);
    seen.extend(std::iter::from_fn(|| outsider.try_receive()));
    (ended, seen)
}

/// Size of a force [N].
fn size_n(force: &Force) -> f64 {
    size(force.force_n)
}

/// Largest force of messages [N].
fn largest_n(seen: &[Force]) -> f64 {
    seen.iter().map(size_n).fold(0.0, f64::max)
}

/// A whole number of a report.
#[track_caller]
fn count(report: &Value, name: &str) -> u64 {
    report[name].as_u64().unwrap_or_else(|| panic!("no {name} in {report}"))
}

/// Every message is a number, and 0 where it says so.
#[track_caller]
fn assert_sound(seen: &[Force]) {
    for force in seen {
        assert!(force.force_n.iter().all(|x| x.is_finite()), "{force:?}");
        assert!(force.flags & SAFE == 0 || force.force_n == [0.0; 3], "{force:?}");
    }
}

/// Besides, no step of the force comes near a jump.
#[track_caller]
fn assert_gentle(seen: &[Force]) {
    gentle(seen).unwrap_or_else(|why| panic!("{why}"));
}

/// Whether no step of sound messages comes near a jump, and where one does.
#[track_caller]
fn gentle(seen: &[Force]) -> Result<(), String> {
    assert_sound(seen);
    let (step_n, most_n) = (largest_step_n(seen), largest_n(seen));
    assert!(most_n > 0.1, "almost no force: {most_n} N");
    let at = seen.windows(2).find(|pair| largest_step_n(pair) >= step_n);
    let why = || format!("a step of {step_n} N, the largest force {most_n} N: {at:?}");
    if step_n <= STEP_PART * most_n { Ok(()) } else { Err(why()) }
}

/// Whether the same holds of all messages but the late ones of a machine that kept the server waiting:
/// after those the force goes back to the tissue's at once.
#[track_caller]
fn gentle_where_in_time(fault: &str, seen: &[Force]) -> Result<(), String> {
    let why = match gentle(seen) {
        Ok(()) => return Ok(()),
        Err(why) => why,
    };
    let most_n = STEP_PART * largest_n(seen);
    let is_late = |force: &Force| force.flags & LATE != 0;
    let in_time = |pair: &&[Force]| !pair.iter().any(is_late);
    if seen.windows(2).filter(in_time).any(|pair| largest_step_n(pair) > most_n) {
        return Err(why);
    }
    let late = seen.iter().filter(|force| is_late(force)).count();
    if 20 * late > seen.len() {
        return Err(why);
    }
    println!("SKIPPED | {fault} | steps of {late} late answers: the machine was late | {why} |");
    Ok(())
}

/// The same of a server whose machine let it work. Else the force fell to 0, as it has to.
///
/// A machine that keeps a server waiting for some poses makes a few of them late: with ticks that
/// end in time the force then goes back to the tissue's at once. That is worth another try.
#[track_caller]
fn gentle_in_time(fault: &str, served: &Value, seen: &[Force]) -> Result<(), String> {
    if count(served, "overloads") == 0 {
        return gentle(seen);
    }
    println!("SKIPPED | {fault} | steps of the force: the machine was overloaded |");
    assert_sound(seen);
    Ok(())
}

/// All ticks were answered, none late by a jump of the force; told as a row of the table.
#[track_caller]
fn undisturbed(
    fault: &str,
    ended: Ended,
    serve: Running,
    seen: &[Force],
    ticks: u64,
) -> Result<(), String> {
    let report = ended.with(0).json();
    let found = ["ticks_answered", "ticks_unanswered", "foreign_answers"];
    assert_eq!(found.map(|name| count(&report, name)), [ticks, 0, 0]);
    let served = serve.interrupt().with(130).json();
    assert_eq!(count(&served, "ticks_executed"), ticks);
    gentle_in_time(fault, &served, seen)?;
    tell_seen(fault, ticks, 0, seen);
    Ok(())
}

/// A row of the table: what was done, ticks answered and lost, largest step and largest force.
fn tell(fault: &str, answered: u64, lost: u64, step_n: f64, most_n: f64) {
    println!("FAULT | {fault} | {answered} | {lost} | {step_n:.3} | {most_n:.2} |");
}

/// [`tell`] with what an outside program has seen.
fn tell_seen(fault: &str, answered: u64, lost: u64, seen: &[Force]) {
    tell(fault, answered, lost, largest_step_n(seen), largest_n(seen));
}
