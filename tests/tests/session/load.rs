//! `cosim --load`: both processes under load, every tick answered, no memory taken, all of it counted.
//!
//! `CHAINCELL_SLOW=1 cargo test --release -p chaincell-tests --test session load` runs for ten minutes.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::time::Duration;

use chaincell_tests::files::{Table, bake, is_hash, scratch, summary, text};
use chaincell_tests::outsider::Outsider;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, chaincell, scene, turn};
use serde_json::Value;

/// Columns of histogram.csv and keys of `histograms`.
const HISTOGRAMS: [&str; 5] = ["wakeup", "step", "round_trip", "floor_wakeup", "floor_round_trip"];

fn plane(folder: &std::path::Path) -> PathBuf {
    bake(folder, "plane:9x9x0.01", &["--alpha", "0.02"])
}

fn number(found: &Value, pointer: &str) -> u64 {
    let number = found.pointer(pointer).and_then(Value::as_u64);
    number.ok_or_else(|| format!("{pointer}: {found}")).unwrap()
}

/// Checks the report of a session that was not interrupted, whatever the machine did to its times.
#[track_caller]
fn check(found: &Value, ticks: u64, floor_ticks: u64) {
    assert_eq!((number(found, "/ticks_sent"), number(found, "/ticks_answered")), (ticks, ticks));
    assert_eq!(found["interrupted"], false);
    assert!(is_hash(&found["state_hash"]));
    assert_eq!(found["state_hash"], found["replay_state_hash"]);
    let found = &found["load"];
    let counts = HISTOGRAMS.map(|name| number(found, &format!("/histograms/{name}/count")));
    // The floor is measured before and after; a late tick is no step.
    let steps = counts[1];
    assert_eq!(counts, [ticks, steps, ticks, 2 * floor_ticks, 2 * floor_ticks]);
    assert!((ticks / 2..=ticks).contains(&steps), "{steps} of {ticks}");
    for name in HISTOGRAMS {
        let spans = &found["histograms"][name];
        let buckets = spans["buckets"].as_array().unwrap();
        let sum: u64 = buckets.iter().map(|bucket| bucket[1].as_u64().unwrap()).sum();
        assert_eq!(sum, number(spans, "/count"), "{name}");
        let ascending = ["min_ns", "mean_ns", "max_ns"].map(|key| spans[key].as_u64().unwrap());
        assert!(ascending.is_sorted(), "{name}: {ascending:?}");
        let last_us = buckets.last().unwrap()[0].as_u64().unwrap();
        assert!(last_us * 1000 <= ascending[2], "{name}: the maximum lies in the last bucket");
    }
    for missed in ["/missed", "/floor_missed/before", "/floor_missed/after", "/floor_missed/both"] {
        let part = |key: &str| number(found, &format!("{missed}/{key}"));
        assert_eq!(part("total"), part("sent_late") + part("in_step") + part("on_the_way"));
        assert!(part("total") <= part("ticks"));
    }
    assert_eq!(number(found, "/floor_missed/both/ticks"), 2 * floor_ticks);
    for side in ["memory_serve", "memory_control"] {
        // The command itself fails on a kilobyte more: less is what the system took back.
        assert!(found[side]["growth_kb"].as_i64().unwrap() <= 0, "{}", found[side]);
        assert!(number(found, &format!("/{side}/first_kb")) > 0);
        assert!(number(found, &format!("/{side}/looks")) >= 2);
    }
    assert!(found["machine"]["system"].as_str().unwrap().split(' ').count() == 3);
    assert!(found["command"].as_str().unwrap().contains(" cosim "));
}

// REQ-COS-08
#[test]
fn a_short_run_under_load() {
    let _turn = turn();
    let folder = scratch();
    let (model, out) = (plane(folder.path()), folder.path().join("out"));
    let args = ["cosim", text(&model), "--seconds", "4", "--load", "1", "--out", text(&out)];
    let ended = Running::chaincell([&args[..], &["--late-share", "off", "--json"]].concat());
    let found = ended.end(5 * SHORT).with(0).json();
    check(&found, 4000, 1000);
    assert_eq!(number(&found, "/load/threads"), 1);
    assert!(found["load"]["gb_per_s"].as_f64().unwrap() > 0.0);
    assert_eq!(summary(&out), found);
    let table = Table::read(&out.join("histogram.csv"));
    for name in HISTOGRAMS {
        let sum: u64 = table.whole(name).into_iter().sum();
        assert_eq!(sum, number(&found, &format!("/load/histograms/{name}/count")), "{name}");
    }
}

#[test]
fn ctrl_c_leaves_what_was_counted_so_far() {
    let _turn = turn();
    let folder = scratch();
    let (model, out, name) = (plane(folder.path()), folder.path().join("out"), scene("load"));
    let args =
        ["cosim", text(&model), "--seconds", "7200", "--load", "0", "--scene", &name, "--out"];
    let mut command = chaincell();
    command.args(args).arg(&out).arg("--json").process_group(0);
    let cosim = Running::start(&mut command);
    // The floor of two hours takes minutes: interrupted there is nothing yet.
    std::thread::sleep(Duration::from_secs(1));
    cosim.interrupt_group().with(130);
    let args = ["cosim", text(&model), "--seconds", "10", "--load", "0", "--scene", &name];
    let cosim = Running::chaincell([&args[..], &["--out", text(&out), "--json"]].concat());
    Outsider::join(&name, false).after(300);
    let found = cosim.interrupt().with(130).json();
    let ticks = number(&found, "/ticks_answered");
    assert!((300..10_000).contains(&ticks), "{ticks}");
    assert_eq!((&found["interrupted"], number(&found, "/load/threads")), (&true.into(), 0));
    assert_eq!(number(&found, "/load/histograms/round_trip/count"), ticks);
    assert_eq!(number(&found, "/load/floor_missed/after/ticks"), 0);
    assert_eq!(summary(&out), found);
}

#[test]
fn a_path_played_over_and_over() {
    let _turn = turn();
    let place = chaincell_tests::place::Place::new("repeat");
    let serve = place.serve(&["--ticks", "600", "--json"]);
    let mut control = place.control(&["--seconds", "0.2", "--repeat", "3"]);
    let control = Running::start(&mut control).end(SHORT).with(0).json();
    assert_eq!((&control["ticks_sent"], &control["ticks_answered"]), (&600.into(), &600.into()));
    assert_eq!(control["foreign_answers"], 0);
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&served["ticks_executed"], &served["poses_repeated"]), (&600.into(), &0.into()));
    assert_eq!(served["state_hash"], control["state_hash"]);
    let none = chaincell_tests::run(["control", "--scene", &place.scene, "--repeat", "0"]).with(2);
    assert!(none.err.contains("--repeat"), "{}", none.err);
}

// REQ-COS-08
#[test]
fn ten_minutes_with_the_organ() {
    if std::env::var_os("CHAINCELL_SLOW").is_none() {
        println!("SKIPPED ten_minutes_with_the_organ: CHAINCELL_SLOW is not set");
        return;
    }
    let _turn = turn();
    let args = ["cosim", "--load", "1", "--seconds", "600", "--late-share", "off", "--json"];
    let found = Running::chaincell(args).end(Duration::from_secs(1000)).with(0).json();
    check(&found, 600_000, 60_000);
    for name in HISTOGRAMS {
        println!("{name}: max {} ns", number(&found, &format!("/load/histograms/{name}/max_ns")));
    }
}
