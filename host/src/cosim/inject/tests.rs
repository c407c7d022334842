//! Faults: read, drawn, counted.

use super::*;

const POSES: u64 = 10_000;

fn plan(faults: &str, seed: u64) -> (Plan, Injected) {
    let plan = Plan::new(POSES, &faults.parse().unwrap(), seed);
    let done = plan.injected.unwrap();
    assert!(plan.sendings().is_sorted_by_key(|sending| sending.due_ns), "{faults}");
    (plan, done)
}

fn due_ns(plan: &Plan, at: usize) -> u64 {
    plan.sendings().nth(at).unwrap().due_ns
}

/// The poses in the order of sending.
fn order(plan: &Plan) -> Vec<u64> {
    plan.sendings().map(|sending| sending.index).collect()
}

#[test]
fn no_fault_is_the_plain_schedule() {
    let plain = Plan::faultless(POSES);
    let (plan, done) = plan("late:0%", 3);
    assert!(plan.sendings().eq(plain.sendings()));
    assert_eq!(done, Injected { seed: 3, rate_hz: 1000, ..Injected::default() });
    assert_eq!((plan.answers(), plain.answers()), (POSES, POSES));
    assert_eq!(due_ns(&plan, 7), 7 * MILLISECOND_NS);
}

#[test]
fn a_seed_gives_the_same_faults_and_another_one_others() {
    let all = "late:5%,lost:1%,dup:1%,reorder:1%,nan:1%,burst:2%,rate:2000,stop:200@1000";
    let (one, _) = plan(all, 1);
    assert_eq!(one, plan(all, 1).0);
    assert!(one.sendings().ne(plan(all, 2).0.sendings()));
}

#[test]
fn each_fault_comes_as_often_as_asked_and_is_counted() {
    let about = |count: u64| assert!((400..600).contains(&count), "{count} of 10,000 at 5 %");
    let (late, done) = plan("late:5%@3", 1);
    about(done.late);
    assert_eq!(order(&late), (0..POSES).collect::<Vec<_>>());
    let delay = |sending: Sending| sending.due_ns - sending.index * PERIOD_NS;
    let longest = late.sendings().map(delay).max().unwrap();
    assert!((2 * MILLISECOND_NS..=3 * MILLISECOND_NS).contains(&longest), "{longest}");
    let (lost, done) = plan("lost:5%", 1);
    about(done.lost);
    assert_eq!(lost.answers(), POSES - done.lost);
    let (dup, done) = plan("dup:5%", 1);
    about(done.duplicated);
    assert_eq!(dup.sendings().count() as u64, POSES + done.duplicated);
    assert_eq!(dup.answers(), POSES);
    let (nan, done) = plan("nan:5%", 1);
    about(done.nan);
    let bad =
        nan.sendings().filter(|sending| sending.pose(ToolPose::default()).position_m[0].is_nan());
    assert_eq!(bad.count() as u64, done.nan);
    let (burst, done) = plan("burst:5%@8", 1);
    about(done.bursts);
    let longest = burst.sendings().map(delay).max().unwrap();
    assert_eq!(longest, 7 * MILLISECOND_NS);
}

#[test]
fn an_overtaken_pose_is_sent_behind_the_next_one() {
    let (plan, done) = plan("reorder:5%", 1);
    assert!((400..600).contains(&done.overtaken), "{}", done.overtaken);
    let order = order(&plan);
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..POSES).collect::<Vec<_>>());
    assert!((0..).zip(&order).all(|(at, &index): (u64, _)| at.abs_diff(index) <= 1));
    let overtaken = order.windows(2).filter(|pair| pair[1] < pair[0]).count();
    assert_eq!(overtaken as u64, done.overtaken);
    assert_eq!(plan.answers(), POSES - done.overtaken);
}

#[test]
fn a_stop_is_made_up_for_at_its_end() {
    let (plan, done) = plan("stop:200@1000", 1);
    assert_eq!(done.stops, 1);
    let due_ms = |at| due_ns(&plan, at) / MILLISECOND_NS;
    assert_eq!([999, 1000, 1199, 1200, 1201].map(due_ms), [999, 1200, 1200, 1200, 1201]);
    let behind_the_end: Faults = "stop:200@20000".parse().unwrap();
    assert_eq!(Plan::new(POSES, &behind_the_end, 1).injected.unwrap().stops, 0);
}

#[test]
fn a_rate_sets_the_period() {
    let (plan, done) = plan("rate:10000", 1);
    assert_eq!((plan.period_ns, done.rate_hz), (100_000, 10_000));
    assert_eq!(due_ns(&plan, 3), 300_000);
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
