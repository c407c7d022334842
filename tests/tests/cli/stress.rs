//! Strain and stress in `final.vtu` and in snapshots.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_tests::files::{array, bake, scratch, summary, text};
use chaincell_tests::run;

/// The body at the deepest point of a press.
fn pressed(folder: &Path, model: &Path) -> String {
    let out = folder.join("out");
    let args = ["run", text(model), "--motion", "press", "--seconds", "1", "--out", text(&out)];
    let how = ["--contact", "probe:0.006", "--snapshot-ticks", "500", "--force"];
    run([&args[..], &how].concat()).with(0);
    std::fs::read_to_string(out.join("state_500.vtu")).unwrap()
}

#[test]
fn a_pressed_body_shows_its_stress() {
    let folder = scratch();
    let options = ["--young-pa", "5000"];
    let model = bake(folder.path(), "box:7x7x5x0.01", &options);
    let vtu = pressed(folder.path(), &model);
    let [stress_pa, mises_pa, mean_pa] =
        ["stress_pa", "von_mises_pa", "mean_stress_pa"].map(|name| array(&vtu, name));
    let points = array(&vtu, "node").len();
    assert_eq!((stress_pa.len(), mises_pa.len(), mean_pa.len()), (6 * points, points, points));
    for ((of, mises_pa), mean_pa) in stress_pa.chunks_exact(6).zip(&mises_pa).zip(&mean_pa) {
        let &[xx, yy, zz, xy, yz, xz] = of else { unreachable!() };
        let normal = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        let wanted_pa = (0.5 * normal + 3.0 * (xy * xy + yz * yz + xz * xz)).sqrt();
        assert!((mises_pa - wanted_pa).abs() <= 1e-3 * wanted_pa + 1e-3, "{of:?}");
        assert!((mean_pa - (xx + yy + zz) / 3.0).abs() <= 1e-3 * wanted_pa + 1e-3, "{of:?}");
    }
    // Under the ball the tissue is pressed, and shortest.
    let [pressure_pa, stretches] =
        ["contact_pressure_pa", "stretches"].map(|name| array(&vtu, name));
    let under = (0..points).max_by(|&a, &b| pressure_pa[a].total_cmp(&pressure_pa[b])).unwrap();
    let (stretches, rest) = stretches.as_chunks::<3>();
    assert!(rest.is_empty() && stretches.len() == points);
    let least = stretches[under][2];
    assert!(mean_pa[under] < 0.0 && least < 0.95, "{} {least}", mean_pa[under]);
    assert!(stretches.iter().all(|of| of.is_sorted_by(|more, less| more >= less)));
}

#[test]
fn a_body_of_links_has_no_stress() {
    let folder = scratch();
    let vtu = pressed(folder.path(), &bake(folder.path(), "box:7x7x5x0.01", &[]));
    assert!(!vtu.contains("stress") && !vtu.contains("stretch"));
}

#[test]
fn a_limit_warns_of_the_first_node_above_it_and_counts_all() {
    let folder = scratch();
    let model = bake(folder.path(), "box:7x7x5x0.01", &["--young-pa", "5000"]);
    let out = folder.path().join("out");
    let press = |limit_pa: &str| {
        let args =
            ["run", text(&model), "--motion", "press", "--seconds", "1", "--out", text(&out)];
        let how =
            ["--contact", "probe:0.006", "--snapshot-ticks", "500", "--force", "--stress-limit-pa"];
        run([&args[..], &how, &[limit_pa]].concat())
    };
    // No node comes to this one.
    let quiet = press("1e9").with(0);
    assert!(!quiet.err.contains("--stress-limit-pa"), "{quiet:?}");
    let most = summary(&out)["stress"].clone();
    let largest_pa = most["largest_von_mises_pa"].as_f64().unwrap();
    assert_eq!((most["nodes_above"].as_u64(), most["tick"].as_u64().unwrap() > 0), (Some(0), true));
    // It saw what the snapshot at the deepest point has.
    let vtu = std::fs::read_to_string(out.join("state_500.vtu")).unwrap();
    let deepest_pa = array(&vtu, "von_mises_pa").into_iter().fold(0.0, f64::max);
    assert!(deepest_pa > 100.0 && deepest_pa <= largest_pa, "{deepest_pa} {largest_pa}");
    // Half of that is passed before, by some nodes.
    let warned = press(&(0.5 * largest_pa).to_string()).with(0);
    assert_eq!(warned.err.matches("above --stress-limit-pa").count(), 1, "{warned:?}");
    assert!(warned.out.contains("above the limit of"), "{warned:?}");
    let report = summary(&out)["stress"].clone();
    let above = report["nodes_above"].as_u64().unwrap();
    assert!((1..200).contains(&above), "{report}");
    assert_eq!(report["node"], most["node"]);
    // Links have none, and no limit is below 0.
    assert!(press("-1").with(2).err.contains("--stress-limit-pa -1: must be above 0"));
    let links = bake(folder.path(), "box:7x7x5x0.01", &[]);
    let args = ["run", text(&links), "--motion", "press", "--out", text(&out), "--force"];
    let refused = run([&args[..], &["--stress-limit-pa", "5"]].concat()).with(2);
    assert!(refused.err.contains("--young-pa"), "{refused:?}");
}
