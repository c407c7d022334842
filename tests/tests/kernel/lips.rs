//! Sides of a cut that press on each other.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::ImageBytes;
use chaincell_host::mesh::Mesh;
use chaincell_kernel::{Predict, Track};

use super::bench::Bench;
use super::cut_bar::{all_across, bar, cut, end, image, made_of};
use super::cutting::network;

/// The end that is moved \[m\].
const END_M: f64 = 0.02;

/// Force along the bar on an end that is moved so far along it, before and after the cut \[N\].
fn forces(mesh: &Mesh, image: &ImageBytes, way_m: f32) -> [f32; 2] {
    let mut body = Bench::<Track>::holding(network(image, 4), &end(mesh, END_M));
    let settled = |body: &mut Bench<'_, Track>| {
        let output = (0..3000).map(|_| body.tick([way_m, 0.0, 0.0])).last().unwrap();
        output.force_n[0]
    };
    body.tick([0.0; 3]);
    let whole = settled(&mut body);
    for face in cut(mesh) {
        body.open(face).unwrap();
    }
    [whole, settled(&mut body)]
}

/// Cut through half its height, a bar is softer if it is pulled, and hardly if it is pressed together.
#[test]
fn sides_carry_each_other_under_pressure() {
    for (edges, least, is_of_links) in [(8, 0.85, false), (12, 0.9, false), (8, 0.85, true)] {
        let bar = bar(edges, 1);
        let image = if is_of_links { made_of(None, &bar) } else { image(&bar, 0.3) };
        let [pulled, pressed] = [0.002, -0.002].map(|way_m| {
            let [whole, cut] = forces(&bar, &image, way_m);
            cut / whole
        });
        println!(
            "{edges} edges, links {is_of_links}: {pulled:.3} of the force whole if pulled, {pressed:.3} if pressed"
        );
        assert!(pulled < 0.8, "{pulled}");
        assert!((least..1.01).contains(&pressed), "{pressed}");
    }
}

/// Two pieces that were drawn apart, pushed through each other and held still: the energy never rises.
#[test]
fn pieces_that_overlap_gain_no_energy() {
    let bar = bar(8, 1);
    for image in [image(&bar, 0.3), made_of(None, &bar)] {
        gain_no_energy(&bar, &image);
    }
}

fn gain_no_energy(bar: &Mesh, image: &ImageBytes) {
    let end = end(bar, END_M);
    let mut body = Bench::<Predict>::holding(network(image, 4), &end);
    for face in all_across(bar) {
        body.open(face).unwrap();
    }
    let way = |body: &mut Bench<'_, Predict>, from: [f32; 3], to: [f32; 3]| {
        let mut at_m = to;
        for tick in 1..=400_u16 {
            let share = f32::from(tick) / 400.0;
            at_m = [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            body.tick(at_m);
        }
        let (mut rises_j, mut before_j) = (0.0, f32::MAX);
        for _ in 0..1000 {
            let energy_j = body.tick(at_m).energy_j;
            rises_j += (energy_j - before_j).max(0.0);
            before_j = energy_j;
        }
        (rises_j, before_j)
    };
    way(&mut body, [0.0; 3], [0.02, 0.0, 0.004]);
    for to in [[-0.004, 0.0, 0.0], [-0.009, 0.002, 0.0], [0.01, 0.0, 0.01], [-0.006, 0.0, 0.004]] {
        let (rises_j, energy_j) = way(&mut body, [0.02, 0.0, 0.004], to);
        println!("at {to:?}: {energy_j} J, {rises_j} J gained at rest");
        assert!(rises_j <= 1e-4 * energy_j, "{rises_j} of {energy_j}");
        way(&mut body, to, [0.02, 0.0, 0.004]);
    }
}

/// Pressed, turned and slid along the cut: the same bits from a snapshot on, with and without vector units.
#[test]
fn pressed_sides_have_the_same_bits_from_a_snapshot_on() {
    let bar = bar(8, 1);
    for image in [image(&bar, 0.3), made_of(None, &bar)] {
        have_the_same_bits(&bar, &image);
    }
}

fn have_the_same_bits(bar: &Mesh, image: &ImageBytes) {
    let end = end(bar, END_M);
    let network = network(image, 2);
    let way = |tick: usize| {
        let share = tick as f32 / 60.0;
        [-0.002 * share, 0.0005 * share, 0.001 * (6.0 * share).sin()]
    };
    let start = |is_scalar: bool| {
        let mut body = Bench::<Predict>::holding(network, &end);
        if is_scalar {
            body.view().go_scalar();
        }
        body
    };
    let (mut body, mut hashes) = (start(false), Vec::new());
    for face in cut(bar) {
        body.open(face).unwrap();
    }
    let mut bytes = Vec::new();
    for tick in 0..60 {
        if tick == 30 {
            bytes = vec![0; body.view().snapshot_bytes(&network).unwrap()];
            body.view().save(&network, &mut bytes).unwrap();
        }
        body.tick(way(tick));
        hashes.push(body.hash());
    }
    assert!(body.cuts().copies > 5, "{:?}", body.cuts());
    for is_scalar in [false, true] {
        let mut other = start(is_scalar);
        other.view().restore(&network, &bytes).unwrap();
        for (tick, hash) in hashes.iter().enumerate().skip(30) {
            other.tick(way(tick));
            assert_eq!(other.hash(), *hash, "tick {tick}");
        }
    }
}
