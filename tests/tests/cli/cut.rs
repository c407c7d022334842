//! A blade in the command: a box is cut, its trace replays, its files show the wound, and what is refused.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use chaincell_tests::files::{Table, array, bake, scratch, summary, text};
use chaincell_tests::{Ended, run};
use serde_json::Value;

const BOX: &str = "box:7x5x4x0.005";
/// Nodes of the box, and its width along the blade \[m\].
const NODES: usize = 7 * 5 * 4;
const WIDTH_M: f64 = 4.0 * 0.005;
/// Depth to which the edge goes \[m\].
const DEPTH_M: f64 = 0.009;
/// Energy that a cut takes for each area \[J/m^2\].
const TOUGHNESS: f64 = 4.0;
/// A blade across the box, longer than that is wide.
const BLADE: &str = "blade:0.06/0,0,0.7071068,0.7071068";

fn block(folder: &Path, spec: &str, spare: &str) -> PathBuf {
    let cuttable = ["--cuttable", "--toughness-j-per-m2", "4", "--cut-spare", spare];
    let options = [&["--young-pa", "5000", "--poisson", "0.3"][..], &cuttable].concat();
    bake(folder, spec, &options)
}

/// A press of the built-in motion at the middle of the top.
fn press(model: &Path, out: &Path, options: &[&str]) -> Ended {
    press_from("0,0,0.01501", model, out, options)
}

/// A press that begins at a place of the tool.
fn press_from(touch_m: &str, model: &Path, out: &Path, options: &[&str]) -> Ended {
    let args = ["run", text(model), "--motion", "press", "--seconds", "0.8", "--out", text(out)];
    let place = ["--touch-m", touch_m, "--direction", "0,0,-1", "--depth-m", "0.009"];
    run([&args[..], &place, &["--force", "--picture", "off"], options].concat())
}

#[test]
fn a_blade_cuts_and_its_trace_replays_to_the_same_bits() {
    let folder = scratch();
    let (model, out) = (block(folder.path(), BOX, "0.5"), folder.path().join("out"));
    let said = press(&model, &out, &["--tool", BLADE]).with(0);
    let report = summary(&out);
    let number = |name: &str| report[name].as_f64().unwrap();
    // The edge sweeps the width of the box, down to its depth less what the tissue gives way.
    let swept = number("cut_area_m2") / (WIDTH_M * DEPTH_M);
    assert!((0.6..1.05).contains(&swept), "{swept} of the edge's way");
    assert!((number("cut_work_j") / (TOUGHNESS * number("cut_area_m2")) - 1.0).abs() < 1e-5);
    assert!(number("opened_faces") >= 8.0 && number("copied_cells") >= 5.0, "{report}");
    assert_eq!(report["refused_splits"], 0);
    assert!(said.out.contains("  cut           ") && !said.err.contains("--cut-spare"), "{said:?}");
    assert!(said.out.contains("chaincell view"), "{}", said.out);
    // The area grows with the ticks, to that of the summary.
    let areas_m2 = Table::read(&out.join("force.csv")).column("cut_area_m2");
    assert!(areas_m2.is_sorted() && areas_m2[0] == 0.0);
    assert_eq!(areas_m2.last().map(|area_m2| *area_m2 as f32), Some(number("cut_area_m2") as f32));
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], report["state_hash"]);
    // Another run comes to the same cut.
    press(&model, &out, &["--tool", BLADE]).with(0);
    assert_eq!(summary(&out)["state_hash"], report["state_hash"]);
    assert_eq!(summary(&out)["cut_area_m2"], report["cut_area_m2"]);
}

/// The upper half of a box tougher than its lower one: the work is summed where the blade cuts, and the trace replays.
#[test]
fn a_body_of_two_toughnesses_replays_to_the_same_bits() {
    let folder = scratch();
    let values = folder.path().join("toughness.txt");
    // Ids ascend along z first, four layers.
    let lines: Vec<&str> = (0..NODES).map(|node| if node % 4 < 2 { "1" } else { "4" }).collect();
    std::fs::write(&values, lines.join(" ")).unwrap();
    let toughness = format!("file:{}", text(&values));
    let cuttable = ["--cuttable", "--cut-spare", "0.5", "--toughness-j-per-m2", &toughness];
    let options = [&["--young-pa", "5000", "--poisson", "0.3"][..], &cuttable].concat();
    let (model, out) = (bake(folder.path(), BOX, &options), folder.path().join("out"));
    press(&model, &out, &["--tool", BLADE]).with(0);
    let report = summary(&out);
    let number = |name: &str| report[name].as_f64().unwrap();
    let mean = number("cut_work_j") / number("cut_area_m2");
    assert!((1.5..3.9).contains(&mean), "{mean} J/m^2, {report}");
    given_j(&report);
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], report["state_hash"]);
}

