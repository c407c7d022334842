//! The worst states: every link out of its band.

use std::time::Instant;

use serde::Serialize;

use super::press::engine;
use super::scene::Scene;
use super::setting::Setting;
use crate::baseline::{Baseline, PerCell};
use crate::reference::Links;
use chaincell_host::engine::Engine;
use chaincell_host::error::Result;
use chaincell_host::session::timing::histogram::{Latencies, Summary};
use chaincell_kernel::{Model, ToolSample};
use nalgebra::Vector3;

/// Factor of the positions.
pub const SCALE: f32 = 1.5;
/// Ticks of a row's worst case.
const TICKS: usize = 25;

/// The tool holds nothing.
const RELEASED: ToolSample = ToolSample { position_m: Vector3::new(0.0, 0.0, 0.0), engaged: 0 };

/// Displacement of the cells in the mixed state [mean link lengths].
const SHAKE: f32 = 0.3;

/// Rest positions shaken: every link out of its band, too long or too short as it falls out, which
/// a branch predictor cannot know.
fn shaken(model: &Model<'_>) -> Vec<[f32; 3]> {
    // The golden ratio's multiples fill the interval evenly and are the same on every machine.
    let share = |at: usize| (at as f64 * 0.618_033_988_749_895).fract() as f32 - 0.5;
    let cell = |cell: usize| {
        let rest = model.rest_position(cell);
        std::array::from_fn(|x| rest[x] + 2.0 * SHAKE * share(7 * cell + 3 * x + 1))
    };
    (0..model.cells()).map(cell).collect()
}

/// Positions of the worst state.
fn scaled(model: &Model<'_>) -> Vec<[f32; 3]> {
    (0..model.cells()).map(|cell| model.rest_position(cell).map(|x| SCALE * x)).collect()
}

/// Times of ticks that start from the worst state.
///
/// # Errors
/// As the engine.
pub fn tick_times(scene: &Scene, setting: Setting, sweeps: u16) -> Result<Summary> {
    let positions = scaled(&scene.model()?);
    let mut engine = engine(scene, setting, sweeps)?;
    let mut times = Latencies::new()?;
    for _ in 0..TICKS {
        engine.set_positions(&positions)?;
        let start = Instant::now();
        engine.tick(&RELEASED);
        times.record(start.elapsed().as_nanos() as u64);
    }
    Ok(times.summary())
}

/// Times of one state's sweeps, medians \[ns\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loops {
    /// The plain per-cell loop with its update.
    pub scalar_ns: u64,
    /// A sweep of `track` without a coarse level, everything included, on the vector unit.
    pub simd_ns: u64,
    /// The same without the vector unit: the once-per-link loop of a microcontroller.
    pub once_per_link_ns: u64,
    /// A sweep of `track` with the coarse level that the bake gives the body.
    pub hats_ns: u64,
}

/// A sweep in the worst state, ours beside the plain loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sweep {
    /// Cells.
    pub cells: usize,
    /// Links.
    pub links: usize,
    /// Links out of their band in the timed sweeps: all of them, or it were no worst case.
    pub taut_links: usize,
    /// Links too long and too short as it falls out: nothing to leave out, nothing to foresee.
    #[serde(flatten)]
    pub mixed: Loops,
    /// Every position scaled by 1.5: all links too long, which branch predictors soon know.
    pub stretched: Loops,
    /// 99 % of the plain loop's sweeps, all equal work, over the median: the machine's noise.
    pub noise: f64,
}

/// Measures the sweep in both states, all loops in turn.
///
/// # Errors
/// As the engine.
pub fn sweep(scene: &Scene, rounds: usize) -> Result<Sweep> {
    let model = scene.model()?;
    let states = [shaken(&model), scaled(&model)];
    let bare = Setting { hats: false, ..Setting::TRACK };
    let mut vector = engine(scene, bare, 1)?;
    let mut scalar = engine(scene, bare, 1)?;
    scalar.go_scalar();
    let mut hats = engine(scene, Setting::TRACK, 1)?;
    let mut plain = PerCell::new(&model);
    let mut times = Vec::with_capacity(8);
    for _ in 0..8 {
        times.push(Latencies::new()?);
    }
    for _ in 0..rounds {
        for (state, positions) in states.iter().enumerate() {
            plain.set_positions(positions);
            timed(&mut times[4 * state], &mut || plain.step());
            for (which, engine) in [&mut vector, &mut scalar, &mut hats].into_iter().enumerate() {
                engine.set_positions(positions)?;
                // The first sweep takes no momentum along; the second is one of many.
                tick(engine);
                timed(&mut times[4 * state + 1 + which], &mut || tick(engine));
            }
        }
    }
    let summaries: Vec<Summary> = times.iter().map(Latencies::summary).collect();
    let loops = |state: usize| {
        let p50 = |which: usize| summaries[4 * state + which].p50;
        Loops { scalar_ns: p50(0), simd_ns: p50(1), once_per_link_ns: p50(2), hats_ns: p50(3) }
    };
    Ok(Sweep {
        cells: model.cells(),
        links: model.links(),
        taut_links: taut(&Links::of_model(&model), &states[0]),
        mixed: loops(0),
        stretched: loops(1),
        noise: summaries[0].p99 as f64 / summaries[0].p50.max(1) as f64,
    })
}

/// Times a sweep.
fn timed(times: &mut Latencies, work: &mut dyn FnMut()) {
    let start = Instant::now();
    work();
    times.record(start.elapsed().as_nanos() as u64);
}

/// A tick with the tool away.
fn tick(engine: &mut Engine<'_>) {
    engine.tick(&RELEASED);
}

/// Links out of their band.
fn taut(links: &Links, positions: &[[f32; 3]]) -> usize {
    let at = |cell: u32| positions[cell as usize].map(f64::from);
    let each = links.ends().iter().zip(links.rest_lengths()).zip(links.alphas());
    each.filter(|((ends, l0), alpha)| {
        let ([i, j], l0) = (ends.map(at), **l0);
        let length = (0..3).map(|x| (i[x] - j[x]).powi(2)).sum::<f64>().sqrt();
        (length - l0).abs() > **alpha * l0
    })
    .count()
}
