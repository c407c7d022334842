//! At the limits: the energy bound, saturation under a held cell, units beyond single precision.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::mesh::load;
use chaincell_kernel::{Flags, Model, Network, Settings, TickOutput, ToolPose};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_tests::graph::kinds;
use nalgebra::Vector3;

/// The middle of the plane.
const CENTRE: u32 = 40;

fn plane(options: &BakeOptions) -> ImageBytes {
    let mesh = load("plane:9x9x0.01", &Default::default()).unwrap();
    bake(&mesh, &mesh.border, options).unwrap()
}

/// Moves a node up by a number of metres a tick, holds it there, then moves it back at once.
fn moved(
    image: &ImageBytes,
    node: u32,
    scheme: Scheme,
    settings: impl Fn(Settings) -> Settings,
    heights_m: impl Iterator<Item = f32>,
) -> Vec<TickOutput> {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let network = Network::new(model, settings(Settings::for_model(&model))).unwrap();
    let held = model.cell_of_input(node).unwrap();
    let mut engine = Engine::new(network, scheme, &[held]).unwrap();
    heights_m.map(|z| engine.tick(&ToolPose::at(Vector3::new(0.0, 0.0, z), 1))).collect()
}

/// The bound stops the tool on its way out and lets it come back.
// REQ-ENE-04
#[test]
fn the_energy_bound_never_locks_the_tool() {
    let energy_max_j = 0.0005;
    let options = BakeOptions { energy_max_j: Some(energy_max_j), ..BakeOptions::default() };
    let out = (0..2000_u16).map(|i| 0.002 * f32::from(i.min(100)));
    // The middle of the top of the box.
    let bodies = [("plane:9x9x0.01", CENTRE), ("box:5x5x3x0.01", 38), ("box:5x5x3x0.01", 38)];
    let [links, shapes] = kinds(&options);
    for ((spec, node), options) in bodies.into_iter().zip([links.clone(), links, shapes]) {
        let image = Shape::generated(spec).unwrap().bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        for Variant { scheme, .. } in Variant::singles_of(&model) {
            let back = std::iter::repeat_n(0.0, 400);
            let answers = moved(&image, node, scheme, |settings| settings, out.clone().chain(back));
            let bound = energy_max_j as f32 * 1.0001;
            assert!(answers.iter().all(|answer| answer.energy_j <= bound));
            assert!(answers[1999].flags.contains(Flags::MOTION_CLAMPED), "{:?}", answers[1999]);
            let (far, home) = (answers[1999].force_n.z.abs(), answers[2399].force_n.z.abs());
            assert!(home < 0.05 * far, "{spec} {scheme:?}: {far} N out, {home} N at the origin");
        }
    }
}

/// With a leak of 1 the free cells return into the range in one step; a held one stays beyond.
// REQ-ENE-08
#[test]
fn euler_clamps_a_held_cell_beyond_saturation_at_every_step() {
    let image = plane(&BakeOptions {
        saturation_m: Some(0.08),
        resistance: 0.25,
        energy_max_j: Some(1e6),
        ..BakeOptions::default()
    });
    let rise = |_| (0..2000_u16).map(|i| 0.001 * f32::from(i.min(200)));
    let last = [0.25, 0.2499].map(|step| {
        let settings = |settings| Settings { step, ..settings };
        *moved(&image, CENTRE, Scheme::Euler, settings, rise(())).last().unwrap()
    });
    let track =
        *moved(&image, CENTRE, Scheme::Track, |settings| settings, rise(())).last().unwrap();
    for euler in last {
        let off = (euler.force_n.z - track.force_n.z).abs() / track.force_n.z.abs();
        assert!(off < 0.01, "euler {} N, track {} N", euler.force_n.z, track.force_n.z);
    }
}

// REQ-MOD-05
#[test]
fn units_beyond_single_precision_are_refused() {
    let mesh = load("plane:3x3x0.01", &Default::default()).unwrap();
    let refused =
        |options: BakeOptions| bake(&mesh, &mesh.border, &options).unwrap_err().to_string();
    let stiff = BakeOptions { stiffness_n_per_m: PerCell::Uniform(1e35), ..BakeOptions::default() };
    assert!(refused(stiff).starts_with("`stiffness_n_per_m`"));
    let slow = BakeOptions { capacitance: 3e38, ..BakeOptions::default() };
    assert!(refused(slow).starts_with("`capacitance`"));
    let leaky = BakeOptions { resistance: 1e-30, ..BakeOptions::default() };
    assert!(refused(leaky).starts_with("`resistance`"));
}
