//! The current drive: loads instead of prescribed positions. Where bodies settle under them, what
//! never rises, and what stays bounded.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::{Drive, Flags, Model, Settings, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::{Monitor, Step, play};
use chaincell_lab::reference::Links;
use chaincell_tests::graph::{body, holds, kinds, sample, shape};
use proptest::prelude::*;

const UNIT_M: f64 = 0.01;

/// A straight chain along x, the first cell fixed unless it floats.
fn chain(stiffness_n_per_m: &[f64], alpha: f64, floats: bool) -> ImageBytes {
    let cells = stiffness_n_per_m.len();
    let nodes_m = (0..cells).map(|i| [UNIT_M * i as f64, 0.0, 0.0]).collect();
    let links = (1..cells as u32).map(|i| [i - 1, i]).collect();
    let options = BakeOptions {
        alpha: PerCell::Uniform(alpha),
        stiffness_n_per_m: PerCell::Each(stiffness_n_per_m.to_vec()),
        // Twice the longest chain's stretch; fixed point reaches up to 63 links.
        saturation_m: Some(0.4),
        energy_max_j: Some(1e3),
        coarse_basis: BasisSpacing::None,
        ..BakeOptions::default()
    };
    shape(nodes_m, links, if floats { vec![] } else { vec![0] }).bake(&options).unwrap()
}

/// An engine whose tool loads these nodes, at once.
fn engine<'m>(
    image: &'m ImageBytes,
    variant: Variant,
    nodes: &[u32],
    change: impl Fn(&mut Settings),
) -> Engine<'m> {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let contact = Shape::default().holding(nodes).cells(&model);
    let loaded = |settings| {
        let mut settings = Settings {
            drive: Drive::Current,
            max_tool_step_m: 1e30,
            unloading: Unloading::Off,
            ..settings
        };
        change(&mut settings);
        settings
    };
    variant.engine(model, Contact::Cells(contact), 4, loaded).unwrap()
}

/// The image of a generated body.
fn image(spec: &str) -> ImageBytes {
    let options = BakeOptions::default();
    Shape::generated(spec).unwrap().bake(&options).unwrap()
}

/// Positions \[m\] by input node.
fn nodes_m(engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
    let ids = engine.network().model().input_id();
    let mut nodes_m = vec![[0.0; 3]; ids.len()];
    for (&id, position) in ids.iter().zip(engine.positions_m()) {
        nodes_m[id as usize] = position;
    }
    nodes_m
}

/// u = `l_max` + 2 I / w for every link of a chain with a load at its end, where the links
/// exert 2 k I against it.
// REQ-FOR-07
#[test]
fn a_loaded_chain_settles_at_the_hand_solution() {
    let current_m = 0.006_f32;
    for stiffness in [&[20.0; 2][..], &[20.0; 5], &[10.0, 30.0, 50.0, 20.0]] {
        for alpha in [0.0, 0.1] {
            let image = chain(stiffness, alpha, false);
            let model = Model::from_bytes(image.as_bytes()).unwrap();
            let mut expected_m = vec![0.0];
            let weight = |i: usize| {
                let mean = 0.5 * (stiffness[i] + stiffness[i + 1]);
                mean / f64::from(model.stiffness_n_per_m())
            };
            for i in 0..stiffness.len() - 1 {
                let length_m = UNIT_M * (1.0 + alpha) + 2.0 * f64::from(current_m) / weight(i);
                expected_m.push(expected_m[i] + length_m);
            }
            let last = stiffness.len() - 1;
            for variant in Variant::plain_ones() {
                let mut engine = engine(&image, variant, &[last as u32], |_| ());
                engine.tick(&sample([0.0; 3], 1));
                let mut output = engine.tick(&sample([current_m, 0.0, 0.0], 1));
                for _ in 0..600 {
                    output = engine.tick(&sample([current_m, 0.0, 0.0], 1));
                }
                let what = format!("{stiffness:?} alpha {alpha} {variant:?}");
                for (at_m, expected_m) in nodes_m(&mut engine).iter().zip(&expected_m) {
                    let off = (at_m[0] - expected_m).abs() + at_m[1].abs() + at_m[2].abs();
                    assert!(off < 2e-4 * UNIT_M, "{what}: {at_m:?}, expected {expected_m}");
                }
                let load_n = 2.0 * model.stiffness_n_per_m() * current_m;
                assert!((output.force_n.x + load_n).abs() < 1e-3 * load_n, "{what}: {output:?}");
                assert_eq!(output.contacts, 1);
            }
        }
    }
}

