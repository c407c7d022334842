//! Paths that lead far beyond the body, as those in millimetres do.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::{bake, play, scratch, text, write_path};
use chaincell_tests::run;

/// A tool that moves up by 8 of a unit, which is given in metres.
fn rows(unit_m: f64) -> impl Iterator<Item = (u64, [f32; 3], u32)> {
    (0..20_u16).map(move |tick| {
        let z = 40.0 + 8.0 * f32::from(tick.min(10)) / 10.0;
        (tick.into(), [0.0, 0.0, (f64::from(z) * unit_m) as f32], u32::from(tick > 0))
    })
}

#[test]
fn a_path_in_millimetres_is_noted_and_read() {
    let folder = scratch();
    let model = bake(folder.path(), "box:5x5x5x0.01", &["--young-pa", "5000"]);
    let [metres, millimetres] = ["m.csv", "mm.csv"].map(|name| folder.path().join(name));
    write_path(&metres, rows(0.001));
    write_path(&millimetres, rows(1.0));
    let out = folder.path().join("out");
    for contact in ["auto", "probe:0.01"] {
        let played = |path, options: &[&str]| {
            let options = [&["--contact", contact, "--force"], options].concat();
            let ended = play(&model, path, &out, &options).with(0);
            (ended.err, std::fs::read_to_string(out.join("force.csv")).unwrap())
        };
        let (err, wanted) = played(&metres, &[]);
        assert!(!err.contains("--path-units"), "{err}");
        for json in [&[][..], &["--json"]] {
            let (err, _) = played(&millimetres, json);
            let parts =
                ["note: the path", "m, and the body is 0.040 m long: the largest force is", "mm"];
            assert!(parts.iter().all(|part| err.contains(part)), "{contact}: {err}");
            assert_eq!(err.matches("--path-units mm").count(), 1, "{err}");
        }
        let (err, found) = played(&millimetres, &["--path-units", "mm"]);
        assert!(found == wanted && !err.contains("--path-units"), "{contact}: {err}");
    }
    let args =
        ["run", text(&model), "--motion", "press", "--path-units", "mm", "--out", text(&out)];
    assert!(run(args).with(2).err.contains("cannot be used with"));
}

#[test]
fn options_of_the_press_are_refused_with_a_path() {
    let folder = scratch();
    let model = bake(folder.path(), "box:5x5x5x0.01", &[]);
    let path = folder.path().join("path.csv");
    write_path(&path, rows(0.001));
    let ended = run(["control", "--path", text(&path), "--contact", "probe:0.01"]).with(2);
    assert!(ended.err.contains("--contact probe:0.01: it is for the press"), "{}", ended.err);
    let ended = run(["control", "--model", text(&model), "--path-units", "mm"]).with(2);
    assert!(ended.err.contains("--path-units"), "{}", ended.err);
}
