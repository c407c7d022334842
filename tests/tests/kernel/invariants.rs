//! What must hold on any graph, whatever the tool does: random bodies of 4 to 40 cells, stiffness
//! over six decades, alpha from 0 to 0.99, pushed, torn and let go.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::{Choice, Flags, Model, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::Monitor;
use chaincell_tests::graph::{Case, body, case, holds, kinds, sample, singles};
use nalgebra::Vector3;
use proptest::prelude::*;

/// Where the tool goes, in metres, some of it far outside the body.
fn moves() -> impl Strategy<Value = Vec<[f32; 3]>> {
    let near = prop::array::uniform3(-0.05_f32..0.05);
    let far = prop::array::uniform3(-20.0_f32..20.0);
    prop::collection::vec(prop_oneof![4 => near, 1 => far], 1..25)
}

/// Bodies of both kinds under every scheme, in single precision.
fn bodies() -> impl Strategy<Value = (Case, Variant)> {
    body(false, singles(Scheme::ALL))
}

fn engine<'m>(
    case: &Case,
    image: &'m ImageBytes,
    variant: Variant,
    unloading: Unloading,
) -> Engine<'m> {
    case.engine(image, variant, unloading).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    /// Left alone the energy never rises, and the published state's energy never exceeds the
    /// certified level, under the tool and after it.
    // REQ-ENE-01, REQ-ENE-03, REQ-FOR-02
    #[test]
    fn energy_never_rises_by_itself((case, variant) in bodies(), moves in moves()) {
        let image = case.image();
        let mut engine = engine(&case, &image, variant, Unloading::Off);
        let mut monitor = Monitor::new(&engine, variant.scheme, variant.numbers);
        monitor.tick(&mut engine, &sample([0.0; 3], 1));
        for position_m in moves {
            monitor.tick(&mut engine, &sample(position_m, 1));
        }
        for _ in 0..50 {
            let output = monitor.tick(&mut engine, &sample([0.0; 3], 0));
            prop_assert_eq!(output.force_n, Vector3::zeros());
            prop_assert_eq!(output.contacts, 0);
        }
        holds(&monitor)?;
    }

    /// Without fixed cells the links' forces cancel: `euler` keeps the centroid.
    #[test]
    fn an_unfixed_body_feels_no_total_force(case in case(true), moves in moves()) {
        // In the linear range, that is: the leak of a saturated cell is an outer force.
        let options = BakeOptions { saturation_m: Some(50.0), ..case.options() };
        let image = case.shape.bake(&options).unwrap();
        let mut engine = engine(&case, &image, Variant::plain(Scheme::Euler, Arithmetic::F32), Unloading::Off);
        engine.tick(&sample([0.0; 3], 1));
        for position_m in moves {
            engine.tick(&sample(position_m, 1));
        }
        let centroid = |engine: &mut Engine<'_>| -> [f64; 3] {
            let positions_m = engine.positions_m();
            let n = positions_m.len() as f64;
            std::array::from_fn(|axis| positions_m.iter().map(|p| p[axis]).sum::<f64>() / n)
        };
        let before = centroid(&mut engine);
        for _ in 0..50 {
            engine.tick(&sample([0.0; 3], 0));
        }
        let after = centroid(&mut engine);
        for axis in 0..3 {
            let drift = (after[axis] - before[axis]).abs();
            prop_assert!(drift < 2e-5 * (0.1 + before[axis].abs()), "drift {drift} m");
        }
    }

    /// The order of the input's nodes is of no consequence.
    #[test]
    fn node_order_does_not_change_the_physics((case, variant) in bodies(), seed in any::<u64>()) {
        let n = case.shape.mesh.nodes_m.len();
        // A permutation that leaves the last node, which the tool holds, in its place.
        let mut to: Vec<usize> = (0..n - 1).collect();
        let mut state = seed | 1;
        for i in (1..n - 1).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            to.swap(i, (state >> 33) as usize % (i + 1));
        }
        to.push(n - 1);
        let other = case.renumbered(&to);
        let forces = [&case, &other].map(|case| {
            let image = case.image();
            let mut engine = engine(case, &image, variant, Unloading::Release);
            engine.tick(&sample([0.0; 3], 1));
            (1..=20).map(|i| engine.tick(&sample([0.001 * i as f32, 0.0, 0.0], 1)).force_n)
                .collect::<Vec<_>>()
        });
        let largest = forces[0].iter().flat_map(|f| f.iter()).fold(0.0_f32, |a, f| a.max(f.abs()));
        for (a, b) in forces[0].iter().zip(&forces[1]) {
            for axis in 0..3 {
                prop_assert!((a[axis] - b[axis]).abs() <= 1e-3 * largest, "{a:?} {b:?}");
            }
        }
    }

    /// Untouched, or held without motion, a body stays as it was to the last bit.
    // REQ-ENE-07
    #[test]
    fn rest_stays_rest((case, variant) in bodies(), engaged in 0_u32..2) {
        let image = case.image();
        let mut engine = engine(&case, &image, variant, Unloading::Release);
        let before = engine.state_hash();
        for _ in 0..200 {
            let output = engine.tick(&sample([0.01, 0.0, 0.0], engaged));
            prop_assert_eq!(output.force_n, Vector3::zeros());
            prop_assert_eq!(output.energy_j.to_bits(), 0);
        }
        prop_assert_eq!(engine.state_hash(), before);
    }

    /// The vector unit gives the bits of the scalar pass, coincident and flattened cells included.
    // REQ-BIT-02
    #[test]
    fn vectors_change_no_bit((case, variant) in bodies(), moves in moves(),
                             flat in any::<bool>(), varied in any::<[bool; 2]>()) {
        let nodes_m = &case.shape.mesh.nodes_m;
        let alphas = |node: usize| case.alpha * (node % 3) as f64 / 3.0;
        let mut options = case.options();
        if varied[0] && case.tissue.is_none() {
            options.alpha = PerCell::Each((0..nodes_m.len()).map(alphas).collect());
        }
        if !varied[1] {
            options.stiffness_n_per_m = PerCell::Uniform(20.0);
        }
        let image = case.shape.bake(&options).unwrap();
        let mut engines = [(); 2].map(|()| engine(&case, &image, variant, Unloading::Release));
        engines[0].go_scalar();
        // The tool drags its cell right onto another one, in a straight line.
        let onto = |axis: usize| (nodes_m[0][axis] - nodes_m[nodes_m.len() - 1][axis]) as f32;
        let mut places = moves;
        if flat {
            places.extend((1..=10_u8).map(|i| {
                [0, 1, 2].map(|axis| onto(axis) * f32::from(i) / 10.0)
            }));
            places.extend([[0, 1, 2].map(onto); 10]);
        }
        for (engaged, place) in [(1, [0.0; 3])].into_iter().chain(places.iter().map(|&p| (1, p)))
            .chain([(0, [0.0; 3]); 5]) {
            let [scalar, vector] =
                engines.each_mut().map(|engine| engine.tick(&sample(place, engaged)));
            prop_assert_eq!(scalar, vector);
            let [scalar, vector] = engines.each_mut().map(|engine| engine.state_hash());
            prop_assert_eq!(scalar, vector);
        }
    }

    /// Leaving sleeping parts out changes no bit: wide bands, small moves, long rests.
    // REQ-BIT-03
    #[test]
    fn sleep_changes_no_bit((case, variant) in bodies(), scalar in any::<bool>(),
                            strokes in prop::collection::vec((0.0_f32..0.03, 1_usize..40, 0_u32..2), 1..12)) {
        let image = case.image();
        let mut engines = [(); 2].map(|()| engine(&case, &image, variant, Unloading::Release));
        engines[0].forbid_sleep();
        if scalar {
            engines[1].go_scalar();
        }
        for (depth, ticks, engaged) in strokes {
            for tick in 0..ticks {
                let place = [depth * tick as f32 / ticks as f32, 0.0, 0.0];
                let [awake, asleep] =
                    engines.each_mut().map(|engine| engine.tick(&sample(place, engaged)));
                prop_assert_eq!(awake, asleep);
                let [awake, asleep] = engines.each_mut().map(|engine| engine.state_hash());
                prop_assert_eq!(awake, asleep);
            }
        }
    }

    /// Saturation: no published coordinate ever leaves the range, the energy rules hold there too,
    /// and the body comes back.
    // REQ-ENE-08
    #[test]
    fn saturation_is_reached_and_left((case, variant) in bodies(),
                                      way in prop::array::uniform3(-1.0_f32..1.0)) {
        let options = BakeOptions { energy_max_j: Some(1e12), ..case.options() };
        let image = case.shape.bake(&options).unwrap();
        let mut engine = engine(&case, &image, variant, Unloading::Off);
        let unit_m = engine.network().model().unit_m();
        let mut monitor = Monitor::new(&engine, variant.scheme, variant.numbers);
        monitor.tick(&mut engine, &sample([0.0; 3], 1));
        for i in 0..120_i16 {
            let far = f32::from(60 - (60 - i).abs()) * 2.0 * unit_m;
            monitor.tick(&mut engine, &sample(way.map(|x| x * far), 1));
        }
        for _ in 0..100 {
            monitor.tick(&mut engine, &sample([0.0; 3], 0));
        }
        holds(&monitor)?;
    }
}