/// A minimum of E - I . P by damped steps with momentum, in double precision.
fn settled(links: &Links, loaded: &[usize], current: [f64; 3]) -> Vec<[f64; 3]> {
    let mut at = links.rest().to_vec();
    let (mut way, mut residual) = (vec![[0.0; 3]; at.len()], vec![[0.0; 3]; at.len()]);
    let mut weights = vec![0.0; at.len()];
    for (ends, w) in links.ends().iter().zip(links.weights()) {
        ends.iter().for_each(|&end| weights[end as usize] += w);
    }
    for _ in 0..20_000 {
        links.residual(&at, &mut residual);
        for cell in (0..at.len()).filter(|&cell| !links.fixed()[cell]) {
            for axis in 0..3 {
                let load = if loaded.contains(&cell) { current[axis] } else { 0.0 };
                let step = (residual[cell][axis] + load) / weights[cell];
                way[cell][axis] = 0.95 * way[cell][axis] + step;
                at[cell][axis] += way[cell][axis];
            }
        }
    }
    at
}

#[test]
fn a_loaded_plane_settles_at_the_minimum_of_energy_less_load() {
    let image = image("plane:9x9x0.01");
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let current_m = [0.002_f32, -0.001, 0.005];
    let nodes = [31_u32, 40, 41];
    let loaded: Vec<usize> =
        nodes.iter().map(|&node| model.cell_of_input(node).unwrap().into()).collect();
    let unit_m = f64::from(model.unit_m());
    let current = current_m.map(|i| f64::from(i) / unit_m);
    let expected = settled(&Links::of_model(&model), &loaded, current);
    for variant in Variant::plain_ones() {
        let mut engine = engine(&image, variant, &nodes, |settings| settings.sweeps = 40);
        engine.tick(&sample([0.0; 3], 1));
        for _ in 0..300 {
            engine.tick(&sample(current_m, 1));
        }
        let mut lowest = 0.0_f64;
        for (cell, at) in engine.positions().into_iter().enumerate() {
            for axis in 0..3 {
                let off = (at[axis] - expected[cell][axis]).abs();
                assert!(off < 2e-3, "{variant:?} cell {cell}: {at:?}, {:?}", expected[cell]);
                lowest = lowest.max(expected[cell][2]);
            }
        }
        assert!(lowest > 0.5, "the load did next to nothing");
    }
}

/// A body of each kind under all that moves it, without a coarse level.
fn each(shape: &Shape) -> Vec<(ImageBytes, Variant)> {
    let coarse_basis = BasisSpacing::None;
    let options = BakeOptions { coarse_basis, ..BakeOptions::default() };
    let images = kinds(&options).map(|options| shape.bake(&options).unwrap());
    let bodies = images.into_iter().flat_map(|image| {
        let variants = Variant::plain_of(&Model::from_bytes(image.as_bytes()).unwrap());
        variants.into_iter().map(move |variant| (image.clone(), variant))
    });
    bodies.collect()
}

