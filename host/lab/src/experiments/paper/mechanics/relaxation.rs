//! Fig. 5c: the force at a constant displacement, on the paper's own dynamics.

use chaincell_kernel::Unloading;

use super::TICK_S;
use crate::experiments::report::scene::Scene;
use crate::reference::{Links, trajectory};
use chaincell_host::error::Result;

/// Samples in a decade of time.
const A_DECADE: f64 = 30.0;
/// Moments at which the exact trajectory is computed [dimensionless time].
const MOMENTS: [f64; 4] = [0.5, 2.0, 10.0, 50.0];
/// What a step of the exact trajectory may add to its error [mean link lengths].
const TOLERANCE: f64 = 1e-9;
/// Steps in which the static press goes to its depth.
const STEPS: u32 = 20;

/// A force that relaxes.
pub struct Relaxation {
    /// Force as the tool jumps to its depth, before any cell has followed \[N\].
    pub first_n: f64,
    /// Time and force, the times in equal ratios \[s, N\].
    pub curve: Vec<[f64; 2]>,
    /// The settled force at this depth \[N\].
    pub minimum_n: f64,
}

/// The first force of a jump to `depth_m` \[N\].
pub fn jump_n(body: &Scene, depth_m: f64) -> Result<f64> {
    let links = Links::of_model(&body.model()?);
    let mut at = links.rest().to_vec();
    for (cell, position) in body.held(depth_m)? {
        at[cell] = position;
    }
    body.push_of(&links, &at)
}

/// Holds a body at `depth_m` from t = 0 on, for `seconds`, a tick of 1 ms advancing by 1 ms over
/// the time constant.
pub fn relax(body: &Scene, depth_m: f64, seconds: f64, time_constant_s: f64) -> Result<Relaxation> {
    let mut tool = body.in_time(TICK_S / time_constant_s)?;
    let ticks = (seconds / TICK_S).round() as u32;
    let (mut curve, mut next) = (Vec::new(), 1.0);
    for tick in 1..=ticks {
        let force_n = tool.press(depth_m)?;
        if f64::from(tick) >= next {
            curve.push([f64::from(tick) * TICK_S, force_n]);
            next = f64::from(tick) * 10_f64.powf(1.0 / A_DECADE);
        }
    }
    let mut still = body.quasi_static(Unloading::Off)?;
    let mut minimum_n = 0.0;
    for step in 1..=STEPS {
        minimum_n = still.settle(depth_m * f64::from(step) / f64::from(STEPS))?.force_n;
    }
    Ok(Relaxation { first_n: jump_n(body, depth_m)?, curve, minimum_n })
}

/// The same force on the exact trajectory, in double precision, at a few moments within `seconds`:
/// times and forces \[s, N\].
pub fn exact(
    body: &Scene,
    depth_m: f64,
    seconds: f64,
    time_constant_s: f64,
) -> Result<Vec<[f64; 2]>> {
    let links = Links::of_model(&body.model()?);
    let within = MOMENTS.into_iter().filter(|t| t * time_constant_s <= seconds);
    let times: Vec<f64> = within.collect();
    let found = trajectory(&links, &body.held(depth_m)?, &times, TOLERANCE);
    let forces = found.iter().zip(times);
    forces.map(|(at, t)| Ok([t * time_constant_s, body.push_of(&links, at)?])).collect()
}

/// The force of a curve at a time between its samples \[N\].
pub fn interpolate(curve: &[[f64; 2]], t_s: f64) -> Option<f64> {
    let pair = curve.windows(2).find(|w| (w[0][0]..=w[1][0]).contains(&t_s))?;
    let part = (t_s / pair[0][0]).ln() / (pair[1][0] / pair[0][0]).ln();
    Some(pair[0][1] + part * (pair[1][1] - pair[0][1]))
}