/// A body that the guard had judged stiff, and that slept, moves on as one that lay awake.
#[test]
fn what_is_learnt_of_a_body_outlasts_its_sleep() {
    let shape = Shape::generated("box:2x2x2x0.02").unwrap().holding(&[7]);
    let mut discarded = 0;
    let coarse_basis = BasisSpacing::Links(1.0);
    for options in kinds(&BakeOptions { coarse_basis, ..BakeOptions::default() }) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        for variant in Variant::plain_of(&model) {
            let contact = || Contact::Cells(shape.cells(&model));
            let mut engines = [(); 2]
                .map(|()| variant.engine(model, contact(), variant.sweeps(), |of| of).unwrap());
            engines[0].forbid_sleep();
            for tick in 0..4000_u16 {
                // Moves with a jump, and a long rest after each.
                let (at, engaged) = (tick % 400, u32::from(tick % 400 < 40));
                let z = if at < 2 { 0.0 } else { 0.002 * f32::from(1 + tick / 400) };
                let [awake, asleep] =
                    engines.each_mut().map(|engine| engine.tick(&sample([0.0, 0.0, z], engaged)));
                discarded += u32::from(awake.flags.contains(Flags::ROLLED_BACK));
                assert_eq!(awake, asleep, "{variant}, tick {tick}");
            }
        }
    }
    assert!(discarded > 0);
}

