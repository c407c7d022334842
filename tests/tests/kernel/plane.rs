//! The paper's plane against trajectories of its differential equation, integrated elsewhere to
//! 1e-9 m (DOP853, relative tolerance 1e-10): 21 x 21 cells, 10 mm apart, border fixed, centre
//! held 50 mm up from t = 0.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Model, Settings, ToolPose};
use chaincell_lab::bodies::Variant;
use chaincell_lab::reference::profile::in_input_order;
use chaincell_lab::reference::vectors::farthest;
use chaincell_tests::graph::sample;

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

/// The plane with 4 or 8 neighbours.
fn plane(diagonals: bool, options: &BakeOptions) -> ImageBytes {
    let mesh =
        load("plane:21x21x0.01", &MeshOptions { diagonals, ..MeshOptions::default() }).unwrap();
    bake(&mesh, &mesh.border, options).unwrap()
}

/// With the tool in contact at its centre.
fn engine(
    image: &ImageBytes,
    scheme: Scheme,
    sweeps: u16,
    change: impl FnOnce(Settings) -> Settings,
) -> Engine<'_> {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let contact = Contact::Cells(vec![model.cell_of_input(CENTRE).unwrap()]);
    let variant = Variant::plain(scheme, Arithmetic::F32);
    let mut engine = variant.unlimited(model, contact, sweeps, change).unwrap();
    engine.tick(&at(0.0));
    engine
}

/// The tool at a height \[m\].
fn at(z_m: f32) -> ToolPose {
    sample([0.0, 0.0, z_m], 1)
}

/// Positions by input id at t = 1, 10 and 100.
fn run(diagonals: bool, alpha: f64, scheme: Scheme, step: f32) -> Vec<Vec<[f64; 3]>> {
    let options = BakeOptions {
        alpha: PerCell::Uniform(alpha),
        stiffness_n_per_m: PerCell::Uniform(0.5),
        ..BakeOptions::default()
    };
    let image = plane(diagonals, &options);
    let mut engine = engine(&image, scheme, 1, |settings| Settings { step, ..settings });
    let mut snapshots = Vec::new();
    let ticks = (100.0 / step).round() as u32;
    for tick in 1..=ticks {
        engine.tick(&at(DEPTH_M));
        if [ticks / 100, ticks / 10, ticks].contains(&tick) {
            snapshots.push(by_id(&mut engine));
        }
    }
    snapshots
}

fn by_id(engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
    let positions_m = engine.positions_m();
    in_input_order(engine.network().model(), &positions_m)
}

fn converges_at_first_order(text: &str, diagonals: bool, alpha: f64) {
    let Reference(exact) = reference(text);
    let coarse = run(diagonals, alpha, Scheme::Euler, 0.02);
    let fine = run(diagonals, alpha, Scheme::Euler, 0.01);
    for moment in 0..3 {
        let errors = [&coarse, &fine].map(|x| farthest(&x[moment], &exact[moment]));
        println!("t = {}: {:.3e} m, {:.3e} m", [1, 10, 100][moment], errors[0], errors[1]);
        if moment < 2 {
            let ratio = errors[0] / errors[1];
            assert!((1.9..2.1).contains(&ratio), "moment {moment}: ratio {ratio}");
        }
    }
    let last = |moment: usize| farthest(&fine[moment], &exact[moment]);
    assert!(last(0) < 3.5e-5, "t = 1: {:e}", last(0));
    assert!(last(2) < 1e-5, "t = 100: {:e}", last(2));
}

// REQ-FOR-07
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

/// `track` answers the static question: the energy minimum, unique without a band.
// REQ-FOR-07
#[test]
fn track_finds_the_minimum() {
    let Reference(exact) = reference(include_str!("../../data/plane_c8_a000_d050.csv"));
    let positions = run(true, 0.0, Scheme::Track, 0.1);
    let errors: Vec<f64> =
        positions.iter().map(|positions| farthest(positions, &exact[3])).collect();
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
            farthest(&there, &exact[moment]) / f64::from(DEPTH_M)
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
    let options = BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() };
    let image = plane(diagonals, &options);
    let mut engine = engine(&image, scheme, sweeps, |settings| Settings { tick_time, ..settings });
    engine.tick(&at(DEPTH_M));
    by_id(&mut engine)
}

/// Short super-steps again after every move, however long the body had been left alone: the way
/// back is as exact as the way there.
#[test]
fn rkl2_begins_anew_after_every_move() {
    let path = |scheme: Scheme, ticks: usize, tick_time: f32, sweeps: u16| {
        let image = plane(false, &BakeOptions::default());
        let step = tick_time / f32::from(sweeps);
        let mut engine =
            engine(&image, scheme, sweeps, |settings| Settings { tick_time, step, ..settings });
        for _ in 0..ticks {
            engine.tick(&at(DEPTH_M));
        }
        engine.tick(&at(0.5 * DEPTH_M));
        by_id(&mut engine)
    };
    let exact = path(Scheme::Euler, 50, 2.0, 400);
    let off = farthest(&path(Scheme::Rkl2, 50, 2.0, 20), &exact) / f64::from(DEPTH_M);
    println!("{off:.1e} of the depth");
    assert!(off < 1e-3, "{off:e} of the depth");
}

// REQ-FOR-07
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
