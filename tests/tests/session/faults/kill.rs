//! Either side killed in the middle of a press, and started again.

use std::time::Duration;

use chaincell_tests::files::text;
use chaincell_tests::outsider::{Outsider, dead_nodes_of};
use chaincell_tests::turn;
use rustix::process::Signal;

use super::*;

// REQ-COS-01
#[test]
fn a_killed_control_leaves_a_force_that_falls_and_rises_with_the_next_one() {
    let _turn = turn();
    let (place, mut serve, outsider) = served("killed-control");
    let first = holding_control(&place, 60_000);
    let mut seen = until(&outsider, |force| force.tick >= 400);
    first.signal(Signal::KILL);
    let silence = until(&outsider, |force| force.flags & SAFE != 0);
    let backwards = silence.iter().rev().take_while(|force| force.flags & STALE != 0);
    let mut falling: Vec<Force> = backwards.copied().collect();
    falling.reverse();
    assert!(falling.len() >= 20, "{} messages on the way down", falling.len());
    assert!(falling.windows(2).all(|pair| size_n(&pair[1]) < size_n(&pair[0])));
    let held = falling[0].state_hash;
    assert!(falling.iter().all(|force| force.state_hash == held), "a cell has moved");
    assert!(serve.is_running());
    seen.extend(silence);
    let (ended, risen) = until_end(holding_control(&place, 600), &outsider);
    let second = ended.with(0).json();
    assert_eq!((count(&second, "ticks_answered"), count(&second, "ticks_unanswered")), (600, 0));
    seen.extend(risen);
    // The last answer to a pose: the server lets the force fall where the controller ends late.
    let last = seen.iter().rfind(|force| force.flags & STALE == 0).unwrap();
    assert!(size_n(last) > 0.5 * largest_n(&seen), "the force is not back");
    gentle_where_in_time("control killed", &seen).unwrap();
    let served = serve.interrupt().with(130).json();
    assert_eq!((count(&served, "publishers"), count(&served, "poses_repeated")), (2, 0));
    assert!(count(&served, "watchdog_fired") >= 1);
    tell_seen("control killed, another one started", count(&served, "ticks_executed"), 0, &seen);
}

// REQ-COS-02
#[test]
fn a_control_outlives_its_server_and_goes_on_with_the_next_one() {
    let _turn = turn();
    one_of_a_few(killed_server);
}

/// One try of it; the error is a step of the force at the device.
fn killed_server() -> Result<(), String> {
    let place = Place::stiff("killed-server");
    let first = place.serve(&[]);
    let outsider = Outsider::join(&place.scene, false);
    let control = holding_control(&place, 3000);
    let mut seen = until(&outsider, |force| force.tick >= 600);
    let killed = first.id();
    first.signal(Signal::KILL);
    first.end(SHORT);
    std::thread::sleep(Duration::from_millis(200));
    let second = place.serve(&["--json"]);
    assert_eq!(dead_nodes_of(killed), 0, "what the first server left was not cleared up");
    let (ended, answers) = until_end(control, &outsider);
    seen.extend(answers);
    let report = ended.with(1).json();
    let (sent, answered) = (count(&report, "ticks_sent"), count(&report, "ticks_answered"));
    let lost = count(&report, "ticks_unanswered");
    assert_eq!((sent, answered + lost, count(&report, "foreign_answers")), (3000, 3000, 0));
    assert!(lost > 0 && count(&report, "silences") >= 1, "{report}");
    let served = second.interrupt().with(130).json();
    let again = count(&served, "ticks_executed");
    assert!(again > 100 && again <= answered, "{again} by the second of {answered}");
    // A device behind the controller feels no jump, though the first server's last force was full.
    let (step_n, most_n) = (report["largest_force_step_n"].as_f64().unwrap(), largest_n(&seen));
    assert!(most_n > 0.1, "almost no force: {most_n} N");
    if step_n > STEP_PART * most_n {
        return Err(format!("{step_n} N of {most_n} N"));
    }
    tell("serve killed, another one started", answered, lost, step_n, most_n);
    Ok(())
}

// REQ-COS-02
#[test]
fn a_control_without_a_server_again_ends_by_itself() {
    let _turn = turn();
    let place = Place::stiff("no-server-again");
    let serve = place.serve(&[]);
    let outsider = Outsider::join(&place.scene, false);
    let control = control(&place, &["--path", text(&hold(&place, 1000))]);
    until(&outsider, |force| force.tick >= 300);
    serve.signal(Signal::KILL);
    let ended = control.end(SHORT).with(1);
    assert!(ended.err.contains("not answered: "), "{}", ended.err);
    let report = ended.json();
    assert_eq!(count(&report, "ticks_sent"), 1000);
    let (answered, lost) = (count(&report, "ticks_answered"), count(&report, "ticks_unanswered"));
    assert!(answered >= 300 && answered + lost == 1000, "{report}");
    let step_n = report["largest_force_step_n"].as_f64().unwrap();
    tell("serve killed, none started", answered, lost, step_n, f64::NAN);
}
