//! Faults: read, drawn, counted.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::engine::motion::Pose;
use chaincell_host::session::loops::inject::{Faults, Injected, Plan, Sending};
use chaincell_host::session::timing::clock::MILLISECOND_NS;

const POSES: u64 = 10_000;

fn run(faults: &str, seed: u64) -> (Vec<Sending>, Injected) {
    let mut plan = Plan::new(POSES, Some((faults.parse().unwrap(), seed)));
    let totals = plan.totals();
    let sendings: Vec<Sending> = plan.by_ref().collect();
    let done = plan.injected().unwrap();
    assert!(sendings.is_sorted_by_key(|sending| sending.due_ns), "{faults}");
    assert_eq!(totals.answers, POSES - done.lost - done.overtaken, "{faults}");
    assert_eq!(totals.end_ns, sendings.last().unwrap().due_ns, "{faults}");
    (sendings, done)
}

/// The poses in the order of sending.
fn order(sendings: &[Sending]) -> Vec<u64> {
    sendings.iter().map(|sending| sending.index).collect()
}

#[test]
fn no_fault_is_the_plain_schedule() {
    let mut plain = Plan::new(POSES, None);
    let (sendings, done) = run("late:0%", 3);
    assert!(plain.by_ref().eq(sendings.iter().copied()));
    assert_eq!(plain.injected(), None);
    assert_eq!(done, Injected { seed: 3, rate_hz: 1000, ..Injected::default() });
    assert_eq!(sendings[7].due_ns, 7 * MILLISECOND_NS);
}

#[test]
fn a_seed_gives_the_same_faults_and_another_one_others() {
    let all = "late:5%,lost:1%,dup:1%,reorder:1%,nan:1%,burst:2%,rate:2000,stop:200@1000";
    let one = run(all, 1);
    assert_eq!(one, run(all, 1));
    assert_ne!(one.0, run(all, 2).0);
}

#[test]
fn each_fault_comes_as_often_as_asked_and_is_counted() {
    let about = |count: u64| assert!((400..600).contains(&count), "{count} of 10,000 at 5 %");
    let (late, done) = run("late:5%@3", 1);
    about(done.late);
    assert_eq!(order(&late), (0..POSES).collect::<Vec<_>>());
    let delay = |sending: &Sending| sending.due_ns - sending.index * MILLISECOND_NS;
    let longest = late.iter().map(delay).max().unwrap();
    assert!((2 * MILLISECOND_NS..=3 * MILLISECOND_NS).contains(&longest), "{longest}");
    let (_, done) = run("lost:5%", 1);
    about(done.lost);
    let (dup, done) = run("dup:5%", 1);
    about(done.duplicated);
    assert_eq!(dup.len() as u64, POSES + done.duplicated);
    let (nan, done) = run("nan:5%", 1);
    about(done.nan);
    let bad = nan.iter().filter(|sending| sending.pose(Pose::default()).position_m[0].is_nan());
    assert_eq!(bad.count() as u64, done.nan);
    let (burst, done) = run("burst:5%@8", 1);
    about(done.bursts);
    let longest = burst.iter().map(delay).max().unwrap();
    assert_eq!(longest, 7 * MILLISECOND_NS);
}

#[test]
fn an_overtaken_pose_is_sent_behind_the_next_one() {
    let (sendings, done) = run("reorder:5%", 1);
    assert!((400..600).contains(&done.overtaken), "{}", done.overtaken);
    let order = order(&sendings);
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..POSES).collect::<Vec<_>>());
    assert!(order.iter().enumerate().all(|(at, &index)| (at as u64).abs_diff(index) <= 1));
    let overtaken = order.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert_eq!(overtaken as u64, done.overtaken);
}

#[test]
fn a_stop_is_made_up_for_at_its_end() {
    let (sendings, done) = run("stop:200@1000", 1);
    assert_eq!(done.stops, 1);
    let due_ms = |index: usize| sendings[index].due_ns / MILLISECOND_NS;
    assert_eq!([999, 1000, 1199, 1200, 1201].map(due_ms), [999, 1200, 1200, 1200, 1201]);
    assert_eq!(run("stop:200@20000", 1).1.stops, 0);
}

#[test]
fn a_rate_sets_the_schedule() {
    let (sendings, done) = run("rate:10000", 1);
    assert_eq!((sendings[3].due_ns, done.rate_hz), (300_000, 10_000));
}

#[test]
fn bad_faults_are_refused_by_name() {
    for (text, part) in [
        ("", "\"\" is no fault"),
        ("late", "KIND:VALUE"),
        ("late:5", "0% to 100%"),
        ("late:-1%", "0% to 100%"),
        ("lost:101%", "0% to 100%"),
        ("nan:NaN%", "0% to 100%"),
        ("late:5%@0", "from 1 to"),
        ("lost:5%@3", "no \"@3\""),
        ("rate:0", "from 1 to 100000 [Hz]"),
        ("rate:1e9", "from 1 to 100000 [Hz]"),
        ("stop:200", "stop:MS@POSES"),
        ("late:1%,late:2%", "given twice"),
        ("slow:5%", "there are late, lost"),
        ("late:5%,,", "\"\" is no fault"),
    ] {
        let why = text.parse::<Faults>().unwrap_err();
        assert!(why.contains(part), "{text}: {why}");
    }
}
