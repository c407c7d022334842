//! `run` seen from outside: its files, its determinism, and what a tick means.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::{Path, PathBuf};

use chaincell_host::bake::ImageBytes;
use chaincell_kernel::Model;
use chaincell_lab::reference::vectors::{farthest, norm};
use chaincell_tests::files::{
    Row, Table, array, bake, is_hash, names, play, scratch, summary, write_path,
};
use chaincell_tests::lattice::positions;

/// Spacing of the bodies: the mean link length too [m].
const D: f32 = 0.01;
/// Node in the middle of `plane:9x9x0.01`.
const CENTRE: usize = 40;

/// A body with a cell that the tool holds, and the folder for its results.
struct Place {
    folder: tempfile::TempDir,
    model: PathBuf,
    held: usize,
}

/// What a run left behind.
struct Results {
    out: PathBuf,
    force: Table,
}

impl Place {
    fn plane(options: &[&str]) -> Self {
        let folder = scratch();
        let model = bake(folder.path(), "plane:9x9x0.01", options);
        Self { folder, model, held: CENTRE }
    }

    /// The plane of links with these options, and a block of nodal shapes whose top is held in its
    /// middle.
    fn both(options: &[&str]) -> [Self; 2] {
        let folder = scratch();
        let model = bake(folder.path(), "box:5x5x5x0.01", &["--young-pa", "5000"]);
        [Self::plane(options), Self { folder, model, held: 64 }]
    }

    /// Mean length of its links \[m\].
    fn link_m(&self) -> f32 {
        let image = ImageBytes::copy(&std::fs::read(&self.model).unwrap());
        Model::from_bytes(image.as_bytes()).unwrap().unit_m()
    }

    /// Runs a path into the folder `name`.
    #[track_caller]
    fn run(&self, name: &str, rows: &[Row], options: &[&str]) -> Results {
        let path = self.folder.path().join(format!("{name}.csv"));
        write_path(&path, rows.iter().copied());
        let out = self.folder.path().join(name);
        let contact = format!("cells:nodes:{}", self.held);
        let options = [&["--contact", &contact], options].concat();
        play(&self.model, &path, &out, &options).with(0);
        let force = Table::read(&out.join("force.csv"));
        Results { out, force }
    }
}

impl Results {
    fn cells(&self, which: &str) -> Vec<[f64; 3]> {
        positions(&self.out.join(format!("cells_{which}.csv")))
    }

    fn bytes(&self, file: &str) -> Vec<u8> {
        std::fs::read(self.out.join(file)).unwrap()
    }

    fn hash(&self) -> String {
        summary(&self.out)["state_hash"].as_str().unwrap().to_owned()
    }

    fn forces(&self) -> Vec<[f64; 3]> {
        self.force.vectors("fx_n")
    }
}

/// Down by `depth_m` over `ticks` ticks from tick 0 on, the tool engaged.
fn press(ticks: u64, depth_m: f32) -> Vec<Row> {
    let z = |tick: u64| -depth_m * tick as f32 / (ticks - 1) as f32;
    (0..ticks).map(|tick| (tick, [0.0, 0.0, z(tick)], 1)).collect()
}

/// A press, a hold and a release.
fn press_and_release() -> Vec<Row> {
    let mut rows = press(60, 2.5 * D);
    rows.extend((60..100).map(|tick| (tick, [0.0, 0.0, -2.5 * D], 1)));
    rows.extend((100..160).map(|tick| (tick, [0.0, 0.0, 0.0], 0)));
    rows
}

