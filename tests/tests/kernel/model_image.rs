//! The model image: whatever its bytes, it is refused or it is safe to run.
#![allow(clippy::unwrap_used)]

use std::sync::OnceLock;

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::mesh::load;
use chaincell_kernel::image::{HEADER_BYTES, kind, nodal, params};
use chaincell_kernel::number::two_float::LANES;
use chaincell_kernel::{Model, ModelError, Network, Settings, ToolPose};
use chaincell_tests::forge::{resealed, section};
use nalgebra::Vector3;
use proptest::prelude::*;

/// An image with every section there is.
fn image() -> &'static ImageBytes {
    static IMAGE: OnceLock<ImageBytes> = OnceLock::new();
    IMAGE.get_or_init(|| {
        let mesh = load("box:4x4x4x0.01", &Default::default()).unwrap();
        let ramp = |from: f64, to: f64| {
            let n = mesh.nodes_m.len() as f64;
            PerCell::Each(
                (0..mesh.nodes_m.len()).map(|i| from + (to - from) * i as f64 / n).collect(),
            )
        };
        let options = BakeOptions {
            alpha: ramp(0.0, 0.2),
            stiffness_n_per_m: ramp(5.0, 50.0),
            ..BakeOptions::default()
        };
        bake(&mesh, &mesh.default_fixed, &options).unwrap()
    })
}

/// Schemes that take every image of links.
const BOTH: [Scheme; 2] = [Scheme::Euler, Scheme::Track];

/// An image of nodal shapes.
fn shapes() -> &'static ImageBytes {
    static IMAGE: OnceLock<ImageBytes> = OnceLock::new();
    IMAGE.get_or_init(|| {
        let mesh = load("box:4x4x4x0.01", &Default::default()).unwrap();
        let of = PerCell::Uniform;
        let tissue = Some(Tissue::new(of(5000.0), of(0.4)));
        let coarse_basis = BasisSpacing::Links(2.5);
        let options = BakeOptions { tissue, coarse_basis, ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options).unwrap()
    })
}

fn error(bytes: Vec<u8>) -> ModelError {
    Model::from_bytes(resealed(bytes).as_bytes()).unwrap_err()
}

// REQ-MOD-01
#[test]
fn every_flipped_bit_and_every_truncation_is_seen() {
    // The image of shapes is many times as long.
    for (image, step) in [(image(), 1), (shapes(), 97)] {
        let bytes = image.as_bytes();
        for at in (0..bytes.len()).step_by(step) {
            let mut flipped = bytes.to_vec();
            flipped[at] ^= 1 << (at % 8);
            assert!(Model::from_bytes(ImageBytes::copy(&flipped).as_bytes()).is_err(), "byte {at}");
            assert!(Model::from_bytes(ImageBytes::copy(&bytes[..at]).as_bytes()).is_err());
        }
    }
}

// REQ-MOD-02
#[test]
fn errors_name_what_is_wrong() {
    let bytes = image().as_bytes().to_vec();
    let with = |at: usize, value: &[u8]| {
        let mut changed = bytes.clone();
        changed[at..at + value.len()].copy_from_slice(value);
        changed
    };
    let at = |kind: u32, offset: usize| section(&bytes, kind).start + offset;
    let nan = f32::NAN.to_le_bytes();
    assert_eq!(Model::from_bytes(&image().as_bytes()[1..]).unwrap_err(), ModelError::Misaligned);
    assert_eq!(error(with(0, b"X")), ModelError::Magic);
    assert_eq!(error(with(8, &[9])), ModelError::Version(9));
    assert_eq!(error(with(HEADER_BYTES + 4, &[7])), ModelError::SectionVersion(kind::PARAMS));
    assert_eq!(error(with(HEADER_BYTES, &[77])), ModelError::Missing(kind::PARAMS));
    assert_eq!(error(with(at(kind::REST, 8), &nan)), ModelError::Value(kind::REST, 0));
    assert_eq!(
        error(with(at(kind::REST_LENGTH, 4), &nan)),
        ModelError::Value(kind::REST_LENGTH, 1)
    );
    assert_eq!(error(with(at(kind::UPPER, 0), &[0, 0])), ModelError::Index(kind::UPPER, 0));
    assert_eq!(error(with(at(kind::UPPER, 0), &[255, 255])), ModelError::Index(kind::UPPER, 0));
    assert_eq!(error(with(at(kind::MOBILITY, 0), &nan)), ModelError::Value(kind::MOBILITY, 0));
    assert_eq!(
        error(with(at(kind::ALPHA, 8), &1.0_f32.to_le_bytes())),
        ModelError::Value(kind::ALPHA, 2)
    );
    assert_eq!(
        error(with(at(kind::WEIGHT, 0), &(-1.0_f32).to_le_bytes())),
        ModelError::Value(kind::WEIGHT, 0)
    );
    assert_eq!(error(with(at(kind::FIXED, 0), &[255, 255])), ModelError::Index(kind::FIXED, 0));
    assert_eq!(
        error(with(at(kind::TETRAHEDRA, 0), &[255, 255])),
        ModelError::Index(kind::TETRAHEDRA, 0)
    );
    assert_eq!(error(with(at(kind::PARAMS, 0), &[65, 0])), ModelError::SectionSize(kind::REST));
}