/// Energy that the tools gave \[J\], of an account that closes.
#[track_caller]
fn given_j(report: &Value) -> f64 {
    let number = |name: &str| report[name].as_f64().unwrap_or(0.0);
    let (given_j, dissipated_j) = (report["given_j"].as_f64().unwrap(), number("dissipated_j"));
    let used_j = number("stored_j") + number("cut_work_j") + number("relaxed_j");
    assert!((used_j + dissipated_j - given_j).abs() < 1e-6 * given_j, "{report}");
    assert!(dissipated_j >= -0.01 * given_j && dissipated_j < given_j, "{report}");
    given_j
}

/// What a blade gives is stored, parts the tissue or is dissipated, and it is the work of its force.
#[test]
fn the_account_of_a_cut_closes() {
    let folder = scratch();
    let (model, out) = (block(folder.path(), BOX, "0.5"), folder.path().join("out"));
    let said = press(&model, &out, &["--tool", BLADE, "--sweeps", "4"]).with(0).out;
    let report = summary(&out);
    let given_j = given_j(&report);
    let number = |name: &str| report[name].as_f64().unwrap();
    assert!(number("cut_work_j") > 0.3 * given_j, "{report}");
    // The blade has left: the body stores next to nothing.
    assert!((0.0..0.05 * given_j).contains(&number("stored_j")), "{report}");
    let forces_n = Table::read(&out.join("force.csv")).column("fz_n");
    let places_m = Table::read(&out.join("path.csv")).column("z_m");
    let mean_n = forces_n.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let ways_m = places_m.windows(2).map(|pair| pair[0] - pair[1]);
    let work_j: f64 = mean_n.zip(ways_m).map(|(force_n, way_m)| force_n * way_m).sum();
    assert!((0.95..1.5).contains(&(given_j / work_j)), "{work_j} J of the force, {report}");
    let line = format!("  energy        {:.3} mJ of the tools: ", 1e3 * given_j);
    assert!(said.contains(&line) && said.contains(" parted the tissue, "), "{said}");
}

/// Relaxed energy is a part of the account. Bodies that neither relax nor can be cut have none, nor have held cells.
#[test]
fn the_account_of_a_body_that_relaxes_closes() {
    let folder = scratch();
    let out = folder.path().join("out");
    let tissue = ["--young-pa", "5000", "--poisson", "0.3"];
    let relaxing = bake(folder.path(), BOX, &[&tissue[..], &["--branch", "1,0.05"]].concat());
    let ball = |model: &Path| press_from("0,0,0.02301", model, &out, &["--tool", "sphere:0.008"]);
    let said = ball(&relaxing).with(0).out;
    let report = summary(&out);
    assert!(report["relaxed_j"].as_f64().unwrap() > 0.01 * given_j(&report), "{report}");
    assert!(said.contains(" relaxed, ") && !said.contains("parted"), "{said}");
    let plain = bake(folder.path(), BOX, &tissue);
    let said = ball(&plain).with(0).out;
    assert_eq!((summary(&out).get("given_j"), said.contains("  energy  ")), (None, false));
    let cuttable = block(folder.path(), BOX, "0.1");
    let said =
        press(&cuttable, &out, &["--contact", "cells:box:-0.006,0.006,-1,1,0.0149,1"]).with(0).out;
    assert_eq!((summary(&out).get("given_j"), said.contains("  energy  ")), (None, false));
}

/// Scissors in front of the box's side; their blades open along z.
const SCISSORS: &str = "scissors:0.04/0.7071068,0,0,0.7071068";
/// Offset of their edges \[m\], and the way of the crossing from the pivot \[m\].
const OFFSET_M: f64 = 0.004;
const WAY_M: [f64; 2] = [0.005, 0.024];
const TICKS: usize = 300;

/// Opening of the scissors in a tick \[rad\].
fn opening_rad(tick: usize) -> f64 {
    let share = tick as f64 / (TICKS - 1) as f64;
    2.0 * (OFFSET_M / (WAY_M[0] + share * (WAY_M[1] - WAY_M[0]))).asin()
}