#[test]
fn files_have_the_columns_of_the_contract() {
    let place = Place::plane(&["--alpha", "0.02"]);
    let results = place.run("out", &press_and_release(), &["--snapshot-ticks", "0,10,159"]);
    let expected = [
        "cells_0.csv",
        "cells_10.csv",
        "cells_159.csv",
        "cells_final.csv",
        "final.vtu",
        "force.csv",
        "force.svg",
        "force_depth.svg",
        "model.chaincell",
        "picture.png",
        "series.pvd",
        "session.trace",
        "state_0.vtu",
        "state_10.vtu",
        "state_159.vtu",
        "summary.json",
    ];
    assert_eq!(names(&results.out), expected);
    assert_eq!(results.force.header, "tick,fx_n,fy_n,fz_n,energy_j,contacts,flags");
    assert!(results.force.whole("tick").into_iter().eq(0..160));
    // The last snapshot is the final state; `positions` checks the header and the input order.
    assert_eq!(results.bytes("cells_159.csv"), results.bytes("cells_final.csv"));
    assert_eq!(results.bytes("state_159.vtu"), results.bytes("final.vtu"));
    for text in String::from_utf8(results.bytes("cells_10.csv")).unwrap().lines().skip(1) {
        for number in text.split(',').skip(1) {
            let digits = number.split('e').next().unwrap();
            let digits = digits.bytes().filter(u8::is_ascii_digit).count();
            assert_eq!(digits, 9, "{number}");
        }
    }
    // Node i * 9 + j lies at (i - 4, j - 4) spacings.
    let rest = results.cells("0");
    for (node, at) in rest.iter().enumerate() {
        let expected = [(node / 9) as f64 - 4.0, (node % 9) as f64 - 4.0, 0.0].map(|x| 0.01 * x);
        let off = (0..3).map(|axis| (at[axis] - expected[axis]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-8, "node {node}: {at:?}");
    }
}

#[test]
fn the_summary_says_what_was_run() {
    let place = Place::plane(&["--alpha", "0.02", "--stiffness-n-per-m", "30"]);
    let options = ["--sweeps", "3", "--scheme", "euler", "--max-force-n", "2"];
    let results = place.run("out", &press(10, D), &options);
    let found = summary(&results.out);
    for (key, value) in [
        ("cells", 81.0),
        ("links", 144.0),
        ("ticks", 10.0),
        ("sweeps_per_tick", 3.0),
        ("alpha", 0.02),
        ("stiffness_n_per_m", 30.0),
        ("max_force_n", 2.0),
        ("max_tool_step_m", 0.01),
        ("step", 0.45),
        ("step_bound", 0.5),
        ("mean_link_m", 0.01),
        ("r_x", 1.0),
        ("capacitance", 1.0),
        ("k_m", 0.16),
    ] {
        let number = found[key].as_f64().unwrap_or(f64::NAN);
        assert!((number / value - 1.0).abs() < 1e-6, "{key}: {} {value}", found[key]);
    }
    assert_eq!(found["scheme"], "euler");
    assert_eq!(found["unloading"], "release");
    assert_eq!(found["drive"], "position");
    assert_eq!(found["contact_nodes"], serde_json::json!([40]));
    assert!(is_hash(&found["state_hash"]), "{}", found["state_hash"]);
    let step = |name: &str| found["step_ns"][name].as_u64().unwrap();
    assert!(step("p50") <= step("p99") && step("p99") <= step("p999"));
    assert!(step("p999") <= step("max"));
}

/// The drive reaches the kernel and the summary: a load needs a while to have its force.
#[test]
fn the_drive_is_what_was_asked_for() {
    let place = Place::plane(&[]);
    let [held, loaded] = ["position", "current"].map(|drive| {
        let results = place.run(drive, &press(10, D), &["--drive", drive]);
        let found = summary(&results.out);
        assert_eq!(found["drive"], drive);
        found["state_hash"].clone()
    });
    assert!(held != loaded);
}

/// A time constant is a step: of euler a sweep, of the others a tick.
#[test]
fn a_time_constant_is_a_step() {
    let place = Place::plane(&[]);
    for (dynamics, sweeps, step) in [("euler", "4", "0.125"), ("rkl2", "8", "0.5")] {
        let common = ["--scheme", dynamics, "--sweeps", sweeps];
        let with = |name: &str, more: [&str; 2]| {
            place.run(&format!("{dynamics}{name}"), &press(40, D), &[&common[..], &more].concat())
        };
        let constant = with("constant", ["--time-constant-s", "0.002"]);
        let found = summary(&constant.out);
        assert_eq!(found["network_time_per_tick"].as_f64().unwrap(), 0.5, "{dynamics}");
        assert!((found["time_constant_s"].as_f64().unwrap() - 0.002).abs() < 1e-9);
        assert_eq!(found["step"].as_f64().unwrap(), step.parse::<f64>().unwrap());
        assert_eq!(constant.hash(), with("step", ["--step", step]).hash());
        assert_ne!(constant.hash(), with("slower", ["--time-constant-s", "0.004"]).hash());
    }
}

/// In the same time of the network, Runge-Kutta-Legendre ends where many small Euler steps do.
#[test]
fn schemes_in_time_agree() {
    let place = Place::plane(&["--diagonals"]);
    let scheme = |dynamics, sweeps| {
        let scheme = ["--scheme", dynamics, "--sweeps", sweeps, "--time-constant-s", "0.0005"];
        place.run(dynamics, &press(30, D), &scheme).cells("final")
    };
    let exact = scheme("euler", "500");
    let off = farthest(&scheme("rkl2", "20"), &exact) / f64::from(D);
    assert!(off < 2e-3, "{off:e} of the depth");
}

#[test]
fn the_same_path_gives_the_same_bytes() {
    for dynamics in ["track", "predict", "euler", "rkl2"] {
        let place = Place::plane(&["--alpha", "0.05"]);
        let options = ["--scheme", dynamics, "--snapshot-ticks", "50"];
        let one = place.run("one", &press_and_release(), &options);
        let two = place.run("two", &press_and_release(), &options);
        for file in ["force.csv", "cells_50.csv", "cells_final.csv", "final.vtu"] {
            assert!(one.bytes(file) == two.bytes(file), "{dynamics}: {file}");
        }
        assert_eq!(one.hash(), two.hash());
        // A snapshot is the state after its row, whatever follows.
        let short = place.run("short", &press_and_release()[..=50], &["--scheme", dynamics]);
        assert!(short.bytes("cells_final.csv") == one.bytes("cells_50.csv"), "{dynamics}");
        assert_ne!(short.hash(), one.hash());
    }
}

pub(super) fn check_vtu(file: &Path, elements: usize, corners: usize) {
    let vtu = std::fs::read_to_string(file).unwrap();
    let count = |name: &str| -> usize {
        let text = vtu.split(&format!("{name}=\"")).nth(1).unwrap();
        text.split('"').next().unwrap().parse().unwrap()
    };
    let points = count("NumberOfPoints");
    assert_eq!(count("NumberOfCells"), elements);
    let connectivity = array(&vtu, "connectivity");
    assert_eq!(connectivity.len(), corners * elements);
    assert!(connectivity.iter().all(|&corner| corner < points as f64));
    let offsets = array(&vtu, "offsets");
    assert!(offsets.iter().enumerate().all(|(at, &n)| n == ((at + 1) * corners) as f64));
    assert_eq!(array(&vtu, "types"), vec![if corners == 4 { 10.0 } else { 5.0 }; elements]);
    let mut nodes = array(&vtu, "node");
    nodes.sort_by(f64::total_cmp);
    assert!(nodes.iter().enumerate().all(|(at, &node)| node == at as f64));
    assert_eq!(nodes.len(), points);
    for name in ["fixed", "contact"] {
        let marks = array(&vtu, name);
        assert_eq!(marks.len(), points);
        assert!(marks.contains(&1.0) && marks.contains(&0.0));
    }
    // Every element opened is closed, in the order of nesting.
    let mut open = Vec::new();
    for tag in vtu.split('<').skip(1).map(|text| text.split(['>', ' ']).next().unwrap()) {
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.starts_with('?') => {}
            None => open.push(tag),
        }
    }
    assert!(open.is_empty());
}

