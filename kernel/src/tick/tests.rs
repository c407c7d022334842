//! Bodies with pins, a second energy term in addition to the links: the sum obeys the same rules as the
//! links' energy.

mod predict;

use std::vec::Vec;

use fixed::types::I8F24;
use nalgebra::Vector3;

use super::budget::Budget;
use super::choices::{Drive, Unloading};
use super::sample::Flags;
use super::settings::{Network, Settings, SettingsError};
use super::tissue::{Tissue, TissueMut};
use crate::contact::pose::ToolPose;
use crate::energy::pin::{Displaced, displaced, store};
use crate::energy::state::{lasting, term_states};
use crate::energy::tests::{pinned, with_word};
use crate::model::image::{ModelError, kind, params};
use crate::model::pin::{PINS, Pin};
use crate::model::{Model, range};
use crate::number::Number;
use crate::number::two_float::{LANES, TwoFloat};
use crate::solver::{Dynamics, Euler, Predict, Rkl2, Track};

/// 299 cells, 20 of them fixed; bands, weights, slices, 24 basis functions and a surface.
static ORGAN: &[u8] = crate::include_model!("../../../tests/data/varied300.chaincell");
const CELLS: usize = 299;
/// Blocks for a coarse level with 16 held cells.
const ROOM: usize = 160;
/// Length beyond which pins slip [mean link lengths].
const SLIP_LENGTH: f32 = 0.7;

type Body<D> = Tissue<CELLS, D, 16, { term_states(CELLS) }>;

/// Numbers from -1 to 1 without a pattern.
fn noise(n: usize) -> f32 {
    (n as f32 * 0.618_034 + 0.3 * (n / 7) as f32) % 1.0 * 2.0 - 1.0
}

/// A pin at every tenth free cell, displaced from its rest position by up to `reach`.
fn pins(model: &Model<'_>, reach: f32, slip_length: f32, give: f32) -> Vec<Pin> {
    let free = (0..model.cells()).filter(|&cell| !model.is_fixed(cell as u16));
    let pin = |cell: usize| {
        let at = model.rest_position(cell);
        let point = [0, 1, 2].map(|axis| at[axis] + reach * noise(3 * cell + axis));
        Pin { cell, point, weight: 2.0 + 1.5 * noise(cell), slip_length, give }
    };
    free.step_by(10).map(pin).collect()
}

/// The organ with pins that slip and relax by a share.
fn organ(reach: f32, give: f32) -> Model<'static> {
    let pins = pins(&Model::from_bytes(ORGAN).unwrap(), reach, SLIP_LENGTH, give);
    Model::from_bytes(pinned(ORGAN, &pins, false)).unwrap()
}

fn network(model: Model<'static>, drive: Drive) -> Network<'static> {
    let settings = Settings { unloading: Unloading::Off, drive, ..Settings::for_model(&model) };
    Network::new(model, settings).unwrap()
}

/// State of a cell's pin.
fn state<D: Dynamics>(tissue: &TissueMut<'_, D>, cell: usize) -> Displaced {
    let rows = lasting(tissue.states.cells(CELLS), CELLS).nth(cell / LANES).unwrap();
    std::array::from_fn(|at| std::array::from_fn(|axis| rows[3 * at + axis][cell % LANES]))
}

/// Positions and states of all cells.
fn kept<D: Dynamics>(tissue: &mut Body<D>, model: &Model<'_>) -> Vec<([f64; 3], Displaced)> {
    let tissue = tissue.view();
    let at = |cell| tissue.position(model, cell).unwrap().map(Number::double);
    (0..CELLS).map(|cell| (at(cell), state(&tissue, cell))).collect()
}

/// Energy that the relaxing pins add at the start of a tick \[J\].
fn given(
    model: &Model<'_>,
    before: &[([f64; 3], Displaced)],
    after: &[([f64; 3], Displaced)],
) -> f64 {
    let of = |pin: &Pin, state: Displaced| {
        let way = before[pin.cell].0.into_iter().zip(pin.anchor(state).map(f64::from));
        f64::from(pin.weight) / 4.0 * way.map(|(a, b)| (a - b).powi(2)).sum::<f64>()
    };
    let rise = |pin: Pin| {
        let (was, now) = (before[pin.cell].1, after[pin.cell].1);
        of(&pin, [was[0], now[1]]) - of(&pin, was)
    };
    model.others.0.iter().map(rise).sum::<f64>() * f64::from(model.energy_unit_j())
}

/// Energy of the published state \[J\] and its rounding error, in double precision.
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
        let d = distance(at(pin.cell), pin.anchor(state(&tissue, pin.cell)).map(f64::from));
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
    tissue.tick(network, &[ToolPose::at(Vector3::from(way_m), on)], Budget::All)
}

