//! `chaincell relaxation`: branches from a measured curve, for a bake, and what is refused.
#![allow(clippy::unwrap_used)]

use std::fmt::Write as _;

use chaincell_host::bake::tissue::{Branch, KnownTissue};
use chaincell_lab::reference::prony::Prony;
use chaincell_tests::files::{bake, scratch, text};
use chaincell_tests::run;

/// A strip of this long-term modulus \[Pa\] with two branches.
fn strip(modulus: f64) -> Prony {
    let branches = [(2.0, 0.4), (1.0, 10.0)].map(|(ratio, time_s)| Branch { ratio, time_s });
    Prony { modulus, branches: branches.to_vec() }
}

/// A press in a second and a hold of a minute, of linear tissue.
fn curve() -> String {
    curve_of(|strain| strain)
}

/// The same of tissue whose elastic response to a strain has this size.
fn curve_of(elastic: fn(f64) -> f64) -> String {
    let strip = strip(1500.0);
    let times = (1..=40).map(|at| 0.05 * f64::from(at)).chain((3..60).map(f64::from));
    let points: Vec<[f64; 2]> = [0.0]
        .into_iter()
        .chain(times)
        .map(|time_s| [time_s, 0.1 * f64::min(time_s, 1.0)])
        .collect();
    let mut text = String::from("time_s,stretch,stress_kpa\n");
    let elastic: Vec<[f64; 2]> =
        points.iter().map(|&[time_s, strain]| [time_s, elastic(strain)]).collect();
    for ([time_s, strain], stress) in points.iter().zip(strip.path(&elastic)).skip(1) {
        let _ = writeln!(text, "{time_s},{},{}", 1.0 - strain, -1e-3 * stress);
    }
    text
}

#[test]
fn the_printed_options_bake_the_tissue_of_the_curve() {
    let folder = scratch();
    let file = folder.path().join("hold.csv");
    std::fs::write(&file, curve()).unwrap();
    let said = run(["relaxation", text(&file)]).with(0).out;
    let options = said.split_once("bake ").unwrap().1.lines().next().unwrap();
    let wanted = "--young-pa 1500 --branch 2,0.4 --branch 1,10";
    assert_eq!(options, wanted, "{said}");
    let model = folder.path().join("model.chaincell");
    let bake = ["bake", "box:4x4x3x0.01", "-o", text(&model)];
    run(bake.into_iter().chain(options.split(' '))).with(0);
    let found = run(["relaxation", text(&file), "--branches", "3", "--json"]).with(0).json();
    let values = found["values"].as_array().unwrap();
    assert_eq!(values.len(), 7);
    assert!(values.iter().any(|value| value["is_identified"] == false), "{found}");
}

/// A law that was found from one press meets one of another rate and depth, and is drawn beside it.
#[test]
fn a_curve_of_another_rate_is_predicted() {
    let folder = scratch();
    let [file, other, force, chart] =
        ["hold.csv", "slower.csv", "force.csv", "curves.svg"].map(|name| folder.path().join(name));
    std::fs::write(&file, curve()).unwrap();
    // Ten times slower, to half the depth, and a fifth stiffer.
    let strip = strip(1800.0);
    let points: Vec<[f64; 2]> = (0..=30)
        .map(f64::from)
        .map(|time_s| [time_s, 0.05 * f64::min(0.1 * time_s, 1.0)])
        .collect();
    let mut text_of = String::from("time_s,strain,stress_pa\n");
    for ([time_s, strain], stress) in points.iter().zip(strip.path(&points)).skip(1) {
        let _ = writeln!(text_of, "{time_s},{strain},{stress}");
    }
    std::fs::write(&other, &text_of).unwrap();
    std::fs::write(&force, text_of.replace("stress_pa", "force_n")).unwrap();
    let args = ["relaxation", text(&file), "--predict"];
    let found =
        run([&args[..], &[text(&other), "--draw", text(&chart), "--json"]].concat()).with(0).json();
    let predicted = &found["predicted"][0];
    for (value, wanted) in [
        (&predicted["peak_error"], 1500.0 / 1800.0 - 1.0),
        (&predicted["hold_errors"][0], 1.0 - 1500.0 / 1800.0),
        (&predicted["hold_errors"][1], 1.0 - 1500.0 / 1800.0),
    ] {
        assert!((value.as_f64().unwrap() - wanted).abs() < 1e-3, "{predicted}");
    }
    let svg = std::fs::read_to_string(&chart).unwrap();
    assert!(svg.contains("slower,") && svg.contains("hold,"), "{svg}");
    // Another unit, and a file that is missing.
    let refused = run([&args[..], &[text(&force)]].concat()).with(2).err;
    assert!(refused.contains("force.csv") && refused.contains("same columns"), "{refused}");
    run([&args[..], &["none.csv"]].concat()).with(2);
}

