//! Tissue that relaxes: what its image holds, what `info` says of it, and what is refused.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::{Band, Branch, DEVICE_HZ, Moduli, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, Cuttable, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme, contact};
use chaincell_host::mesh::load;
use chaincell_kernel::image::{BRANCHES_MAX, branch, kind};
use chaincell_kernel::{Choice, Model, ModelError, Network};
use chaincell_tests::files::{bake as bake_file, scratch, text};
use chaincell_tests::forge::Forged;
use chaincell_tests::run;

const SPEC: &str = "box:5x5x4x0.01";
const CELLS: usize = 5 * 5 * 4;

fn options(branches: &[(f64, f64)]) -> BakeOptions {
    let branches = branches.iter().map(|&(ratio, time_s)| Branch { ratio, time_s }).collect();
    let relaxation = Some(Relaxation { branches, is_instant: false, device_hz: DEVICE_HZ });
    let tissue = Tissue::new(PerCell::Uniform(1000.0), PerCell::Uniform(0.45));
    BakeOptions { tissue: Some(Tissue { relaxation, ..tissue }), ..BakeOptions::default() }
}

/// The section, number by number.
#[test]
fn the_section_holds_shares_times_and_what_fades() {
    let mesh = load(SPEC, &Default::default()).unwrap();
    let options = options(&[(1.5, 60.0), (0.5, 0.02)]);
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let numbers: Vec<[f32; branch::WORDS]> = Forged::of(image.as_bytes()).get(kind::BRANCHES);
    assert_eq!(numbers.len(), 2);
    for (numbers, (ratio, time)) in numbers.iter().zip([(0.5, 20.0_f64), (1.5, 6e4)]) {
        assert_eq!(numbers[..branch::FADED], [(ratio / 3.0) as f32, time as f32, 1e-3]);
        for (power, faded) in numbers[branch::FADED..].iter().enumerate() {
            let left = (-f64::from(1 << power) / time).exp();
            let exact = 1.0 - left;
            assert!((f64::from(*faded) / exact - 1.0).abs() < 1e-7, "{faded} {exact}");
        }
    }
}

/// Materials of groups keep the branches; each its own modulus in the end.
#[test]
fn cells_of_other_moduli_relax_alike() {
    let mesh = load(SPEC, &Default::default()).unwrap();
    let young: Vec<f64> = (0..mesh.nodes_m.len()).map(|at| 500.0 + 10.0 * at as f64).collect();
    let poisson: Vec<f64> = (0..young.len()).map(|at| 0.3 + 0.001 * at as f64).collect();
    let mut options = options(&[(2.0, 0.1)]);
    let tissue = options.tissue.as_mut().unwrap();
    tissue.young_pa = PerCell::Each(young.clone());
    tissue.poisson = PerCell::Each(poisson.clone());
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    for (node, (young_pa, poisson)) in young.into_iter().zip(poisson).enumerate() {
        let cell = usize::from(model.cell_of_input(node as u32).unwrap());
        let [instant_pa, read] = model.elasticity(cell).unwrap().map(f64::from);
        let moduli = Moduli { young_pa: instant_pa, poisson: read }.long_term(2.0 / 3.0);
        assert!((moduli.young_pa / young_pa - 1.0).abs() < 1e-4, "{node}: {moduli:?}");
        assert!((read - poisson).abs() < 1e-5, "{node}: {read}");
    }
}