// REQ-FOR-05
#[test]
fn the_first_row_counts_as_an_edge() {
    for place in Place::both(&[]) {
        // Far off from the start on: what counts is the way from the first row.
        let at = [1.0_f32, -2.0, 3.0];
        let rows = [(7, at, 1), (8, [at[0], at[1], at[2] - 0.5 * D], 1), (9, at, 1)];
        let results = place.run("out", &rows, &["--snapshot-ticks", "7,8,9"]);
        let rest_m = results.cells("7")[place.held];
        assert!(place.held != CENTRE || rest_m == [0.0; 3]);
        assert_eq!(results.forces()[0], [0.0; 3]);
        let lift_m = |name: &str| results.cells(name)[place.held][2] - rest_m[2];
        assert!((lift_m("8") + 0.005).abs() < 1e-6);
        assert!(lift_m("9").abs() < 1e-6);
        assert_eq!(results.force.whole("contacts"), [1, 1, 1]);
        // A rollback (64) is the guard's own business.
        let flags = results.force.whole("flags");
        assert!(flags.iter().all(|flags| flags & !64 == 0), "{flags:?}");
    }
}

// REQ-FOR-04
#[test]
fn the_tool_moves_its_cells_by_at_most_one_mean_link_a_tick() {
    for place in Place::both(&[]) {
        let link_m = place.link_m();
        let down = [0.0, 0.0, -2.5 * link_m];
        let rows: Vec<Row> =
            (0..6).map(|tick| (tick, if tick == 0 { [0.0; 3] } else { down }, 1)).collect();
        let results = place.run("out", &rows, &["--snapshot-ticks", "0,1,2,3,4"]);
        let z = |results: &Results, name: &str| results.cells(name)[place.held][2];
        let rest_m = z(&results, "0");
        // A rollback (64) is the guard's own business.
        let flags = |results: &Results| -> Vec<u64> {
            results.force.whole("flags").iter().map(|flags| flags & !64).collect()
        };
        assert_eq!(flags(&results), [0, 1, 1, 0, 0, 0]);
        for (tick, links) in [("1", 1.0), ("2", 2.0), ("3", 2.5), ("4", 2.5)] {
            let depth_m = rest_m - z(&results, tick);
            assert!((depth_m - links * f64::from(link_m)).abs() < 1e-7, "tick {tick}: {depth_m}");
        }
        let slow = place.run("slow", &rows, &["--max-tool-step-m", "0.001"]);
        assert_eq!(flags(&slow), [0, 1, 1, 1, 1, 1]);
        assert!((rest_m - z(&slow, "final") - 0.005).abs() < 1e-7);
    }
}

