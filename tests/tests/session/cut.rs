//! Bodies that can be cut, in a session: the summaries say how far they are, and the remedy where splits were refused.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::{bake, scratch, summary, text};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};
use serde_json::Value;

/// A body that tears soon, with too few spare cells.
const BODY: &[&str] =
    &["--young-pa", "5000", "--cuttable", "--cut-spare", "0", "--tear-stretch", "1.02"];
const REMEDY: &str = "bake it with more --cut-spare";

/// What a summary says of a body that has torn farther than its spare cells last.
#[track_caller]
fn check(found: &Value) {
    let number = |name: &str| found[name].as_u64().unwrap();
    assert!(number("torn_cells") > 0 && number("opened_faces") > 0, "{found}");
    assert!(number("copied_cells") > 0 && number("refused_splits") > 0, "{found}");
    assert_eq!(found["cut_area_m2"], 0.0);
}

#[test]
fn cosim_says_how_far_the_body_is_torn() {
    let _turn = turn();
    let folder = scratch();
    let model = bake(folder.path(), "box:7x7x5x0.01", BODY);
    let out = folder.path().join("out");
    let args = ["cosim", text(&model), "--seconds", "1", "--depth-m", "0.03", "--out", text(&out)];
    let said = run([&args[..], &["--late-share", "off"]].concat()).with(0);
    check(&summary(&out));
    assert_eq!(said.err.matches(REMEDY).count(), 1, "{}", said.err);
    assert!(said.out.contains("\n  cut   ") && said.out.contains(" torn"), "{}", said.out);
    assert!(said.out.contains("chaincell view"), "{}", said.out);
}

#[test]
fn serve_says_how_far_the_body_is_torn() {
    let _turn = turn();
    let place = Place::new("torn");
    let model = bake(place.file(".").as_path(), "box:7x7x5x0.01", BODY);
    let out = place.file("out");
    for json in [false, true] {
        let args = ["serve", text(&model), "--scene", &place.scene, "--ticks", "1000", "--force"];
        let args = [&args[..], &["--late-share", "off"]].concat();
        let json = if json { &["--json"][..] } else { &[] };
        let mut serve = Running::chaincell([&args[..], &["--out", text(&out)], json].concat());
        serve.wait_for_line("ready");
        let args = ["control", "--model", text(&model), "--scene", &place.scene, "--seconds", "1"];
        let more = ["--depth-m", "0.03", "--late-share", "off"];
        Running::chaincell([&args[..], &more].concat()).end(SHORT).with(0);
        let said = serve.end(SHORT).with(0);
        check(&summary(&out));
        assert!(said.err.contains(REMEDY), "{}", said.err);
        if json.is_empty() {
            assert!(said.out.contains("\n  cut         ") && said.out.contains(" torn"));
            assert!(said.out.contains("chaincell view"), "{}", said.out);
        } else {
            check(&said.json());
        }
    }
}
