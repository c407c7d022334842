//! A program killed at any of the file calls of its start leaves nothing that stands in the way of the
//! next one.
//!
//! A library in front of the C library kills the process behind its n-th call that makes or changes a
//! file of shared memory. Each test has shared memory of its own, where the system lets it.
//! Plain `cargo test` tries some of the calls, all of them with `CHAINCELL_SLOW=1`.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use chaincell_tests::place::Place;
use chaincell_tests::process::{SHORT, unshared};
use chaincell_tests::{Ended, Running, turn};

/// Calls of a start that are tried.
const CALLS: usize = 60;
/// The calls, by what they do.
const KINDS: [&str; 8] =
    ["any", "shm_open", "open", "ftruncate", "fchmod", "mkdir", "write", "unlink"];
/// Begins the shell in which a test's programs run: with shared memory of their own.
const OWN_MEMORY: &str = "mount -t tmpfs -o size=256m,mode=1777 tmpfs /dev/shm && mkdir -p -m 700 /tmp/iceoryx2 \
    && mount -t tmpfs -o mode=700 tmpfs /tmp/iceoryx2 || exit 99";

/// What kills, where a compiler of C is at hand.
fn killer(folder: &Path) -> Option<PathBuf> {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/data/killed_at_call.c");
    let library = folder.join("killed_at_call.so");
    let built = Command::new("cc")
        .args(["-O1", "-shared", "-fPIC", source, "-ldl", "-o"])
        .arg(&library)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    built.is_ok_and(|status| status.success()).then_some(library)
}

/// What a test's shell has at hand: `killed KIND AT ARGUMENTS` starts chaincell and kills it at that
/// call; `proper WHAT WANTED ARGUMENTS` tells of one that does not end as wanted within a minute;
/// `nothing_is_left` tells of files that stay.
const SHELL: &str = r#"
killed() {
    kind=$1; at=$2; shift 2
    KILL_CALL=$kind KILL_AT=$at LD_PRELOAD=$library timeout -k 1 ${limit:-60} "$chaincell" "$@" > /dev/null 2>> "$told"
}
proper() {
    what=$1; wanted=$2; shift 2
    timeout -k 1 60 "$chaincell" "$@" > said 2>&1; code=$?
    [ $code = $wanted ] || { echo "$what: $code: $(tail -n 2 said)"; failures=$((failures + 1)); }
    [ ${failures:-0} -lt 8 ] || exit 0
}
nothing_is_left() {
    ls /dev/shm | grep -v global_mgmt
    find /tmp/iceoryx2/nodes /tmp/iceoryx2/services -mindepth 1
}
"#;

/// Runs shell lines with shared memory of their own; what they say. `None`, with a line that says so,
/// where there is no compiler, or this user may not.
fn in_own_memory(test: &str, place: &Place, lines: &str) -> Option<Ended> {
    let Some(library) = killer(place.folder.path()) else {
        println!("SKIPPED {test}: no `cc`");
        return None;
    };
    let lines = format!("{OWN_MEMORY}\n{SHELL}\n{lines}");
    let mut command = unshared(test, place.folder.path(), &lines)?;
    command.env("library", library).env("told", "told").env("model", &place.model);
    Some(Running::start(&mut command).end(20 * SHORT))
}

/// Which of the calls are tried.
fn tried() -> String {
    if std::env::var_os("CHAINCELL_SLOW").is_none() {
        return "1 3 9 27".to_owned();
    }
    let calls: Vec<String> = (1..=CALLS).map(|call| call.to_string()).collect();
    calls.join(" ")
}

