//! From a closed surface to a finer mesh under the tool, by what the program itself proposes; and the picture that
//! a run leaves.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use chaincell_tests::Ended;
use chaincell_tests::files::{scratch, summary, text};
use chaincell_tests::run;
use serde_json::Value;

/// Half the edges of the block, and its height \[m\].
const HALF_M: f64 = 0.025;
const HIGH_M: f64 = 0.025;

/// A block as an STL file in millimetres.
fn block(folder: &Path) -> PathBuf {
    let (low, high) =
        ([-1e3 * HALF_M, -1e3 * HALF_M, 0.0], [1e3 * HALF_M, 1e3 * HALF_M, 1e3 * HIGH_M]);
    let at = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { high[k] } else { low[k] });
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut stl = String::from("solid\n");
    for [a, b, c, d] in faces {
        for corners in [[a, b, c], [a, c, d]] {
            stl.push_str("facet normal 0 0 0\nouter loop\n");
            for [x, y, z] in corners.map(at) {
                writeln!(stl, "vertex {x} {y} {z}").unwrap();
            }
            stl.push_str("endloop\nendfacet\n");
        }
    }
    let file = folder.join("block.stl");
    std::fs::write(&file, stl + "endsolid\n").unwrap();
    file
}

fn baked(stl: &Path, fill: &str, model: &Path, options: &[&str]) -> Ended {
    let fixed = ["--units", "mm", "--young-pa", "5000", "--fix", "box:-1,1,-1,1,-1,1e-4"];
    let args = ["bake", text(stl), "--fill", fill, "-o", text(model)];
    run([&args[..], &fixed, options].concat())
}

/// A ball of 5 mm pressed 2.5 mm into the middle of the top.
fn pressed(model: &Path, out: &Path, options: &[&str]) -> Ended {
    let press = ["--motion", "press", "--touch-m", "0,0,0.0302", "--direction=0,0,-1"];
    let depth = ["--tool", "sphere:0.005", "--depth-m", "0.0027", "--seconds", "0.2"];
    let args = ["run", text(model), "--out", text(out)];
    run([&args[..], &press, &depth, options].concat())
}

/// The judgement's own remedy is pasted and makes the mesh fine enough.
#[test]
fn what_the_judgement_proposes_is_fine_enough() {
    let folder = scratch();
    let (stl, model) = (block(folder.path()), folder.path().join("a.chaincell"));
    baked(&stl, "0.008", &model, &[]).with(0);
    let coarse = pressed(&model, &folder.path().join("coarse"), &["--picture", "off"]).with(0);
    let mesh = coarse.out.lines().find(|line| line.trim_start().starts_with("mesh ")).unwrap();
    let proposed = mesh.split_once("(--fill ").unwrap().1.split(" of a closed").next().unwrap();
    assert!(proposed.contains(",0.0025@") && proposed.ends_with(",0.0075"), "{mesh}");
    let cells: f64 =
        mesh.split_once(", some ").unwrap().1.split(' ').next().unwrap().parse().unwrap();

    let report = baked(&stl, proposed, &model, &["--json"]).with(0);
    let report: Value = serde_json::from_str(&report.out).unwrap();
    let number = |key: &str| report["filled"][key].as_f64().unwrap();
    let edges_m = &report["filled"]["graded_edges_m"];
    let fine_m = edges_m[0].as_f64().unwrap();
    assert!((fine_m / 0.0025 - 1.0).abs() < 0.1, "{report}");
    // The body is too small for a part that is nowhere graded, or that part is coarse.
    assert!(edges_m[1].as_f64().is_none_or(|coarse_m| coarse_m > 2.5 * fine_m), "{report}");
    assert!(
        number("smallest_dihedral_deg") > 10.0 && number("largest_dihedral_deg") < 160.0,
        "{report}"
    );
    assert!(number("roundness_min") > 0.2 && number("volume_error").abs() < 0.03, "{report}");
    assert!((0.5..2.0).contains(&(number("nodes") / cells)), "{mesh} {report}");

    let out = folder.path().join("fine");
    let fine = pressed(&model, &out, &[]).with(0);
    assert!(fine.out.contains("deep: the force is within 14 %"), "{}", fine.out);
    let edge_m = summary(&out)["judgement"]["mesh"]["edge_m"].as_f64().unwrap();
    assert!(edge_m <= 0.0025, "{edge_m}");
}

#[test]
fn sizes_and_places_that_cannot_be_are_refused_with_the_remedy() {
    let folder = scratch();
    let (stl, model) = (block(folder.path()), folder.path().join("a.chaincell"));
    for (fill, parts) in [
        ("0.008,0.002", &["--fill", "needs its place", "SIZE,FINE@X,Y,Z,R"][..]),
        ("0.008,0.009@0,0,0.025,0.01", &["must be below the first; take 0.004"]),
        ("0.008,0.00001@0,0,0.025,0.01", &["too fine for the first; take 0.000125"]),
        ("0.008,0.002@0,0,0.025,0", &["radius", "give it in metres"]),
        (
            "0.008,0.002@0,0,25,10",
            &["does not touch the body", "in metres whatever the unit", "25.0 m from its middle"],
        ),
        (
            "0.008,0.001@0,0,0,0.03",
            &["more than 65535 cells", "take --fill 0.0", "or a smaller region"],
        ),
        (
            "0.008,0.002@near:box:1,2,1,2,1,2",
            &["@near:box:1,2,1,2,1,2: it selects no node", "all nodes are in box:"],
        ),
    ] {
        let why = baked(&stl, fill, &model, &[]).with(2).err;
        for part in parts {
            assert!(why.contains(part), "{fill}: `{part}` is missing: {why}");
        }
    }
    assert!(!model.exists());
}

/// A run leaves a picture, none with `off`, and one elsewhere where it is told.
#[test]
fn a_run_leaves_a_picture() {
    let folder = scratch();
    let (model, out) = (folder.path().join("a.chaincell"), folder.path().join("out"));
    run(["bake", "organ:300", "--young-pa", "5000", "-o", text(&model)]).with(0);
    let press = |out: &Path, options: &[&str]| {
        let args = [
            "run",
            text(&model),
            "--motion",
            "press",
            "--contact",
            "probe:0.012",
            "--seconds",
            "0.1",
        ];
        run([&args[..], &["--out", text(out)], options].concat()).with(0)
    };
    let ended = press(&out, &[]);
    let is_png = |file: &Path| std::fs::read(file).unwrap().starts_with(b"\x89PNG\r\n\x1a\n");
    assert!(is_png(&out.join("picture.png")));
    let said = ended.out.lines().find(|line| line.contains("picture.png")).unwrap();
    assert!(said.contains("displacement up to") && ended.out.contains("chaincell view"), "{said}");
    // The same picture as that of the recorded session.
    let again = folder.path().join("again.png");
    run(["picture", text(&out), "--out", text(&again)]).with(0);
    assert_eq!(std::fs::read(&again).unwrap(), std::fs::read(out.join("picture.png")).unwrap());

    let ended = press(&out, &["--force", "--picture", "off"]);
    assert!(!out.join("picture.png").exists() && !Path::new("off").exists(), "an earlier one goes");
    assert!(!ended.out.contains("picture"), "{}", ended.out);
    let elsewhere = folder.path().join("there.png");
    press(&out, &["--force", "--picture", text(&elsewhere)]);
    assert!(is_png(&elsewhere) && !out.join("picture.png").exists());
}
