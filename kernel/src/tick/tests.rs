//! Bodies with pins, a second term beside the links: what holds for the energy of links holds for
//! the sum of both.

use std::vec::Vec;

use fixed::types::I8F24;
use nalgebra::Vector3;

use super::choices::{Drive, Unloading};
use super::sample::{Flags, ToolSample};
use super::settings::{Network, Settings};
use super::tissue::Tissue;
use crate::model::image::{ModelError, kind, params};
use crate::model::pin::{PINS, Pin};
use crate::model::{Model, range};
use crate::number::Number;
use crate::solver::{Dynamics, Euler, GaussSeidel, Rkl1, Rkl2, Track};
use crate::terms::tests::{pinned, with_word};

/// 299 cells, 20 of them fixed; bands, weights, slices, 24 basis functions, colours and a surface.
static ORGAN: &[u8] = crate::include_model!("../../../tests/data/varied300.chaincell");
const CELLS: usize = 299;
/// Blocks for a coarse level with 16 held cells or a probe.
const ROOM: usize = 160;

type Body<D> = Tissue<CELLS, D, 16>;

/// Numbers from -1 to 1 without a pattern.
fn noise(n: usize) -> f32 {
    (n as f32 * 0.618_034 + 0.3 * (n / 7) as f32) % 1.0 * 2.0 - 1.0
}

/// A pin at every tenth free cell, drawn away from its place at rest by up to `reach`.
fn pins(model: &Model<'_>, reach: f32) -> Vec<Pin> {
    let free = (0..model.cells()).filter(|&cell| !model.is_fixed(cell as u16));
    let pin = |cell: usize| {
        let at = model.rest_position(cell);
        let point = [0, 1, 2].map(|axis| at[axis] + reach * noise(3 * cell + axis));
        Pin { cell, point, weight: 2.0 + 1.5 * noise(cell) }
    };
    free.step_by(10).map(pin).collect()
}

fn organ(reach: f32) -> Model<'static> {
    let pins = pins(&Model::from_bytes(ORGAN).unwrap(), reach);
    Model::from_bytes(pinned(ORGAN, &pins, false)).unwrap()
}

