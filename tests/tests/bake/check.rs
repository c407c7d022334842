//! `chaincell check`: its estimate of the mesh's error beside quadratic elements, and what it refuses.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, PerCell, bake as baked};
use chaincell_host::engine::Contact;
use chaincell_host::engine::mesh_error::{Pressed, free_volumes_m3, place_error};
use chaincell_host::engine::place::places;
use chaincell_host::mesh::{MeshOptions, Refined, load};
use chaincell_kernel::Model;
use chaincell_tests::files::{bake, scratch, text};
use chaincell_tests::run;

/// A mesh of the reference data with a patch of nodes pushed by 1 mm, and its true errors: the distance of nodal shapes
/// on it, in force and field, to quadratic elements on the mesh cut once.
struct Case {
    mesh: &'static str,
    patch: &'static str,
    direction: &'static str,
    /// Poisson's ratio, force and field.
    errors: [[f64; 3]; 2],
}

const CASES: [Case; 2] = [
    Case {
        mesh: "liver_181",
        patch: "nodes:120,123,124,125,126,131,132,133",
        direction: "0.13245715,-0.28792116,-0.94844953",
        errors: [[0.3, 0.157, 0.117], [0.45, 0.168, 0.166]],
    },
    Case {
        mesh: "liver_500",
        patch: "nodes:72,104,116,118,138,142,150",
        direction: "0.25023956,-0.07487656,-0.96528424",
        errors: [[0.3, 0.080, 0.113], [0.45, 0.079, 0.120]],
    },
];

#[test]
fn the_estimate_is_within_a_factor_of_quadratic_elements_on_the_cut_mesh() {
    let Ok(folder) = std::env::var("CHAINCELL_REFERENCE") else {
        println!("SKIPPED check beside quadratic elements: CHAINCELL_REFERENCE is not set");
        return;
    };
    // The larger mesh takes a minute.
    let cases = if std::env::var_os("CHAINCELL_SLOW").is_some() { 2 } else { 1 };
    for case in &CASES[..cases] {
        let mesh = format!("{folder}/meshes/{}.vtk", case.mesh);
        let fixed = format!("file:{folder}/meshes/{}.sets.json#fixed", case.mesh);
        for [poisson, force, field] in case.errors {
            let report = run([
                &["check", &mesh, "--fix", &fixed, "--young-pa", "5000"][..],
                &["--poisson", &poisson.to_string(), "--hold", case.patch],
                &["--direction", case.direction, "--depth-m", "0.001", "--json"],
            ]
            .concat())
            .with(0)
            .json();
            let ratios = [("force_error", force), ("field_error", field)]
                .map(|(name, truth)| report[name].as_f64().unwrap() / truth);
            println!("{} {poisson}: estimate / truth {ratios:.2?}", case.mesh);
            assert!(ratios.iter().all(|of| (1.0 / 1.3..1.3).contains(of)), "{ratios:?}");
        }
    }
}

/// A block of 48 nodes 8 mm apart under balls, half their radius deep, beside the same press on the mesh cut
/// three times.
#[test]
fn the_estimate_under_a_ball_is_a_third_to_twice_the_distance_to_a_mesh_cut_three_times() {
    if std::env::var_os("CHAINCELL_SLOW").is_none() {
        println!("SKIPPED check beside a mesh cut three times: CHAINCELL_SLOW is not set");
        return;
    }
    // The meshes, each the cut one of that before it.
    const EDGE_M: f64 = 0.008;
    let mut mesh = load(&format!("box:4x4x3x{EDGE_M}"), &MeshOptions::default()).unwrap();
    let mut fixed = mesh.default_fixed.clone();
    let volumes_m3 = free_volumes_m3(&mesh, &fixed);
    let tissue = Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45));
    let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
    let mut images = vec![baked(&mesh, &fixed, &options).unwrap()];
    for _ in 0..3 {
        let refined = Refined::of(&mesh).unwrap();
        fixed = refined.with_middles(&mesh, &fixed);
        mesh = refined.mesh;
        images.push(baked(&mesh, &fixed, &options).unwrap());
    }
    let models = images.iter().map(|image| Model::from_bytes(image.as_bytes()).unwrap());
    let models: Vec<_> = models.collect();
    // Estimate and truth at three places.
    for edges in [0.5, 1.0, 2.0] {
        let radius_m = edges * EDGE_M;
        let contact = Contact::sphere(radius_m as f32, 0.0);
        let body = |cuts: usize| Pressed { model: models[cuts], contact: &contact };
        for place in places(&models[0], &contact, None, 3).unwrap() {
            let [estimate, truth] = [1, 3].map(|cuts| {
                place_error([body(0), body(cuts)], &place, 0.5 * radius_m, &volumes_m3).unwrap()
            });
            println!(
                "radius of {edges} edges at {:.4?} m: force {:.5} N of {:.5}, estimate {:.3}, truth {:.3}",
                place.touch_m,
                truth.force_n,
                truth.finer_force_n,
                estimate.force_error,
                truth.force_error
            );
            let ratio = estimate.force_error / truth.force_error;
            assert!((0.33..2.0).contains(&ratio), "{ratio}");
        }
    }
}