// REQ-MOD-02
#[test]
fn errors_name_what_is_wrong_with_shapes() {
    let bytes = shapes().as_bytes().to_vec();
    let with = |kind: u32, number: usize, value: f32| {
        let at = section(&bytes, kind).start + 4 * number;
        let mut changed = bytes.clone();
        changed[at..at + 4].copy_from_slice(&value.to_le_bytes());
        error(changed)
    };
    // Cell 3 and its first half-link, lane by lane.
    let of_cell = |row: usize| LANES * row + 3;
    for (row, value) in [
        (nodal::VOLUME, 0.0),
        (nodal::VOLUME, f32::NAN),
        (nodal::MU, -1.0),
        (nodal::LAMBDA_3, f32::INFINITY),
        (nodal::OWN, 1.0e9),
        (nodal::BOUND, 0.5),
        (nodal::BAND, -1.0),
        (nodal::BAND, f32::NAN),
    ] {
        let why = with(kind::NODAL_CELLS, of_cell(row), value);
        assert_eq!(why, ModelError::Value(kind::NODAL_CELLS, 3), "{row}: {value}");
    }
    for (row, value) in [(nodal::SPREAD, f32::NAN), (nodal::AREA + 1, f32::INFINITY)] {
        let why = with(kind::NODAL_SLOTS, of_cell(row), value);
        assert!(matches!(why, ModelError::Value(kind::NODAL_SLOTS, _)), "{row}: {why}");
    }
    // Half-links of ten numbers, as release 0.2 wrote them.
    let slots = section(&bytes, kind::NODAL_SLOTS).len();
    let mut old = bytes.clone();
    let entry =
        (HEADER_BYTES..).step_by(16).find(|&at| old[at..at + 4] == kind::NODAL_SLOTS.to_le_bytes());
    old[entry.unwrap() + 12..][..4].copy_from_slice(&(slots as u32 / 2).to_le_bytes());
    assert_eq!(error(old).to_string(), "section 40 has the wrong size: bake again");
    // The law 1 of release 0.2, by the sum of the stretches, and one that never was.
    for law in [1, 9] {
        let why = with(kind::NODAL, 0, f32::from_bits(law));
        assert_eq!(why, ModelError::SectionVersion(kind::NODAL));
        assert_eq!(
            why.to_string(),
            "section 38 has an unknown version: bake again with this release"
        );
    }
    assert_eq!(with(kind::NODAL, 1, 2.0), ModelError::Value(kind::NODAL, 1));
    // Without a band its stiffness has to be 0.
    assert_eq!(with(kind::NODAL, 1, 0.0), ModelError::Value(kind::NODAL_CELLS, 0));
    let turns = with(kind::COARSE_TURNS, 0, f32::from_bits(u32::MAX));
    assert_eq!(turns, ModelError::Index(kind::COARSE_TURNS, 0));
    for factor in [0.5, f32::NAN, f32::INFINITY] {
        let why = with(kind::COARSE_FACTORS, 5, factor);
        assert_eq!(why, ModelError::Value(kind::COARSE_FACTORS, 5), "{factor}");
    }
    let inverse = with(kind::COARSE_INVERSE, 1, 3.0);
    assert_eq!(inverse, ModelError::Value(kind::COARSE_INVERSE, 0));
    let bound = with(kind::PARAMS, params::DEGREE_BOUND, 1.0e-3);
    assert_eq!(bound, ModelError::Parameter(params::DEGREE_BOUND as u32));
    let far = with(kind::PARAMS, params::SATURATION, 9.0e5);
    assert_eq!(far, ModelError::Parameter(params::SATURATION as u32));
}

/// The last force of a press.
fn press(image: &ImageBytes, schemes: &[Scheme]) -> Option<f32> {
    let model = Model::from_bytes(image.as_bytes()).ok()?;
    let network = Network::new(model, Settings::for_model(&model)).ok()?;
    let free = (0..model.cells() as u16).rev().find(|&cell| !model.is_fixed(cell))?;
    let mut last = 0.0;
    for &scheme in schemes {
        let mut engine = Engine::new(network, scheme, &[free]).ok()?;
        for tick in 0..20_i16 {
            let position_m = Vector3::new(0.0, 0.0, -0.001 * f32::from(tick));
            last = engine.tick(&ToolPose::at(position_m, 1)).force_n.z;
        }
    }
    Some(last)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(4000) })]

    /// Words changed at random, the checksum made right again: refused, or run without a panic.
    // REQ-MOD-03
    #[test]
    fn changed_words_are_refused_or_harmless(changes in prop::collection::vec(
        (any::<prop::sample::Index>(), prop_oneof![
            any::<u32>(), Just(0), Just(u32::MAX), Just(f32::INFINITY.to_bits()), 0_u32..70,
        ]), 1..4)) {
        let mut bytes = image().as_bytes().to_vec();
        for (index, value) in changes {
            let at = 4 * index.index(bytes.len() / 4);
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        let _ = press(&resealed(bytes), &BOTH);
    }

    /// The same with the numbers of shapes, and every force finite.
    // REQ-MOD-03
    #[test]
    fn changed_shapes_are_refused_or_harmless(changes in prop::collection::vec(
        (any::<bool>(), any::<prop::sample::Index>(), prop_oneof![
            any::<u32>(), (-30_i8..30, any::<bool>()).prop_map(|(power, negative)| {
                let size = 10.0_f32.powi(power.into());
                (if negative { -size } else { size }).to_bits()
            }),
        ]), 1..4)) {
        let mut bytes = shapes().as_bytes().to_vec();
        for (of_cell, index, value) in changes {
            let kind = if of_cell { kind::NODAL_CELLS } else { kind::NODAL_SLOTS };
            let numbers = section(&bytes, kind);
            let at = numbers.start + 4 * index.index(numbers.len() / 4);
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        let force_n = press(&resealed(bytes), &[Scheme::Track]);
        prop_assert!(force_n.is_none_or(f32::is_finite), "{force_n:?}");
    }
}

#[test]
fn the_unchanged_image_runs() {
    assert!(press(image(), &BOTH).unwrap() > 0.0);
    assert!(press(shapes(), &[Scheme::Track]).unwrap() > 0.0);
}
