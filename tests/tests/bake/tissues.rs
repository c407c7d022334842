//! Tissues by name: the list, a bake of each, and what goes before a tissue's values.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::TOUGHNESS_J_PER_M2;
use chaincell_host::bake::tissue::KnownTissue;
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

/// A body that can be cut takes the toughness of its tissue, also where it is printed as an option.
#[test]
fn a_cuttable_body_has_the_toughness_of_its_tissue() {
    let toughness = |options: &[&str]| {
        let report = info(&[&["--cuttable"], options].concat());
        report["cutting"]["toughness_j_per_m2"].as_f64().unwrap()
    };
    assert_eq!(toughness(&["--tissue", "liver"]), 164.0);
    assert_eq!(toughness(&["--tissue", "liver", "--toughness-j-per-m2", "90"]), 90.0);
    // Where the table has none it is the default.
    assert_eq!(toughness(&["--tissue", "brain_in_vivo"]), TOUGHNESS_J_PER_M2);
    // The printed options.
    let folder = scratch();
    let said = run(["tissues"]).with(0).out;
    let printed = said.split_once("liver: ").unwrap().1.lines().nth(1).unwrap();
    let by_hand: Vec<&str> = printed.split([' ', ',']).filter(|word| !word.is_empty()).collect();
    assert!(by_hand.contains(&"--cuttable"), "{printed}");
    let model = |options: &[&str]| std::fs::read(bake(folder.path(), SPEC, options)).unwrap();
    assert_eq!(model(&by_hand), model(&["--tissue", "liver", "--cuttable"]));
    // Without --cuttable nothing of it is in the model.
    let elastic = ["--young-pa", "5000", "--poisson", "0.45"];
    assert_eq!(model(&["--tissue", "liver"]), model(&elastic));
}

/// A table of two tissues, of which a name chooses one; the same table with a fault.
#[test]
fn a_tissue_is_taken_from_a_table_of_the_user() {
    let folder = scratch();
    let table = folder.path().join("own.csv");
    let [muscle, cervix] = ["muscle", "cervix"].map(|name| KnownTissue::find(name).unwrap());
    let (muscle, cervix) = (muscle.table(), cervix.table());
    let both = format!("{muscle}{}\n", cervix.lines().nth(1).unwrap());
    std::fs::write(&table, &both).unwrap();
    let table_name = |name: &str| format!("{}{name}", text(&table));
    let model =
        |tissue: &str| std::fs::read(bake(folder.path(), SPEC, &["--tissue", tissue])).unwrap();
    assert_eq!(model(&table_name(":muscle")), model("muscle"));
    assert_eq!(model(&table_name(":cervix")), model("cervix"));
    let out = folder.path().join("none.chaincell");
    let refused =
        |tissue: &str| run(["bake", SPEC, "-o", text(&out), "--tissue", tissue]).with(2).err;
    let why = refused(&table_name(""));
    assert!(why.contains("own.csv: there are several tissues, muscle, cervix; name one"), "{why}");
    let why = refused(&table_name(":liver"));
    assert!(why.contains("own.csv: there is no tissue liver; there are muscle, cervix"), "{why}");
    // A table is no place for a model.
    let why = run(["bake", SPEC, "-o", text(&table), "--tissue", &table_name(":muscle")]);
    assert!(why.with(2).err.contains("own.csv"));
    assert_eq!(std::fs::read_to_string(&table).unwrap(), both);
    std::fs::write(&table, both.replace("3197,", "soft,")).unwrap();
    let why = refused(&table_name(":muscle"));
    assert!(why.contains("own.csv:3: young_pa is \"soft\"; give a number above 0"), "{why}");
    assert!(!out.exists());
}

/// Whatever shows that a value cannot be, the refusal names its row and column, and an option only where that is given.
#[test]
fn a_bad_value_of_a_table_is_refused_by_its_line() {
    let folder = scratch();
    let (table, out) = (folder.path().join("own.csv"), folder.path().join("none.chaincell"));
    let top = "name,tissue,young_pa,modulus,poisson,g1,tau1_s,stiffening_pa,toughness_j_per_m2,friction,status,\
               source,note";
    let bake = |values: &str, options: &[&str]| {
        let row = format!("bad,some tissue,{values},,fitted,own,none");
        std::fs::write(&table, format!("{top}\n{}\n{row}\n", row.replace("bad,", "next,")))
            .unwrap();
        let tissue = format!("{}:bad", text(&table));
        run([&["bake", SPEC, "-o", text(&out), "--tissue", &tissue], options].concat())
    };
    let bands = "900,long-term,0.45,,,0.1=500 ";
    for (values, options, column) in [
        (format!("{bands}2=500,"), &[][..], "stiffening_pa: half-width 2: must be from 0.01"),
        (format!("{bands}0.2=-5,"), &[], "stiffening_pa: modulus -5 of half-width 0.2: must be"),
        (format!("{bands}0.1=9,"), &[], "stiffening_pa: half-width 0.1 twice"),
        (format!("{bands}0.2=5e11,"), &[], "stiffening_pa: modulus 500000000000 of half-width 0.2"),
        (format!("{bands}0.2=5e11,"), &["--young-pa", "800"], "stiffening_pa: modulus 5000000000"),
        ("900,long-term,0.45,2,0.0005,,".into(), &[], "g,tau_s 2,0.0005: the second number"),
        ("900,long-term,0.45,200,0.5,,".into(), &[], "g,tau_s: 200 times the long-term modulus"),
        ("1e25,long-term,0.45,,,,".into(), &[], "young_pa 1e25 with links of"),
        ("1e60,long-term,0.45,,,,".into(), &[], "young_pa 1"),
        ("900,long-term,0.45,,,,1e7".into(), &["--cuttable"], "toughness_j_per_m2 10000000: must"),
    ] {
        let why = bake(&values, options).with(2).err;
        assert!(why.contains(&format!("own.csv:3: {column}")), "{values}: {why}");
    }
    // A value that is given is that of its option.
    for (options, part) in [
        (&["--stiffening", "3=5"][..], "chaincell: --stiffening: half-width 3"),
        (&["--branch", "1,1e9"], "chaincell: --branch 1,1000000000: the second number"),
        (&["--young-pa", "1e25"], "chaincell: --young-pa 1e25 with links"),
        (&["--poisson", "0.6"], "chaincell: --poisson 0.6: must be"),
        (
            &["--cuttable", "--toughness-j-per-m2", "1e8"],
            "chaincell: --toughness-j-per-m2 100000000: must",
        ),
    ] {
        let why = bake("900,long-term,0.45,,,,", options).with(2).err;
        assert!(why.contains(part), "{options:?}: {why}");
    }
    // And a bad one of the table is no matter where it is given.
    bake(&format!("{bands}2=500,"), &["--stiffening", "none"]).with(0);
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
    assert!(elastic["stiffening"].is_null());
    let stiffening = muscle(&["--branch", "none", "--cuttable"]);
    assert!(stiffening["cutting"].is_object());
    assert!(!stiffening["stiffening"].as_array().unwrap().is_empty());
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
