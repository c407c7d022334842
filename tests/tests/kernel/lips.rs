//! Sides of a cut that press on each other.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BasisSpacing, ImageBytes, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{Predict, Track};

use super::cutting::{Body, centre, faces, network, options};

/// A bar of 40 x 20 x 20 mm, held at both ends.
struct Bar {
    mesh: Mesh,
    image: ImageBytes,
    end: Vec<u32>,
    /// Faces along an oblique cut through half its height.
    open: Vec<(usize, usize)>,
}

fn bar(mesh: &str) -> Bar {
    let mesh = load(mesh, &MeshOptions::default()).unwrap();
    let at = |x: f64| {
        let nodes = (0..).zip(&mesh.nodes_m).filter(move |(_, place)| (place[0] - x).abs() < 1e-6);
        nodes.map(|(node, _)| node).collect::<Vec<u32>>()
    };
    let (fixed, end) = (at(-0.02), at(0.02));
    assert!(!fixed.is_empty() && !end.is_empty());
    let image = bake(&mesh, &fixed, &options(Some(0.5), BasisSpacing::Links(2.0))).unwrap();
    let middle = mesh.nodes_m.iter().map(|place| place[2]).sum::<f64>() / mesh.nodes_m.len() as f64;
    let side = |tetrahedron: usize| {
        let [x, _, z] = centre(&mesh, tetrahedron);
        (x + 0.5 * (z - middle) > 0.0, z > middle)
    };
    let of_both = faces(&mesh).into_iter().filter(|[(one, _), (other, _)]| {
        let (one, other) = (side(*one), side(*other));
        one.0 != other.0 && one.1 && other.1
    });
    let open = of_both.map(|[one, _]| one).collect();
    Bar { image, end, open, mesh }
}

/// Force along the bar on an end that is moved so far along it, before and after the cut \[N\].
fn forces(bar: &Bar, way_m: f32) -> [f32; 2] {
    let mut body = Body::<Track>::new(network(&bar.image, 4), &bar.end);
    let mut settled = |body: &mut Body<'_, Track>| {
        let output = (0..3000).map(|_| body.tick([way_m, 0.0, 0.0])).last().unwrap();
        output.force_n[0]
    };
    body.tick([0.0; 3]);
    let whole = settled(&mut body);
    for face in &bar.open {
        body.open(*face).unwrap();
    }
    [whole, settled(&mut body)]
}

/// Cut through half its height, a bar is softer if it is pulled, and hardly if it is pressed together.
#[test]
fn sides_carry_each_other_under_pressure() {
    for (mesh, least) in [("box:9x5x5x0.005", 0.85), ("box:13x7x7x0.0033333333", 0.9)] {
        let bar = bar(mesh);
        let [pulled, pressed] = [0.002, -0.002].map(|way_m| {
            let [whole, cut] = forces(&bar, way_m);
            cut / whole
        });
        println!("{mesh}: {pulled:.3} of the force whole if pulled, {pressed:.3} if pressed");
        assert!(pulled < 0.8, "{pulled}");
        assert!((least..1.01).contains(&pressed), "{pressed}");
    }
}

/// Pressed, turned and slid along the cut: the same bits from a snapshot on, with and without vector units.
#[test]
fn pressed_sides_have_the_same_bits_from_a_snapshot_on() {
    let bar = bar("box:9x5x5x0.005");
    let network = network(&bar.image, 2);
    let way = |tick: usize| {
        let share = tick as f32 / 60.0;
        [-0.002 * share, 0.0005 * share, 0.001 * (6.0 * share).sin()]
    };
    let start = |is_scalar: bool| {
        let mut body = Body::<Predict>::new(network, &bar.end);
        if is_scalar {
            body.view().go_scalar();
        }
        body
    };
    let (mut body, mut hashes) = (start(false), Vec::new());
    for face in &bar.open {
        body.open(*face).unwrap();
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
