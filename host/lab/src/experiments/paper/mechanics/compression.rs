//! Fig. 5a and the quasi-static half of Fig. 5b: the settled force on the way in and back.

use chaincell_kernel::Unloading;

use super::curve::{Shape, shape, work_j};
use crate::experiments::paper::body::Felt;
use crate::experiments::report::scene::Scene;
use chaincell_host::error::Result;

/// Settled forces at ascending depths.
pub struct Compression {
    /// The curve, the first step first.
    pub curve: Vec<Felt>,
    /// What is read from it.
    pub shape: Shape,
}

/// Presses a body step by step to `deepest_m`, settling at each.
pub fn compress(body: &Scene, deepest_m: f64, steps: u32) -> Result<Compression> {
    let mut tool = body.quasi_static(Unloading::Off)?;
    let depths = (1..=steps).map(|step| deepest_m * f64::from(step) / f64::from(steps));
    let curve: Vec<Felt> = depths.map(|depth_m| tool.settle(depth_m)).collect::<Result<_>>()?;
    let shape = shape(&curve, body.no_force_n()?);
    Ok(Compression { curve, shape })
}

/// A press and its way back, with the links restored to their initial lengths from the turn on.
pub struct Loop {
    /// Displacement and force on the way in, from 0 on \[m, N\].
    pub loading: Vec<[f64; 2]>,
    /// The way back, to 0 \[m, N\].
    pub unloading: Vec<[f64; 2]>,
    /// Work of the tool on the way in \[J\].
    pub loading_work_j: f64,
    /// What the tool got back \[J\].
    pub returned_work_j: f64,
    /// Energy that closing the bands put into the links before the body settled anew: what they
    /// hold at the first point after it, less what they held at the same depth on the way in \[J\].
    pub band_energy_j: f64,
}

impl Loop {
    /// The loop through a way in and a way back.
    pub fn new(loading: Vec<[f64; 2]>, unloading: Vec<[f64; 2]>) -> Self {
        let (loading_work_j, returned_work_j) = (work_j(&loading), -work_j(&unloading));
        Self { loading, unloading, loading_work_j, returned_work_j, band_energy_j: 0.0 }
    }

    /// Area between the paths \[J\]: above 0 where the body kept work, as tissue does; below 0
    /// where the tool got back more than it gave.
    pub fn area_j(&self) -> f64 {
        self.loading_work_j - self.returned_work_j
    }

    /// The area over the work of loading; none where that is next to nothing beside what returned.
    pub fn relative(&self) -> Option<f64> {
        let enough = self.loading_work_j > 1e-3 * self.returned_work_j.abs();
        enough.then(|| self.area_j() / self.loading_work_j)
    }
}

/// Presses a body to `deepest_m` and back, settling at every step. The kernel closes the bands a
/// tenth of a mean link length after the turn ([`Unloading::Retreat`]).
pub fn there_and_back(body: &Scene, deepest_m: f64, steps: u32) -> Result<Loop> {
    let mut tool = body.quasi_static(Unloading::Retreat)?;
    let depth = |step: u32| deepest_m * f64::from(step) / f64::from(steps);
    let way_in: Vec<Felt> = (1..=steps).map(|at| tool.settle(depth(at))).collect::<Result<_>>()?;
    let back: Vec<Felt> =
        (0..steps).rev().map(|at| tool.settle(depth(at))).collect::<Result<_>>()?;
    let point = |at: &Felt| [at.depth_m, at.force_n];
    let loading: Vec<[f64; 2]> = [[0.0; 2]].into_iter().chain(way_in.iter().map(point)).collect();
    let turn = way_in.last().map(point);
    let mut found = Loop::new(loading, turn.into_iter().chain(back.iter().map(point)).collect());
    let before = |depth_m: f64| {
        way_in.iter().find(|at| (at.depth_m - depth_m).abs() < 1e-9).map_or(0.0, |at| at.energy_j)
    };
    let gain = back.iter().map(|at| at.energy_j - before(at.depth_m));
    found.band_energy_j = gain.fold(0.0, f64::max);
    Ok(found)
}

/// Presses a body at a speed to `deepest_m` and back on the paper's own dynamics, a tick of 1 ms
/// advancing by 1 ms over the time constant; the bands stay as they are.
pub fn at_speed(
    body: &Scene,
    deepest_m: f64,
    speed_m_per_s: f64,
    time_constant_s: f64,
) -> Result<Loop> {
    let mut tool = body.in_time(super::TICK_S / time_constant_s)?;
    let ticks = (deepest_m / (speed_m_per_s * super::TICK_S)).round().max(1.0) as u32;
    let mut run = |ticks: &mut dyn Iterator<Item = u32>, all: u32| -> Result<Vec<[f64; 2]>> {
        let depth = |tick: u32| deepest_m * f64::from(tick) / f64::from(all);
        ticks.map(|tick| Ok([depth(tick), tool.press(depth(tick))?])).collect()
    };
    let loading = run(&mut (0..=ticks), ticks)?;
    let mut unloading: Vec<[f64; 2]> = loading.last().copied().into_iter().collect();
    unloading.extend(run(&mut (0..ticks).rev(), ticks)?);
    Ok(Loop::new(loading, unloading))
}
