//! The contact's force under a sphere beside that of finite elements.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

use chaincell_host::bake::ImageBytes;
use chaincell_host::engine::{Contact, Scheme};
use chaincell_kernel::{Flags, ToolPose};
use chaincell_tests::bodies::{nodal, under};

/// Forces of a rigid sphere without friction on a round slab, 50 mm in radius and 40 mm high, of 5
/// kPa and Poisson's ratio 0.45, its bottom held: axisymmetric quadratic elements, neo-Hookean, of
/// 1.25 mm and at most an eighth of the sphere's radius.
const CURVES: &str = include_str!("sphere.csv");

/// About as wide and as high, a node in the middle of its top.
const SLAB: &str = "box:15x15x7x0.0066666667";
const HEIGHT_M: f64 = 0.04;
/// The force settles when it changes by less than this part of itself in this number of ticks.
const STILL: f64 = 5e-4;
const LOOK: usize = 10;

fn slab() -> ImageBytes {
    nodal(SLAB, 5000.0)
}

/// Settled force along the way back at rising depths, the sphere so far aside of the middle \[N\].
fn forces(image: &ImageBytes, radius_m: f64, aside_m: f64, depths_m: &[f64]) -> Vec<f64> {
    let contact = Contact::sphere(radius_m as f32, 0.0);
    let mut engine = under(image, contact, (Scheme::Track, 32), radius_m as f32).unwrap();
    let mut tick = |depth_m: f64| {
        let position_m = [aside_m, aside_m, HEIGHT_M + radius_m - depth_m].map(|x| x as f32);
        engine.tick(&ToolPose::at(position_m.into(), 1))
    };
    tick(-radius_m);
    let mut settled = |&depth_m: &f64| {
        let mut before = f64::INFINITY;
        for _ in 0..60 {
            let output = (1..LOOK).fold(tick(depth_m), |_, _| tick(depth_m));
            let force = f64::from(output.force_n.z);
            let clamped = output.flags.contains(Flags::MOTION_CLAMPED);
            if !clamped && (force - before).abs() <= STILL * force.abs() {
                return force;
            }
            before = force;
        }
        panic!("no settled force at {depth_m} m under a sphere of {radius_m} m")
    };
    depths_m.iter().map(&mut settled).collect()
}

/// Spheres of half an edge to two edges, over a node and over the middle of an edge, where the bar
/// is 30 %; what touches lightly says nothing of a sphere smaller than an edge.
#[test]
fn the_force_under_a_sphere_is_about_that_of_finite_elements() {
    let rows: Vec<[f64; 3]> = (CURVES.lines().skip(1))
        .map(|line| {
            let mut fields = line.split(',').map(|field| field.parse().unwrap());
            [(); 3].map(|()| fields.next().unwrap())
        })
        .collect();
    let image = slab();
    for sphere_m in [0.004, 0.008, 0.016] {
        let judged = |row: &&[f64; 3]| row[0] == sphere_m && row[1] > 0.24 * sphere_m;
        let judged: Vec<&[f64; 3]> = rows.iter().filter(judged).collect();
        let depths_m: Vec<f64> = judged.iter().map(|row| row[1]).collect();
        assert_eq!(depths_m.len(), 3);
        for aside_m in [0.0, HEIGHT_M / 12.0] {
            let found = forces(&image, sphere_m, aside_m, &depths_m);
            for (force, [_, depth_m, expected]) in found.iter().zip(&judged) {
                let ratio = force / expected;
                println!("{sphere_m} m, {aside_m} m aside, {depth_m} m deep: {ratio:.3}");
                assert!((ratio - 1.0).abs() < 0.3, "{ratio} at {depth_m} m under {sphere_m} m");
            }
        }
    }
}

/// Depths count from where the sphere first touches.
#[test]
fn forces_begin_at_the_top() {
    let found = forces(&slab(), 0.008, 0.0, &[1e-5, 1e-3]);
    assert!(found[0] < 2e-3 * found[1] && found[1] > 0.01, "{found:?}");
}
