//! Clocks that jump, and clocks that differ from process to process.

use std::process::Command;

use chaincell_tests::{chaincell, turn};

use super::*;

/// A library that makes every look at the wall clock jump by 400 days, back and forth.
const JUMPS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/clock_jumps.c");

// REQ-COS-05
#[test]
fn a_wall_clock_that_jumps_at_every_look_changes_nothing() {
    let _turn = turn();
    let place = Place::stiff("jumps");
    let library = place.file("clock_jumps.so");
    let built =
        Command::new("cc").args(["-shared", "-fPIC", "-O1", "-o", text(&library), JUMPS]).output();
    if !built.is_ok_and(|built| built.status.success()) {
        println!("SKIPPED a_wall_clock_that_jumps_at_every_look_changes_nothing: no C compiler");
        return;
    }
    let jumping = |command: &mut Command| Running::start(command.env("LD_PRELOAD", &library));
    // It does jump: two looks, at least 700 days apart.
    let looks = [(); 2].map(|()| {
        let ended =
            jumping(Command::new("sh").args(["-c", "date +%s; date +%s"])).end(SHORT).with(0);
        ended.out.lines().map(|line| line.parse::<i64>().unwrap()).collect::<Vec<_>>()
    });
    let now = std::time::UNIX_EPOCH.elapsed().unwrap().as_secs() as i64;
    assert!(looks.concat().iter().all(|look| (look - now).abs() > 300 * 86_400), "{looks:?}");
    one_of_a_few(|| {
        let serve_args = ["serve", text(&place.model), "--scene", &place.scene, "--contact", "40"];
        let mut serve = jumping(chaincell().args(serve_args).args(["--json", "--wait", "event"]));
        serve.wait_for_line("ready");
        let outsider = Outsider::join(&place.scene, false);
        let path = hold(&place, 800);
        let mut control = place.control(&["--path", text(&path), "--wait", "event"]);
        let control = jumping(&mut control);
        let (ended, seen) = until_end(control, &outsider);
        undisturbed("wall clock jumps by 400 days at every look", ended, serve, &seen, 800)
    });
}

// REQ-COS-05
#[test]
fn clocks_a_day_apart_are_no_matter() {
    let _turn = turn();
    let apart = ["--time", "--fork", "--monotonic", "86400", "--boottime", "86400"];
    let may = Command::new("unshare").args(apart).arg("true").output();
    if !may.is_ok_and(|tried| tried.status.success()) {
        println!("SKIPPED clocks_a_day_apart_are_no_matter: `unshare --time` is not permitted");
        return;
    }
    one_of_a_few(|| {
        let (place, serve, outsider) = served("apart");
        let path = hold(&place, 800);
        let control = place.control(&["--path", text(&path)]);
        let mut command = Command::new("unshare");
        command.args(apart).arg(control.get_program()).args(control.get_args());
        let (ended, seen) = until_end(Running::start(&mut command), &outsider);
        undisturbed("monotonic clocks a day apart", ended, serve, &seen, 800)
    });
}