/// Ends on release: no force, no contacts, and back to the rest shape.
// REQ-ENE-06
#[test]
fn a_released_body_returns() {
    for (image, variant) in each(&Shape::generated("box:4x4x4x0.01").unwrap()) {
        let mut engine = engine(&image, variant, &[63], |settings| settings.sweeps = 30);
        let rest_m = nodes_m(&mut engine);
        let distance = |at_m: &[[f64; 3]]| {
            let each = at_m.iter().flatten().zip(rest_m.iter().flatten());
            each.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        engine.tick(&sample([0.0; 3], 1));
        let mut loaded = engine.tick(&sample([0.01, 0.0, 0.01], 1));
        for _ in 0..50 {
            loaded = engine.tick(&sample([0.01, 0.0, 0.01], 1));
        }
        let out_m = distance(&nodes_m(&mut engine));
        assert!(out_m > 0.3 * UNIT_M && loaded.energy_j > 0.0, "{variant:?}: {out_m}");
        let (mut before, mut output) = (loaded.energy_j, loaded);
        for _ in 0..400 {
            output = engine.tick(&sample([0.5, 0.5, 0.5], 0));
            assert_eq!((output.force_n.norm(), output.contacts), (0.0, 0));
            // f64 leaves rest lengths the rounding that f32 gave them: links let go at the rim.
            let allowed = before + 1e-9 * loaded.energy_j;
            assert!(output.energy_j <= allowed, "{variant:?}: {} J", output.energy_j);
            before = output.energy_j;
        }
        let left_m = distance(&nodes_m(&mut engine));
        assert!(left_m < 0.05 * out_m, "{variant:?}: {left_m} of {out_m}");
        assert!(output.energy_j < 1e-3 * loaded.energy_j, "{variant:?}");
    }
}

/// Under `euler` the centroid of a body that nothing fixes moves by exactly the impulse, C times
/// the cells times its way = I times the time; and no further than K.
#[test]
fn an_unfixed_body_drifts_by_the_impulse_up_to_saturation() {
    let image = chain(&[20.0; 4], 0.05, true);
    let current_m = [0.001_f32, 0.002, 0.0];
    let mut engine = engine(&image, Variant::plain(Scheme::Euler, Arithmetic::F32), &[1], |_| ());
    engine.tick(&sample([0.0; 3], 1));
    let centroid = |engine: &mut Engine<'_>| -> [f64; 3] {
        let at_m = engine.positions_m();
        [0, 1, 2].map(|axis| at_m.iter().map(|p| p[axis]).sum::<f64>() / at_m.len() as f64)
    };
    let before = centroid(&mut engine);
    for _ in 0..20 {
        engine.tick(&sample(current_m, 1));
    }
    let after = centroid(&mut engine);
    let time = 20.0 * 4.0 * f64::from(engine.network().settings().step);
    for axis in 0..3 {
        let expected = f64::from(current_m[axis]) * time / 4.0;
        let way = after[axis] - before[axis];
        assert!((way - expected).abs() < 1e-4 * UNIT_M, "{axis}: {way} {expected}");
    }
    assert!(after[1] - before[1] > UNIT_M);
    for variant in Variant::plain_ones() {
        let mut engine = self::engine(&image, variant, &[1], |settings| settings.sweeps = 20);
        engine.tick(&sample([0.0; 3], 1));
        for _ in 0..3000 {
            engine.tick(&sample([0.0, 0.01, 0.0], 1));
        }
        let furthest = engine.positions_m().iter().map(|p| p[1]).fold(0.0, f64::max);
        assert!((furthest - 0.4).abs() < 1e-6, "{variant:?}: {furthest}");
    }
}

/// However absurd the current, the energy stays below the model's bound, and the tool can take the
/// load back.
// REQ-ENE-03, REQ-ENE-04
#[test]
fn the_energy_bound_holds_for_ever() {
    let slab = Shape::generated("box:6x5x3x0.01").unwrap();
    for (image, variant) in each(&slab).into_iter().chain(each(&slab.floating())) {
        let mut engine = engine(&image, variant, &[38, 41], |_| ());
        let model = *engine.network().model();
        let bound_j = f64::from(model.energy_max() * model.energy_unit_j());
        let mut monitor = Monitor::new(&engine, variant.numbers);
        monitor.tick(&mut engine, &[sample([0.0; 3], 1)], None);
        for tick in 0..600_u16 {
            let far = if tick % 200 < 150 { 3e4 } else { -3e4 };
            let output = monitor.tick(&mut engine, &[sample([far, 2.0 * far, 1e5], 1)], None);
            assert!(tick > 0 || output.flags.contains(Flags::MOTION_CLAMPED), "{variant}");
            assert!(f64::from(output.energy_j) <= 1.0001 * bound_j, "{variant} {tick}");
        }
        let highest_j = monitor.worst().energy_peak_j;
        assert!(highest_j > 0.01 * bound_j, "{variant}: {highest_j} of {bound_j}");
        let output = monitor.tick(&mut engine, &[sample([0.0; 3], 1)], None);
        assert!(!output.flags.contains(Flags::MOTION_CLAMPED), "{variant}");
        assert!(monitor.failures().is_empty(), "{variant}: {:?}", monitor.failures());
    }
}

