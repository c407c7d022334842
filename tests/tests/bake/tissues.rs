//! Tissues by name: the list, a bake of each, and what goes before a tissue's values.
#![allow(clippy::unwrap_used)]

use chaincell_tests::files::{bake, scratch, text};
use chaincell_tests::run;
use serde_json::Value;

const SPEC: &str = "box:4x4x3x0.01";

fn info(options: &[&str]) -> Value {
    let folder = scratch();
    let model = bake(folder.path(), SPEC, options);
    run(["info", text(&model), "--json"]).with(0).json()
}

#[test]
fn every_tissue_of_the_list_bakes_by_its_name() {
    let list = run(["tissues", "--json"]).with(0).json();
    let said = run(["tissues"]).with(0).out;
    let tissues = list["tissues"].as_array().unwrap();
    assert!(tissues.len() > 10);
    for tissue in tissues {
        let name = tissue["name"].as_str().unwrap();
        let report = info(&["--tissue", name]);
        let relaxation = &report["relaxation"];
        let branches = tissue["branches"].as_array().unwrap().len();
        let is_instant = tissue["modulus"] == "instant";
        let young = if is_instant || branches == 0 {
            &report["young_pa"]
        } else {
            &relaxation["long_term_young_pa"]
        };
        let ratio = young.as_f64().unwrap() / tissue["young_pa"].as_f64().unwrap();
        assert!((ratio - 1.0).abs() < 1e-4, "{name}: {ratio}");
        assert_eq!(relaxation["branches"].as_array().map_or(0, Vec::len), branches, "{name}");
        let bands = |value: &Value| value.as_array().map_or(0, Vec::len);
        assert_eq!(bands(&report["stiffening"]), bands(&tissue["stiffening"]), "{name}");
        for word in ["source", "note", "status"] {
            assert!(said.contains(tissue[word].as_str().unwrap()), "{name}: {word}");
        }
    }
}

/// The options that the list prints make the same model.
#[test]
fn the_printed_options_are_the_tissue() {
    let folder = scratch();
    let said = run(["tissues"]).with(0).out;
    let printed = said.split_once("muscle: ").unwrap().1.lines().nth(1).unwrap();
    let by_hand: Vec<&str> = printed.split_whitespace().collect();
    let model = |options: &[&str]| std::fs::read(bake(folder.path(), SPEC, options)).unwrap();
    assert_eq!(model(&by_hand), model(&["--tissue", "muscle"]));
}

#[test]
fn options_by_hand_go_before_the_tissue() {
    let number = |value: &Value| (value.as_f64().unwrap() * 1e3).round() / 1e3;
    let muscle = |options: &[&str]| info(&[&["--tissue", "muscle"], options].concat());
    let given = muscle(&["--young-pa", "2000", "--poisson", "0.4", "--stiffening", "0.2=900"]);
    assert_eq!(number(&given["relaxation"]["long_term_young_pa"]), 2000.0);
    assert_eq!(number(&given["poisson"]), 0.4);
    assert_eq!(number(&given["stiffening"][0][1]), 900.0);
    assert_eq!(given["relaxation"]["branches"].as_array().unwrap().len(), 2);
    let instant = muscle(&["--young-pa", "2000", "--instant"]);
    assert_eq!(number(&instant["young_pa"]), 2000.0);
    let other = muscle(&["--branch", "1,3"]);
    assert_eq!(number(&other["relaxation"]["branches"][0]["time_s"]), 3.0);
    let elastic = muscle(&["--branch", "none", "--stiffening", "none", "--cuttable"]);
    assert!(elastic["relaxation"].is_null() && elastic["cutting"].is_object());
    assert_eq!(number(&elastic["young_pa"]), 636.0);
}

#[test]
fn what_is_no_tissue_is_refused_with_those_that_are() {
    let folder = scratch();
    let out = folder.path().join("none.chaincell");
    for (options, part) in [
        (&["--tissue", "stone"][..], "--tissue stone: there is none; known are muscle, muscle_3"),
        (&["--tissue", "muscle", "--instant"], "--instant: the modulus is that of --tissue"),
        (&["--tissue", "brain_in_vivo", "--device-hz", "1000"], "no branches that relax"),
        (&["--tissue", "muscle", "--cuttable"], "of a --tissue by giving none"),
        (&["--tissue", "muscle", "--alpha", "0.1"], "--alpha"),
        (&["--tissue", "muscle", "--branch=none", "--branch=1,1"], "goes alone"),
    ] {
        let why = run([&["bake", SPEC, "-o", text(&out)], options].concat()).with(2).err;
        assert!(why.contains(part), "{options:?}: {why}");
    }
    assert!(!out.exists());
}