/// A run of the path `text`.
fn snip(model: &Path, out: &Path, path: &str) -> Ended {
    let file = out.with_extension("csv");
    std::fs::write(&file, path).unwrap();
    let args = ["run", text(model), "--path", text(&file), "--tool", SCISSORS, "--out", text(out)];
    run([&args[..], &["--force"]].concat())
}

#[test]
fn scissors_cut_as_they_close_and_their_trace_replays_to_the_same_bits() {
    let folder = scratch();
    let (model, out) = (block(folder.path(), BOX, "0.5"), folder.path().join("out"));
    let rows = (0..TICKS).map(|tick| format!("{tick},0,-0.017,0.0075,1,{}", opening_rad(tick)));
    let rows = rows.collect::<Vec<String>>().join("\n");
    let path = format!("tick,x_m,y_m,z_m,engaged,opening_rad\n{rows}\n");
    let said = snip(&model, &out, &path).with(0);
    let report = summary(&out);
    let number = |name: &str| report[name].as_f64().unwrap();
    assert!(number("opened_faces") >= 8.0 && number("cut_area_m2") > 1e-4, "{report}");
    // The largest torque is that of the toughness times the height of the box, at the end of the way.
    let slope = 0.5 * WAY_M[1] * (WAY_M[1].powi(2) - OFFSET_M.powi(2)).sqrt() / OFFSET_M;
    let most_n_m = TOUGHNESS * 3.0 * 0.005 * slope;
    let torque_n_m = number("opening_torque_n_m");
    assert!((0.6..1.15).contains(&(torque_n_m / most_n_m)), "{torque_n_m} of {most_n_m}");
    assert!(said.out.contains(&format!("handles       {torque_n_m:.5} N m")), "{}", said.out);
    assert!(out.join("picture.png").exists());
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], report["state_hash"]);
    // A still pose with the last opening cuts nothing.
    let still = path.replace(&rows, "0,0,-0.017,0.0075,1,0.4");
    snip(&model, &out, &still).with(0);
    assert_eq!(summary(&out)["opened_faces"], 0);
    // Scissors that no row opens, and those of the built-in motion, stay closed: both say so.
    let closed = still.replace(",opening_rad", "").replace(",0.4", "");
    for closed in [closed, still.replace(",0.4", ",0")] {
        let said = snip(&model, &out, &closed).with(0);
        assert!(said.err.contains("the scissors stay closed") && !said.out.contains("stay closed"));
        assert!(said.err.contains("`opening_rad`"), "{}", said.err);
    }
    let said = press(&model, &out, &["--tool", SCISSORS]).with(0);
    assert!(said.err.contains("leaves scissors closed"), "{}", said.err);
    let said = snip(&model, &out, &still).with(0);
    assert!(!said.err.contains("closed"), "{}", said.err);
    // An opening that cannot be.
    let why = snip(&model, &out, &still.replace(",0.4", ",4.5")).with(2).err;
    assert!(why.contains("field opening_rad `4.5`") && why.contains("0 to 3.14159"), "{why}");
}

/// With `--cut off` a blade feels nothing, and the trace says so: it replays to the same bits.
#[test]
fn with_cut_off_a_blade_cuts_nothing() {
    let folder = scratch();
    let (model, out) = (block(folder.path(), BOX, "0.5"), folder.path().join("out"));
    let said = press(&model, &out, &["--tool", BLADE, "--cut", "off"]).with(0).out;
    assert!(
        said.contains("cutting is off, so blades feel nothing: leave `--cut off` out"),
        "{said}"
    );
    let report = summary(&out);
    assert_eq!((&report["cut"], &report["opened_faces"]), (&"off".into(), &0.into()));
    assert_eq!((&report["cut_area_m2"], &report["copied_cells"]), (&0.0.into(), &0.into()));
    assert!(Table::read(&out.join("force.csv")).column("fz_n").iter().all(|&fz_n| fz_n == 0.0));
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], report["state_hash"]);
    press(&model, &out, &["--tool", BLADE]).with(0);
    assert_eq!(summary(&out)["cut"], "on");
    assert_ne!(summary(&out)["state_hash"], report["state_hash"]);
}

/// Behind the coupling of a device an edge that cuts has its force too: its stiffness is that with which it springs
/// back.
#[test]
fn a_device_feels_the_blade_while_it_cuts() {
    let folder = scratch();
    let (model, out) = (block(folder.path(), BOX, "0.5"), folder.path().join("out"));
    press(&model, &out, &["--tool", BLADE, "--device", "touch"]).with(0);
    let report = summary(&out);
    assert!(report["opened_faces"].as_u64() > Some(0), "{report}");
    assert_eq!(report["flag_ticks"]["safe_state"].as_u64().unwrap_or(0), 0, "{report}");
}