#[test]
fn what_does_not_relax_is_refused_by_name() {
    let mesh = load(SPEC, &Default::default()).unwrap();
    let mut bands = options(&[(1.0, 1.0)]);
    bands.tissue.as_mut().unwrap().stiffening = vec![Band::new(0.1, 1e4)];
    assert!(bake(&mesh, &mesh.default_fixed, &bands).is_ok());
    let good = || options(&[(1.0, 1.0)]);
    for (options, parts) in [
        (
            BakeOptions { cuttable: Some(Cuttable::default()), ..good() },
            ["`branches` with `cuttable`", "leave one out"],
        ),
        (BakeOptions { lean: true, ..good() }, ["`lean` with `young_pa`", "leave one out"]),
        (BakeOptions { cells: Some(20), ..good() }, ["`cells` with `young_pa`", "leave one out"]),
    ] {
        let why = bake(&mesh, &mesh.default_fixed, &options).unwrap_err().to_string();
        assert!(parts.iter().all(|part| why.contains(part)), "{why}");
    }
    // The schemes and the numbers in which a body of shapes moves.
    let image = bake(&mesh, &mesh.default_fixed, &good()).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let held = contact::automatic(&model).unwrap();
    for &scheme in Scheme::ALL {
        for &numbers in Arithmetic::ALL {
            let network = Network::new(model, scheme.settings(&model, 4)).unwrap();
            let engine =
                Engine::with_contact(network, scheme, numbers, Contact::Cells(held.clone()));
            let is_static = matches!(scheme, Scheme::Track | Scheme::Predict);
            if is_static && numbers == Arithmetic::F32 {
                assert!(engine.is_ok());
                continue;
            }
            let why = engine.err().unwrap().to_string();
            assert!(why.contains("`precision`"), "{why}");
        }
    }
}

/// Branches that contradict each other, in an image that no bake writes.
// REQ-MOD-02
#[test]
fn errors_name_what_is_wrong_with_branches() {
    let mesh = load(SPEC, &Default::default()).unwrap();
    let options = options(&[(1.0, 0.1), (1.0, 5.0)]);
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let error = |change: &dyn Fn(&mut Vec<[f32; branch::WORDS]>)| {
        let mut forged = Forged::of(image.as_bytes());
        forged.change(kind::BRANCHES, |of| change(of));
        Model::from_bytes(forged.sealed().as_bytes()).unwrap_err()
    };
    assert_eq!(error(&|of| of.clear()), ModelError::SectionSize(kind::BRANCHES));
    let more = error(&|of| of.resize(BRANCHES_MAX + 1, of[0]));
    assert_eq!(more, ModelError::SectionSize(kind::BRANCHES));
    assert_eq!(error(&|of| of.reverse()), ModelError::Value(kind::BRANCHES, 1));
    for word in 0..branch::WORDS {
        for value in [f32::NAN, -1.0, f32::INFINITY, 0.0] {
            let why = error(&|of| of[1][word] = value);
            assert_eq!(why, ModelError::Value(kind::BRANCHES, 1), "{word} {value}");
        }
    }
}

