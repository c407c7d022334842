//! `--tool`: what it refuses, and runs of several tools offline.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use chaincell_tests::files::{Table, bake, play, scratch, summary, text};
use chaincell_tests::{Ended, run};

/// Two tools, the first of two parts.
const TOOLS: [&str; 2] =
    ["--tool=sphere:0.008+capsule:0.01,0.002@0,0,0.015", "--tool=box:0.004,0.006,0.002,0.003"];
/// Height of the top \[m\].
const TOP_M: f64 = 0.03;

fn block(folder: &Path) -> PathBuf {
    bake(folder, "box:9x9x4x0.01", &["--young-pa", "5000"])
}

/// A press of the built-in motion.
fn press(model: &Path, out: &Path, options: &[&str]) -> Ended {
    let args = ["run", text(model), "--motion", "press", "--seconds", "0.1", "--out", text(out)];
    run([&args[..], &["--depth-m", "0.004", "--force", "--json"], options].concat())
}

/// Two tools that go into the top beside each other, the second one turned.
fn path_of_two(file: &Path) {
    let mut rows = String::from("tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged\n");
    for tick in 0..60_u32 {
        let way_m = 1.0e-4 * f64::from(tick.min(50));
        let (first, second) = (TOP_M + 0.009 - way_m, TOP_M + 0.006 - way_m);
        let engaged = u32::from(tick > 0);
        let _ = writeln!(rows, "{tick},0,-0.02,0.001,{first},0,0,0,1,{engaged}");
        let _ = writeln!(rows, "{tick},1,0.02,0.001,{second},0,0.0998334166,0,0.9950041653,1");
    }
    std::fs::write(file, rows).unwrap();
}

#[test]
fn a_tool_that_cannot_be_is_refused_with_its_place_and_the_remedy() {
    let folder = scratch();
    let model = block(folder.path());
    let out = folder.path().join("out");
    let refused: [(&[&str], &str); 10] = [
        (&["--tool", "ball:0.01"], "unknown kind: write sphere:R"),
        (&["--tool", "sphere:0.01+sphere:0"], "part 2 `sphere:0`: the radius 0 must be above 0"),
        (&["--tool", "capsule:0.01"], "write capsule:HALF_LENGTH,RADIUS"),
        (&["--tool", "sphere:0.01/0,0,0,2"], "has length 2"),
        (&["--tool", "sphere:0.01@9,0,0"], "--tool sphere:0.01@9,0,0: 9 m is more than"),
        (&["--tool", "sphere:0.01", "--contact", "probe:0.01"], "cannot be used with"),
        (&["--tool", "sphere:0.01", "--friction", "11"], "--friction 11: must be 0 to 10"),
        (&["--tool", "sphere:0.01", "--max-torque-n-m", "0"], "must be above 0 and finite"),
        (&["--tool", "half-space"], "give run or control a --path"),
        (&["--tool", "sphere:0.01", "--drive", "current"], "a --tool has none"),
    ];
    for (options, wanted) in refused {
        let err = press(&model, &out, options).with(2).err;
        let (found, wanted) = (err.replace('\n', " "), wanted.replace('\n', " "));
        assert!(found.contains(&wanted), "{options:?}: {found}");
    }
    for options in [&["--contact", "probe:0.01"][..], &[]] {
        let options = [options, &["--max-torque-n-m", "1"]].concat();
        let err = press(&model, &out, &options).with(2).err;
        assert!(err.contains("--tool"), "{options:?}: {err}");
    }
    let nine = ["--tool=sphere:0.01"; 9];
    assert!(press(&model, &out, &nine).with(2).err.contains("at most 8 tools"));
    let cells = folder.path().join("cells");
    std::fs::create_dir(&cells).unwrap();
    let cells = bake(&cells, "box:5x5x4x0.01", &["--contact-surface", "no"]);
    let err = press(&cells, &out, &["--tool", "sphere:0.01"]).with(2).err;
    assert!(err.contains("a tool touches") && err.contains("--contact-surface yes"), "{err}");
    assert!(!out.exists(), "a run that was refused made its folder");
}

