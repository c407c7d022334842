//! Tools on a surface under any input: answers stay finite, the level never falls below 0, and scalar and
//! vector units give the same bits.
#![allow(clippy::unwrap_used)]

use std::sync::LazyLock;

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{
    Budget, Model, NOT_TURNED, Network, Predict, Settings, Tissue as Memory, ToolPart, ToolPose,
    TouchStore, Unloading,
};
use proptest::prelude::*;

/// A block of liver on a fixed ground, 30 mm high.
static BLOCK: LazyLock<ImageBytes> = LazyLock::new(|| {
    let mesh = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
    let tissue = Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45)));
    let options = BakeOptions { tissue, ..BakeOptions::default() };
    bake(&mesh, &mesh.default_fixed, &options).unwrap()
});

fn model() -> Model<'static> {
    Model::from_bytes(BLOCK.as_bytes()).unwrap()
}

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
        position_m: at.into(),
        orientation,
        engaged,
    });
    prop::collection::vec(pose, 0..=tools)
}

#[derive(Debug, Clone)]
enum Act {
    Ticks(Vec<ToolPose>, u8),
    Late(ToolPose),
    Grip(usize),
    LetGo(usize, u16),
    Reset,
}

fn acts(tools: usize) -> impl Strategy<Value = Vec<Act>> {
    let act = prop_oneof![
        8 => (poses(tools), 1_u8..6).prop_map(|(poses, times)| Act::Ticks(poses, times)),
        2 => poses(1).prop_map(|poses| {
            poses.first().copied().map_or(Act::Reset, Act::Late)
        }),
        2 => (0..9_usize).prop_map(Act::Grip),
        1 => (0..9_usize, 0..3_u16).prop_map(|(tool, ticks)| Act::LetGo(tool, ticks)),
        1 => Just(Act::Reset),
    ];
    prop::collection::vec(act, 1..25)
}

/// Parts of all kinds, from the smallest radius that there may be up to 100 m.
fn part() -> impl Strategy<Value = ToolPart> {
    let radius = prop_oneof![
        Just(model().tool_radius_min().unwrap() * model().unit_m() * 1.0001),
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

fn engine(tools: &[Vec<ToolPart>], friction: f32, sweeps: u16) -> Option<Engine<'static>> {
    let model = model();
    let unloading = Unloading::Off;
    let settings =
        Settings { sweeps, unloading, max_tool_step_m: 1.0e3, ..Settings::for_model(&model) };
    let contact = Contact::Tools { tools: tools.to_vec(), friction };
    let network = Network::new(model, settings).unwrap();
    // Parts beyond the largest coordinate are refused.
    Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact).ok()
}

/// What an act answers, as bits.
fn act(engine: &mut Engine<'_>, act: &Act, tools: usize) -> Vec<u32> {
    let mut bits = Vec::new();
    let mut see = |output: &chaincell_kernel::TickOutput| {
        let [x, y, z]: [f32; 3] = output.force_n.into();
        let all = [x, y, z, output.energy_j, output.work_j];
        assert!(all.iter().all(|x| x.is_finite()) && output.energy_j >= 0.0, "{output:?}");
        bits.extend(all.map(f32::to_bits));
    };
    match act {
        Act::Ticks(poses, times) => {
            (0..*times).for_each(|_| see(&engine.tick_by(poses, Budget::All)))
        }
        Act::Late(pose) => {
            let ToolPose { position_m, engaged, .. } = *pose;
            see(&engine.tick_by(&[ToolPose::at(position_m, engaged)], Budget::again(Some(0))));
        }
        Act::Grip(tool) => bits.push(engine.grip(*tool) as u32),
        Act::LetGo(tool, ticks) => engine.let_go(*tool, *ticks),
        Act::Reset => {}
    }
    for tool in 0..tools {
        let output = engine.tool_output(tool);
        let [x, y, z]: [f32; 3] = output.force_n.into();
        let [a, b, c]: [f32; 3] = output.torque_n_m.into();
        let all = [x, y, z, a, b, c, output.work_j, output.stiffness_n_per_m];
        assert!(all.iter().all(|x| x.is_finite()), "{output:?}");
        bits.extend(all.map(f32::to_bits));
    }
    for of in engine.contact_forces() {
        let all = [of.position_m, of.normal_n, of.tangential_n];
        assert!(all.as_flattened().iter().all(|x| x.is_finite()), "{of:?}");
    }
    assert!(engine.positions().as_flattened().iter().all(|x| x.is_finite()));
    bits
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn any_poses_grips_and_resets_give_finite_answers_and_the_same_bits(
        tools in tools(), friction in prop::sample::select(vec![0.0_f32, 0.3, 10.0]),
        sweeps in 1_u16..5, acts in acts(8),
    ) {
        let new = || engine(&tools, friction, sweeps);
        let (Some(mut one), Some(mut other)) = (new(), new()) else { return Ok(()) };
        other.go_scalar();
        for next in &acts {
            if let Act::Reset = next {
                one.reset().unwrap();
                other.reset().unwrap();
                other.go_scalar();
            }
            prop_assert_eq!(act(&mut one, next, tools.len()), act(&mut other, next, tools.len()));
            prop_assert_eq!(one.state_hash(), other.state_hash());
        }
    }

    /// Room for one triangle and one held sample.
    #[test]
    fn the_smallest_room_is_enough_for_any_acts(acts in acts(1), radius_m in 0.002_f32..0.03) {
        let model = model();
        let network = Network::new(model, Settings::for_model(&model)).unwrap();
        let mut tissue = Box::new(Memory::<64, Predict<2048>, 1, 64>::new());
        let mut store = Box::new(TouchStore::<64, 1, 1, 1>::new());
        let mut tissue = tissue.touching(store.room());
        tissue.reset(&network).unwrap();
        tissue.choose_tools(&network, &[&[ToolPart::sphere(radius_m)]], 0.5).unwrap();
        for next in &acts {
            let output = match next {
                Act::Ticks(poses, _) => tissue.tick(&network, poses, Budget::All),
                Act::Late(pose) => tissue.tick(&network, &[*pose], Budget::LATE),
                Act::Grip(tool) => {
                    prop_assert!(tissue.grip(&network, *tool) < 100);
                    continue;
                }
                Act::LetGo(tool, ticks) => {
                    tissue.let_go(*tool, *ticks);
                    continue;
                }
                Act::Reset => {
                    tissue.reset(&network).unwrap();
                    continue;
                }
            };
            prop_assert!(output.force_n.iter().all(|x| x.is_finite()), "{output:?}");
            prop_assert!(output.energy_j.is_finite() && output.energy_j >= 0.0, "{output:?}");
        }
    }
}
