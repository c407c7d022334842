//! What must hold of tools on a contact surface, whatever they do: presses, slides, jumps and turns on blocks of
//! shapes and of links, and any poses, grips and resets. The checks of every tick are the monitor's: the
//! published level against the energy of tissue and tools in double precision, over the samples of all
//! triangles.
#![allow(clippy::unwrap_used)]

use std::sync::LazyLock;

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::Result;
use chaincell_kernel::{
    Budget, NOT_TURNED, Network, Predict, Settings, Tissue as Memory, ToolPart, ToolPose,
    TouchStore, term_states,
};
use chaincell_lab::monitor::{Act, Monitor, Step, play};
use chaincell_lab::states::State;
use chaincell_tests::bodies::{baked, model, nodal, under};
use chaincell_tests::graph::holds;
use proptest::prelude::*;

/// Height of the top of the block \[m\].
const TOP_M: f32 = 0.04;

/// Blocks on a fixed ground, 40 mm high and 48 mm wide, with edges of about 8 mm: of liver, of links, and of
/// links with slack.
static BLOCKS: LazyLock<[(&str, ImageBytes); 3]> = LazyLock::new(|| {
    let block = |alpha, coarse_basis| {
        let alpha = PerCell::Uniform(alpha);
        baked("box:7x7x6x0.008", &BakeOptions { alpha, coarse_basis, ..BakeOptions::default() })
    };
    // Links are too near to the ground for coarse functions by themselves.
    [
        ("shapes", nodal("box:7x7x6x0.008", 5000.0)),
        ("links", block(0.0, BasisSpacing::Links(2.5))),
        ("slack links", block(0.05, BasisSpacing::Links(2.5))),
    ]
});

/// Scheme and sweeps.
const WAYS: [(Scheme, u16); 3] = [(Scheme::Predict, 1), (Scheme::Predict, 4), (Scheme::Track, 2)];

/// An engine under tools of this friction that go any way in a tick.
fn engine<'m>(
    image: &'m ImageBytes,
    tools: &[Vec<ToolPart>],
    friction: f32,
    way: (Scheme, u16),
) -> Result<Engine<'m>> {
    under(image, Contact::Tools { tools: tools.to_vec(), friction }, way, 1.0e3)
}

/// Plays steps of tools of this friction on every block in every way, and gives what came of it.
fn each(
    tools: &[Vec<ToolPart>],
    friction: f32,
    state: Option<State>,
    steps: &[Step],
    see: impl Fn(&str, &Monitor<'_>),
) {
    for (kind, image) in BLOCKS.iter() {
        for way in WAYS {
            let new = || engine(image, tools, friction, way);
            let state = state.map(|state| state.positions(&model(image), 3));
            let steps = steps.iter().cloned();
            let monitor = play(new, Arithmetic::F32, state.as_deref(), steps).unwrap();
            let name = format!("{kind} {way:?} {tools:?}");
            assert!(monitor.failures().is_empty(), "{name}: {:?}", monitor.failures());
            see(&name, &monitor);
        }
    }
}

fn touches(name: &str, monitor: &Monitor<'_>) {
    assert!(monitor.worst().force_max_n > 1e-3, "{name}: {:?}", monitor.worst());
}

fn pose(position_m: [f32; 3]) -> ToolPose {
    ToolPose::at(position_m.into(), 1)
}

/// About y by an angle \[rad\].
fn tilted(position_m: [f32; 3], angle: f32) -> ToolPose {
    let (sin, cos) = (0.5 * angle).sin_cos();
    ToolPose { orientation: [0.0, sin, 0.0, cos], ..pose(position_m) }
}

/// Pressed in, aside, and there: where the tool stands the level is near to the energy.
#[test]
fn slides_and_taps() {
    for radius_m in [0.002_f32, 0.008, 0.03] {
        let tools = [vec![ToolPart::sphere(radius_m)]];
        let at = |x_m: f32, depth_m: f32| pose([x_m, 0.001, TOP_M + radius_m - depth_m]);
        let slide = (0..120_u8).map(|tick| {
            let (down, aside) = (f32::from(tick.min(40)), f32::from(tick.clamp(40, 80) - 40));
            Step::of(&[at(-0.01 + 5.0e-4 * aside, 2.0e-4 * down)])
        });
        each(&tools, 0.0, None, &slide.collect::<Vec<_>>(), |name, monitor| {
            touches(name, monitor);
            let (stored_j, level_j) = (monitor.stored().energy_j, monitor.worst().level_end_j);
            assert!(level_j < 1.01 * stored_j, "{name}: level {level_j} over energy {stored_j}");
        });
        let taps = (0..120_u8).flat_map(|tick| {
            let depth_m = 0.006 * (0.35 * f32::from(tick)).sin();
            let tap = ToolPose { engaged: u16::from(tick % 29 > 2), ..at(0.0, depth_m) };
            let late = Step { sweeps: Some(0), ..Step::of(&[tap]) };
            [Some(Step::of(&[tap])), (tick % 5 == 0).then_some(late)].into_iter().flatten()
        });
        each(&tools, 0.0, None, &taps.collect::<Vec<_>>(), touches);
    }
}

#[test]
fn jumps_through_the_body() {
    for part in [
        ToolPart::sphere(0.002),
        ToolPart::sphere(0.012),
        ToolPart::sphere(0.1),
        ToolPart::capsule(0.01, 0.004),
        ToolPart::rounded_box([0.006, 0.004, 0.003], 0.002),
        ToolPart::half_space(0.004),
    ] {
        let mut random = 7_u32;
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / 16_777_216.0 - 0.5
        };
        // A half space turns by half a radius a tick at the farthest point of the surface.
        let (jumps, stays) = if part.is_half_space() { (10, 40) } else { (25, 6) };
        let steps = (0..jumps).flat_map(|jump| {
            let place = [0.09 * next(), 0.09 * next(), 0.03 + 0.15 * next()];
            let engaged = u16::from(jump % 7 < 6);
            vec![Step::of(&[ToolPose { engaged, ..tilted(place, 6.0 * next()) }]); stays]
        });
        each(&[vec![part]], 0.0, None, &steps.collect::<Vec<_>>(), touches);
    }
}

