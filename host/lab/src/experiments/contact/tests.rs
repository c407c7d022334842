use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, PerCell, ProbeContact, bake};
use chaincell_host::engine::Contact;
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::ToolPart;

use super::*;

/// A sphere of half an edge and one of an edge, where the bar is 30 %.
#[test]
fn small_spheres_feel_about_the_force_of_finite_elements() {
    let body = Slab::new(EDGES_M[0], SEED).unwrap();
    for (sphere_m, place) in [(0.004, 1), (0.008, 3)] {
        let depths_m = [0.25 * sphere_m, 0.5 * sphere_m];
        let elements = sphere_m / ELEMENTS;
        let reference =
            indentation::press(&slab(Law::NeoHooke), sphere_m, elements, &depths_m).unwrap();
        let found = forces(&body, sphere_m, body.places_m[place], &depths_m).unwrap();
        for (force, press) in found.iter().zip(&reference) {
            let ratio = force / press.force_n;
            assert!((ratio - 1.0).abs() < 0.3, "{ratio} at {} m", press.depth_m);
        }
    }
}

/// Depths count from where the sphere first touches.
#[test]
fn forces_begin_at_the_top() {
    let body = Slab::new(EDGES_M[0], SEED).unwrap();
    let found = forces(&body, 0.008, body.places_m[0], &[1e-5, 1e-3]).unwrap();
    assert!(found[0] < 2e-3 * found[1] && found[1] > 0.01, "{found:?}");
}

#[test]
fn bars_count_the_judged_depths_alone() {
    let row = |sphere_m, ratios: [f64; 4]| Row {
        sphere_m,
        edge_m: 0.005,
        ratios: ratios.map(|ratio| vec![1.0, ratio]).into(),
    };
    let rows = [row(0.012, [2.0, 1.07, 0.95, 1.0]), row(0.006, [1.0, 1.0, 1.31, 1.0])];
    let bars = bars(&rows);
    assert_eq!(bars.iter().map(|bar| bar.holds()).collect::<Vec<_>>(), [true, false, true]);
    assert!((bars[0].worst - 0.07).abs() < 1e-12 && bars[2].worst == 0.0);
}

/// What a budget leaves under load: one sweep a tick, under a tool that moves.
#[test]
fn one_sweep_holds_the_force_of_a_moving_tool() {
    let tissue = Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(POISSON));
    let probe_contact = ProbeContact::Surface;
    let options = BakeOptions { tissue: Some(tissue), probe_contact, ..BakeOptions::default() };
    let mesh = load("organ:600", &MeshOptions::default()).unwrap();
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    for way in [(0.043, 0.0, 1000), (0.02, 0.0, 500)] {
        let tools = vec![vec![ToolPart::sphere(0.012)]];
        let contact = Contact::Tools { tools, friction: 0.0 };
        let moving = Moving::press(&image, contact, way, 24).unwrap();
        let (one, two) = (moving.row(1).unwrap(), moving.row(2).unwrap());
        println!("{way:?}: {:.3} N, {one:?}, {two:?}", moving.peak_n());
        assert!(one.median < 0.02 && one.p90 < 0.10, "{way:?}: {one:?}");
        assert!(two.median < 0.005 && two.p90 < 0.03, "{way:?}: {two:?}");
    }
}
