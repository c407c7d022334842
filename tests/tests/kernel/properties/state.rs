//! From any state of a body, and to the ends of the range of fixed point.

use chaincell_host::bake::BakeOptions;
use chaincell_host::engine::{Arithmetic, Contact, Scheme};
use chaincell_kernel::{Choice, Model, Settings, Unloading};
use chaincell_lab::bodies::Variant;
use chaincell_lab::monitor::{Monitor, Step};
use chaincell_lab::states::State;
use chaincell_tests::graph::{Case, body, case, holds, sample, shape, singles};
use proptest::prelude::*;

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

/// Links of the body of [`both_lanes_of_an_odd_box_tell_what_leaves_the_range`].
#[rustfmt::skip]
const ODD_BOX_LINKS: [[u32; 2]; 31] = [
    [0, 1], [0, 2], [0, 4], [0, 5], [0, 6], [0, 7], [0, 8], [0, 10],
    [1, 2], [1, 3], [1, 7], [1, 8], [1, 11], [2, 3], [2, 4], [2, 5],
    [2, 6], [2, 9], [2, 10], [3, 4], [3, 5], [3, 6], [3, 8], [3, 9],
    [4, 9], [4, 11], [5, 6], [5, 10], [6, 8], [9, 10], [10, 11],
];

/// A box of the coarse level with an odd number of cells names its last one twice, once without weights:
/// whether that one would leave the range counts too, over slices as cell by cell.
// REQ-BIT-01
#[test]
fn both_lanes_of_an_odd_box_tell_what_leaves_the_range() {
    let nodes_m = vec![
        [0.06895338150942458, -0.02596555749006306, -0.02841856612529461],
        [0.08428644976050421, 0.01436506186853162, -0.021200598487481345],
        [-0.08668489510355884, 0.0, -0.0526362208286021],
        [-0.03915810614093158, -0.022789988288537445, -0.0973936380930527],
        [0.0, -0.0975304286061435, 0.0],
        [0.0283607026485811, -0.08421378557540443, -0.05134108676944624],
        [-0.04392988743589849, 0.08938662518593608, 0.02987125779289959],
        [0.0735237717579774, -0.06830624909545044, -0.012120461585647483],
        [0.08825671769837419, 0.012692522406767067, -0.03401889760719635],
        [0.02222691950817222, -0.09323074679841332, -0.0710582357891384],
        [0.0930806445051259, -0.09658909528855017, -0.05573202749275713],
        [-0.020453319671749334, 0.05884591088596897, -0.07122613435673854],
    ];
    let shape = shape(nodes_m, ODD_BOX_LINKS.to_vec(), vec![5]);
    let case = Case {
        sweeps: 8,
        tick_time: 36.640377,
        coarse_functions: Some(2.934874692298619),
        ..Case::new(
            shape,
            0.0,
            vec![
                259.21718150234136,
                2.349109360177919,
                0.13427219040531335,
                80.72862689812219,
                14.18059185325733,
                3.372062396037226,
                209.9594658976975,
                0.05816000991977795,
                1.0969379636379804,
                0.006522794582250446,
                573.6871120488038,
                2.9915634788800545,
            ],
        )
    };
    let variant = Variant { scheme: Scheme::Predict, numbers: Arithmetic::F32, coarse: false };
    let start = Start {
        state: State::Scattered(3.4501116),
        seed: 8912127351897187861,
        variant,
        wide: false,
        held: true,
    };
    check(&case, start).unwrap();
}