/// Far from its pivot a small turn of a half space is a long way.
#[test]
fn a_half_space_that_turns() {
    // Upside down over the body, its frame 0.1 m aside: by 0.3 into the body, back, and away.
    let steps = (0..240_usize).map(|tick| {
        let angle = [0.0, 0.3, 0.0, -0.3][tick / 60 % 4];
        Step::of(&[tilted([-0.1, 0.0, TOP_M + 0.02], std::f32::consts::PI + angle)])
    });
    each(&[vec![ToolPart::half_space(0.004)]], 0.0, None, &steps.collect::<Vec<_>>(), touches);
}

/// A tool of two parts and another one, then no pose at all; without friction, and with it and a grip.
#[test]
fn tools_together() {
    let jaw = vec![
        ToolPart::capsule(0.008, 0.002),
        ToolPart { centre_m: [0.015, 0.0, 0.0], ..ToolPart::sphere(0.012) },
    ];
    let tools = [jaw, vec![ToolPart::rounded_box([0.01, 0.003, 0.003], 0.002)]];
    let steps = (0..160_u16).map(|tick| {
        let (turned, aside_m) = (0.02 * f32::from(tick), 2.0e-4 * f32::from(tick));
        let z = TOP_M + 0.012 - 0.012 * (0.05 * f32::from(tick)).sin();
        let mut first = tilted([-0.015 + aside_m, 0.002, z], turned);
        first.engaged = u16::from(tick % 50 < 44);
        Step::of(&[first, tilted([0.015 - aside_m, -0.004, z - 0.006], -turned)])
    });
    let mut steps: Vec<Step> = steps.chain((0..40).map(|_| Step::default())).collect();
    each(&tools, 0.0, None, &steps, touches);
    steps[90].act = Some(Act::Grip(1));
    each(&tools, 0.25, None, &steps, touches);
}

#[test]
fn from_hard_states() {
    for state in [
        State::Inverted,
        State::Mirrored,
        State::Flattened,
        State::Stretched,
        State::HalfCoincident,
        State::Shaken,
        State::Scattered(10.0),
    ] {
        for part in [ToolPart::sphere(0.01), ToolPart::rounded_box([0.01; 3], 0.003)] {
            let steps = (0..60_u8).map(|tick| {
                let inside = tilted([0.0, 0.001, 0.5 * TOP_M], 0.4);
                Step::of(&[if tick < 30 { inside } else { tilted([0.01, 0.0, TOP_M], 0.0) }])
            });
            each(&[vec![part]], 0.0, Some(state), &steps.collect::<Vec<_>>(), |_, _| ());
        }
    }
}

/// A block of liver on a fixed ground, 30 mm high.
static BLOCK: LazyLock<ImageBytes> = LazyLock::new(|| nodal("box:4x4x4x0.01", 5000.0));

/// Coordinates near the body, far away, tiny, or of any bits.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -0.04_f32..0.06,
        1 => any::<u32>().prop_map(f32::from_bits),
        1 => prop::sample::select(vec![0.0, -0.0, 1.0e-42, 1.0e30, f32::MAX, f32::NAN]),
    ]
}

