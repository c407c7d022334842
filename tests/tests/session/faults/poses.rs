//! Poses that are late, lost, repeated, out of order, no numbers, too fast, in bursts.

use chaincell_tests::outsider::{Outsider, Pose};
use chaincell_tests::{run, turn};

use super::*;

/// Poses of a run.
const POSES: u64 = 1000;

/// What both sides say of a press with faults, and what an outside program has seen of it.
#[track_caller]
fn press(faults: &str) -> (Value, Value, Vec<Force>) {
    one_of_a_few(|| press_once(faults))
}

/// The same, or where the force jumped.
#[track_caller]
fn press_once(faults: &str) -> Result<(Value, Value, Vec<Force>), String> {
    let (place, serve, outsider) = served("poses");
    let path = hold(&place, POSES);
    let control = control(&place, &["--path", text(&path), "--inject", faults, "--inject-seed=7"]);
    let (ended, seen) = until_end(control, &outsider);
    let report = ended.with(0).json();
    let served = serve.interrupt().with(130).json();
    let injected = &report["injected"];
    let (lost, overtaken) = (count(injected, "lost"), count(injected, "overtaken"));
    assert_eq!(count(&report, "ticks_sent"), POSES - lost, "{faults}");
    assert_eq!(count(&report, "ticks_answered"), POSES - lost - overtaken, "{faults}");
    assert_eq!(count(&report, "ticks_unanswered"), 0, "{faults}");
    assert_eq!(count(&report, "foreign_answers"), 0, "{faults}");
    assert_eq!(count(&served, "ticks_executed"), POSES - lost - overtaken, "{faults}");
    assert_eq!(
        count(&served, "poses_repeated"),
        overtaken + count(injected, "duplicated"),
        "{faults}"
    );
    assert_eq!(served["state_hash"], report["state_hash"], "{faults}");
    let answered = count(&report, "ticks_answered");
    gentle_in_time(faults, &served, &seen)?;
    tell_seen(&format!("`--inject {faults}`"), answered, POSES - answered, &seen);
    Ok((report, served, seen))
}

// REQ-COS-03
#[test]
fn late_lost_and_bursts() {
    let _turn = turn();
    for (faults, name) in [("late:5%@5", "late"), ("lost:1%", "lost"), ("burst:2%@50", "bursts")] {
        let (report, _, _) = press(faults);
        assert!(count(&report["injected"], name) > 0, "{faults}");
    }
}

// REQ-COS-03
#[test]
fn twice_and_out_of_order() {
    let _turn = turn();
    for (faults, name) in [("dup:2%", "duplicated"), ("reorder:2%", "overtaken")] {
        let (report, _, _) = press(faults);
        assert!(count(&report["injected"], name) > 0, "{faults}");
    }
}

// REQ-COS-03
#[test]
fn no_numbers() {
    let _turn = turn();
    let (report, _, seen) = press("nan:2%");
    let bad = count(&report["injected"], "nan");
    let held = seen.iter().filter(|force| force.flags & (STALE | 2) == 2).count() as u64;
    assert!(bad > 0 && held == bad, "{held} of {bad} bad samples held");
}

// REQ-COS-03
#[test]
fn ten_times_as_fast() {
    let _turn = turn();
    let (report, served, _) = press("rate:10000");
    assert_eq!(count(&report["injected"], "rate_hz"), 10_000);
    assert_eq!((count(&served, "sends_failed"), count(&served, "poses_throttled")), (0, 0));
}

/// Poses beyond the rate, some of them lost before: each is counted once.
#[test]
fn too_fast_and_lost() {
    let _turn = turn();
    let (place, serve, _) = served("fast-lost");
    let path = hold(&place, 3 * POSES);
    let args = ["--path", text(&path), "--inject", "rate:10000,lost:2%", "--inject-seed=7"];
    let report = control(&place, &args).end(SHORT).json();
    let served = serve.interrupt().with(130).json();
    let of = |name: &str| count(&served, name);
    assert!(of("poses_throttled") > 0 && count(&report["injected"], "lost") > 0);
    let all = of("ticks_executed") + of("poses_missing") + of("poses_throttled");
    assert_eq!(all, 3 * POSES, "{served}");
}

/// Beyond the burst that a server takes at once, `cosim` lets it take the rate that it asks for.
#[test]
fn ten_times_as_fast_for_half_a_second() {
    let _turn = turn();
    let place = Place::stiff("fast");
    let model = text(&place.model);
    let args = ["cosim", model, "--seconds", "5", "--inject", "rate:10000", "--json"];
    let args = [&args[..], &["--late-share", "off"]].concat();
    one_of_a_few(|| {
        let ended = run(&args);
        let report = ended.json();
        // At 10 kHz the poses that wait for a server fill their queue within some tens of milliseconds.
        if count(&report, "poses_missing") > 0 {
            return if is_busy("rate:10000", &report) { Ok(()) } else { Err(report.to_string()) };
        }
        ended.with(0);
        let found = ["ticks_answered", "poses_throttled"].map(|name| count(&report, name));
        assert_eq!(found, [5000, 0]);
        Ok(())
    });
}

// REQ-COS-03
#[test]
fn a_stop_and_all_of_them_at_once() {
    let _turn = turn();
    let (_, served, seen) = press("stop:200@600");
    assert!(count(&served, "watchdog_fired") >= 1);
    assert!(seen.iter().any(|force| force.flags & SAFE != 0), "the force did not fall to 0");
    press("late:5%,lost:1%,dup:1%,reorder:1%,nan:1%,burst:2%,stop:100@500");
}

// REQ-COS-03
#[test]
fn bad_samples_without_end_take_the_force_away_along_a_ramp() {
    let _turn = turn();
    let place = Place::stiff("bad-samples");
    let serve = place.serve(&["--json", "--watchdog-ms", "0"]);
    let outsider = Outsider::join(&place.scene, true);
    let mut seen = Vec::new();
    let mut send = |ticks: std::ops::Range<u64>, bad: bool| {
        for tick in ticks {
            let z = if bad { f32::NAN } else { -depth_m(tick) };
            outsider.send(Pose { tick, position_m: [0.0, 0.0, z], engaged: u32::from(tick > 0) });
            seen.push(outsider.receive());
            std::thread::sleep(Duration::from_millis(1));
        }
        *seen.last().unwrap()
    };
    let full_n = size_n(&send(0..300, false));
    let safe = send(300..400, true);
    assert_eq!((safe.force_n, safe.flags & SAFE), ([0.0; 3], SAFE));
    let again_n = size_n(&send(400..500, false));
    assert!((again_n - full_n).abs() < 0.01 * full_n, "{again_n} N after, {full_n} N before");
    assert_gentle(&seen);
    let served = serve.interrupt().with(130).json();
    assert_eq!(count(&served, "ticks_executed"), 500);
    tell_seen("100 poses in a row with NaN", 500, 0, &seen);
}