/// A tool presses at three places; a finer mesh of the same body is nearer to its own cut one.
#[test]
fn finer_meshes_have_smaller_errors_under_a_tool() {
    let errors = ["box:4x4x3x0.02", "box:7x7x5x0.01"].map(|spec| {
        let words =
            ["check", spec, "--young-pa", "5000", "--tool", "sphere:0.03", "--depth-m", "0.008"];
        let report = run([&words[..], &["--json"]].concat()).with(0).json();
        assert_eq!(report["places"].as_array().unwrap().len(), 3);
        assert!(report["solver"]["force_error"]["p99"].as_f64().unwrap() < 1.0);
        // The first place is a corner.
        report["places"][1]["force_error"].as_f64().unwrap()
    });
    let [coarse, fine] = errors;
    assert!(fine < 0.7 * coarse && fine > 0.0, "{errors:?}");
    let said = run(["check", "box:4x4x3x0.02", "--young-pa", "5000", "--sweeps", "2"]).with(0).out;
    for part in ["from the mesh", "halve it where", "at 2 sweeps"] {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn what_cannot_be_checked_is_refused_with_a_remedy() {
    let refused = |words: &[&str], part: &str| {
        let said = run([&["check"], words].concat()).with(2).err;
        assert!(said.contains(part), "{said}");
    };
    refused(&["box:4x4x3x0.01"], "--young-pa");
    refused(&["plane:5x5x0.01", "--young-pa", "5000"], "tetrahedra");
    refused(&["box:4x4x3x0.01", "--young-pa", "5000", "--cells", "20"], "--cells");
    refused(&["box:4x4x3x0.01", "--young-pa", "5000", "--tool", "blade:0.01"], "blade");
    refused(&["box:4x4x3x0.01", "--young-pa", "5000", "--depth-m", "0"], "--depth-m");
    let block = ["box:4x4x3x0.01", "--young-pa", "5000"];
    let of_block = |words: &[&str], part: &str| refused(&[&block, words].concat(), part);
    of_block(&["--hold", "box:-1,1,-1,1,-1,0.001"], "--hold: node 0 is fixed");
    of_block(&["--hold", "nodes:47"], "hold a patch");
    of_block(&["--fix", "none"], "give --fix");
    of_block(&["--branch", "1,0.1"], "--branch");
    of_block(&["--sweeps", "64"], "63");
    of_block(&["--cuttable", "--cut-spare", "-3"], "--cut-spare");
    of_block(&["--tool", "sphere:1e-7"], "--tool");
    // Between the fixed bottom and the held top no node is left.
    refused(
        &["box:3x3x2x0.01", "--young-pa", "5000", "--hold", "box:-1,1,-1,1,0.009,1"],
        "finer mesh",
    );
    refused(&["box:4x4x3x0.01", "--young-pa", "5000", "--hold", "nodes:999"], "--hold");
    let folder = scratch();
    let baked = bake(folder.path(), "box:4x4x3x0.01", &["--young-pa", "5000"]);
    refused(&[text(&baked), "--young-pa", "5000"], "give the mesh it was baked from");
}
