//! Models, paths, contacts and parameters that are refused: exit code 2, the place, the remedy.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::{bake, text};
use chaincell_tests::run;

use super::place::Place;

#[test]
fn models_that_are_no_models() {
    let place = Place::new();
    let bytes = std::fs::read(&place.model).unwrap();
    let empty = place.file("empty", b"");
    let mesh = place.file("body.msh", b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    let longer = place.file("longer", [bytes.as_slice(), &[0; 16]].concat());
    let cut = place.file("cut", &bytes[..bytes.len() - 1]);
    let mut wrong = bytes.clone();
    wrong[97] ^= 1;
    let wrong = place.file("wrong", wrong);
    let missing = place.folder.path().join("missing");
    let folder = place.folder.path().to_owned();
    for model in [&mesh, &place.path] {
        place.refuses(&["info", text(model)], &["not a chaincell model", "chaincell bake"]);
    }
    for model in [&empty, &mesh, &longer, &cut, &wrong, &missing, &folder, &place.path] {
        place.refuses(&["info", text(model)], &["cannot read model", text(model)]);
        for command in ["serve", "cosim", "latency"] {
            place.refuses(&[command, text(model)], &["cannot read model", text(model)]);
        }
        let out = place.folder.path().join("out");
        let args = ["run", text(model), "--path", text(&place.path), "--out", text(&out)];
        place.refuses(&args, &["cannot read model", text(model)]);
    }
}

#[test]
fn paths_that_break_the_rules() {
    const HEADER: &str = "tick,x_m,y_m,z_m,engaged";
    let place = Place::new();
    let out = place.folder.path().join("out");
    let scene = chaincell_tests::scene("paths");
    for (content, part) in [
        (format!("{HEADER}\n0,0,0,0,0\n2,0,0,0,0\n"), "bad.csv:3: field tick 2: must be 1"),
        (format!("{HEADER}\n0,0,NaN,0,0\n"), "bad.csv:2: field y_m `NaN`: must be finite"),
        ("tick,x,y,z,engaged\n0,0,0,0,0\n".into(), "bad.csv:1: the header is"),
    ] {
        let path = place.file("bad.csv", content);
        let args = ["run", text(&place.model), "--path", text(&path), "--out", text(&out)];
        place.refuses(&args, &[part, text(&path)]);
        place.refuses(&["control", "--scene", &scene, "--path", text(&path)], &[part]);
    }
    for path in [place.folder.path().join("missing.csv"), place.folder.path().to_owned()] {
        let args = ["run", text(&place.model), "--path", text(&path), "--out", text(&out)];
        place.refuses(&args, &[text(&path), "cannot"]);
    }
    let packed = place.file("bad.csv", b"\x1f\x8b\x08\0\0");
    let args = ["run", text(&place.model), "--path", text(&packed), "--out", text(&out)];
    place.refuses(&args, &["bad.csv: it is gzip-compressed: unpack it first with gunzip"]);
}

#[test]
fn contacts_that_cannot_be_held() {
    let place = Place::new();
    let sets = place.file("sets.json", r#"{"far": [25]}"#);
    let key = |key: &str| format!("cells:file:{}{key}", sets.display());
    for (contact, parts) in [
        ("cells:nodes:25", &["'25' is no node", "0 to 24"][..]),
        ("cells:nodes:0", &["node 0 is fixed"]),
        ("cells:", &["unknown selector"]),
        ("sphere:0.01", &["--contact sphere:0.01", "probe:RADIUS", "given with --tool"]),
        ("cells:border", &["fixed"]),
        ("probe:thick", &["probe:thick", "no radius [m]"]),
        ("probe:", &["no radius [m]"]),
        ("probe:0", &["radius must be above 0"]),
        ("probe:-0.01", &["radius must be above 0"]),
        ("probe:nan", &["radius must be above 0"]),
        ("probe:1e9", &["is more than"]),
        (&key("#far"), &["'25' is no node"]),
    ] {
        let parts = [parts, &["--contact"]].concat();
        place.refuses_run(&["--contact", contact], &parts);
        place.refuses(&["serve", text(&place.model), "--contact", contact], &parts);
    }
    let all_fixed = bake(place.folder.path(), "plane:3x3x0.01", &["--fix", "box:-1,1,-1,1,-1,1"]);
    let args = ["serve", text(&all_fixed)];
    place.refuses(&args, &["--contact auto: every cell is fixed"]);
}

#[test]
fn nodes_that_cannot_be_fixed() {
    let place = Place::new();
    for (fix, part) in [
        ("nodes:25", "'25' is no node"),
        ("nodes:1,1", "given twice"),
        ("file:/none/none", "cannot read /none/none"),
    ] {
        place.refuses_bake(&["--fix", fix], &["--fix", part]);
    }
}

// REQ-MOD-05
#[test]
fn body_parameters_out_of_range() {
    let place = Place::new();
    for alpha in ["-0.1", "1", "1.5", "0.99999999999", "NaN", "inf", "x", ""] {
        place.refuses_bake(&["--alpha", alpha], &["--alpha"]);
    }
    place.refuses_bake(&["--alpha", "-0.1"], &["--alpha -0.1: must be in [0, 1)"]);
    for stiffness in ["0", "-1", "inf", "NaN", "1e-60", "1e60"] {
        let parts = ["--stiffness-n-per-m", "must be above 0 and finite"];
        place.refuses_bake(&["--stiffness-n-per-m", stiffness], &parts);
    }
    place.refuses_bake(&["--k-m", "0.01"], &["--k-m 0.01", "at least twice"]);
    for (option, range) in [
        ("--k-m", "must be above 0 and finite"),
        ("--r-x", "must be from 1e-11 to 1e11"),
        ("--capacitance", "must be from 1e-11 to 1e11"),
        ("--energy-max-j", "must be above 0 and finite"),
    ] {
        for value in ["0", "-1", "NaN", "inf", "1e99", "1e-99"] {
            place.refuses_bake(&[option, value], &[option, range]);
        }
        place.refuses_bake(&[option, "many"], &[option, "many"]);
    }
    let few = format!("file:{}", place.file("few", "0.1 0.1").display());
    place.refuses_bake(&["--alpha", &few], &["--alpha", "2 values for 25 nodes"]);
    let bad = format!("file:{}", place.file("bad", "0.1 2 ".repeat(12) + "0").display());
    place.refuses_bake(&["--alpha", &bad], &["--alpha", "node 1", "[0, 1)"]);
    let word = format!("file:{}", place.file("word", "0.1 soft").display());
    place.refuses_bake(&["--alpha", &word], &["--alpha", "value 1", "soft"]);
    place.refuses_bake(&["--alpha", "file:/none/none"], &["--alpha", "/none/none"]);
}

// REQ-SET-01
#[test]
fn run_parameters_out_of_range() {
    let place = Place::new();
    let bound = "must be above 0 and at most 0.5, the model's proven bound";
    for step in ["0", "-0.1", "0.51", "1e9", "NaN", "inf"] {
        place.refuses_run(&["--scheme", "euler", "--step", step], &["--step", bound]);
    }
    let mut scheme = ["--scheme", "rkl2", "--step", ""];
    for step in ["0", "1e-45", "-0.1", "NaN", "inf"] {
        scheme[3] = step;
        place.refuses_run(&scheme, &["--step", "must be finite and at least 0.0000000000005"]);
    }
    // 4 sweeps of at most 0.5 in a tick of 1 ms.
    for (constant_s, dynamics, why) in [
        ("0.0004", "euler", "bound is 0.5: at least 0.0005 s with 4 sweeps"),
        ("0", "euler", "must be above 0 and finite"),
        ("-1", "rkl2", "must be above 0 and finite"),
        ("NaN", "rkl2", "must be above 0 and finite"),
        ("1e-44", "rkl2", "must be above 0 and finite"),
        ("0.1", "track", "answers the static question"),
    ] {
        let scheme = ["--scheme", dynamics, "--time-constant-s", constant_s];
        place.refuses_run(&scheme, &["--time-constant-s", why]);
    }
    for dynamics in ["track", "predict"] {
        let step = ["--scheme", dynamics, "--step", "0.01"];
        place.refuses_run(&step, &["--step 0.01", "answers the static question"]);
    }
    place.refuses_run(&["--contact", "probe"], &["--contact probe", "as in probe:0.012"]);
    let both = ["--scheme", "euler", "--step", "0.1", "--time-constant-s", "1"];
    place.refuses_run(&both, &["--time-constant-s", "cannot be used with"]);
    for option in ["--max-tool-step-m", "--max-force-n"] {
        for value in ["0", "-1", "NaN", "inf"] {
            place.refuses_run(&[option, value], &[option, "must be above 0 and finite"]);
        }
    }
    place.refuses_run(&["--sweeps", "0"], &["--sweeps 0: must be at least 1"]);
    for sweeps in ["-1", "65536", "1.5", "x"] {
        place.refuses_run(&["--sweeps", sweeps], &["--sweeps", sweeps]);
    }
    for threads in ["0", "9", "-1", "many"] {
        place.refuses_run(&["--threads", threads], &["--threads", threads, "1 to 8, or auto"]);
    }
    place.refuses_run(&["--threads", "2"], &["--threads 2", "4096 cells of shapes or more"]);
    let euler = ["--threads", "2", "--scheme", "euler"];
    place.refuses_run(&euler, &["--threads 2", "--scheme track and predict"]);
    place.refuses_run(&["--snapshot-ticks", "5"], &["--snapshot-ticks 5", "0 to 4"]);
    place.refuses_run(&["--snapshot-ticks", "1,9"], &["--snapshot-ticks 9", "0 to 4"]);
    place.refuses_run(&["--snapshot-ticks", "1,-1"], &["--snapshot-ticks", "-1"]);
    place.refuses_run(&["--scheme", "verlet"], &["--scheme", "euler", "track"]);
    place.refuses_run(&["--unloading", "never"], &["--unloading", "retreat"]);
}

#[test]
fn session_parameters_out_of_range() {
    let place = Place::new();
    let model = text(&place.model);
    let scene = chaincell_tests::scene("ranges");
    let common = ["--scene", &scene];
    for seconds in ["0", "-1", "NaN", "1e9", "inf", "0.001"] {
        let option = ["--seconds", seconds];
        let parts = ["--seconds", "must be from 0.02 to 86400"];
        place.refuses(&[&["cosim", model], &common[..], &option].concat(), &parts);
        place.refuses(&[&["control"], &common[..], &option].concat(), &parts);
        place.refuses(&[&["latency", model], &common[..], &option].concat(), &parts);
    }
    for seconds in ["0", "-1", "NaN", "inf", "1e30"] {
        let args = [&["serve", model], &common[..], &["--seconds", seconds]].concat();
        place.refuses(&args, &["--seconds", "must be "]);
    }
    for command in ["serve", "cosim"] {
        let args = |options: &[&'static str]| [&[command, model], &common[..], options].concat();
        for budget in ["0", "-1", "fast", "1e3", "2000000"] {
            place.refuses(&args(&["--budget-us", budget]), &["--budget-us", "auto, off"]);
        }
        for dynamics in ["euler", "rkl2"] {
            let options = ["--scheme", dynamics, "--budget-us", "auto"];
            let parts = ["--budget-us auto", dynamics, "the tissue's time", "--scheme track"];
            place.refuses(&args(&options), &parts);
        }
        place.refuses(&args(&["--late-share", "1"]), &["--late-share", "as in 1%, or off"]);
    }
    let faults = ["--inject", "lost:1%"];
    let args = [&["serve", model], &common[..], &faults].concat();
    place.refuses(&args, &["--inject", "sweep:PERIODS"]);
    let args = [&["control"], &common[..], &["--inject", "sweep:2"]].concat();
    place.refuses(&args, &["--inject", "serve or cosim"]);
    for depth in ["0", "-1", "NaN", "inf"] {
        for command in [&["cosim", model][..], &["control"], &["latency", model]] {
            let args = [command, &common[..], &["--depth-m", depth]].concat();
            place.refuses(&args, &["--depth-m", "must be above 0 and finite"]);
        }
    }
    // Meant in millimetres.
    for command in ["cosim", "latency"] {
        let args = [&[command, model][..], &common[..], &["--depth-m", "10"]].concat();
        place.refuses(&args, &["--depth-m 10.0: 10.0 m into a body of ", "the depth in metres"]);
    }
    for wait in ["-1", "NaN", "inf", "1e30"] {
        let args = [&["control"], &common[..], &["--wait-for-server-s", wait]].concat();
        place.refuses(&args, &["--wait-for-server-s", "must be "]);
    }
    for (option, value) in [
        ("--direction", "0,0,0"),
        ("--direction", "0,0"),
        ("--touch-m", "a,b,c"),
        ("--touch-m", "NaN,0,0"),
    ] {
        place.refuses(&[&["control"], &common[..], &[option, value]].concat(), &[option]);
    }
    let both = ["control", "--path", text(&place.path), "--motion", "press"];
    place.refuses(&both, &["--path", "--motion"]);
}

#[test]
fn scene_names_that_are_refused() {
    let place = Place::new();
    let (model, out) = (text(&place.model), place.folder.path().join("out"));
    let long = "x".repeat(65);
    for scene in ["", "a/b", &long, "tools"] {
        for command in [
            &["serve", model, "--out", text(&out)][..],
            &["cosim", model, "--out", text(&out)],
            &["latency", model],
            &["control"],
        ] {
            let args = [command, &["--scene", scene]].concat();
            place.refuses(&args, &["--scene", "give 1 to 64 letters"]);
        }
    }
}

#[test]
fn unknown_commands_and_options() {
    let place = Place::new();
    for args in [
        &[][..],
        &["bend"],
        &["bake"],
        &["bake", "plane:3x3x0.01"],
        &["info"],
        &["run", "m"],
        &["info", text(&place.model), "--colour"],
        &["cosim", "a", "b"],
    ] {
        place.refuses(args, &["Usage"]);
    }
    let serve = ["serve", text(&place.model)];
    for (option, value) in
        [("--wait", "sometimes"), ("--ticks", "-1"), ("--hash-every", "x"), ("--watchdog-ms", "-1")]
    {
        place.refuses(&[&serve, &[option, value][..]].concat(), &[option, value]);
    }
    let both = [&serve, &["--settings", "of-cosim"][..]].concat();
    place.refuses(&both, &["--settings", "unexpected argument"]);
    place.refuses(&["control", "--settings", "none"], &["cannot read settings none"]);
    for args in [&["--help"][..], &["--version"], &["run", "--help"], &["help", "cosim"]] {
        let ended = run(args).with(0);
        assert!(!ended.out.is_empty() && ended.err.is_empty());
    }
}
