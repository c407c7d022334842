//! The current source: what an input displacement does as `I_i` of Eq. 2, beside a prescribed one.
//!
//! Settled, the links of a contact cell exert the opposite of its current, sum of mu
//! (`P_j` - `P_c`) = -I: on a body with one contact cell that is the state of a prescribed
//! displacement whose force is 2 k I. So what the kernel's current drive yields is held against
//! that curve.

use serde::Serialize;

use crate::experiments::paper::body::{Felt, Source};
use crate::experiments::paper::mechanics::compress;
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;

/// Input displacements \[m\].
const INPUTS_M: [f64; 5] = [0.001, 0.005, 0.01, 0.02, 0.05];
/// Stiffnesses of a link [N/m].
const STIFFNESSES: [f64; 3] = [5.0, 20.0, 80.0];
const DEEPEST_M: f64 = 0.12;
const STEPS: u32 = 120;

/// An input under both readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Yield {
    /// Stiffness of a link [N/m].
    pub stiffness_n_per_m: f64,
    /// Half-width of the band.
    pub alpha: f64,
    /// The input displacement \[m\].
    pub input_m: f64,
    /// Where the contact cell settles with the input as current \[m\].
    pub displacement_m: f64,
    /// The same read from the settled curve of force over prescribed displacement \[m\].
    pub curve_displacement_m: f64,
    /// The force then, 2 k I \[N\].
    pub force_n: f64,
    /// The force with the input as prescribed displacement \[N\].
    pub prescribed_force_n: f64,
}

/// The plane under both readings, for several stiffnesses and with a band.
///
/// # Errors
/// As [`compress`].
pub fn yields(plane: &Source) -> Result<Vec<Yield>> {
    let elastic = STIFFNESSES.map(|k| (k, 0.0));
    let mut all = Vec::new();
    for (stiffness_n_per_m, alpha) in elastic.into_iter().chain([(STIFFNESSES[1], 0.05)]) {
        let options = BakeOptions {
            alpha: PerCell::Uniform(alpha),
            stiffness_n_per_m: PerCell::Uniform(stiffness_n_per_m),
            ..BakeOptions::default()
        };
        let body = plane.bake(&options)?;
        let curve = compress(&body, DEEPEST_M, STEPS)?.curve;
        let mut tool = body.driven()?;
        for input_m in INPUTS_M {
            let force_n = 2.0 * stiffness_n_per_m * input_m;
            let (Some(curve_displacement_m), Some(prescribed_force_n)) = (
                between(&curve, |at| at.force_n, |at| at.depth_m, force_n),
                between(&curve, |at| at.depth_m, |at| at.force_n, input_m),
            ) else {
                continue;
            };
            all.push(Yield {
                stiffness_n_per_m,
                alpha,
                input_m,
                displacement_m: tool.yielded(input_m)?,
                curve_displacement_m,
                force_n,
                prescribed_force_n,
            });
        }
    }
    Ok(all)
}

/// `y` where `x` takes a value, between two points of a curve.
fn between(
    curve: &[Felt],
    x: impl Fn(&Felt) -> f64,
    y: impl Fn(&Felt) -> f64,
    value: f64,
) -> Option<f64> {
    let none = Felt { depth_m: 0.0, force_n: 0.0, energy_j: 0.0, residual: 0.0 };
    let points: Vec<Felt> = [none].into_iter().chain(curve.iter().copied()).collect();
    let pair = points.windows(2).find(|w| x(&w[0]) < value && x(&w[1]) >= value - 1e-12)?;
    let part = (value - x(&pair[0])) / (x(&pair[1]) - x(&pair[0]));
    Some(y(&pair[0]) + part * (y(&pair[1]) - y(&pair[0])))
}
