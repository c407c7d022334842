//! What the commands of a session print for people: flags by name, and why a session failed.

#![allow(clippy::panic, reason = "a failing helper fails its test")]
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{run, turn};

/// The rest of the line that begins with a name.
#[track_caller]
fn line<'a>(out: &'a str, name: &str) -> &'a str {
    let found = out.lines().find_map(|line| line.trim_start().strip_prefix(name));
    found.unwrap_or_else(|| panic!("no line {name} in {out}")).trim_start()
}

/// A tool that may move by 0.1 mm a tick, and a press that is faster.
const SLOW_TOOL: [&str; 2] = ["--max-tool-step-m", "0.0001"];

#[test]
fn serve_and_control_count_flags_by_name() {
    let _turn = turn();
    let place = Place::new("flags");
    let serve = place.serve(&[&["--ticks", "200"][..], &SLOW_TOOL].concat());
    let press = ["control", "--scene", &place.scene, "--seconds", "0.2", "--late-share", "off"];
    let control = run(press).with(0);
    let serve = serve.end(SHORT).with(0);
    let flags = line(&serve.out, "flags");
    assert!(flags.starts_with("motion_clamped on ") && flags.contains(" tick"), "{flags}");
    assert!(line(&control.out, "flags").starts_with(flags), "{} {flags}", control.out);
}

#[test]
fn cosim_counts_flags_by_name() {
    let _turn = turn();
    let cosim = |more: &[&str]| {
        run([&["cosim", "--seconds", "0.2", "--late-share", "off"], more].concat()).with(0)
    };
    let json = cosim(&[&["--json"][..], &SLOW_TOOL].concat()).json();
    let ticks = json["flag_ticks"]["motion_clamped"].as_u64().unwrap();
    let counted = format!("motion_clamped on {ticks} ticks");
    assert!(ticks > 1);
    // The poses are the same ones, and what the tissue makes of them too.
    let printed = cosim(&SLOW_TOOL).out;
    assert!(line(&printed, "flags").starts_with(&counted), "{counted} in {printed}");
    let error = line(&printed, "force error");
    assert!(error.starts_with("within ") && error.ends_with(" of 64 sweeps"), "{error}");
    let verdict = line(&printed, "verdict");
    assert!(
        verdict.contains("; the force within ") && verdict.contains(" % (99 of 100"),
        "{verdict}"
    );
}

#[test]
fn an_overloaded_cosim_says_what_happened() {
    let _turn = turn();
    let ended = run(["cosim", "--seconds", "1", "--sweeps", "1000", "--budget-us", "off"]).with(1);
    assert!(!ended.err.contains("interrupted"), "{}", ended.err);
    let said = ended.err.lines().filter(|line| line.starts_with("chaincell: "));
    let said: Vec<&str> = said.collect();
    let [said] = said[..] else { panic!("more than one reason: {said:?}") };
    for part in ["not answered: ", " of 1000 ticks", "overloaded", "--sweeps", "was stopped"] {
        assert!(said.contains(part), "{said}");
    }
}
