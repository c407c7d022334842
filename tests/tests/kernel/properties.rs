//! What must hold on any body, whatever the tool does: random bodies of 4 to 40 cells, stiffness over six
//! decades, alpha from 0 to 0.99, pushed, torn, let go and left alone, and from any state at all. The checks of
//! every tick are the monitor's, as in `chaincell stress`.
//!
//! `CHAINCELL_SLOW=1 cargo test --release -p chaincell-tests --test kernel properties` takes a hundred times as
//! many states.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::{Choice, Flags, Model, Settings, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::{Monitor, Step};
use chaincell_lab::states::State;
use chaincell_tests::graph::{Case, body, case, holds, kinds, sample, shape, singles};
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

/// Ticks from a state, of one to four sweeps each.
const TICKS: u32 = 40;
/// Cases of states, some hundred sweeps each.
const CASES: u32 = 1_000;
const CASES_SLOW: u32 = 100_000;
/// Nearly the largest K of fixed point [mean link lengths].
const FIXED_RANGE: f64 = 62.9;

fn cases() -> u32 {
    if std::env::var_os("CHAINCELL_SLOW").is_some() { CASES_SLOW } else { CASES }
}

fn states() -> impl Strategy<Value = State> {
    prop_oneof![
        Just(State::Inverted),
        Just(State::Flattened),
        Just(State::Coincident([0.0; 3])),
        Just(State::HalfCoincident),
        (-6.0_f32..3.0).prop_map(|decades| State::Scattered(10.0_f32.powf(decades))),
        (-1.0_f32..3.0).prop_map(|decades| State::Mixed(10.0_f32.powf(decades))),
        Just(State::Stretched),
        Just(State::Grid),
        Just(State::Denormal),
        Just(State::Rest),
    ]
}

/// What happens to a body: the state it starts from, and whether the tool holds it at first.
#[derive(Debug, Clone, Copy)]
struct Start {
    state: State,
    seed: u64,
    variant: Variant,
    /// With a wide range the state stays linear, else scattered ones saturate.
    wide: bool,
    held: bool,
}

/// The tool holds for the first half of the ticks, or never.
fn holding(held: bool) -> impl Iterator<Item = Step> {
    (0..TICKS).map(move |tick| Step::at([0.0; 3], u32::from(held && tick < TICKS / 2)))
}

fn check(case: &Case, start: Start) -> Result<(), TestCaseError> {
    let fixed_point = start.variant.numbers == Arithmetic::Fixed;
    let baked =
        |saturation_m| case.shape.bake(&BakeOptions { saturation_m, ..case.options() }).unwrap();
    // Of shapes within the range that an image of them may have.
    let wide_m = if case.tissue.is_some() { 1e2 } else { 1e4 };
    let mut image = baked(if fixed_point { None } else { start.wide.then_some(wide_m) });
    if fixed_point && start.wide {
        // As wide as it goes.
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let k_m = FIXED_RANGE * f64::from(model.unit_m());
        if model.saturation() < 62.9 {
            image = baked(Some(k_m));
        }
    }
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let state = start.state.positions(&model, start.seed);
    let steps = holding(start.held);
    let monitor = case.play(&image, start.variant, Unloading::Off, Some(&state), steps);
    // What leaves the range of fixed point is refused.
    prop_assume!(monitor.is_ok() || fixed_point);
    monitor.map_or(Ok(()), |monitor| holds(&monitor))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) })]

    // REQ-ENE-01, REQ-ENE-02
    #[test]
    fn from_any_state(
        (case, variant) in prop_oneof![
            3 => body(false, singles(Scheme::ALL)),
            1 => body(true, singles(Scheme::ALL)),
        ],
        state in states(), seed in any::<u64>(), wide in any::<bool>(), held in any::<bool>(),
    ) {
        check(&case, Start { state, seed, variant, wide, held })?;
    }

    // REQ-ENE-05
    #[test]
    fn from_any_state_in_fixed_point(
        case in prop_oneof![3 => case(false), 1 => case(true)], state in states(),
        seed in any::<u64>(),
        scheme in prop::sample::select(vec![Scheme::Track, Scheme::Euler]),
        wide in any::<bool>(), held in any::<bool>(),
    ) {
        let mut case = case;
        // A decade and a half instead of six.
        for stiffness in &mut case.stiffness_n_per_m {
            *stiffness = stiffness.powf(0.25);
        }
        let variant = Variant::plain(scheme, Arithmetic::Fixed);
        check(&case, Start { state, seed, variant, wide, held })?;
    }
}

