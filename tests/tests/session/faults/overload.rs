//! Sweeps that take long, poses that come late, and what the force does meanwhile.

use chaincell_tests::outsider::{LATE, Outsider, Pose, RELEASE_FIRST};
use chaincell_tests::{run, turn};

use super::*;

/// Five seconds of `cosim` with sweeps stretched to a number of pose periods.
fn stretched(periods: &str) -> Ended {
    let place = Place::stiff("stretched");
    let sweep = format!("sweep:{periods}");
    run(["cosim", text(&place.model), "--seconds", "5", "--inject", &sweep, "--json"])
}

// REQ-COS-09
#[test]
fn a_sweep_below_the_pose_period_is_a_force_in_time() {
    let _turn = turn();
    for periods in ["0.3", "0.8"] {
        one_of_a_few(|| {
            let report = stretched(periods).json();
            let sent = count(&report, "ticks_sent");
            assert_eq!(count(&report, "ticks_answered"), sent, "{report}");
            assert_eq!(report["state_hash"], report["replay_state_hash"]);
            let (late, overloads) = (count(&report, "ticks_late"), count(&report, "overloads"));
            if is_busy(periods, &report) {
                return Ok(());
            }
            let p99 = |name: &str| report[name]["p99"].as_u64().unwrap();
            let most_ns = 3_000_000 + p99("floor_round_trip_ns");
            println!(
                "OVERLOAD | {periods} | {late} late of {sent} | p99 {} us |",
                p99("round_trip_ns") / 1000
            );
            let holds = late <= sent / 20 && overloads == 0 && p99("round_trip_ns") <= most_ns;
            if holds { Ok(()) } else { Err(report.to_string()) }
        });
    }
}

/// Whether the machine overloaded a server before its sweeps, slow in time, surely did.
///
/// What the force did by then says nothing of the sweeps.
fn overloaded_before(fault: &str, served: &Value) -> bool {
    let overloads = count(served, "overloads");
    assert!(overloads > 0, "{fault}: not overloaded by slow sweeps: {served}");
    if overloads > 1 {
        println!("SKIPPED | {fault} | steps of the force: the machine was overloaded before |");
    }
    overloads > 1
}

// REQ-COS-09
#[test]
fn a_sweep_above_the_pose_period_takes_the_force_away() {
    let _turn = turn();
    let periods = "2";
    one_of_a_few(|| {
        let place = Place::stiff("overload");
        let from = 600;
        let sweep = format!("sweep:{periods}@{from}");
        let serve = place.serve(&["--json", "--inject", &sweep]);
        let outsider = Outsider::join(&place.scene, false);
        let mut control = holding_control(&place, 1500);
        let mut seen = Vec::new();
        while control.is_running() {
            seen.extend(std::iter::from_fn(|| outsider.try_receive()));
            std::thread::sleep(Duration::from_micros(200));
        }
        let report = control.end(SHORT).with(0).json();
        let served = serve.interrupt().with(130).json();
        assert_eq!(count(&report, "ticks_answered"), 1500);
        assert_sound(&seen);
        // The last answer to a pose: the server goes on where the controller ends late.
        let last = seen.iter().rfind(|force| force.flags & STALE == 0).unwrap();
        assert_eq!(last.flags & (LATE | SAFE), LATE | SAFE, "{last:?}");
        if overloaded_before(periods, &served) {
            return Ok(());
        }
        assert_gentle(&seen);
        let before_n = seen.iter().find(|force| force.tick == from).map_or(0.0, size_n);
        if before_n == 0.0 {
            return Err(format!("{periods}: no force when the sweeps began to be slow"));
        }
        Ok(())
    });
    let ended = stretched(periods).with(1);
    assert!(ended.err.contains("longer than a pose period"), "{}", ended.err);
}

