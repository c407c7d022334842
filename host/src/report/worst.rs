//! The worst state: every position scaled by 1.5, so that every link is out of its band.

use std::time::Instant;

use serde::Serialize;

use super::press::engine;
use super::scene::Scene;
use crate::baseline::{Baseline, PerCell};
use crate::cosim::histogram::{Latencies, Summary};
use crate::engine::Scheme;
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

/// Positions of the worst state.
fn scaled(model: &Model<'_>) -> Vec<[f32; 3]> {
    (0..model.cells()).map(|cell| model.rest_position(cell).map(|x| SCALE * x)).collect()
}

/// Times of ticks that start from the worst state.
///
/// # Errors
/// As the engine.
pub fn tick_times(scene: &Scene, scheme: Scheme, sweeps: u16) -> Result<Summary> {
    let positions = scaled(&scene.model()?);
    let mut engine = engine(scene, scheme, sweeps)?;
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
    /// A sweep of `track` in a tick of its own, everything included, median \[ns\].
    pub simd_ns: u64,
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
    let positions = scaled(&model);
    let mut engine = engine(scene, Scheme::Track, 1)?;
    let mut plain = PerCell::new(&model);
    let mut times = [Latencies::new()?, Latencies::new()?, Latencies::new()?];
    let mut timed = |which: usize, work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        times[which].record(start.elapsed().as_nanos() as u64);
    };
    for _ in 0..rounds {
        plain.set_positions(&positions);
        timed(0, &mut || plain.step());
        engine.set_positions(&positions)?;
        // The first sweep takes no momentum along; the second is one of many.
        timed(1, &mut || {
            engine.tick(&RELEASED);
        });
        timed(2, &mut || {
            engine.tick(&RELEASED);
        });
    }
    engine.set_positions(&positions)?;
    engine.tick(&RELEASED);
    let [scalar, first, later] = times.map(|times| times.summary());
    Ok(Sweep {
        cells: model.cells(),
        links: model.links(),
        taut_links: taut(&Links::of_model(&model), &super::press::field(&mut engine)),
        scalar_ns: scalar.p50,
        simd_ns: later.p50,
        simd_first_ns: first.p50,
        noise: scalar.p99 as f64 / scalar.p50.max(1) as f64,
    })
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