/// Kills programs at all these calls, with a proper start behind each.
#[track_caller]
fn each(test: &str, before: &str, killed: &str, proper: &str, after: &str) {
    let _turn = turn();
    let place = Place::new(test);
    let is_long = std::env::var_os("CHAINCELL_SLOW").is_some();
    let (kinds, calls) = (KINDS[..if is_long { 8 } else { 5 }].join(" "), tried());
    let lines = format!(
        "{before}\nfor kind in {kinds}; do for at in {calls}; do\nkilled $kind $at {killed}\n\
         proper \"$kind $at\" {proper}\ndone; done\n{after}\nnothing_is_left"
    );
    let Some(ended) = in_own_memory(test, &place, &lines) else { return };
    assert_eq!(ended.out, "", "{}", ended.err);
    let told = std::fs::read_to_string(place.file("told")).unwrap();
    let reached = told.lines().filter(|line| *line == "reached").count();
    println!("{reached} killed");
    assert!(reached > 5, "only {reached} were killed: this is no test");
}

const SERVE: &str = "serve $model --scene own --contact 40 --seconds 0.02";
/// A server that stays until it is interrupted.
const STAYS: &str =
    "\"$chaincell\" serve $model --scene own --contact 40 --seconds 600 > served 2>&1 & server=$!
    until grep -q ready served; do sleep 0.01; done";
/// It obeys the first interrupt.
const ENDS: &str = "kill -INT $server; { sleep 30; kill -9 $server; } > /dev/null 2>&1 & late=$!
    wait $server; code=$?; kill $late; [ $code = 130 ] || echo \"no end of the server: $code\"";

// REQ-COS-02
#[test]
fn a_server_starts_behind_one_that_was_killed_at_its_start() {
    each("killed-serve", "", SERVE, &format!("0 {SERVE}"), "");
}

// REQ-COS-02
#[test]
fn a_controller_joins_behind_one_that_was_killed_at_its_start() {
    let control = "control --scene own --path short.csv --late-share off --watchdog-ms 0";
    let path = "{ echo tick,x_m,y_m,z_m,engaged; echo 1,0,0,0,0; echo 2,0,0,0,0; } > short.csv";
    // The last one is killed while it makes the connection that the server waits for.
    let after = format!("killed shm_open 1 {control}\nsleep 0.3\n{ENDS}\nproper last 0 {SERVE}");
    each("killed-control", &format!("{path}\n{STAYS}"), control, &format!("0 {control}"), &after);
}

// REQ-COS-02
#[test]
fn a_viewer_joins_behind_one_that_was_killed_at_its_start() {
    let command = "command --scene own pause";
    // What the server had in common with the killed ones is cleared up once it has ended too.
    let after = format!("{ENDS}\nproper last 0 {SERVE}");
    each(
        "killed-state",
        &format!("limit=1\n{STAYS}"),
        "state --scene own --once",
        &format!("0 {command}"),
        &after,
    );
}

/// Stopped, not killed: nothing may be cleared up. The wait ends with a message, and obeys the first
/// Ctrl-C.
// REQ-COS-02
#[test]
fn a_program_that_stands_still_at_its_start_is_named_within_seconds() {
    let _turn = turn();
    let place = Place::new("stands-still");
    let lines = format!(
        "KILL_STOPS=1 KILL_CALL=shm_open KILL_AT=2 LD_PRELOAD=$library \"$chaincell\" {SERVE} > /dev/null 2> told & stands=$!
        until grep -q reached told; do sleep 0.01; done
        timeout -k 1 60 \"$chaincell\" {SERVE}; echo \"code $?\"
        timeout -s INT -k 30 0.5 \"$chaincell\" {SERVE}; echo \"code $?\"
        kill -KILL $stands; wait $stands
        timeout -k 1 60 \"$chaincell\" {SERVE} > /dev/null; echo \"code $?\""
    );
    let Some(ended) = in_own_memory("stands-still", &place, &lines) else { return };
    // `timeout` tells its own end by 124.
    assert_eq!(ended.out, "code 2\ncode 124\ncode 0\n", "{}", ended.err);
    assert!(ended.err.contains("began to make /dev/shm/"), "{}", ended.err);
}