/// A stiff link between the tool and a fixed cell holds nearly all of the energy, so the errors of
/// its length are no random walk.
#[test]
fn one_link_that_holds_nearly_all_the_energy() {
    let nodes_m = vec![[-0.1, 0.02, 0.01], [0.03, 0.01, 0.01], [0.1, -0.05, 0.02]];
    let shape = shape(nodes_m, vec![[0, 1], [0, 2], [1, 2]], vec![0]);
    let case = Case { tick_time: 0.5, ..Case::new(shape, 0.69, vec![1e3, 1e-3, 1e3]) };
    let (image, variant) = (case.image(), Variant::plain(Scheme::Track, Arithmetic::F32));
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let contact = Contact::Cells(case.shape.cells(&model));
    let fast = |settings| Settings { max_tool_step_m: 1.0, unloading: Unloading::Off, ..settings };
    let mut engine = case.engine_with(model, variant, contact, fast).unwrap();
    let mut monitor = Monitor::new(&engine, variant.numbers);
    monitor.tick(&mut engine, &[sample([0.0; 3], 1)], None);
    for tick in 0..20_000_u16 {
        // About the place where the link leaves its band.
        let part = 0.695 + 0.004 * (1.7 * f32::from(tick)).sin();
        let slant = 1e-3 * f32::from(tick % 97);
        let way = [0.2, slant - 0.07, 0.01].map(|length| part * length);
        monitor.tick(&mut engine, &[sample(way, 1)], None);
    }
    let used = monitor.worst().rounding_used;
    assert!(monitor.failures().is_empty() && used > 0.2, "{used} {:?}", monitor.failures());
}

/// Nothing holds this body and its stiffness spans four decades: with too little margin for the
/// rounding of the inverse the certificate of its coarse functions was wrong in the fourth digit.
// REQ-ENE-02
#[test]
fn coarse_functions_of_a_floating_body_of_contrasts() {
    let nodes_m = vec![
        [0.052287608115276024, -0.05834054153493455, 0.05217711296870717],
        [-0.04824130634402384, -0.04522286314284126, -0.0776850652139585],
        [0.005034306937952206, -0.06786774831963129, 0.03873900747489446],
        [0.049898442547184785, -0.09578208437199019, 0.07771364764907504],
    ];
    let shape = shape(nodes_m, vec![[0, 1], [1, 2], [1, 3]], Vec::new());
    let stiffness_n_per_m = vec![
        0.0030232489971425396,
        0.0025370255915611512,
        17.494421248089022,
        0.007765792267692402,
    ];
    let case = Case { coarse_functions: Some(1.0), ..Case::new(shape, 0.0, stiffness_n_per_m) };
    let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
    let start = Start { state: State::Flattened, seed: 0, variant, wide: false, held: false };
    check(&case, start).unwrap();
}

/// A link is shorter than ten steps of fixed point are wide: its direction is off by per cents, and
/// with it the force.
#[test]
fn a_link_of_next_to_no_length_in_fixed_point() {
    let nodes_m = [0.0, -0.02078909951488514, 0.03553161576337957, -0.0877758683337419];
    let nodes_m = nodes_m.map(|z| [0.0, 0.0, z]).to_vec();
    let shape = shape(nodes_m, vec![[0, 1], [0, 2], [0, 3]], vec![0]);
    let case = Case { tick_time: 0.5, ..Case::new(shape, 0.0, vec![1.0; 4]) };
    let variant = Variant::plain(Scheme::Track, Arithmetic::Fixed);
    let state = State::Scattered(5.4409516e-6);
    for seed in [78_426_888_867_826].into_iter().chain(0..200) {
        check(&case, Start { state, seed, variant, wide: false, held: true }).unwrap();
    }
}

/// In fixed point as far as its range goes.
fn at_the_ends(case: &Case, of: impl Fn(usize, [f32; 3]) -> [f32; 3]) {
    let image = case.image();
    let unit_m = f64::from(Model::from_bytes(image.as_bytes()).unwrap().unit_m());
    let saturation_m = Some(FIXED_RANGE * unit_m);
    let image = case.shape.bake(&BakeOptions { saturation_m, ..case.options() }).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let state: Vec<_> =
        (0..model.cells()).map(|cell| of(cell, model.rest_position(cell))).collect();
    for scheme in [Scheme::Track, Scheme::Euler] {
        let variant = Variant::plain(scheme, Arithmetic::Fixed);
        let monitor = case.play(&image, variant, Unloading::Off, Some(&state), holding(false));
        holds(&monitor.unwrap()).unwrap();
    }
}

/// Twelve links exert 27 units each, six in one direction and six in the other: sums of some of
/// them leave the range of fixed point, the sum of all does not.
// REQ-ENE-05
#[test]
fn sums_that_leave_the_range_on_their_way() {
    let around = |at: usize| {
        let turn = at as f64 * std::f64::consts::TAU / 12.0;
        [0.01 * turn.cos(), 0.01 * turn.sin(), 0.0]
    };
    let shape = shape(
        (0..12).map(around).chain([[0.0; 3]]).collect(),
        (0..12).map(|at| [at, 12]).collect(),
        (0..12).collect(),
    );
    at_the_ends(&Case::new(shape, 0.0, vec![1.0; 13]), |cell, rest| {
        if rest[0].abs() + rest[1].abs() < 0.1 {
            [10.0, 0.0, 0.0]
        } else {
            [if cell < 7 { -55.0 } else { 55.0 }, 0.0, 0.0]
        }
    });
}

