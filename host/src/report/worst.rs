//! The worst state: every position scaled by 1.5, so that every link is out of its band.

use std::time::Instant;

use serde::Serialize;

use super::press::engine;
use super::scene::Scene;
use super::setting::Setting;
use crate::baseline::{Baseline, PerCell};
use crate::cosim::histogram::{Latencies, Summary};
use crate::engine::{Engine, Scheme};
use crate::error::Result;
use crate::reference::Links;
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

/// A sweep in the worst state, ours beside the plain loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Sweep {
    /// Cells.
    pub cells: usize,
    /// Links.
    pub links: usize,
    /// Links out of their band in the timed sweeps: all of them, or it were no worst case.
    pub taut_links: usize,
    /// The plain per-cell loop with its update, median \[ns\].
    pub scalar_ns: u64,
    /// The same where links are too long and too short by turns, median \[ns\].
    pub scalar_mixed_ns: u64,
    /// A sweep of `track` in a tick of its own, everything included, median \[ns\].
    pub simd_ns: u64,
    /// The same where links are too long and too short by turns, median \[ns\].
    pub simd_mixed_ns: u64,
    /// A sweep of `euler` in the worst state: the link pass and its update without momentum, guard
    /// and coarse level, median \[ns\].
    pub euler_ns: u64,
    /// The same where links are too long and too short by turns, median \[ns\].
    pub euler_mixed_ns: u64,
    /// The first sweep after a state was set, which starts without momentum, median \[ns\].
    pub simd_first_ns: u64,
    /// 99 % of the plain loop's sweeps, all equal work, over the median: the machine's noise.
    pub noise: f64,
}

/// Measures the sweep in the worst state, both loops in turn.
///
/// # Errors
/// As the engine.
pub fn sweep(scene: &Scene, rounds: usize) -> Result<Sweep> {
    let model = scene.model()?;
    let states = [scaled(&model), shaken(&model)];
    let euler = Setting { scheme: Scheme::Euler, hats: true };
    let mut track = engine(scene, Setting::TRACK, 1)?;
    let mut euler = engine(scene, euler, 1)?;
    let mut plain = PerCell::new(&model);
    let mut times = vec![[(); 4].map(|()| Latencies::new()); 2];
    let mut timed = |state: usize, which: usize, work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        if let Ok(times) = &mut times[state][which] {
            times.record(start.elapsed().as_nanos() as u64);
        }
    };
    for _ in 0..rounds {
        for (state, positions) in states.iter().enumerate() {
            plain.set_positions(positions);
            timed(state, 0, &mut || plain.step());
            euler.set_positions(positions)?;
            timed(state, 1, &mut || tick(&mut euler));
            track.set_positions(positions)?;
            // The first sweep takes no momentum along; the second is one of many.
            timed(state, 2, &mut || tick(&mut track));
            timed(state, 3, &mut || tick(&mut track));
        }
    }
    track.set_positions(&states[0])?;
    tick(&mut track);
    let mut summaries = Vec::with_capacity(8);
    for times in times.into_iter().flatten() {
        summaries.push(times?.summary());
    }
    let p50 = |state: usize, which: usize| summaries[4 * state + which].p50;
    Ok(Sweep {
        cells: model.cells(),
        links: model.links(),
        taut_links: taut(&Links::of_model(&model), &super::press::field(&mut track)),
        scalar_ns: p50(0, 0),
        scalar_mixed_ns: p50(1, 0),
        simd_ns: p50(0, 3),
        simd_mixed_ns: p50(1, 3),
        euler_ns: p50(0, 1),
        euler_mixed_ns: p50(1, 1),
        simd_first_ns: p50(0, 2),
        noise: summaries[0].p99 as f64 / summaries[0].p50.max(1) as f64,
    })
}

/// A tick with the tool away.
fn tick(engine: &mut Engine<'_>) {
    engine.tick(&RELEASED);
}

/// Links out of their band.
fn taut(links: &Links, field: &[[f64; 3]]) -> usize {
    let at = |cell: u32| {
        let (rest, u) = (links.rest()[cell as usize], field[cell as usize]);
        [rest[0] + u[0], rest[1] + u[1], rest[2] + u[2]]
    };
    let each = links.ends().iter().zip(links.rest_lengths()).zip(links.alphas());
    each.filter(|((ends, l0), alpha)| {
        let ([i, j], l0) = (ends.map(at), **l0);
        let length = (0..3).map(|x| (i[x] - j[x]).powi(2)).sum::<f64>().sqrt();
        (length - l0).abs() > **alpha * l0
    })
    .count()
}