#[test]
fn one_sphere_is_the_probe_and_the_press_moves_the_first_tool_alone() {
    let folder = scratch();
    let model = block(folder.path());
    let out = folder.path().join("out");
    let hash = |options: &[&str]| press(&model, &out, options).with(0).json()["state_hash"].clone();
    let probe = hash(&["--contact", "probe:0.008"]);
    assert_eq!(hash(&["--tool", "sphere:0.008"]), probe);
    let rubbed = hash(&["--contact", "probe:0.008", "--friction", "0.3"]);
    assert_eq!(hash(&["--tool", "sphere:0.008", "--friction", "0.3"]), rubbed);
    assert_eq!(hash(&["--tool", "sphere:0.008", "--max-torque-n-m", "1e-9"]), probe);
    assert_eq!(hash(&["--tool", "sphere:0.008", "--tool", "sphere:0.02"]), probe);
    assert_eq!(summary(&out)["tools"], serde_json::json!(["sphere:0.008", "sphere:0.02"]));
    let (tools, force) = (Table::read(&out.join("tools.csv")), Table::read(&out.join("force.csv")));
    let (each, first) = (tools.vectors("fx_n"), force.vectors("fx_n"));
    assert!(each.iter().step_by(2).eq(&first) && first.iter().any(|of| of[2] > 0.01));
    assert!(each.iter().skip(1).step_by(2).all(|of| *of == [0.0; 3]));
    // An output stage for one tool, and one for each of two.
    hash(&["--tool", "sphere:0.008", "--device", "omega"]);
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], summary(&out)["state_hash"]);
    hash(&["--tool", "sphere:0.008", "--tool", "sphere:0.02", "--device", "omega"]);
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], summary(&out)["state_hash"]);
}

/// The built-in press begins outside with every kind of tool, turned or not, and presses.
#[test]
fn the_press_of_every_kind_of_tool_begins_outside_and_presses() {
    let folder = scratch();
    let model = block(folder.path());
    let out = folder.path().join("out");
    for tool in [
        "capsule:0.02,0.004",
        "capsule:0.02,0.004/0.7071068,0,0,0.7071068",
        "box:0.01,0.008,0.012,0.003",
        "box:0.01,0.008,0.012,0.003/0.2,0.3,0.1,0.9273618",
        "sphere:0.004+capsule:0.012,0.003@0,0,-0.02/0,0.3826834,0,0.9238795",
    ] {
        for direction in [&[][..], &["--direction=0.5,0,-1"]] {
            let options = [&["--tool", tool], direction].concat();
            let pressed = press(&model, &out, &options).with(0).json();
            let table = Table::read(&out.join("force.csv"));
            let (flags, forces) = (table.whole("flags"), table.vectors("fx_n"));
            assert!(flags.iter().all(|flags| flags & 2048 == 0), "{tool}: {pressed}");
            let squared = |force: &[f64; 3]| force.iter().map(|x| x * x).sum::<f64>();
            assert!(forces.iter().any(|force| squared(force) > 1e-4), "{tool}: {pressed}");
            // Not from far away, either: half of a millimetre deeper it is in contact.
            let first = table.whole("contacts").iter().position(|of| *of > 0).unwrap();
            assert!(first < 30, "{tool}: {first}");
        }
    }
}

#[test]
fn a_path_of_two_tools_is_played_recorded_and_replayed() {
    let folder = scratch();
    let model = block(folder.path());
    let (path, out) = (folder.path().join("two.csv"), folder.path().join("out"));
    path_of_two(&path);
    let err = play(&model, &path, &out, &TOOLS[..1]).with(2).err;
    assert!(err.contains("it moves 2 tools") && err.contains("--tool chooses 1"), "{err}");
    let options = [&TOOLS[..], &["--friction", "0.2", "--json"]].concat();
    let played = play(&model, &path, &out, &options).with(0).json();
    let tools = Table::read(&out.join("tools.csv"));
    let (forces, torques) = (tools.vectors("fx_n"), tools.vectors("tx_n_m"));
    assert_eq!(forces.len(), 120);
    // Both press; the second is turned about y, so that one side lies deeper.
    assert!(forces[118][2] > 0.05 && forces[119][2] > 0.05, "{:?}", &forces[118..]);
    assert!(torques[119][1].abs() > 1e-5 && tools.whole("contacts")[119] > 0);
    let trace = out.join("session.trace");
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], played["state_hash"]);
    assert_eq!((&replayed["ticks"], &replayed["end"]), (&60.into(), &"complete".into()));
    // Cut behind the poses of tick 40: what is whole before them is played.
    let bytes = std::fs::read(&trace).unwrap();
    let parts = 80 + 2 * 3 * 48;
    assert_eq!(bytes.len(), parts + 60 * 3 * 48);
    for (kept, ended) in [(40 * 3 + 2, "cut within record 128"), (40 * 3, "complete")] {
        std::fs::write(&trace, &bytes[..parts + kept * 48]).unwrap();
        let cut = run(["replay", text(&out), "--json"]).with(0).json();
        assert_eq!((&cut["ticks"], &cut["end"]), (&40.into(), &ended.into()));
    }
    std::fs::write(&trace, &bytes[..80 + 48]).unwrap();
    let err = run(["replay", text(&out)]).with(2).err;
    assert!(err.contains("the parts of its tools are not all there"), "{err}");
}
