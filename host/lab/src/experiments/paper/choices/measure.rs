//! What a choice changes: force and profile at the end of a press, time of relaxation.

use chaincell_kernel::Unloading;
use serde::Serialize;

use crate::experiments::paper::body::{Body, Tool};
use crate::experiments::paper::mechanics::{TIME_CONSTANT_S, jump_n};
use chaincell_host::error::{Error, Result};

/// Network time of the press [dimensionless time].
pub const PRESS_TIME: f64 = 30.0;
/// Longest relaxation that is followed [dimensionless time].
const RELAX_TIME: f64 = 100.0;
/// Steps of the static press.
const STEPS: u32 = 25;
/// Input ids from the plane's centre to its border.
const HALF_ROW: std::ops::RangeInclusive<u32> = 220..=230;

/// Three figures of a body under one choice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Measures {
    /// Force at the end of the press \[N\].
    pub force_n: f64,
    /// Deviation of the pressed profile from a straight line between centre and border, root mean
    /// square over the depth: 0 for the pyramid of the traditional method.
    pub profile: f64,
    /// Time until 1/e of the difference between first and settled force is left \[s\].
    pub relaxation_s: f64,
}

/// Relative change of a figure.
#[must_use]
pub fn change(from: f64, to: f64) -> f64 {
    to / from - 1.0
}

/// A press to `depth_m` in a fixed network time with Euler steps of about `step`: the tool at its
/// end, with the last force \[N\].
///
/// # Errors
/// As [`Tool::press`].
pub fn press(body: &Body, depth_m: f64, step: f64) -> Result<(Tool<'_>, f64)> {
    let ticks = (PRESS_TIME / step).ceil();
    let mut tool = body.in_time(PRESS_TIME / ticks)?;
    let mut force_n = 0.0;
    for tick in 1..=ticks as u32 {
        force_n = tool.press(depth_m * f64::from(tick) / ticks)?;
    }
    Ok((tool, force_n))
}

/// Measures a plane under Euler steps of `step` [dimensionless time].
///
/// # Errors
/// As [`Tool::press`]; a force that does not relax.
pub fn measure(body: &Body, depth_m: f64, step: f64) -> Result<Measures> {
    let (mut tool, force_n) = press(body, depth_m, step)?;
    let profile = profile(body, &mut tool, depth_m)?;
    let mut still = body.quasi_static(Unloading::Off)?;
    let mut minimum_n = 0.0;
    for at in 1..=STEPS {
        minimum_n = still.settle(depth_m * f64::from(at) / f64::from(STEPS))?.force_n;
    }
    let relaxation_s = relaxation_s(body, depth_m, step, minimum_n)?;
    Ok(Measures { force_n, profile, relaxation_s })
}

/// Time until 1/e of the difference to `minimum_n` is left of the force of a jump \[s\].
fn relaxation_s(body: &Body, depth_m: f64, step: f64, minimum_n: f64) -> Result<f64> {
    let mut before = jump_n(body, depth_m)?;
    let wanted = minimum_n + (before - minimum_n) / std::f64::consts::E;
    let mut tool = body.in_time(step)?;
    for tick in 0..(RELAX_TIME / step) as u32 {
        let force_n = tool.press(depth_m)?;
        if force_n <= wanted {
            let part = (before - wanted) / (before - force_n);
            return Ok(TIME_CONSTANT_S * step * (f64::from(tick) + part));
        }
        before = force_n;
    }
    Err(Error::check(format!("{}: the force does not relax", body.name)))
}

/// How far the half row from centre to border is from straight, over the depth.
fn profile(body: &Body, tool: &mut Tool<'_>, depth_m: f64) -> Result<f64> {
    let model = body.model()?;
    let at = tool.positions();
    let cells = HALF_ROW.filter_map(|id| model.cell_of_input(id));
    let sinks: Vec<f64> = cells
        .map(|cell| {
            let rest = tool.links().rest()[usize::from(cell)];
            (rest[2] - at[usize::from(cell)][2]) * f64::from(model.unit_m()) / depth_m
        })
        .collect();
    let count = sinks.len() as f64;
    let line = |at: usize| 1.0 - at as f64 / (count - 1.0);
    let squares = sinks.iter().enumerate().map(|(at, sink)| (sink - line(at)).powi(2));
    Ok((squares.sum::<f64>() / count).sqrt())
}