/// Kind of the tool's contact.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tool {
    Held,
    Current,
}

/// Presses, holds, presses on and releases. While nothing external acts the level never rises, and it bounds
/// the energy. Returns the number of passes that the guard discarded, and the last hash.
fn session<D: Dynamics>(
    model: Model<'static>,
    tool: Tool,
    prepare: impl Fn(&mut Body<D>, &Model<'static>),
) -> (usize, u64) {
    let drive = if tool == Tool::Current { Drive::Current } else { Drive::Position };
    let network = network(model, drive);
    let mut tissue = Body::<D>::new();
    tissue.reset(&network).unwrap();
    prepare(&mut tissue, &model);
    // Some of these cells have pins.
    let free = (0..CELLS as u16).filter(|&cell| !model.is_fixed(cell));
    let cells: Vec<u16> = free.skip(100).step_by(5).take(9).collect();
    tissue.choose_contacts(&network, &cells).unwrap();
    let (mut discarded, mut last) = (0, f64::INFINITY);
    let mut before = kept(&mut tissue, &model);
    for tick in 0..96_usize {
        let moves = (1..=8).contains(&(tick % 24));
        let depth = if tool == Tool::Current { 0.05 } else { 0.3 };
        let reach = depth * (tick / 24 * 8 + (tick % 24).min(8)) as f32 * model.unit_m();
        let way = [0, 1, 2].map(|axis| reach * noise(axis + 5));
        let engaged = u32::from(tick < 72);
        let output = press(&mut tissue, &network, way, engaged);
        let acts = moves || tick == 72;
        let [energy, rounding] = energy(&mut tissue, &model);
        let level = f64::from(output.energy_j);
        let grain = match D::Number::NAME {
            "fixed" => 4e-6 * rounding + 1e-6 * f64::from(model.energy_unit_j()),
            _ => 4.0 * f64::from(f32::EPSILON) * rounding,
        };
        let now = kept(&mut tissue, &model);
        let rise = given(&model, &before, &now);
        before = now;
        let most = if rise == 0.0 { last } else { last + rise + grain };
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

fn all_tools<D: Dynamics>(
    give: f32,
    prepare: impl Fn(&mut Body<D>, &Model<'static>),
) -> [(usize, u64); 2] {
    let model = || organ(0.8, give);
    [Tool::Held, Tool::Current].map(|tool| session::<D>(model(), tool, &prepare))
}

/// Sets every cell to an arbitrary position within a share of K.
fn scattered<D: Dynamics>(tissue: &mut Body<D>, model: &Model<'static>, share: f32) {
    let k = share * model.saturation();
    let at = |cell: usize| [0, 1, 2].map(|axis| k * noise(3 * cell + axis));
    let positions: Vec<[f32; 3]> = (0..CELLS).map(at).collect();
    let network = network(*model, Drive::Position);
    tissue.view().set_positions(&network, &positions).unwrap();
}

fn exploded<D: Dynamics>(tissue: &mut Body<D>, model: &Model<'static>) {
    scattered(tissue, model, 0.9);
}

#[test]
fn with_pins_the_level_never_rises_and_bounds_the_energy() {
    let mut discarded = 0;
    macro_rules! under {
        ($($dynamics:ty),*) => {$(
            for give in [0.0, 0.4] {
                let runs = [all_tools::<$dynamics>(give, |_, _| {}), all_tools(give, exploded::<$dynamics>)];
                discarded += runs.as_flattened().iter().map(|of| of.0).sum::<usize>();
            }
        )*};
    }
    under!(Track<ROOM>, Predict<ROOM>, Track<0, I8F24>, Euler, Rkl2);
    // The guard had something to discard.
    assert!(discarded > 0);
}

#[test]
fn with_pins_all_loops_give_the_same_bits() {
    let hashes = |prepare: fn(&mut Body<Track<ROOM>>, &Model<'static>)| {
        all_tools::<Track<ROOM>>(0.4, prepare).map(|of| of.1)
    };
    let plain = hashes(|_, _| {});
    assert_eq!(plain, hashes(|tissue, _| tissue.view().go_scalar()), "without the vector unit");
    assert_eq!(plain, hashes(|tissue, model| tissue.view().forbid_sleep(model)), "without sleep");
    let hashes = |prepare: fn(&mut Body<Rkl2>, &Model<'static>)| {
        all_tools::<Rkl2>(0.4, prepare).map(|of| of.1)
    };
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
    let pins: Vec<Pin> = pins(&organ, 0.0, f32::INFINITY, 0.0).into_iter().step_by(3).collect();
    let model = Model::from_bytes(pinned(ORGAN, &pins, true)).unwrap();
    assert!(model.fixed().is_empty());
    let network = network(model, Drive::Position);
    let mut tissue = Tissue::<CELLS, Track, 64, { term_states(CELLS) }>::new();
    tissue.reset(&network).unwrap();
    // The first of them has a pin.
    let first = pins[2].cell as u16;
    tissue.choose_contacts(&network, &[first, first + 60, first + 61]).unwrap();
    let way_m = [1.0, -2.0, 0.5].map(|way| way * model.unit_m());
    let mut force = [0.0; 3];
    for tick in 0..3000 {
        let position_m = if tick == 0 { Vector3::zeros() } else { Vector3::from(way_m) };
        force = tissue.tick(&network, &[ToolPose::at(position_m, 1)], Budget::All).force_n.into();
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
    let model = organ(0.0, 0.4);
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
fn what_changes_at_the_start_of_a_tick_wakes_its_cell() {
    let model = organ(0.0, 0.4);
    let network = network(model, Drive::Position);
    let mut tissue = Body::<Track<ROOM>>::new();
    tissue.reset(&network).unwrap();
    let rest = tissue.view().state_hash(&model);
    let cell = model.others.0.iter().nth(5).unwrap().cell;
    let mut view = tissue.view();
    let memory = view.states.shared(CELLS).all().change(cell / LANES).unwrap();
    store([[0.0; 3], [0.1, 0.0, 0.0]], cell % LANES, memory);
    assert_ne!(tissue.view().state_hash(&model), rest);
    press(&mut tissue, &network, [0.0; 3], 0);
    let mut view = tissue.view();
    assert!(view.head.awake.set.contains(cell / LANES));
    assert_eq!(displaced(view.states.shared(CELLS).all(), cell), Displaced::default());
}

#[test]
fn pins_that_cannot_be_are_refused() {
    let organ = Model::from_bytes(ORGAN).unwrap();
    let refused =
        |pins: &[Pin]| Model::from_bytes(pinned(ORGAN, pins, false)).map(|_| ()).unwrap_err();
    let good = pins(&organ, 0.1, SLIP_LENGTH, 0.4);
    let mut back = good.clone();
    back.swap(0, 1);
    assert_eq!(refused(&back), ModelError::Index(PINS, 1));
    let mut far = good.clone();
    far[2].point[1] = f32::NAN;
    assert_eq!(refused(&far), ModelError::Value(PINS, 2));
    let mut void = good.clone();
    void[0].weight = 0.0;
    assert_eq!(refused(&void), ModelError::Value(PINS, 0));
    let mut loose = good.clone();
    loose[1].give = 1.0;
    assert_eq!(refused(&loose), ModelError::Value(PINS, 1));
    // The largest step was computed without the pins.
    let mut stiff = good;
    stiff[0].weight = 1000.0;
    let baked = pinned(ORGAN, &stiff, false);
    assert!(Model::from_bytes(baked).is_ok());
    let (word, bound) = (params::DEGREE_BOUND, organ.degree_bound.to_bits());
    let error =
        Model::from_bytes(with_word(baked, kind::PARAMS, word, bound)).map(|_| ()).unwrap_err();
    assert_eq!(error, ModelError::Parameter(params::DEGREE_BOUND as u32));
}

/// After some ticks, all of which end with a pass at the published positions or ahead of them, the guard
/// discards the last pass of a tick: positions and states stay as they were.
fn discards<D: Dynamics>(sweeps: u16, ticks: usize, tolerance: f32) {
    let model = organ(0.8, 0.0);
    let tick_time = D::tick_time(&model, sweeps);
    let settings = Settings { sweeps, tick_time, ..*network(model, Drive::Position).settings() };
    let network = Network::new(model, settings).unwrap();
    let mut tissue = Body::<D>::new();
    tissue.reset(&network).unwrap();
    // Far from K: states beyond K are not restored exactly.
    scattered(&mut tissue, &model, 0.3);
    let mut tick = || press(&mut tissue, &network, [0.0; 3], 0).flags.contains(Flags::ROLLED_BACK);
    let last = (0..ticks).fold(false, |_, _| tick());
    // The pass after a discarded one is accepted in any case.
    while last && tick() {}
    let before = kept(&mut tissue, &model);
    // A level that no state is below.
    tissue.view().head.level.set(TwoFloat::ZERO);
    let output = press(&mut tissue, &network, [0.0; 3], 0);
    assert!(output.flags.contains(Flags::ROLLED_BACK));
    for (before, now) in before.iter().zip(&kept(&mut tissue, &model)) {
        assert_eq!(before.0, now.0);
        for (a, b) in before.1.as_flattened().iter().zip(now.1.as_flattened()) {
            assert!((a - b).abs() <= tolerance, "{} {ticks}: {a} became {b}", D::NAME);
        }
    }
}

#[test]
fn a_discarded_pass_takes_back_what_the_terms_keep() {
    for ticks in 1..8 {
        discards::<Track<ROOM>>(1, ticks, 0.0);
        // The first pass of these ticks is where the last one was: pins slip by rounding alone.
        discards::<Rkl2>(4, ticks, 1e-6);
    }
}

/// A snapshot holds the states of the terms; positions alone, and a reset, forget them.
#[test]
fn a_saved_state_goes_on_with_the_same_bits() {
    let model = organ(0.8, 0.4);
    let network = network(model, Drive::Position);
    let [mut one, mut two] = [(); 2].map(|()| Body::<Track<ROOM>>::new());
    one.reset(&network).unwrap();
    for _ in 0..20 {
        press(&mut one, &network, [0.0; 3], 0);
    }
    let mut bytes = std::vec![0; one.view().snapshot_bytes(&network).unwrap()];
    one.view().save(&network, &mut bytes).unwrap();
    two.view().restore(&network, &bytes).unwrap();
    for _ in 0..40 {
        let outputs = [&mut one, &mut two].map(|of| press(of, &network, [0.0; 3], 0).energy_j);
        assert_eq!(outputs[0].to_bits(), outputs[1].to_bits());
        assert_eq!(kept(&mut one, &model), kept(&mut two, &model));
    }
    let rest = [[0.0; 3]; 2];
    assert!(kept(&mut one, &model).iter().any(|(_, state)| *state != rest));
    let positions: Vec<[f32; 3]> =
        (0..CELLS).map(|cell| one.view().position(&model, cell).unwrap()).collect();
    one.view().set_positions(&network, &positions).unwrap();
    two.reset(&network).unwrap();
    for tissue in [&mut one, &mut two] {
        assert!(kept(tissue, &model).iter().all(|(_, state)| *state == rest));
    }
}

/// A time that is lost in rounding would make no pass: the error reports the smallest, which makes one.
#[test]
fn the_smallest_time_makes_a_pass() {
    let model = Model::from_bytes(ORGAN).unwrap();
    let min = model.tick_time_min();
    for tick_time in [1.0e-45, 0.99 * min, f32::NAN] {
        let settings = Settings { tick_time, ..Settings::for_model(&model) };
        assert_eq!(Network::new(model, settings).err(), Some(SettingsError::TickTime { min }));
    }
    let settings = Settings { tick_time: min, ..Settings::for_model(&model) };
    let network = Network::new(model, settings).unwrap();
    let mut tissue = Body::<Rkl2>::new();
    tissue.reset(&network).unwrap();
    let away = |cell: usize| model.rest_position(cell).map(|x| 1.2 * x);
    let positions: Vec<[f32; 3]> = (0..CELLS).map(away).collect();
    tissue.view().set_positions(&network, &positions).unwrap();
    let output = press(&mut tissue, &network, [0.0; 3], 0);
    assert!(output.energy_j > 0.0 && output.sweeps == settings.sweeps, "{output:?}");
}
