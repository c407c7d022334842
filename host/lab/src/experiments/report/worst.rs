//! The worst states: every link out of its band.

use serde::Serialize;

use super::press::engine;
use super::scene::Scene;
use super::setting::Setting;
use crate::baseline::{Baseline, PerCell};
use crate::reference::Links;
use crate::reference::vectors::{minus, norm};
use crate::states::State;
use chaincell_host::error::Result;
use chaincell_host::session::timing::histogram::{Latencies, Summary};
use chaincell_kernel::ToolPose;
use nalgebra::Vector3;

/// Ticks of a row's worst case.
const TICKS: usize = 25;

/// The tool holds nothing.
const RELEASED: ToolPose = ToolPose::at(Vector3::new(0.0, 0.0, 0.0), 0);

/// The states of a worst sweep, the mixed one first.
pub const STATES: [State; 2] = [State::Shaken, State::Stretched];

/// Times of ticks that start from the worst state.
///
/// # Errors
/// As the engine.
pub fn tick_times(scene: &Scene, setting: Setting, sweeps: u16) -> Result<Summary> {
    let positions = State::Stretched.positions(&scene.model()?, 0);
    let mut engine = engine(scene, setting, sweeps)?;
    let mut times = Latencies::new()?;
    for _ in 0..TICKS {
        engine.set_positions(&positions)?;
        times.time(|| engine.tick(&RELEASED));
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

/// Loops of a worst sweep, in the order of [`measure`].
pub const LOOPS: [&str; 4] = [
    "plain loop over the cells",
    "track, vector unit",
    "track, scalar",
    "track with a coarse level",
];

/// Times of a sweep in each of the [`STATES`] and [`LOOPS`], all loops in turn, so that a slow
/// spell of the machine meets all of them.
///
/// # Errors
/// As the engine.
pub fn measure(scene: &Scene, rounds: usize) -> Result<[[Summary; 4]; 2]> {
    let model = scene.model()?;
    let states = STATES.map(|state| state.positions(&model, 0));
    let bare = Setting { coarse: false, ..Setting::TRACK };
    let mut vector = engine(scene, bare, 1)?;
    let mut scalar = engine(scene, bare, 1)?;
    scalar.go_scalar();
    let mut coarse = engine(scene, Setting::TRACK, 1)?;
    let mut plain = PerCell::new(&model);
    let mut times = Vec::with_capacity(8);
    for _ in 0..8 {
        times.push(Latencies::new()?);
    }
    for _ in 0..rounds {
        for (state, positions) in states.iter().enumerate() {
            plain.set_positions(positions);
            times[4 * state].time(|| plain.step());
            for (which, engine) in [&mut vector, &mut scalar, &mut coarse].into_iter().enumerate() {
                engine.set_positions(positions)?;
                // The first sweep takes no momentum along; the second is one of many.
                engine.tick(&RELEASED);
                times[4 * state + 1 + which].time(|| engine.tick(&RELEASED));
            }
        }
    }
    let of = |state: usize| std::array::from_fn(|which| times[4 * state + which].summary());
    Ok([of(0), of(1)])
}

/// Measures the sweep in both states.
///
/// # Errors
/// As the engine.
pub fn sweep(scene: &Scene, rounds: usize) -> Result<Sweep> {
    let model = scene.model()?;
    let [mixed, stretched] = measure(scene, rounds)?;
    let loops = |of: [Summary; 4]| {
        let [scalar_ns, simd_ns, once_per_link_ns, hats_ns] = of.map(|summary| summary.p50);
        Loops { scalar_ns, simd_ns, once_per_link_ns, hats_ns }
    };
    Ok(Sweep {
        cells: model.cells(),
        links: model.links(),
        taut_links: taut(&Links::of_model(&model), &STATES[0].positions(&model, 0)),
        mixed: loops(mixed),
        stretched: loops(stretched),
        noise: mixed[0].p99 as f64 / mixed[0].p50.max(1) as f64,
    })
}

/// Links out of their band.
fn taut(links: &Links, positions: &[[f32; 3]]) -> usize {
    let at = |cell: u32| positions[cell as usize].map(f64::from);
    let each = links.ends().iter().zip(links.rest_lengths()).zip(links.alphas());
    each.filter(|((ends, l0), alpha)| {
        let [i, j] = ends.map(at);
        (norm(minus(i, j)) - **l0).abs() > **alpha * **l0
    })
    .count()
}
