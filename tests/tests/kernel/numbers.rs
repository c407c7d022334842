//! Number types: how far fixed point is from single precision under the same scheme, and that no
//! sample makes any of them leave its range.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Model, Settings, ToolPose, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::{Step, play};
use chaincell_lab::reference::vectors::farthest;
use chaincell_tests::graph::holds;
use nalgebra::Vector3;
use proptest::prelude::*;

const CENTRE: u32 = 220;
/// Three link lengths in 300 ticks, then held.
const DEPTH_M: f32 = 0.015;
const PRESSING: u16 = 300;
const TICKS: u16 = 2000;

fn plane() -> ImageBytes {
    let options = MeshOptions { diagonals: true, ..MeshOptions::default() };
    let mesh = load("plane:21x21x0.005", &options).unwrap();
    // Only single precision has coarse functions.
    let options = BakeOptions { coarse_basis: BasisSpacing::None, ..BakeOptions::default() };
    bake(&mesh, &mesh.border, &options).unwrap()
}

/// The middle of the block's top.
const TOP: u32 = 71;

/// A block of nodal shapes.
fn block() -> ImageBytes {
    let of = PerCell::Uniform;
    let options =
        BakeOptions { tissue: Some(Tissue::new(of(5000.0), of(0.45))), ..BakeOptions::default() };
    Shape::generated("box:7x5x4x0.005").unwrap().bake(&options).unwrap()
}

fn engine(image: &ImageBytes, node: u32, variant: Variant) -> Engine<'_> {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let centre = Contact::Cells(vec![model.cell_of_input(node).unwrap()]);
    let settings = |settings| Settings { unloading: Unloading::Off, ..settings };
    variant.engine(model, centre, 4, settings).unwrap()
}

/// Positions after the press of a node [m], and the force of every tick \[N\].
fn press(
    (image, node): (&ImageBytes, u32),
    scheme: Scheme,
    numbers: Arithmetic,
) -> (Vec<[f64; 3]>, Vec<f64>) {
    let mut engine = engine(image, node, Variant::plain(scheme, numbers));
    let forces = (1..=TICKS).map(|tick| {
        let depth_m = DEPTH_M * f32::from(tick.min(PRESSING)) / f32::from(PRESSING);
        let sample = ToolPose::at(Vector3::new(0.0, 0.0, -depth_m), 1);
        f64::from(engine.tick(&sample).force_n.norm())
    });
    let forces = forces.collect();
    (engine.positions_m(), forces)
}

/// Largest distance of a cell at the end over the press; difference of the force over the largest
/// force, at the end and at most on the way.
fn difference(
    (at, forces): &(Vec<[f64; 3]>, Vec<f64>),
    (single, single_forces): &(Vec<[f64; 3]>, Vec<f64>),
) -> [f64; 3] {
    let field = farthest(at, single);
    let largest = single_forces.iter().copied().fold(0.0, f64::max);
    let off = || forces.iter().zip(single_forces).map(|(a, b)| (a - b).abs() / largest);
    [field / f64::from(DEPTH_M), off().next_back().unwrap(), off().fold(0.0, f64::max)]
}

#[test]
fn a_press_of_two_thousand_ticks() {
    let options = BakeOptions { coarse_basis: BasisSpacing::None, ..BakeOptions::default() };
    let body = Shape::generated("box:5x5x5x0.015").unwrap().bake(&options).unwrap();
    let plane = plane();
    // The middle of the box's top.
    let (plane, body) = ((&plane, CENTRE), (&body, 64));
    // What track does on the way over the plane hangs on decisions that the last bit may turn.
    for (of, scheme, bounds) in [
        (plane, Scheme::Euler, [1e-5, 1e-5, 2e-5]),
        (plane, Scheme::Track, [1e-4, 1e-3, 5e-2]),
        (body, Scheme::Euler, [1e-4, 1e-3, 2e-3]),
        (body, Scheme::Track, [1e-4, 1e-3, 2e-3]),
    ] {
        let [fixed, single] =
            [Arithmetic::Fixed, Arithmetic::F32].map(|numbers| press(of, scheme, numbers));
        let off = difference(&fixed, &single);
        let [field, end, way] = off;
        println!("{scheme:?}: field {field:.1e}, force {end:.1e}, {way:.1e}");
        assert!(off[0] > 0.0, "{scheme:?}: the numbers made no difference");
        assert!(
            off.iter().zip(bounds).all(|(off, bound)| *off < bound),
            "{off:?}, at most {bounds:?}"
        );
    }
}

/// Any bits that a sample may have, near and far positions more often.
fn any_sample() -> impl Strategy<Value = ToolPose> {
    let number = prop_oneof![
        3 => -0.3_f32..0.3,
        1 => any::<u32>().prop_map(f32::from_bits),
        1 => prop::sample::select(vec![0.0, f32::MAX, f32::MIN, f32::MIN_POSITIVE, f32::NAN]),
    ];
    (prop::array::uniform3(number), prop_oneof![3 => Just(1), 1 => Just(0), 1 => any::<u32>()])
        .prop_map(|([x, y, z], engaged)| ToolPose::at(Vector3::new(x, y, z), engaged))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    /// Built with the checks for overflow on, so that what would wrap panics.
    // REQ-SMP-03
    #[test]
    fn no_sample_leaves_the_range(
        samples in prop::collection::vec(any_sample(), 1..60),
        scheme in prop::sample::select(vec![Scheme::Track, Scheme::Euler]),
        numbers in prop::sample::select(vec![Arithmetic::F32, Arithmetic::Fixed]),
        of_shapes in prop::option::of(prop::sample::select(Variant::of_shapes())),
    ) {
        let (image, node) = if of_shapes.is_some() { (block(), TOP) } else { (plane(), CENTRE) };
        let variant = of_shapes.unwrap_or(Variant::plain(scheme, numbers));
        let steps = samples.iter().map(|sample| Step::of(&[*sample]));
        let new = || Ok(engine(&image, node, variant));
        holds(&play(new, variant.numbers, None, steps).unwrap())?;
    }
}

// REQ-MOD-04
#[test]
fn other_schemes_and_larger_bodies_are_refused() {
    let shape = Shape::generated("plane:60x3x0.01").unwrap();
    let image = shape.bake(&BakeOptions::default()).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let engine = |scheme, numbers| {
        let variant = Variant::plain(scheme, numbers);
        variant.engine(model, Contact::Cells(Vec::new()), 4, |of| of)
    };
    let why = engine(Scheme::Track, Arithmetic::Fixed).err().unwrap();
    assert!(why.to_string().contains("63") && why.to_string().contains("saturation_m"), "{why}");
    let why = engine(Scheme::Rkl2, Arithmetic::Fixed).err().unwrap();
    assert!(why.to_string().contains("euler and track"), "{why}");
}

// REQ-ENE-05, REQ-MOD-04
#[test]
fn shapes_move_under_track_and_predict_in_single_precision_alone() {
    let image = block();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    for variant in Variant::plain_ones() {
        let engine = variant.engine(model, Contact::Cells(Vec::new()), 4, |of| of);
        match engine {
            Ok(_) => assert!(variant.takes_shapes(), "{variant}"),
            Err(why) => {
                assert!(!variant.takes_shapes(), "{variant}: {why}");
                // Beyond the range of fixed point besides.
                let is_fixed = variant.numbers == Arithmetic::Fixed;
                let part = if is_fixed { "take f32" } else { "nodal shapes moves under track" };
                assert!(why.to_string().contains(part), "{why}");
            }
        }
    }
}
