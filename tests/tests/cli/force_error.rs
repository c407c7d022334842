//! `run` says how far its forces are off, and ends ticks by that.
#![allow(clippy::unwrap_used)]

use chaincell_tests::files::{Table, bake, scratch, summary, text};
use chaincell_tests::run;

#[test]
fn ticks_end_by_the_error_of_their_forces_and_are_replayed() {
    let folder = scratch();
    let model = bake(folder.path(), "organ:400", &["--young-pa", "5000"]);
    let press = |name: &str, options: &[&str]| {
        let out = folder.path().join(name);
        let args = ["run", text(&model), "--motion", "press", "--contact", "probe:0.02"];
        let more = ["--depth-m", "0.012", "--seconds", "0.5", "--sweeps", "8", "--picture", "off"];
        let ended = run([&args[..], &more, &["--out", text(&out)], options].concat());
        (ended, out)
    };
    // All sweeps: a small error in each tick with contact.
    let (ended, all) = press("all", &[]);
    ended.with(0);
    let table = Table::read(&all.join("force.csv"));
    let known = table.column("force_error_n").into_iter().zip(table.column("contacts"));
    let told: Vec<bool> =
        known.map(|(error_n, contacts)| error_n.is_nan() == (contacts == 0.0)).collect();
    assert!(told.iter().filter(|&&is_told| is_told).count() * 100 > 95 * told.len());
    assert!(summary(&all)["sweeps_mean"].is_null());
    // Fewer sweeps until a share of the force.
    let (ended, some) = press("some", &["--force-error", "0.05"]);
    ended.with(0);
    let [fine, coarse] = [&all, &some].map(|out| summary(out)["force_error_estimate"].clone());
    assert!(fine["ticks"].as_u64() > Some(100) && coarse["ticks"].as_u64() > Some(100));
    assert!(fine["median"].as_f64() < coarse["median"].as_f64());
    assert!(coarse["p99"].as_f64() < Some(0.06), "{coarse}");
    assert!(summary(&some)["sweeps_mean"].as_f64() < Some(6.0));
    run(["replay", text(&some.join("session.trace"))]).with(0);
    // Refused where no error is known.
    let (ended, _) = press("track", &["--force-error", "0.05", "--scheme", "track"]);
    assert!(ended.with(2).err.contains("--force-error"));
}
