//! Whatever a tool does to cells that it holds.

use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_kernel::{Choice, Model, Unloading};
use chaincell_lab::bodies::Variant;
use chaincell_lab::monitor::Step;
use chaincell_tests::graph::{Case, body, case, holds, sample, singles};
use proptest::prelude::*;

/// Ticks of a tool: where it is \[m\], whether it is engaged, the sweeps, and how often.
type Ticks = ([f32; 3], u32, Option<u16>, u8);

/// Anywhere, near as a rule, with ticks that end early or are late, and samples that are none.
fn anywhere() -> impl Strategy<Value = Vec<Ticks>> {
    let near = prop::array::uniform3(-0.05_f32..0.05);
    let far = prop::array::uniform3(-20.0_f32..20.0);
    let bits = prop::array::uniform3(any::<u32>().prop_map(f32::from_bits));
    let place = prop_oneof![20 => near, 4 => far, 1 => bits];
    let engaged = prop_oneof![16 => Just(1), 4 => Just(0), 1 => any::<u32>()];
    let sweeps = prop_oneof![3 => Just(Some(0)), 2 => (1_u16..6).prop_map(Some), 3 => Just(None)];
    let times = prop_oneof![4 => Just(1), 1 => 2_u8..15];
    prop::collection::vec((place, engaged, sweeps, times), 1..30)
}

/// Small moves and long rests, in which parts of the body sleep.
fn strokes() -> impl Strategy<Value = Vec<Ticks>> {
    prop::collection::vec((0.0_f32..0.03, 1_u8..40, 0_u32..2), 1..8).prop_map(|strokes| {
        let stroke = |(depth, ticks, engaged): (f32, u8, u32)| {
            (0..ticks).map(move |tick| {
                ([depth * f32::from(tick) / f32::from(ticks), 0.0, 0.0], engaged, None, 1)
            })
        };
        strokes.into_iter().flat_map(stroke).collect()
    })
}

fn unloadings() -> impl Strategy<Value = Unloading> {
    prop::sample::select(vec![Unloading::Off, Unloading::Release, Unloading::Retreat])
}

/// At rest first, untouched or held; then what the tool does; then free.
fn steps(engaged: u32, ticks: &[Ticks]) -> Vec<Step> {
    let still = (0..30).map(|_| Step::at([0.01, 0.0, 0.0], engaged));
    let moves = ticks.iter().flat_map(|&(place_m, engaged, sweeps, times)| {
        (0..times).map(move |_| Step { sweeps, ..Step::at(place_m, engaged) })
    });
    let free = (0..50).map(|_| Step::at([0.0; 3], 0));
    still.chain(moves).chain(free).collect()
}

/// In a straight line right onto another cell, and there.
fn onto(case: &Case) -> impl Iterator<Item = Ticks> {
    let (from, to) = (*case.shape.mesh.nodes_m.last().unwrap(), case.shape.mesh.nodes_m[0]);
    (1..=20_u8).map(move |tick| {
        let share = f64::from(tick.min(10)) / 10.0;
        ([0, 1, 2].map(|axis| (share * (to[axis] - from[axis])) as f32), 1, None, 1)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    /// From rest, under any tool, in every scheme: with coincident cells, with stiffness and alpha that vary
    /// or do not, with ticks of any number of sweeps.
    // REQ-ENE-01, REQ-ENE-03, REQ-ENE-07, REQ-FOR-02, REQ-TCK-03, REQ-TCK-06, REQ-BIT-02, REQ-BIT-03
    #[test]
    fn whatever_a_tool_does(
        (case, variant) in body(false, singles(Scheme::ALL)), unloading in unloadings(),
        engaged in 0_u32..2, ticks in prop_oneof![2 => anywhere(), 1 => strokes()],
        flat in any::<bool>(), varied in any::<[bool; 2]>(),
    ) {
        let nodes = case.shape.mesh.nodes_m.len();
        let mut options = case.options();
        if varied[0] && case.tissue.is_none() {
            let alpha = |node: usize| case.alpha * (node % 3) as f64 / 3.0;
            options.alpha = PerCell::Each((0..nodes).map(alpha).collect());
        }
        if !varied[1] {
            options.stiffness_n_per_m = PerCell::Uniform(20.0);
        }
        let image = case.shape.bake(&options).unwrap();
        let ticks: Vec<Ticks> =
            if flat { ticks.into_iter().chain(onto(&case)).collect() } else { ticks };
        let steps = steps(engaged, &ticks);
        holds(&case.play(&image, variant, unloading, None, steps).unwrap())?;
    }

    /// Saturation: the outputs reach the end of their range and leave it.
    // REQ-ENE-08
    #[test]
    fn saturation_is_reached_and_left(
        (case, variant) in body(false, singles(Scheme::ALL)),
        way in prop::array::uniform3(-1.0_f32..1.0),
    ) {
        let options = BakeOptions { energy_max_j: Some(1e12), ..case.options() };
        let image = case.shape.bake(&options).unwrap();
        let unit_m = Model::from_bytes(image.as_bytes()).unwrap().unit_m();
        let out = (0..120_i16).map(|tick| {
            let far = f32::from(60 - (60 - tick).abs()) * 2.0 * unit_m;
            Step::at(way.map(|x| x * far), 1)
        });
        let steps = out.chain((0..100).map(|_| Step::at([0.0; 3], 0)));
        holds(&case.play(&image, variant, Unloading::Off, None, steps).unwrap())?;
    }

    /// Without fixed cells the links' forces cancel: `euler` keeps the centroid.
    #[test]
    fn an_unfixed_body_feels_no_total_force(case in case(true), ticks in anywhere()) {
        // In the linear range, that is: the leak of a saturated cell is an outer force.
        let options = BakeOptions { saturation_m: Some(50.0), ..case.options() };
        let image = case.shape.bake(&options).unwrap();
        let variant = Variant::plain(Scheme::Euler, Arithmetic::F32);
        let mut engine = case.engine(&image, variant, Unloading::Off).unwrap();
        engine.tick(&sample([0.0; 3], 1));
        for (position_m, ..) in ticks {
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
    fn node_order_does_not_change_the_physics(
        (case, variant) in body(false, singles(Scheme::ALL)), seed in any::<u64>(),
    ) {
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
            let mut engine = case.engine(&image, variant, Unloading::Release).unwrap();
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
}