fn poses(tools: usize) -> impl Strategy<Value = Vec<ToolPose>> {
    let orientation = prop_oneof![
        3 => prop::array::uniform4(-1.0_f32..1.0),
        3 => Just(NOT_TURNED),
        1 => prop::array::uniform4(coordinate()),
    ];
    let engaged = prop_oneof![20 => Just(1_u32), 3 => Just(0), 1 => any::<u32>()];
    let pose = (prop::array::uniform3(coordinate()), orientation, engaged);
    let pose = pose.prop_map(|(at, orientation, engaged)| ToolPose {
        orientation,
        ..ToolPose::at(at.into(), engaged)
    });
    prop::collection::vec(pose, 0..=tools)
}

/// Poses for a few ticks, late ones, and what may come before them.
fn steps(tools: usize) -> impl Strategy<Value = Vec<Step>> {
    let act = prop_oneof![
        8 => Just(None),
        2 => (0..9_usize).prop_map(|tool| Some(Act::Grip(tool))),
        1 => (0..9_usize, 0..3_u16).prop_map(|(tool, ticks)| Some(Act::LetGo(tool, ticks))),
        1 => Just(Some(Act::Reset)),
    ];
    let sweeps = prop_oneof![4 => Just(None), 1 => Just(Some(0))];
    let some = (act, poses(tools), sweeps, 1_usize..6).prop_map(|(act, poses, sweeps, times)| {
        let mut steps = vec![Step { sweeps, ..Step::of(&poses) }; times];
        steps[0].act = act;
        steps
    });
    prop::collection::vec(some, 1..25).prop_map(|steps| steps.concat())
}

/// Parts of all kinds, from the smallest radius that there may be up to 100 m.
fn part() -> impl Strategy<Value = ToolPart> {
    let model = model(&BLOCK);
    let radius = prop_oneof![
        Just(model.tool_radius_min().unwrap() * model.unit_m() * 1.0001),
        0.001_f32..0.02,
        Just(100.0),
    ];
    (radius, 0..4_u8, prop::array::uniform3(0.0_f32..0.02)).prop_map(|(radius_m, kind, half_m)| {
        match kind {
            0 => ToolPart::sphere(radius_m),
            1 => ToolPart::capsule(half_m[2], radius_m),
            2 => ToolPart::rounded_box(half_m, radius_m),
            _ => ToolPart::half_space(radius_m),
        }
    })
}

fn tools() -> impl Strategy<Value = Vec<Vec<ToolPart>>> {
    prop_oneof![
        4 => prop::collection::vec(prop::collection::vec(part(), 1..4), 1..4),
        1 => prop::collection::vec(part(), 8).prop_map(|parts| vec![parts; 8]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn any_poses_grips_and_resets(
        tools in tools(), friction in prop::sample::select(vec![0.0_f32, 0.3, 10.0]),
        sweeps in 1_u16..5, steps in steps(8),
    ) {
        let way = (Scheme::Predict, sweeps);
        // Parts beyond the largest coordinate are refused.
        let monitor = play(|| engine(&BLOCK, &tools, friction, way), Arithmetic::F32, None, steps);
        monitor.map_or(Ok(()), |monitor| holds(&monitor))?;
    }

    /// Memory for one triangle and one held sample.
    #[test]
    fn the_smallest_memory_is_enough(steps in steps(1), radius_m in 0.002_f32..0.03) {
        let model = model(&BLOCK);
        let network = Network::new(model, Settings::for_model(&model)).unwrap();
        let mut tissue = Box::new(Memory::<64, Predict<2048>, 1, { term_states(64) }>::new());
        let mut store = Box::new(TouchStore::<64, 1, 1, 1>::new());
        let mut tissue = tissue.touching(store.room());
        tissue.reset(&network).unwrap();
        tissue.choose_tools(&network, &[&[ToolPart::sphere(radius_m)]], 0.5).unwrap();
        for Step { act, poses, sweeps } in &steps {
            match act {
                None => {}
                Some(Act::Grip(tool)) => prop_assert!(tissue.grip(&network, *tool) < 100),
                Some(Act::LetGo(tool, ticks)) => tissue.let_go(*tool, *ticks),
                Some(Act::Reset) => tissue.reset(&network).unwrap(),
            }
            let output = tissue.tick(&network, poses, Budget::again(*sweeps));
            prop_assert!(output.force_n.iter().all(|x| x.is_finite()), "{output:?}");
            prop_assert!(output.energy_j.is_finite() && output.energy_j >= 0.0, "{output:?}");
        }
    }
}