// REQ-COS-09
#[test]
fn a_fixed_count_that_cannot_keep_up_lets_the_force_go() {
    let _turn = turn();
    let place = Place::stiff("fixed");
    let slow = ["--budget-us", "off", "--sweeps", "4", "--inject", "sweep:0.5@600"];
    let serve = place.serve(&[&["--json"][..], &slow].concat());
    let outsider = Outsider::join(&place.scene, false);
    let (ended, seen) = until_end(holding_control(&place, 1500), &outsider);
    let report = ended.with(0).json();
    let served = serve.interrupt().with(130).json();
    // All poses are executed in full, and none of their forces is shown as one of now.
    assert_eq!(count(&report, "ticks_answered"), 1500);
    assert_eq!(count(&served, "ticks_late"), 0);
    assert_eq!(count(&served["sweeps"], "p1"), 4);
    let last = seen.iter().rfind(|force| force.flags & STALE == 0).unwrap();
    assert_eq!((last.force_n, last.flags & (LATE | SAFE)), ([0.0; 3], LATE | SAFE), "{last:?}");
    if !overloaded_before("fixed", &served) {
        assert_gentle(&seen);
    }
}

/// The press of [`hold`] with thirty of its poses held back and sent at once.
// REQ-COS-09
#[test]
fn thirty_poses_at_once_make_no_larger_force_than_in_time() {
    let _turn = turn();
    let largest = |faults: &[&str]| {
        let (place, serve, outsider) = served("thirty");
        let path = place.file("steady.csv");
        // 0.08 mm a tick.
        let row = |tick: u64| (tick, [0.0, 0.0, -8e-5 * tick.min(250) as f32], u32::from(tick > 0));
        write_path(&path, (0..600).map(row));
        let control = control(&place, &[&["--path", text(&path)][..], faults].concat());
        let (ended, seen) = until_end(control, &outsider);
        assert_eq!(count(&ended.with(0).json(), "ticks_answered"), 600);
        serve.interrupt().with(130);
        (largest_n(&seen), seen)
    };
    for stop in ["stop:30@150", "stop:15@150", "stop:8@200"] {
        one_of_a_few(|| {
            let ((in_time_n, _), (at_once_n, seen)) = (largest(&[]), largest(&["--inject", stop]));
            assert!(seen.iter().any(|force| force.flags & LATE != 0), "{stop}: none came late");
            println!("OVERLOAD | {stop} | {at_once_n} N, in time {in_time_n} N |");
            if at_once_n > 1.1 * in_time_n {
                return Err(format!("{stop}: {at_once_n} N, in time {in_time_n} N"));
            }
            gentle(&seen)
        });
    }
}

/// What a poser who never lets go gets from a server that has just begun.
// REQ-COS-11
#[test]
fn a_server_that_begins_anew_waits_for_a_release() {
    let _turn = turn();
    let place = Place::stiff("release-first");
    let out = place.file("out");
    let serve = place.serve(&["--json", "--out", text(&out), "--budget-us", "off"]);
    let outsider = Outsider::join(&place.scene, true);
    let mut tick = 0;
    let mut answer = |engaged: u32| {
        outsider.send(Pose { tick, position_m: [0.0, 0.0, -1e-4 * tick as f32], engaged });
        tick += 1;
        loop {
            let force = outsider.receive();
            if force.flags & STALE == 0 {
                return force;
            }
        }
    };
    for _ in 0..50 {
        let force = answer(1);
        assert_eq!((force.force_n, force.flags, force.contacts), ([0.0; 3], RELEASE_FIRST, 0));
    }
    assert_eq!(answer(0).flags & RELEASE_FIRST, 0);
    let pressed: Vec<Force> = (0..80).map(|_| answer(1)).collect();
    assert!(size_n(&pressed[79]) > 0.1 && pressed[79].flags & RELEASE_FIRST == 0);
    let served = serve.interrupt().with(130).json();
    assert_eq!(count(&served["flag_ticks"], "release_first"), 50);
    // Recorded as executed.
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
}
