//! The paper's plane against trajectories of its differential equation, integrated elsewhere to
//! 1e-9 m (DOP853, relative tolerance 1e-10): 21 x 21 cells, 10 mm apart, border fixed, centre
//! held 50 mm up from t = 0.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::bake::{BakeOptions, PerCell, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Model, Network, Settings, ToolSample, Unloading};
use nalgebra::Vector3;

const CENTRE: u32 = 220;
const DEPTH_M: f32 = 0.05;

/// Columns of the table: positions at t = 1, 10, 100, and at the energy minimum where given.
struct Reference(Vec<Vec<[f64; 3]>>);

fn reference(text: &str) -> Reference {
    let rows: Vec<Vec<f64>> = (text.lines().skip(1))
        .map(|row| row.split(',').skip(1).map(|x| x.parse().unwrap()).collect())
        .collect();
    let moments = rows[0].len() / 3;
    let at = |moment: usize| {
        rows.iter().map(|row| std::array::from_fn(|axis| row[3 * moment + axis])).collect()
    };
    Reference((0..moments).map(at).collect())
}

/// Positions by input id at t = 1, 10 and 100, and the force at t = 100.
fn run(diagonals: bool, alpha: f64, scheme: Scheme, step: f32) -> (Vec<Vec<[f64; 3]>>, f64) {
    let options = MeshOptions { diagonals, ..MeshOptions::default() };
    let mesh = load("plane:21x21x0.01", &options).unwrap();
    let stiffness = PerCell::Uniform(0.5);
    let options = BakeOptions {
        alpha: PerCell::Uniform(alpha),
        stiffness_n_per_m: stiffness,
        colours: true,
        ..BakeOptions::default()
    };
    let image = bake(&mesh, &mesh.border, &options).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let settings = Settings {
        sweeps: 1,
        step,
        max_tool_step_m: 1.0,
        unloading: Unloading::Off,
        ..Settings::for_model(&model)
    };
    let network = Network::new(model, settings).unwrap();
    let centre = model.input_id().iter().position(|&id| id == CENTRE).unwrap() as u16;
    let mut engine = Engine::new(network, scheme, &[centre]).unwrap();
    let at = |z| ToolSample { position_m: Vector3::new(0.0, 0.0, z), engaged: 1 };
    let mut snapshots = Vec::new();
    let mut force_n = 0.0;
    engine.tick(&at(0.0));
    let ticks = (100.0 / step).round() as u32;
    for tick in 1..=ticks {
        force_n = f64::from(engine.tick(&at(DEPTH_M)).force_n.z);
        if [ticks / 100, ticks / 10, ticks].contains(&tick) {
            snapshots.push(by_id(&mut engine));
        }
    }
    (snapshots, force_n)
}

fn by_id(engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
    let positions_m = engine.positions_m();
    let input_id = engine.network().model().input_id();
    let mut by_id = vec![[0.0; 3]; positions_m.len()];
    for (position, &id) in positions_m.into_iter().zip(input_id) {
        by_id[id as usize] = position;
    }
    by_id
}

fn largest_distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let distance = |(a, b): (&[f64; 3], &[f64; 3])| {
        (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
    };
    a.iter().zip(b).map(distance).fold(0.0, f64::max)
}

fn converges_at_first_order(text: &str, diagonals: bool, alpha: f64) {
    let Reference(exact) = reference(text);
    let (coarse, _) = run(diagonals, alpha, Scheme::Euler, 0.02);
    let (fine, _) = run(diagonals, alpha, Scheme::Euler, 0.01);
    for moment in 0..3 {
        let errors = [&coarse, &fine].map(|x| largest_distance(&x[moment], &exact[moment]));
        println!("t = {}: {:.3e} m, {:.3e} m", [1, 10, 100][moment], errors[0], errors[1]);
        if moment < 2 {
            let ratio = errors[0] / errors[1];
            assert!((1.9..2.1).contains(&ratio), "moment {moment}: ratio {ratio}");
        }
    }
    let last = |moment: usize| largest_distance(&fine[moment], &exact[moment]);
    assert!(last(0) < 3.5e-5, "t = 1: {:e}", last(0));
    assert!(last(2) < 1e-5, "t = 100: {:e}", last(2));
}

#[test]
fn euler_converges_with_8_neighbours() {
    converges_at_first_order(include_str!("../../data/plane_c8_a000_d050.csv"), true, 0.0);
}

#[test]
fn euler_converges_with_4_neighbours() {
    converges_at_first_order(include_str!("../../data/plane_c4_a000_d050.csv"), false, 0.0);
}

#[test]
fn euler_converges_with_a_band() {
    converges_at_first_order(include_str!("../../data/plane_c4_a100_d050.csv"), false, 0.1);
}

/// Cell by cell in place, far more slowly than `track` and without its memory.
#[test]
fn gauss_seidel_finds_the_minimum() {
    let Reference(exact) = reference(include_str!("../../data/plane_c8_a000_d050.csv"));
    let (positions, _) = run(true, 0.0, Scheme::GaussSeidel, 0.01);
    let errors: Vec<f64> =
        positions.iter().map(|positions| largest_distance(positions, &exact[3])).collect();
    println!("after 100, 1000, 10000 passes: {errors:?} m");
    assert!(errors[2] < 5e-6 && errors[1] < 5e-4);
}