/// A body of 1,000 cells thrown into the corners of fixed point's range: its energy is far beyond
/// what a tool may load into it.
// REQ-ENE-05
#[test]
fn energies_beyond_what_a_tool_may_load() {
    let at = |i: usize| [i / 100, i / 10 % 10, i % 10];
    let neighbours = (0..1000_usize).flat_map(|i| {
        let place = at(i);
        [100, 10, 1].into_iter().enumerate().filter_map(move |(axis, step)| {
            (place[axis] < 9).then_some([i as u32, (i + step) as u32])
        })
    });
    let nodes_m = (0..1000).map(|i| at(i).map(|x| 0.01 * x as f64)).collect();
    let shape = shape(nodes_m, neighbours.collect(), vec![0]);
    let case = Case { sweeps: 2, ..Case::new(shape, 0.0, vec![1.0; 1000]) };
    at_the_ends(&case, |cell, _| {
        [1, 2, 4].map(|bit| if ((cell * 2_654_435_761) >> 7) & bit == 0 { -62.0 } else { 62.0 })
    });
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

/// Each way to compute a body of links and one of shapes.
fn each(shape: &Shape, of: impl Fn(&ImageBytes, Variant)) {
    for options in kinds(&BakeOptions::default()) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        Variant::plain_of(&model).into_iter().for_each(|variant| of(&image, variant));
    }
}

/// 20,000 ticks at rest on the generated organ, without a band, with bad samples and good ones: the hash
/// stays.
// REQ-ENE-07
#[test]
fn ten_thousand_ticks_of_rest() {
    each(&Shape::generated("organ:300").unwrap(), |image, variant| {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let cells = Contact::Cells(Vec::new());
        let mut engine = variant.engine(model, cells, variant.sweeps(), |of| of).unwrap();
        let mut monitor = Monitor::new(&engine, variant.numbers);
        monitor.rests(&mut engine);
        let before = engine.state_hash();
        for tick in 0..20_000_u16 {
            let sample = if tick % 2 == 0 { sample([f32::NAN; 3], 7) } else { sample([0.0; 3], 0) };
            // The energy in double precision of every hundredth tick is enough.
            if tick % 100 < 2 {
                monitor.tick(&mut engine, &[sample], None);
            } else {
                engine.tick(&sample);
            }
        }
        assert_eq!(engine.state_hash(), before, "{variant}");
        holds(&monitor).unwrap();
    });
}

/// Bad samples: the force of the last good one for ten ticks, then 0 and cells as they are, then back.
// REQ-SMP-01, REQ-SMP-02
#[test]
fn bad_samples_end_in_the_safe_state() {
    let shape = Shape::generated("box:5x5x5x0.01").unwrap().holding(&[124]);
    each(&shape, |image, variant| {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let contact = Contact::Cells(shape.cells(&model));
        let Ok(mut engine) = variant.engine(model, contact, variant.sweeps(), |of| of) else {
            assert_eq!(variant.numbers, Arithmetic::Fixed, "{variant}");
            return;
        };
        let mut monitor = Monitor::new(&engine, variant.numbers);
        let mut tick = |sample| monitor.tick(&mut engine, &[sample], None);
        tick(sample([0.0; 3], 1));
        let good = sample([0.0, 0.0, -0.004], 1);
        tick(good);
        for bad in [sample([f32::NAN, 0.0, 0.0], 1), sample([0.0; 3], 2)] {
            for at in 1..=30 {
                let output = tick(bad);
                assert_eq!(output.force_n.z > 0.0, at <= 10, "{variant}, {at}: {output:?}");
            }
            let output = tick(good);
            assert!(output.force_n.z > 0.0 && output.flags.0 == 0, "{variant}: {output:?}");
        }
        holds(&monitor).unwrap();
    });
}

/// The tool's way in late ticks counts as in any other: none of it is lost, and none made twice.
// REQ-TCK-06
#[test]
fn a_tick_after_late_ones_is_where_the_tool_is() {
    let shape = Shape::generated("box:7x6x4x0.008").unwrap();
    for options in kinds(&BakeOptions::default()) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let held = model.surface().iter().copied().rfind(|&cell| !model.is_fixed(cell)).unwrap();
        let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
        let engine =
            || variant.engine(model, Contact::Cells(vec![held]), 4, |settings| settings).unwrap();
        let [mut late, mut all] = [engine(), engine()];
        let mut monitor = Monitor::new(&late, variant.numbers);
        let mut forces = [0.0; 2];
        for tick in 0..200_u16 {
            let pose = sample([0.0, 0.0, -8e-5 * f32::from(tick.min(60))], 1);
            let sweeps = if (31..60).contains(&tick) { Some(0) } else { None };
            forces = [monitor.tick(&mut late, &[pose], sweeps), all.tick(&pose)]
                .map(|output| output.force_n.norm());
            if tick == 30 || tick == 59 {
                assert!((forces[0] == forces[1]) == (tick == 30), "{forces:?}");
            }
        }
        holds(&monitor).unwrap();
        assert!(forces[1] > 0.01 && (forces[0] / forces[1] - 1.0).abs() < 1e-3, "{forces:?}");
        let place = |engine: &mut Engine<'_>| engine.positions_m()[usize::from(held)];
        assert_eq!(place(&mut late), place(&mut all));
    }
}