/// With and without the vector unit, with and without sleep.
// REQ-BIT-03
#[test]
fn all_loops_give_the_same_bits() {
    for (spec, spacing, kind) in [
        ("plane:21x21x0.01", BasisSpacing::None, 0),
        ("organ:500", BasisSpacing::Links(2.5), 0),
        ("organ:500", BasisSpacing::None, 0),
        ("organ:500", BasisSpacing::Links(2.5), 1),
    ] {
        let options = BakeOptions {
            alpha: PerCell::Uniform(0.05),
            coarse_basis: spacing,
            ..BakeOptions::default()
        };
        let options = &kinds(&options)[kind];
        let image = Shape::generated(spec).unwrap().bake(options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let free: Vec<u32> = (0..model.cells())
            .filter(|&cell| !model.is_fixed(cell as u16))
            .map(|cell| model.input_id()[cell])
            .collect();
        let nodes = [free[free.len() / 3], free[free.len() / 2]];
        for variant in Variant::singles_of(&model) {
            let new = || {
                Ok(engine(&image, variant, &nodes, |settings| {
                    settings.unloading = Unloading::Retreat;
                    settings.max_tool_step_m = model.unit_m();
                    settings.sweeps = 9;
                }))
            };
            let steps = (0..220_u16).map(|tick| {
                let way = |from: u16, to: u16| {
                    f32::from(tick.clamp(from, to) - from) / f32::from(to - from)
                };
                let depth = way(20, 60) - way(90, 130);
                let at = [0.5 * way(60, 90), 0.2 * depth, -2.0 * depth].map(|x| x * model.unit_m());
                Step::at(at, u32::from(!(140..=190).contains(&tick)))
            });
            let monitor = play(new, variant.numbers, None, steps).unwrap();
            let what = format!("{spec} {spacing:?} {variant}");
            assert!(monitor.failures().is_empty(), "{what}: {:?}", monitor.failures());
            assert!(monitor.worst().energy_peak_j > 1e-7, "{what}: the body hardly moved");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    /// On any graph, under any current: E - I . P never rises while I stays, and E is at most what
    /// is published.
    // REQ-ENE-06
    #[test]
    fn energy_less_load_never_rises(
        (case, variant) in body(false, Variant::plain_ones()),
        currents in prop::collection::vec(prop::array::uniform3(-0.05_f32..0.05), 1..5),
    ) {
        let options = BakeOptions { energy_max_j: Some(1e12), ..case.options() };
        let image = case.shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let contact = Contact::Cells(case.shape.cells(&model));
        let cell = usize::from(case.shape.cells(&model)[0]);
        let loaded = |settings| Settings {
            unloading: Unloading::Off,
            drive: Drive::Current,
            max_tool_step_m: 1.0,
            ..settings
        };
        let Ok(mut engine) = case.engine_with(model, variant, contact, loaded) else {
            return Ok(());
        };
        let mut monitor = Monitor::new(&engine, variant.numbers);
        let resolution =
            if variant.numbers == Arithmetic::Fixed { 2.0_f64.powi(-22) } else { 0.0 };
        let k = 2.0 * f64::from(model.stiffness_n_per_m());
        let origin_m = engine.positions_m()[cell];
        monitor.tick(&mut engine, &[sample([0.0; 3], 1)], None);
        for current_m in currents {
            let mut before = f64::INFINITY;
            for tick in 0..20 {
                let output = monitor.tick(&mut engine, &[sample(current_m, 1)], None);
                prop_assert!(!output.flags.contains(Flags::MOTION_CLAMPED));
                let at_m = engine.positions_m()[cell];
                let (mut work, mut rounding) = (0.0, 0.0);
                for axis in 0..3 {
                    let i = k * f64::from(current_m[axis]);
                    work += i * (at_m[axis] - origin_m[axis]);
                    let way = f64::from(f32::EPSILON) * (at_m[axis].abs() + origin_m[axis].abs() + 0.2);
                    rounding += i.abs() * (way + resolution * f64::from(model.unit_m()));
                    // The current itself is rounded to the number.
                    let grain = 2.0_f64.powi(-24) * (1.0 + i.abs() / k / f64::from(model.unit_m()));
                    rounding += k * f64::from(model.unit_m()) * grain * (at_m[axis] - origin_m[axis]).abs();
                }
                let stored = monitor.stored();
                let allowance = stored.allowance_j + rounding;
                let certified = f64::from(output.energy_j);
                let guarded = stored.energy_j - work;
                prop_assert!(
                    guarded <= before + allowance,
                    "tick {}: {:e} after {:e}, {:e}", tick, guarded, before, allowance
                );
                // Level by level for the guarded schemes: the level lies above the state.
                before = if variant.scheme == Scheme::Euler {
                    guarded
                } else {
                    (certified - work).min(before)
                };
            }
        }
        holds(&monitor)?;
    }
}
