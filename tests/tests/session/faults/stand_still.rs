//! Either side stopped for 200 ms in the middle of a press, and a reader that never reads.

use chaincell_tests::outsider::Outsider;
use chaincell_tests::{Running, turn};
use rustix::process::Signal;

use super::*;

/// Poses of a run.
const POSES: u64 = 1500;

fn stop(process: &Running) {
    process.signal(Signal::STOP);
    std::thread::sleep(Duration::from_millis(200));
    process.signal(Signal::CONT);
}

#[test]
fn a_server_that_stood_still_answers_all_and_no_hand_is_thrown() {
    let _turn = turn();
    let (place, serve, outsider) = served("stopped-server");
    let control = holding_control(&place, POSES);
    let mut seen = until(&outsider, |force| force.tick >= 400);
    stop(&serve);
    let (ended, more) = until_end(control, &outsider);
    seen.extend(more);
    let report = ended.with(0).json();
    assert_eq!((count(&report, "ticks_answered"), count(&report, "ticks_unanswered")), (POSES, 0));
    assert!(count(&report, "silences") >= 1 && count(&report, "missed_deadlines") >= 100);
    let served = serve.interrupt().with(130).json();
    assert_eq!(count(&served, "ticks_executed"), POSES);
    assert_gentle(&seen);
    let (step_n, most_n) = (report["largest_force_step_n"].as_f64().unwrap(), largest_n(&seen));
    assert!(step_n <= STEP_PART * most_n, "{step_n} N of {most_n} N");
    tell("SIGSTOP of serve for 200 ms", POSES, 0, step_n, most_n);
}

#[test]
fn a_control_that_stood_still_sends_all_and_the_force_falls_meanwhile() {
    let _turn = turn();
    let (place, serve, outsider) = served("stopped-control");
    let control = holding_control(&place, POSES);
    let mut seen = until(&outsider, |force| force.tick >= 400);
    stop(&control);
    let (ended, more) = until_end(control, &outsider);
    seen.extend(more);
    let report = ended.with(0).json();
    assert_eq!((count(&report, "ticks_answered"), count(&report, "ticks_unanswered")), (POSES, 0));
    assert!(seen.iter().any(|force| force.flags & (STALE | SAFE) == STALE | SAFE));
    assert_gentle(&seen);
    let served = serve.interrupt().with(130).json();
    assert!(count(&served, "watchdog_fired") >= 1);
    assert_eq!(count(&served, "ticks_executed"), POSES);
    let step_n = report["largest_force_step_n"].as_f64().unwrap();
    assert!(step_n <= STEP_PART * largest_n(&seen), "{step_n} N at the device");
    tell_seen("SIGSTOP of control for 200 ms", POSES, 0, &seen);
}

#[test]
fn a_reader_that_never_reads_holds_up_nobody() {
    let _turn = turn();
    let place = place("never-reads");
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
    assert_gentle(&seen);
    tell_seen("a reader that never reads", POSES, 0, &seen);
}