/// 10,000 ticks at rest on the generated organ, without a band: the hash stays.
// REQ-ENE-07
#[test]
fn ten_thousand_ticks_of_rest() {
    let shape = Shape::generated("organ:300").unwrap();
    for options in kinds(&BakeOptions::default()) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        for variant in Variant::plain_of(&model) {
            let contact = Contact::Cells(Vec::new());
            let mut engine = variant.engine(model, contact, variant.sweeps(), |of| of).unwrap();
            let before = engine.state_hash();
            for _ in 0..10_000 {
                let output = engine.tick(&sample([f32::NAN; 3], 7));
                assert_eq!(output.force_n, Vector3::zeros());
                engine.tick(&sample([0.0; 3], 0));
            }
            assert_eq!(engine.state_hash(), before, "{variant}");
        }
    }
}

/// Bad samples: the last good one holds for ten ticks, then force 0 and cells as they are.
// REQ-SMP-01, REQ-SMP-02
#[test]
fn bad_samples_end_in_the_safe_state() {
    let shape = Shape::generated("box:5x5x5x0.01").unwrap().holding(&[124]);
    for options in kinds(&BakeOptions::default()) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let contact = Contact::Cells(shape.cells(&model));
        let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
        let mut engine = variant.engine(model, contact, variant.sweeps(), |of| of).unwrap();
        engine.tick(&sample([0.0; 3], 1));
        engine.tick(&sample([0.0, 0.0, -0.004], 1));
        for bad in [sample([f32::NAN, 0.0, 0.0], 1), sample([0.0; 3], 2)] {
            for _ in 0..10 {
                let output = engine.tick(&bad);
                assert!(output.force_n.z > 0.0 && output.flags == Flags::BAD_SAMPLE, "{output:?}");
            }
            let before = engine.state_hash();
            for _ in 0..5 {
                let output = engine.tick(&bad);
                assert_eq!(output.force_n, Vector3::zeros());
                assert_eq!(output.flags.0, 2 + 16);
                assert_eq!((output.contacts, engine.state_hash()), (1, before));
            }
            let output = engine.tick(&sample([0.0, 0.0, -0.004], 1));
            assert!(output.force_n.z > 0.0 && output.flags.0 == 0);
        }
    }
}