/// A box that is fixed at one end and cut through beyond it: the other end is loose.
#[test]
fn a_piece_that_is_cut_off_is_loose() {
    let folder = scratch();
    let fixed = ["--fix=box:-1,-0.0149,-1,1,-1,1", "--young-pa", "5000", "--poisson", "0.3"];
    let cut = ["--cuttable", "--toughness-j-per-m2", "1", "--cut-spare", "1"];
    let baked =
        |loose: &str| bake(folder.path(), BOX, &[&fixed[..], &cut, &["--loose", loose]].concat());
    let out = folder.path().join("out");
    let run_to = |depth_m: &str, loose: &str| {
        let model = baked(loose);
        let args = ["--motion", "press", "--seconds", "2", "--touch-m", "0.0007,0,0.01501"];
        let place = ["--direction", "0,0,-1", "--depth-m", depth_m, "--tool", BLADE, "--force"];
        let files = ["run", text(&model), "--picture", "off", "--out", text(&out)];
        run([&files[..], &args, &place].concat()).with(0).out
    };
    let said = run_to("0.004", "leave");
    let report = summary(&out);
    assert_eq!((&report["loose_pieces"], &report["loose_cells"]), (&0.into(), &0.into()));
    assert!(report["opened_faces"].as_u64().unwrap() > 0 && !said.contains("loose"), "{said}");
    let said = run_to("0.02", "leave");
    let report = summary(&out);
    assert_eq!(report["loose_pieces"], 1, "{report}");
    let cells = report["loose_cells"].as_u64().unwrap();
    assert!(cells >= 3 * 5 * 4 && cells < NODES as u64, "{cells}");
    assert!(said.contains(&format!(", 1 piece of {cells} cells loose\n")), "{said}");
    // Dropped it is reported, and no file shows it.
    let shown = || {
        array(&std::fs::read_to_string(out.join("final.vtu")).unwrap(), "connectivity").len() / 4
    };
    let all = shown();
    let said = run_to("0.02", "drop");
    let report = summary(&out);
    assert!(
        (report["loose_cells"].as_u64(), report["loose_pieces"].as_u64()) == (Some(cells), Some(1)),
        "{said}"
    );
    assert!((all / 3..all).contains(&shown()), "{} of {all}", shown());
    let info = run(["info", text(&baked("freeze")), "--json"]).with(0).json();
    assert_eq!(info["cutting"]["loose"], "freeze");
}

/// Both sides of the wound have points of their own, and no point lies elsewhere than its node.
#[test]
fn files_show_the_cells_as_they_are_cut() {
    let folder = scratch();
    let (model, out) = (block(folder.path(), BOX, "0.5"), folder.path().join("out"));
    press(&model, &out, &["--tool", BLADE, "--snapshot-ticks", "2,500"]).with(0);
    let copies = summary(&out)["copied_cells"].as_u64().unwrap() as usize;
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let points = |file: &str| array(file, "node").len();
    assert_eq!(points(&read("state_2.vtu")), NODES);
    assert!(points(&read("state_500.vtu")) > NODES);
    let file = read("final.vtu");
    let (nodes, places) = (array(&file, "node"), array(&file, "position_m"));
    assert_eq!((nodes.len(), places.len()), (NODES + copies, 3 * (NODES + copies)));
    for name in ["displacement_m", "stress_pa", "von_mises_pa", "fixed", "contact_pressure_pa"] {
        assert_eq!(array(&file, name).len() % nodes.len(), 0, "{name}");
    }
    // The tool has left: all is back where it was, each copy at its node.
    for way_m in array(&file, "displacement_m") {
        assert!(way_m.abs() < 1e-4, "{way_m}");
    }
    // Copies stand on one side of the blade's plane each, the nodes they copy on the other.
    let corners = array(&file, "connectivity");
    let mut sides: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for tetrahedron in corners.chunks(4) {
        let ids: Vec<usize> = tetrahedron.iter().map(|&id| id as usize).collect();
        let middle_m = ids.iter().map(|&id| places[3 * id]).sum::<f64>() / 4.0;
        ids.iter().for_each(|&id| sides.entry(id).or_default().push(middle_m));
    }
    assert_eq!(sides.len(), NODES + copies);
    for copy in NODES..NODES + copies {
        let node = nodes[..NODES].iter().position(|id| *id == nodes[copy]).unwrap();
        let side = |id: usize| sides[&id].iter().all(|x| x.signum() == sides[&id][0].signum());
        assert!(side(copy) && side(node), "{copy} {node}: {sides:?}");
        assert!(sides[&copy][0] * sides[&node][0] < 0.0, "{copy} {node}");
    }
    // Tables have the nodes of the mesh.
    assert_eq!(Table::read(&out.join("cells_final.csv")).column("node").len(), NODES);
}