#[test]
fn info_shows_branches_and_moduli() {
    let folder = scratch();
    let asked = ["--young-pa", "1000", "--branch", "2,0.1", "--branch", "1,4"];
    let model = bake_file(folder.path(), SPEC, &asked);
    let said = run(["info", text(&model), "--json"]).with(0);
    let report = said.json();
    let of = &report["relaxation"];
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    // G = 3, nu = 0.45: lambda is 36 long-term shear moduli, nu in the end 36 / 74.
    let (poisson, instant_pa) = (36.0 / 74.0, 4.0 * 1000.0 * 1.45 / (1.0 + 36.0 / 74.0));
    for (value, wanted) in [
        (&report["young_pa"], instant_pa),
        (&report["poisson"], 0.45),
        (&of["long_term_young_pa"], 1000.0),
        (&of["long_term_poisson"], poisson),
        (&of["tick_s"], 1e-3),
        (&of["branches"][0]["ratio"], 2.0),
        (&of["branches"][0]["share"], 0.5),
        (&of["branches"][1]["time_s"], 4.0),
    ] {
        assert!((number(value) / wanted - 1.0).abs() < 1e-4, "{value} {wanted}");
    }
    // Whole groups of eight cells, and a clock.
    let groups = CELLS.next_multiple_of(8) * (2 * 36 + 40);
    assert!((groups..groups + 100).contains(&(number(&of["ram_bytes"]) as usize)), "{of}");
    let said = run(["info", text(&model)]).with(0).out;
    for part in
        ["3902 Pa, Poisson's ratio 0.450", "1000 Pa, Poisson's ratio 0.486", "50.0 % of", "in 4 s"]
    {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(report.get("ram_bytes_euler").is_none(), "{report}");
    // Links have a stiffness.
    let links = bake_file(folder.path(), SPEC, &["--branch", "2,0.1", "--branch", "1,4"]);
    let said = run(["info", text(&links)]).with(0).out;
    // Schemes that refuse links that relax have no row.
    for (scheme, is_listed) in [("predict", true), ("euler", false), ("rkl2", false)] {
        assert_eq!(said.contains(&format!("bytes ({scheme})")), is_listed, "{scheme}: {said}");
    }
    for part in ["stiffness     80 N/m", "25.0 % of the first stiffness", "50.0 % of", "in 4 s"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let elastic = bake_file(folder.path(), SPEC, &["--young-pa", "1000"]);
    assert!(!run(["info", text(&elastic), "--json"]).with(0).out.contains("relaxation"));
}

/// Refusals of the command name options and remedies; a session with other ticks is one.
#[test]
fn the_command_refuses_by_option() {
    let folder = scratch();
    let out = folder.path().join("none.chaincell");
    let young = "--young-pa=1000";
    for (options, part) in [
        (&["--branch=1,1", "--lean"][..], "--lean with --branch"),
        (&["--branch=1,1", "--cells=9"], "--cells with --branch"),
        (&["--branch=1,1", "--cuttable"], "--cuttable with --branch"),
        (&["--instant"], "--branch"),
        (&[young, "--instant"], "--branch"),
        (&[young, "--branch=1"], "give G,TAU"),
        (&[young, "--branch=-1,1"], "--branch -1,1"),
        (&[young, "--branch=1,2000"], "from 0.001 to 1600 s"),
        (&[young, "--branch=1,1", "--cuttable"], "--branch with --cuttable"),
        (&[young, "--branch=1,1", "--device-hz=9"], "from 10 to 100000"),
    ] {
        let why = run([&["bake", SPEC, "-o", text(&out)], options].concat()).with(2).err;
        assert!(why.contains(part), "{options:?}: {why}");
    }
    assert!(!out.exists());
    // A model for 500 ticks a second.
    let model = bake_file(folder.path(), SPEC, &[young, "--branch=1,1", "--device-hz=500"]);
    let session = folder.path().join("session");
    let motion = ["--motion=press", "--seconds=0.1", "--picture=off", "--out", text(&session)];
    for (command, options) in
        [("run", &motion[..]), ("serve", &[]), ("latency", &[]), ("view", &[])]
    {
        let why = run([&[command, text(&model)], options].concat()).with(2).err;
        for part in ["1000 ticks a second", "baked for 500", "--device-hz 500"] {
            assert!(why.contains(part), "{command}: {why}");
        }
    }
    let asked = ["run", text(&model), "--device-hz=500", "--snapshot-ticks=40", "--json"];
    let found = run([&asked[..], &motion[..]].concat()).with(0).json();
    assert_eq!(found["ticks"], 50, "a tenth of a second");
    let read = |name: &str| std::fs::read_to_string(session.join(name)).unwrap();
    assert!(read("force.svg").contains("time at 500 Hz [s]"));
    assert!(read("series.pvd").contains("timestep=\"0.08\""));
    let why = run(["serve", text(&model), "--device-hz=5000"]).with(2).err;
    assert!(why.contains("--device-hz 5000") && why.contains("--max-pose-hz 10000"), "{why}");
    let why = run(["cosim", text(&model), "--device-hz=500"]).with(2).err;
    assert!(why.contains("--device-hz 500") && why.contains("sends 1000 poses a second"), "{why}");
    let why = run(["cosim", text(&model)]).with(2).err;
    assert!(
        why.contains("not baked for the 1000 poses") && why.contains("without --device-hz"),
        "{why}"
    );
    run(["replay", text(&session)]).with(0);
    // Bands are said to stay elastic.
    let bands = [young, "--branch=1,1", "--stiffening=0.1=5000"];
    let said = run([&["bake", SPEC, "-o", text(&out)], &bands[..]].concat()).with(0).err;
    assert!(said.contains("do not relax"), "{said}");
}
