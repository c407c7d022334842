//! Whole trajectories with the vector unit and without it, awake and asleep, on one thread and on two: the same
//! bits, tick by tick.
//!
//! `cargo test --release -p chaincell-tests --test kernel same_bits` checks the fully optimised build.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Scheme};
use chaincell_host::mesh::MeshOptions;
use chaincell_kernel::parts::{PARTS, Parts};
use chaincell_kernel::{Choice, Model, Settings, Unloading, VectorUnit};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::{Step, play};

/// A generated body; planes have diagonals.
fn body(spec: &str) -> Shape {
    let options = MeshOptions { diagonals: spec.starts_with("plane"), ..MeshOptions::default() };
    Shape::generated_with(spec, &options).unwrap()
}

/// A press in one corner direction, a drag across, the way back, then the release.
fn stroke(tick: u16, length_m: f32) -> Step {
    let way = |from: u16, to: u16| f32::from(tick.clamp(from, to) - from) / f32::from(to - from);
    let depth = way(0, 60) - way(100, 140);
    let way = [2.0 * way(60, 100), 0.5 * depth, -3.0 * depth];
    Step::at(way.map(|x| x * length_m), u32::from(tick < 150))
}

/// Plays the stroke on two cells in so few ticks under these schemes.
fn strokes(shape: &Shape, options: &BakeOptions, schemes: &[Scheme], ticks: u16) {
    if VectorUnit::find().is_none() {
        println!("SKIPPED vector unit: this processor has none that the kernel knows");
    }
    let image = shape.bake(options).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let is_coarse = options.coarse_basis != BasisSpacing::None;
    assert!(model.is_sliced() && (model.coarse_functions() > 0) == is_coarse, "{options:?}");
    let free = (0..model.cells() as u16).filter(|&cell| !model.is_fixed(cell));
    let free: Vec<u16> = free.collect();
    let contacts = vec![free[free.len() / 3], free[free.len() / 2]];
    for &scheme in schemes {
        let variant = Variant::plain(scheme, Arithmetic::F32);
        // A super-step takes four sweeps.
        let sweeps = if scheme.goes_by_tick() { 9 } else { 3 };
        let new = || {
            let release = |of| Settings { unloading: Unloading::Release, ..of };
            variant.engine(model, Contact::Cells(contacts.clone()), sweeps, release)
        };
        let steps = (0..ticks).map(|tick| stroke(tick * (200 / ticks), model.unit_m()));
        let monitor = play(new, Arithmetic::F32, None, steps).unwrap();
        let what = format!("{options:?} {scheme:?}");
        assert!(monitor.failures().is_empty(), "{what}: {:?}", monitor.failures());
        assert!(monitor.worst().force_max_n > 1e-3, "{what}: the body hardly moved");
    }
}

// REQ-BIT-02
#[test]
fn trajectories_of_links() {
    for spec in ["plane:21x21x0.01", "organ:500", "box:7x6x5x0.01"] {
        let shape = body(spec);
        for (coarse_basis, alpha) in [
            (BasisSpacing::None, 0.0),
            (BasisSpacing::None, 0.05),
            (BasisSpacing::Links(2.5), 0.0),
            (BasisSpacing::Links(3.0), 0.05),
        ] {
            let alpha = PerCell::Uniform(alpha);
            let options = BakeOptions { alpha, coarse_basis, ..BakeOptions::default() };
            strokes(&shape, &options, Scheme::ALL, 200);
        }
    }
}

/// Tissue by Young's modulus and Poisson's ratio, pressed and let go.
// REQ-BIT-02, REQ-BIT-08
#[test]
fn trajectories_of_nodal_shapes() {
    let of = PerCell::Uniform;
    for (spec, poisson, stretch_min, ticks) in [
        ("organ:500", 0.45, Some(0.95), 200),
        ("box:7x6x5x0.01", 0.0, None, 200),
        ("organ:16800", 0.3, Some(0.7), 12),
    ] {
        let shape = body(spec);
        let tissue = Some(Tissue { stretch_min, ..Tissue::new(of(5000.0), of(poisson)) });
        let (bare, coarse) = (BasisSpacing::None, BasisSpacing::Links(5.0));
        let both = [Scheme::Track, Scheme::Predict];
        for (coarse_basis, schemes) in [(bare, &both[..1]), (coarse, &both[..])] {
            let tissue = tissue.clone();
            let options = BakeOptions { tissue, coarse_basis, ..BakeOptions::default() };
            strokes(&shape, &options, schemes, ticks);
        }
    }
}

/// Bodies of several parts, awake in all of them or in a few.
// REQ-BIT-08
#[test]
fn trajectories_of_large_bodies() {
    let shape = body("organ:16800");
    assert_eq!(Parts::of_links(shape.mesh.nodes_m.len()).count(), PARTS);
    for (coarse_basis, alpha) in [(BasisSpacing::Links(3.5), 0.0), (BasisSpacing::None, 0.05)] {
        let alpha = PerCell::Uniform(alpha);
        let options = BakeOptions { alpha, coarse_basis, ..BakeOptions::default() };
        strokes(&shape, &options, &[Scheme::Track, Scheme::Predict], 40);
    }
}