#[test]
fn without_spare_cells_a_run_names_the_remedy() {
    let folder = scratch();
    // A cut across nine cells needs nine copies, and a bake leaves eight at least.
    let (model, out) = (block(folder.path(), "box:7x9x4x0.005", "0"), folder.path().join("out"));
    let said = press(&model, &out, &["--tool", BLADE, "--json"]).with(0);
    assert!(said.json()["refused_splits"].as_u64().unwrap() > 0, "{}", said.out);
    assert!(said.err.contains("bake it with more --cut-spare"), "{}", said.err);
}

/// A body that is not cut says nothing of cuts, and one that could be says that it is whole.
#[test]
fn what_is_not_cut_is_whole() {
    let folder = scratch();
    let out = folder.path().join("out");
    let plain = bake(folder.path(), BOX, &["--young-pa", "5000"]);
    let said = press(&plain, &out, &["--tool", "sphere:0.008"]).with(0);
    assert!(!said.out.contains("  cut  "), "{}", said.out);
    assert_eq!((summary(&out).get("cut_area_m2"), summary(&out).get("opened_faces")), (None, None));
    assert!(!Table::read(&out.join("force.csv")).header.contains("cut_area_m2"));
    let said = press(&block(folder.path(), BOX, "0.1"), &out, &["--tool", "sphere:0.008"]).with(0);
    assert!(said.out.contains("0.00 mm^2 with 0.000 mJ, 0 faces open, 0 copied"), "{}", said.out);
    assert_eq!(summary(&out)["opened_faces"], 0);
}

/// Links that snap before a blade parts them: the bake names the limit, and a body baked at it has no remark.
#[test]
fn links_that_are_too_tough_are_told_with_the_remedy() {
    let folder = scratch();
    let model = folder.path().join("links.chaincell");
    let bake = |options: &[&str]| {
        let args = ["bake", BOX, "-o", text(&model), "--cuttable"];
        run([&args[..], options].concat()).with(0).err
    };
    let said = bake(&[]);
    assert!(said.contains("note: a toughness of 160.000 J/m^2 is above a quarter of"), "{said}");
    let info = run(["info", text(&model), "--json"]).with(0).json();
    let number = |name: &str| info[name].as_f64().unwrap();
    let young_pa = info["equivalent_young_pa"]["mean"].as_f64().unwrap();
    let most = 0.25 * young_pa * number("mean_link_m");
    let remedy = format!("{:.2}", (100.0 * most).floor() / 100.0);
    assert!(said.contains(&format!("--toughness-j-per-m2 {remedy} or less")), "{said} {remedy}");
    let above = format!("{}", 1.01 * most);
    assert!(bake(&["--toughness-j-per-m2", &above]).contains("snap under a blade"));
    assert!(!bake(&["--toughness-j-per-m2", &remedy]).contains("snap"));
    // Links as many times as stiff.
    let times = said.split_once("with links ").unwrap().1.split_once(' ').unwrap().0;
    let stiff = format!("{}", 20.0 * times.parse::<f64>().unwrap());
    assert!(!bake(&["--stiffness-n-per-m", &stiff]).contains("snap"), "{stiff}");
    assert!(!bake(&["--young-pa", "5000"]).contains("snap"));
}