#[test]
fn lost_ticks_are_executed_once_and_repeated_and_bad_ones_not_at_all() {
    let place = Place::plane(&[]);
    let rows = press(20, D);
    let lost: Vec<Row> =
        rows.iter().map(|&(tick, at, engaged)| (tick + 5 * (tick / 10), at, engaged)).collect();
    let mut repeated = rows.clone();
    repeated.insert(8, (7, [9.0; 3], 1));
    repeated.insert(12, (3, [f32::NAN; 3], 7));
    repeated.insert(15, (u64::MAX, [9.0; 3], 1));
    let strict = place.run("strict", &rows, &[]);
    let lost = place.run("lost", &lost, &["--recorded"]);
    let repeated = place.run("repeated", &repeated, &["--recorded"]);
    assert_eq!(lost.force.rows.len(), 20);
    assert_eq!(lost.force.whole("tick")[9..12], [9, 15, 16]);
    assert_eq!(repeated.bytes("force.csv"), strict.bytes("force.csv"));
    assert_eq!(summary(&repeated.out)["poses_repeated"], 3);
    assert_eq!(summary(&repeated.out)["ticks"], 20);
    for other in [&lost, &repeated] {
        assert_eq!(other.hash(), strict.hash());
        assert_eq!(other.forces(), strict.forces());
    }
}

// REQ-FOR-03
#[test]
fn the_force_is_shortened_to_its_limit() {
    for place in Place::both(&[]) {
        let free = place.run("free", &press(40, 2.5 * D), &[]);
        let limited = place.run("limited", &press(40, 2.5 * D), &["--max-force-n", "0.1"]);
        assert_eq!(free.hash(), limited.hash(), "the limit concerns the tool alone");
        let mut clamped = 0;
        for (tick, (free, limited_n)) in free.forces().iter().zip(limited.forces()).enumerate() {
            let flag = limited.force.whole("flags")[tick];
            if norm(*free) > 0.1 {
                clamped += 1;
                assert_eq!(flag & 8, 8, "tick {tick}");
                assert!((norm(limited_n) - 0.1).abs() < 1e-7);
            } else {
                assert_eq!(flag & 8, 0, "tick {tick}");
                assert_eq!(*free, limited_n);
            }
        }
        assert!((1..40).contains(&clamped), "{clamped}");
    }
}

#[test]
fn the_default_scheme_is_the_one_that_suits_the_scene() {
    let slack = Place::plane(&["--alpha", "0.05"]);
    let tight = Place::plane(&["--alpha", "0"]);
    let path = slack.folder.path().join("path.csv");
    write_path(&path, press(5, D));
    let ran = |place: &Place, options: &[&str]| {
        let out = place.folder.path().join("out");
        play(&place.model, &path, &out, &[&["--force"], options].concat()).with(0);
        let found = summary(&out);
        (found["scheme"].clone(), found["state_hash"].clone())
    };
    for (place, options, scheme) in [
        (&tight, &[][..], "predict"),
        (&tight, &["--contact", "probe:0.02"], "predict"),
        (&tight, &["--drive", "current"], "track"),
        (&tight, &["--precision", "fixed"], "track"),
        (&slack, &[], "track"),
    ] {
        let found = ran(place, options);
        assert_eq!(found.0, scheme, "{options:?}");
        // Left to choose or told: the same run.
        assert_eq!(found, ran(place, &[&["--scheme", scheme], options].concat()));
    }
}

#[test]
fn predict_says_where_it_is_track() {
    let slack = Place::plane(&["--alpha", "0.05"]);
    let tight = Place::plane(&["--alpha", "0"]);
    let path = slack.folder.path().join("path.csv");
    write_path(&path, [(0, [0.0; 3], 0), (1, [0.0; 3], 1)]);
    let said = |place: &Place, options: &[&str]| {
        let out = place.folder.path().join("out");
        let options = [&["--scheme", "predict", "--force"], options].concat();
        play(&place.model, &path, &out, &options).with(0).err
    };
    for (place, options, why) in [
        (&tight, &["--drive", "current"][..], "under a current it is track"),
        (&slack, &[][..], "on a model with slack"),
    ] {
        let err = said(place, options);
        assert!(err.contains(why), "{err}");
    }
    assert!(!said(&tight, &[]).contains("it is track"));
}
