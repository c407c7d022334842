//! Either side stopped for up to ten seconds in the middle of a press, and a reader that never
//! reads.

use chaincell_tests::outsider::Outsider;
use chaincell_tests::turn;
use rustix::process::Signal;

use super::*;

/// Poses of a run, those of a stop aside.
const POSES: u64 = 1500;
/// Lengths of the stops [ms].
const STOPS_MS: [u64; 3] = [200, 1500, 10_000];

/// Which side stands still.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Serve,
    Control,
}

/// A press and a hold in the middle of which a side stands still for so long: what control and
/// serve say, and all messages with their times.
fn stopped(side: Side, ms: u64) -> (Value, Value, Vec<Timed>) {
    // At ordinary priority, so that the reader has its turn as often as both sides.
    let place = Place::stiff("stopped");
    let serve = place.serve(&["--json", "--no-realtime"]);
    let outsider = Outsider::join(&place.scene, false);
    let path = hold(&place, POSES + ms);
    let mut control = control(&place, &["--path", text(&path), "--no-realtime"]);
    let mut seen = timed_until(&outsider, |force| force.tick >= 400);
    let mut looked = Instant::now();
    let signal = |signal| match side {
        Side::Serve => serve.signal(signal),
        Side::Control => control.signal(signal),
    };
    signal(Signal::STOP);
    let stopped = Instant::now();
    while stopped.elapsed() < Duration::from_millis(ms) {
        take(&outsider, &mut looked, &mut seen);
    }
    signal(Signal::CONT);
    while control.is_running() {
        take(&outsider, &mut looked, &mut seen);
    }
    let report = control.end(SHORT).json();
    let served = serve.interrupt().with(130).json();
    take(&outsider, &mut looked, &mut seen);
    (report, served, seen)
}

/// What must hold whichever side stood still.
#[track_caller]
fn assert_no_jump(
    side: Side,
    ms: u64,
    (report, served, seen): &(Value, Value, Vec<Timed>),
) -> Result<(), String> {
    let sent = count(report, "ticks_sent");
    let of = |name: &str| count(served, name);
    assert_eq!(sent, POSES + ms);
    // Each pose was executed, was overwritten in the full queue, or was too many at once.
    let all = of("ticks_executed") + of("poses_missing") + of("poses_throttled");
    assert_eq!(all, sent, "{served}");
    // Behind the stop a thousand answers come at once: a reader that the machine keeps waiting loses
    // the oldest of a full queue.
    let lost = of("ticks_executed").checked_sub(count(report, "ticks_answered"));
    assert!(lost.is_some_and(|lost| lost <= sent / 50), "{report}");
    let forces: Vec<Force> = seen.iter().map(|(_, _, force)| *force).collect();
    let fault = format!("SIGSTOP of {side:?} for {ms} ms");
    gentle(&forces)?;
    let most_n = largest_n(&forces);
    let step_n = report["largest_force_step_n"].as_f64().unwrap();
    if step_n > STEP_PART * most_n {
        return Err(format!("{fault}: {step_n} N of {most_n} N at the device"));
    }
    // A reader that the machine keeps waiting sees the messages of several milliseconds at once.
    let within_ms = largest_in_a_millisecond_n(seen);
    let executed = of("ticks_executed");
    tell(&fault, executed, sent - executed, within_ms, most_n);
    if within_ms <= STEP_PART * most_n {
        return Ok(());
    }
    Err(format!("{fault}: {within_ms} N in a millisecond, of {most_n} N"))
}

// REQ-COS-05
#[test]
fn a_server_that_stood_still_throws_no_hand() {
    let _turn = turn();
    for ms in STOPS_MS {
        one_of_a_few(|| {
            let found = stopped(Side::Serve, ms);
            assert!(count(&found.0, "silences") >= 1);
            assert!(count(&found.0, "missed_deadlines") >= 100);
            if ms >= 1500 {
                assert!(count(&found.1, "poses_missing") > 0, "a queue of 1,024 and {ms} poses");
            }
            assert_no_jump(Side::Serve, ms, &found)
        });
    }
}

// REQ-COS-05
#[test]
fn a_control_that_stood_still_throws_no_hand_and_the_force_falls_meanwhile() {
    let _turn = turn();
    for ms in STOPS_MS {
        one_of_a_few(|| {
            let found = stopped(Side::Control, ms);
            let fell = |(_, _, force): &Timed| force.flags & (STALE | SAFE) == STALE | SAFE;
            assert!(found.2.iter().any(fell) && count(&found.1, "watchdog_fired") >= 1);
            assert_no_jump(Side::Control, ms, &found)
        });
    }
}

// REQ-COS-05
#[test]
fn a_reader_that_never_reads_holds_up_nobody() {
    let _turn = turn();
    let place = Place::stiff("never-reads");
    let serve = place.serve(&["--json"]);
    let (idle, outsider) =
        (Outsider::join(&place.scene, false), Outsider::join(&place.scene, false));
    let (ended, seen) = until_end(holding_control(&place, POSES), &outsider);
    let report = ended.with(0).json();
    assert_eq!((count(&report, "ticks_answered"), count(&report, "sends_failed")), (POSES, 0));
    let served = serve.interrupt().with(130).json();
    assert_eq!((count(&served, "ticks_executed"), count(&served, "sends_failed")), (POSES, 0));
    let ticks: Vec<u64> = seen.iter().filter(|f| f.flags & STALE == 0).map(|f| f.tick).collect();
    assert!(ticks.into_iter().eq(0..POSES), "the other reader has missed an answer");
    // The idle one finds the newest messages once it looks.
    let kept: Vec<Force> = std::iter::from_fn(|| idle.try_receive()).collect();
    assert!(kept.last().is_some_and(|force| force.tick == POSES - 1), "{}", kept.len());
    gentle_where_in_time("a reader that never reads", &seen).unwrap();
    tell_seen("a reader that never reads", POSES, 0, &seen);
}
