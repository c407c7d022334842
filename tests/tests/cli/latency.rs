//! `latency` seen from outside.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::{bake, scratch, text};
use chaincell_tests::{run, turn};

/// The session is one of programs of its own: they may use every processor, wherever the threads
/// that measured the step alone were pinned.
#[test]
fn threads_share_the_sweeps_alone_and_in_the_session() {
    let _turn = turn();
    if std::thread::available_parallelism().unwrap().get() < 2 {
        println!("SKIPPED latency with two threads: this machine has one processor");
        return;
    }
    let folder = scratch();
    let model = bake(folder.path(), "box:26x26x26x0.005", &[]);
    let scene = chaincell_tests::scene("latency");
    let options = ["--threads", "2", "--seconds", "0.1", "--scene", &scene, "--json"];
    let ended = run([&["latency", text(&model)], &options[..]].concat());
    // Late answers are the machine's matter; without a session there would be no summary.
    let summary = ended.json();
    assert_eq!(summary["ticks"], 100, "{ended:#?}");
    for measured in ["step_alone_ns", "step_ns"] {
        assert!(summary[measured]["p50"].as_u64().unwrap() > 0, "{measured}: {summary}");
    }
}