/// `track` answers the static question: the energy minimum, unique without a band.
#[test]
fn track_finds_the_minimum() {
    let Reference(exact) = reference(include_str!("../../data/plane_c8_a000_d050.csv"));
    let (positions, _) = run(true, 0.0, Scheme::Track, 0.1);
    let errors: Vec<f64> =
        positions.iter().map(|positions| largest_distance(positions, &exact[3])).collect();
    println!("after 10, 100, 1000 passes: {errors:?} m");
    assert!(errors[2] < 1e-5 && errors[1] < 5e-3);
}

/// Whether one tick over the times 1, 10 and 100, in so many sweeps each, ends within `error` of
/// the depth; with a fraction of them it does not.
fn one_tick_is_right(
    text: &str,
    diagonals: bool,
    alpha: f64,
    scheme: Scheme,
    error: f64,
    sweeps: [u16; 3],
) {
    let Reference(exact) = reference(text);
    for (moment, (time, sweeps)) in [1.0, 10.0, 100.0].into_iter().zip(sweeps).enumerate() {
        let [off, hurried] = [sweeps, sweeps / 2].map(|sweeps| {
            let there = one_tick(diagonals, alpha, scheme, time, sweeps);
            largest_distance(&there, &exact[moment]) / f64::from(DEPTH_M)
        });
        println!("{scheme:?}, t = {time}: {off:.1e} in {sweeps} passes, {hurried:.1e} in half");
        assert!(off <= error, "t = {time}: {off:e} of the depth in {sweeps} passes");
        assert!(hurried > error, "t = {time}: half the passes do: {hurried:e}");
    }
}

/// Positions by input id after one tick that moves the centre and advances so much time.
fn one_tick(
    diagonals: bool,
    alpha: f64,
    scheme: Scheme,
    tick_time: f32,
    sweeps: u16,
) -> Vec<[f64; 3]> {
    let options = MeshOptions { diagonals, ..MeshOptions::default() };
    let mesh = load("plane:21x21x0.01", &options).unwrap();
    let options = BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() };
    let image = bake(&mesh, &mesh.border, &options).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let settings = Settings {
        tick_time,
        max_tool_step_m: 1.0,
        unloading: Unloading::Off,
        ..scheme.settings(&model, sweeps)
    };
    let network = Network::new(model, settings).unwrap();
    let centre = model.input_id().iter().position(|&id| id == CENTRE).unwrap() as u16;
    let mut engine = Engine::new(network, scheme, &[centre]).unwrap();
    let at = |z| ToolSample { position_m: Vector3::new(0.0, 0.0, z), engaged: 1 };
    engine.tick(&at(0.0));
    engine.tick(&at(DEPTH_M));
    by_id(&mut engine)
}

/// Short super-steps again after every move, however long the body had been left alone: the way
/// back is as exact as the way there.
#[test]
fn rkl2_begins_anew_after_every_move() {
    let path = |scheme: Scheme, ticks: usize, tick_time: f32, sweeps: u16| {
        let mesh = load("plane:21x21x0.01", &MeshOptions::default()).unwrap();
        let image = bake(&mesh, &mesh.border, &BakeOptions::default()).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let settings = Settings {
            tick_time,
            step: tick_time / f32::from(sweeps),
            max_tool_step_m: 1.0,
            unloading: Unloading::Off,
            ..scheme.settings(&model, sweeps)
        };
        let network = Network::new(model, settings).unwrap();
        let centre = model.input_id().iter().position(|&id| id == CENTRE).unwrap() as u16;
        let mut engine = Engine::new(network, scheme, &[centre]).unwrap();
        let at = |z| ToolSample { position_m: Vector3::new(0.0, 0.0, z), engaged: 1 };
        engine.tick(&at(0.0));
        for _ in 0..ticks {
            engine.tick(&at(DEPTH_M));
        }
        engine.tick(&at(0.5 * DEPTH_M));
        by_id(&mut engine)
    };
    let exact = path(Scheme::Euler, 50, 2.0, 400);
    let off = largest_distance(&path(Scheme::Rkl2, 50, 2.0, 20), &exact) / f64::from(DEPTH_M);
    println!("{off:.1e} of the depth");
    assert!(off < 1e-3, "{off:e} of the depth");
}

#[test]
fn rkl2_is_right_in_a_few_passes_with_8_neighbours() {
    let text = include_str!("../../data/plane_c8_a000_d050.csv");
    one_tick_is_right(text, true, 0.0, Scheme::Rkl2, 1e-3, [13, 45, 140]);
}

#[test]
fn rkl2_is_right_in_a_few_passes_with_4_neighbours() {
    let text = include_str!("../../data/plane_c4_a000_d050.csv");
    one_tick_is_right(text, false, 0.0, Scheme::Rkl2, 1e-3, [13, 45, 120]);
}

#[test]
fn rkl2_is_right_in_a_few_passes_with_a_band() {
    let text = include_str!("../../data/plane_c4_a100_d050.csv");
    one_tick_is_right(text, false, 0.1, Scheme::Rkl2, 1e-3, [13, 45, 120]);
}

#[test]
fn rkl1_is_roughly_right_in_fewer_passes() {
    let c8 = include_str!("../../data/plane_c8_a000_d050.csv");
    one_tick_is_right(c8, true, 0.0, Scheme::Rkl1, 1e-2, [13, 35, 100]);
    let c4 = include_str!("../../data/plane_c4_a000_d050.csv");
    one_tick_is_right(c4, false, 0.0, Scheme::Rkl1, 1e-2, [13, 35, 80]);
    let band = include_str!("../../data/plane_c4_a100_d050.csv");
    one_tick_is_right(band, false, 0.1, Scheme::Rkl1, 1e-2, [13, 35, 80]);
}