fn network(model: Model<'static>, drive: Drive) -> Network<'static> {
    let settings = Settings { unloading: Unloading::Off, drive, ..Settings::for_model(&model) };
    Network::new(model, settings).unwrap()
}

/// The energy of the published state \[J\], and what rounding may make of it, in double precision.
fn energy<D: Dynamics>(tissue: &mut Body<D>, model: &Model<'_>) -> [f64; 2] {
    let tissue = tissue.view();
    let at = |cell| tissue.position(model, cell).unwrap().map(Number::double);
    let distance = |a: [f64; 3], b: [f64; 3]| {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    let (mut stored, mut rounding) = (0.0, 0.0);
    let mut add = |weight: f32, d: f64, u: f64| {
        stored += f64::from(weight) * d * d / 4.0;
        rounding += f64::from(weight) * u * d;
    };
    for i in 0..model.cells() {
        for link in model.row(i) {
            let u = distance(at(i), at(usize::from(model.upper[link])));
            let (l0, alpha) =
                (f64::from(model.rest_length[link]), f64::from(model.link_alpha(link)));
            add(model.link_weight(link), u - u.clamp(l0 * (1.0 - alpha), l0 * (1.0 + alpha)), u);
        }
    }
    for pin in model.others.0.iter() {
        let d = distance(at(pin.cell), pin.point.map(f64::from));
        add(pin.weight, d, d);
    }
    let unit = f64::from(model.energy_unit_j());
    [stored * unit, (stored + rounding) * unit]
}

fn press<D: Dynamics>(
    tissue: &mut Body<D>,
    network: &Network<'_>,
    way_m: [f32; 3],
    on: u32,
) -> super::sample::TickOutput {
    tissue.tick(network, &ToolSample { position_m: Vector3::from(way_m), engaged: on })
}

/// How the tool acts.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tool {
    Held,
    Current,
    Probe,
}

/// Presses, stays, presses on and lets go; where nothing acts from outside the level never rises,
/// and it bounds the energy. The number of passes that the guard discarded, and the last hash.
fn session<D: Dynamics>(
    model: Model<'static>,
    tool: Tool,
    prepare: impl Fn(&mut Body<D>, &Model<'_>),
) -> (usize, u64) {
    let drive = if tool == Tool::Current { Drive::Current } else { Drive::Position };
    let network = network(model, drive);
    let mut tissue = Body::<D>::new();
    tissue.reset(&network).unwrap();
    prepare(&mut tissue, &model);
    match tool {
        Tool::Probe => tissue.choose_probe(&network, 2.0 * model.unit_m()).unwrap(),
        // Some of these cells have pins.
        _ => {
            let free = (0..CELLS as u16).filter(|&cell| !model.is_fixed(cell));
            let cells: Vec<u16> = free.skip(100).step_by(5).take(9).collect();
            tissue.choose_contacts(&network, &cells).unwrap();
        }
    }
    let surface = model.rest_position(usize::from(model.surface()[40]));
    let start = [0, 1, 2].map(|axis| match tool {
        Tool::Probe => model.centre_m()[axis] + surface[axis] * model.unit_m(),
        _ => 0.0,
    });
    let (mut discarded, mut last) = (0, f64::INFINITY);
    for tick in 0..96_usize {
        let moves = (1..=8).contains(&(tick % 24));
        let depth = if tool == Tool::Current { 0.05 } else { 0.3 };
        let reach = depth * (tick / 24 * 8 + (tick % 24).min(8)) as f32 * model.unit_m();
        let way = [0, 1, 2].map(|axis| start[axis] + reach * noise(axis + 5));
        let engaged = u32::from(tick < 72);
        let output = press(&mut tissue, &network, way, engaged);
        let acts = moves || tick == 72;
        let [energy, rounding] = energy(&mut tissue, &model);
        let level = f64::from(output.energy_j);
        let grain = match D::Number::NAME {
            "fixed" => 4e-6 * rounding + 1e-6 * f64::from(model.energy_unit_j()),
            _ => 4.0 * f64::from(f32::EPSILON) * rounding,
        };
        // A probe at rest still pushes out the cells that come to it.
        let pushed = f64::from(output.work_j.max(0.0)) + grain;
        let most = if tool == Tool::Probe { last + pushed } else { last };
        let case = (D::NAME, tool, tick);
        if D::NAME != "euler" {
            assert!(energy <= level + grain, "{case:?}: {energy} above {level}");
            let acts = acts || tool == Tool::Current;
            assert!(acts || level <= most, "{case:?}: {level} above {most}");
        }
        last = level;
        discarded += usize::from(output.flags.contains(Flags::ROLLED_BACK));
    }
    (discarded, tissue.view().state_hash(&model))
}

fn all_tools<D: Dynamics>(prepare: impl Fn(&mut Body<D>, &Model<'_>)) -> [(usize, u64); 3] {
    [Tool::Held, Tool::Current, Tool::Probe].map(|tool| session::<D>(organ(0.8), tool, &prepare))
}

/// Puts every cell anywhere within reach of K.
fn exploded<D: Dynamics>(tissue: &mut Body<D>, model: &Model<'_>) {
    let k = 0.9 * model.saturation();
    let at = |cell: usize| [0, 1, 2].map(|axis| k * noise(3 * cell + axis));
    let positions: Vec<[f32; 3]> = (0..CELLS).map(at).collect();
    let network = network(organ(0.8), Drive::Position);
    tissue.view().set_positions(&network, &positions).unwrap();
}

#[test]
fn with_pins_the_level_never_rises_and_bounds_the_energy() {
    let mut discarded = 0;
    macro_rules! under {
        ($($dynamics:ty),*) => {$(
            discarded += all_tools::<$dynamics>(|_, _| {}).iter().map(|of| of.0).sum::<usize>();
            discarded += all_tools::<$dynamics>(exploded).iter().map(|of| of.0).sum::<usize>();
        )*};
    }
    under!(Track<ROOM>, Track<0, f64>, Track<0, I8F24>, Euler, Rkl1, Rkl2, GaussSeidel);
    // The guard was put to the test.
    assert!(discarded > 0);
}

#[test]
fn with_pins_all_loops_give_the_same_bits() {
    let hashes = |prepare: fn(&mut Body<Track<ROOM>>, &Model<'_>)| {
        all_tools::<Track<ROOM>>(prepare).map(|of| of.1)
    };
    let plain = hashes(|_, _| {});
    assert_eq!(plain, hashes(|tissue, _| tissue.view().go_scalar()), "without the vector unit");
    assert_eq!(plain, hashes(|tissue, model| tissue.view().forbid_sleep(model)), "without sleep");
    let hashes =
        |prepare: fn(&mut Body<Rkl2>, &Model<'_>)| all_tools::<Rkl2>(prepare).map(|of| of.1);
    assert_eq!(
        hashes(|_, _| {}),
        hashes(|tissue, _| tissue.view().go_scalar()),
        "without the vector unit"
    );
}

/// A body that floats between its pins: at equilibrium they carry the tool's force.
#[test]
fn the_pins_carry_the_force() {
    let organ = Model::from_bytes(ORGAN).unwrap();
    let pins: Vec<Pin> = pins(&organ, 0.0).into_iter().step_by(3).collect();
    let model = Model::from_bytes(pinned(ORGAN, &pins, true)).unwrap();
    assert!(model.fixed().is_empty());
    let network = network(model, Drive::Position);
    let mut tissue = Tissue::<CELLS, Track>::new();
    tissue.reset(&network).unwrap();
    // The first of them has a pin.
    let first = pins[2].cell as u16;
    tissue.choose_contacts(&network, &[first, first + 60, first + 61]).unwrap();
    let way_m = [1.0, -2.0, 0.5].map(|way| way * model.unit_m());
    let mut force = [0.0; 3];
    for tick in 0..3000 {
        let position_m = if tick == 0 { Vector3::zeros() } else { Vector3::from(way_m) };
        force = tissue.tick(&network, &ToolSample { position_m, engaged: 1 }).force_n.into();
    }
    let view = tissue.view();
    for (axis, force) in force.into_iter().enumerate() {
        let carried: f32 = pins
            .iter()
            .map(|pin| {
                let here = view.position(&model, pin.cell).unwrap()[axis];
                0.5 * pin.weight * (pin.point[axis] - here) * model.force_unit_n()
            })
            .sum();
        let size = way_m[axis].abs() * model.stiffness_n_per_m();
        assert!(
            (force - carried).abs() < 1e-3 * size && force.abs() > 0.1 * size,
            "{force} {carried}"
        );
        assert!(force * way_m[axis] < 0.0);
    }
}

#[test]
fn pins_at_their_places_leave_a_body_at_rest() {
    let model = organ(0.0);
    let network = network(model, Drive::Position);
    let mut tissue = Body::<Track<ROOM>>::new();
    tissue.reset(&network).unwrap();
    let rest = tissue.view().state_hash(&model);
    for _ in 0..40 {
        let output = press(&mut tissue, &network, [0.0; 3], 0);
        assert_eq!((output.energy_j, tissue.view().state_hash(&model)), (0.0, rest));
    }
    assert!(tissue.view().head.awake.set.is_empty(range(&[0, 0], 0).len() + model.slice_count()));
}

#[test]
fn pins_that_cannot_be_are_refused() {
    let organ = Model::from_bytes(ORGAN).unwrap();
    let refused =
        |pins: &[Pin]| Model::from_bytes(pinned(ORGAN, pins, false)).map(|_| ()).unwrap_err();
    let good = pins(&organ, 0.1);
    let mut back = good.clone();
    back.swap(0, 1);
    assert_eq!(refused(&back), ModelError::Index(PINS, 1));
    let mut far = good.clone();
    far[2].point[1] = f32::NAN;
    assert_eq!(refused(&far), ModelError::Value(PINS, 2));
    let mut void = good.clone();
    void[0].weight = 0.0;
    assert_eq!(refused(&void), ModelError::Value(PINS, 0));
    // The largest step was worked out without them.
    let mut stiff = good;
    stiff[0].weight = 1000.0;
    let baked = pinned(ORGAN, &stiff, false);
    assert!(Model::from_bytes(baked).is_ok());
    let (word, bound) = (params::DEGREE_BOUND, organ.degree_bound.to_bits());
    let error =
        Model::from_bytes(with_word(baked, kind::PARAMS, word, bound)).map(|_| ()).unwrap_err();
    assert_eq!(error, ModelError::Parameter(params::DEGREE_BOUND as u32));
}