/// The table that is written makes the same model as the printed options, with a name or without one.
#[test]
fn the_written_table_bakes_the_tissue_of_the_curve() {
    let folder = scratch();
    let [file, table] = ["hold.csv", "own.csv"].map(|name| folder.path().join(name));
    let stiffening = curve_of(|strain| strain + 2.0 * f64::max(strain - 0.05, 0.0));
    std::fs::write(&file, stiffening).unwrap();
    let args = ["relaxation", text(&file), "--out", text(&table), "--half-widths", "0.05"];
    let said = run([&args[..], &["--name", "soft_2"]].concat()).with(0).out;
    assert!(said.contains(&format!("bake --tissue {}", text(&table))), "{said}");
    let options = said.split_once("bake ").unwrap().1.lines().next().unwrap();
    let by_hand: Vec<&str> = options.split(' ').collect();
    let model =
        |options: &[&str]| std::fs::read(bake(folder.path(), "box:4x4x3x0.01", options)).unwrap();
    let wanted = model(&by_hand);
    assert_eq!(model(&["--tissue", text(&table)]), wanted);
    assert_eq!(model(&["--tissue", &format!("{}:soft_2", text(&table))]), wanted);
    let found = KnownTissue::find(text(&table)).unwrap();
    assert_eq!((found.name.as_str(), found.status.as_str()), ("soft_2", "fitted"));
    assert!(found.source.contains("hold.csv") && found.note.contains("% rms"), "{found:?}");
    assert_eq!((found.branches.len(), found.stiffening.len()), (2, 1));
    // Another table in its place, with the name that stands for none.
    std::fs::write(&file, curve()).unwrap();
    run(["relaxation", text(&file), "--out", text(&table), "--json"]).with(0);
    let found = KnownTissue::find(&format!("{}:found", text(&table))).unwrap();
    assert_eq!((found.young_pa, found.stiffening.len()), (1500.0, 0));
}

#[test]
fn a_table_that_could_not_be_used_is_refused() {
    let folder = scratch();
    let [file, force, table] =
        ["hold.csv", "force.csv", "own.csv"].map(|name| folder.path().join(name));
    std::fs::write(&file, curve()).unwrap();
    std::fs::write(&force, curve().replace("stress_kpa", "force_n")).unwrap();
    let text_file = folder.path().join("own.txt");
    for (curve, out, name, part) in [
        (&file, &text_file, "soft", "give a file whose name ends with .csv"),
        (&file, &table, "Soft", "--name Soft: give small letters"),
        (&file, &table, "", "--name : give small letters"),
        (&force, &table, "soft", "give strain or stretch, and stress_pa"),
        (&file, &file, "soft", "hold.csv"),
    ] {
        let args = ["relaxation", text(curve), "--out", text(out), "--name", name];
        let why = run(args).with(2).err;
        assert!(why.contains(part), "{out:?}: {why}");
    }
    assert!(!table.exists() && !text_file.exists());
    let why = run(["relaxation", text(&file), "--name", "soft"]).with(2).err;
    assert!(why.contains("--out"), "{why}");
}

/// A branch that fades within a tick.
#[test]
fn values_that_a_bake_refuses_are_no_options() {
    let folder = scratch();
    let file = folder.path().join("fast.csv");
    let strip = Prony { modulus: 1500.0, branches: vec![Branch { ratio: 2.0, time_s: 3e-4 }] };
    let points: Vec<[f64; 2]> = (0..200)
        .map(|at| f64::from(at) * 1e-5)
        .map(|time_s| [time_s, 0.1_f64.min(1e3 * time_s)])
        .collect();
    let rows = points.iter().zip(strip.path(&points)).skip(1);
    let rows: String =
        rows.map(|([time_s, strain], pa)| format!("{time_s},{strain},{pa}\n")).collect();
    std::fs::write(&file, format!("time_s,strain,stress_pa\n{rows}")).unwrap();
    let args = ["relaxation", text(&file), "--branches", "1"];
    let said = run(args).with(0);
    let why = "a bake refuses these values: branches 2,0.0003: the second number, the time, must be from 0.001 to";
    assert!(said.out.contains(why) && !said.out.contains("--branch"), "{}", said.out);
    assert!(said.err.contains("take fewer branches"), "{}", said.err);
    let table = folder.path().join("own.csv");
    let why = run([&args[..], &["--out", text(&table)]].concat()).with(1).err;
    assert!(why.contains("own.csv: not written") && !table.exists(), "{why}");
    let found = run([&args[..], &["--json"]].concat()).with(0).json();
    assert!(
        found["bake"].is_null() && found["refusal"].as_str().unwrap().contains("2,0.0003"),
        "{found}"
    );
}

/// Presses are fitted in equilibrium.
#[test]
fn identify_takes_no_branches() {
    let folder = scratch();
    let file = folder.path().join("press.csv");
    let rows: String = (1..10).map(|at| format!("0.00{at},0.{at}\n")).collect();
    std::fs::write(&file, format!("displacement_m,force_n\n{rows}")).unwrap();
    let [model, out] = ["model.chaincell", "out"].map(|name| folder.path().join(name));
    let args = ["identify", "box:5x5x4x0.01", "--target", text(&file), "-o", text(&model)];
    let why = run([&args[..], &["--out", text(&out), "--tissue", "cervix"]].concat()).with(2).err;
    assert!(why.contains("--branch") && why.contains("chaincell relaxation"), "{why}");
    assert!(!out.exists());
}

#[test]
fn what_is_no_curve_is_refused() {
    let folder = scratch();
    let file = folder.path().join("hold.csv");
    std::fs::write(&file, "time_s,strain,force_n\n1,0.1,1\n2,0.1,0.5\n").unwrap();
    let file = text(&file);
    for (args, part) in [
        (&[file][..], "2 rows for 5 values"),
        (&[file, "--branches", "5"], "--branches"),
        (&[file, "--half-widths", "0.1,0.1"], "--half-widths 0.1,0.1"),
        (&["none.csv"], "none.csv"),
    ] {
        let why = run([&["relaxation"], args].concat()).with(2).err;
        assert!(why.contains(part), "{args:?}: {why}");
    }
}