#[test]
fn a_blade_that_cannot_cut_is_refused_with_the_remedy() {
    let folder = scratch();
    let out = folder.path().join("out");
    let plain = bake(folder.path(), BOX, &["--young-pa", "5000"]);
    let why = press(&plain, &out, &["--tool", "blade:0.01"]).with(2).err;
    assert!(why.contains("--tool blade:0.01: a blade cuts") && why.contains("--cuttable"), "{why}");
    let model = block(folder.path(), BOX, "0.1");
    for (tool, wanted) in [
        ("blade", "write blade:LENGTH"),
        ("blade:0", "the length 0 must be above 0"),
        ("blade:0.01+sphere:0.004", "part 1 is a blade: a tool has one, as its last part"),
        ("blade:0.01+blade:0.01", "part 1 is a blade"),
        ("blade:9", "is more than"),
        ("scissors:0.04,0.05", "must be below the length"),
        ("scissors:0.04+blade:0.01", "part 1 is a blade"),
        ("scissors:9", "is more than"),
    ] {
        let why = press(&model, &out, &["--tool", tool]).with(2).err.replace('\n', " ");
        assert!(why.contains(wanted), "{tool}: {why}");
    }
    // The page cuts with a blade and with scissors, and plays what cuts.
    let page = folder.path().join("page.html");
    let view = |of: &Path, options: &[&str]| {
        run([&["view", text(of), "--html", text(&page)], options].concat())
    };
    view(&model, &["--tool", "blade:0.01"]).with(0);
    view(&model, &["--tool", "scissors:0.04"]).with(0);
    let said = press(&model, &out, &["--tool", BLADE]).with(0).out;
    assert!(said.contains("chaincell view"), "{said}");
    view(&out, &[]).with(0);
}

/// A bar whose end a tool draws away tears; the trace replays to the same bits.
#[test]
fn a_bar_that_is_drawn_apart_tears() {
    let folder = scratch();
    let tears = ["--cuttable", "--tear-stretch", "1.3", "--cut-spare", "1"];
    let fixed = "--fix=box:-1,-0.0199,-1,1,-1,1";
    let options = [&["--young-pa", "5000", "--poisson", "0.3", fixed][..], &tears].concat();
    let model = bake(folder.path(), "box:9x3x5x0.005", &options);
    let info = run(["info", text(&model), "--json"]).with(0).json();
    assert_eq!(info["cutting"]["tears"]["stretch"].as_f64().unwrap() as f32, 1.3);
    let draw = |out: &Path, depth_m: &str, cut: &str| {
        let place = ["--touch-m", "0.02,0,0", "--direction", "1,0,0", "--depth-m", depth_m];
        let held = ["--contact", "cells:box:0.0199,1,-1,1,-1,1", "--picture", "off", "--force"];
        let args = ["run", text(&model), "--motion", "press", "--seconds", "1.2", "--cut", cut];
        run([&args[..], &place, &held, &["--out", text(out)]].concat()).with(0)
    };
    let out = folder.path().join("torn");
    let said = draw(&out, "0.02", "on");
    let report = summary(&out);
    assert!(report["torn_cells"].as_u64().unwrap() >= 5, "{report}");
    assert!(report["copied_cells"].as_u64().unwrap() >= 5, "{report}");
    assert_eq!((&report["cut_area_m2"], &report["refused_splits"]), (&0.0.into(), &0.into()));
    assert!(said.out.contains(" cells torn") && said.out.contains("chaincell view"), "{said:?}");
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], report["state_hash"]);
    let page = folder.path().join("page.html");
    // The page plays it.
    let said = run(["view", text(&out), "--html", text(&page)]).with(0);
    assert!(said.out.contains("wrote ") && said.err.is_empty(), "{said:?}");
    // A shorter way stays below the limit, and with cutting off nothing tears.
    for (depth_m, cut) in [("0.002", "on"), ("0.02", "off")] {
        draw(&out, depth_m, cut);
        assert_eq!(summary(&out)["torn_cells"], 0, "{depth_m} {cut}");
        let replayed = run(["replay", text(&out), "--json"]).with(0).json();
        assert_eq!(replayed["state_hash"], summary(&out)["state_hash"]);
    }
}

#[test]
fn limits_of_tears_are_refused_with_the_remedy() {
    let folder = scratch();
    let out = folder.path().join("out.chaincell");
    let refused = |options: &[&str]| {
        let args = ["bake", BOX, "--young-pa", "5000", "-o", text(&out)];
        run([&args[..], options].concat()).with(2).err
    };
    for stretch in ["1", "1.009", "11", "nan", "-2"] {
        let why = refused(&["--cuttable", "--tear-stretch", stretch]);
        assert!(why.contains("--tear-stretch") && why.contains("from 1.01 to 10"), "{why}");
    }
    assert!(refused(&["--tears"]).contains("--cuttable"));
    assert!(refused(&["--tear-stretch", "2"]).contains("--cuttable"));
    let both = refused(&["--cuttable", "--tears", "--tear-stretch", "2"]);
    assert!(both.contains("--tears") && both.contains("--tear-stretch"), "{both}");
}
