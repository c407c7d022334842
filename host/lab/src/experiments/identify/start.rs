//! Where the fit starts: the best of a fixed set of places.

use super::Parameters;
use super::fit::Fit;
use super::forward::Predicted;
use super::target::Data;
use chaincell_host::bake::PerCell;
use chaincell_host::error::Result;

/// Starts that are followed to their end.
const STARTS: usize = 2;
/// Alphas that starts are tried at, in parts of the bound.
const START_ALPHAS: [f64; 3] = [0.04, 0.15, 0.4];
/// A group's stiffness in starts, times that of the others.
const START_RATIOS: [f64; 2] = [0.2, 5.0];
/// Time constants that starts are tried at, in parts of the longest curve.
const START_TIMES: [f64; 3] = [0.002, 0.02, 0.2];

/// The best places of the fixed set, their stiffness scaled to the forces measured.
pub(super) fn best(fit: &Fit<'_>) -> Result<Vec<Parameters>> {
    let places = places(fit);
    let found = fit.predict_all(&places)?;
    let mut tried: Vec<(f64, Parameters)> = places
        .into_iter()
        .zip(found)
        .map(|(mut place, mut found)| {
            let factor = scale(fit, &found);
            for k in &mut place.stiffness_n_per_m {
                *k *= factor;
            }
            // Forces grow with the stiffness of the whole, displacements do not change.
            for (target, values) in fit.bench.targets.iter().zip(&mut found) {
                if target.width() == 1 {
                    values.iter_mut().for_each(|force| *force *= factor);
                }
            }
            (fit.residuals(&found).iter().map(|r| r * r).sum(), place)
        })
        .collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(tried.into_iter().take(STARTS).map(|(_, place)| place).collect())
}

/// Factor on the forces that meets the measured ones best.
fn scale(fit: &Fit<'_>, found: &Predicted) -> f64 {
    let (mut both, mut square) = (0.0, 0.0);
    for ((target, values), noise) in fit.bench.targets.iter().zip(found).zip(&fit.noise) {
        if target.width() == 1 {
            for (o, f) in target.observed().iter().zip(values) {
                both += o * f / (noise * noise);
                square += f * f / (noise * noise);
            }
        }
    }
    if both > 0.0 && square > 0.0 { both / square } else { 1.0 }
}

/// Every combination of a few alphas, one stiffer or softer group, and a few time constants.
fn places(fit: &Fit<'_>) -> Vec<Parameters> {
    let groups = fit.bench.groups.len();
    let middle = match &fit.bench.options.stiffness_n_per_m {
        PerCell::Uniform(value) => *value,
        PerCell::Each(values) => values.iter().sum::<f64>() / values.len() as f64,
    };
    let mut ratios = vec![vec![middle; groups]];
    if groups > 1 {
        for group in 0..groups {
            for ratio in START_RATIOS {
                let mut one = vec![middle; groups];
                one[group] *= ratio;
                ratios.push(one);
            }
        }
    }
    let longest_s = (fit.bench.targets.iter())
        .filter_map(|target| match &target.data {
            Data::Relaxation { time_s, .. } => time_s.last().copied(),
            _ => None,
        })
        .fold(0.0, f64::max);
    let times: Vec<f64> =
        if longest_s > 0.0 { START_TIMES.map(|part| part * longest_s).to_vec() } else { vec![1.0] };
    let mut all = Vec::new();
    for part in START_ALPHAS {
        for stiffness_n_per_m in &ratios {
            for &time_constant_s in &times {
                all.push(Parameters {
                    stiffness_n_per_m: stiffness_n_per_m.clone(),
                    alpha: vec![part * fit.bounds.alpha_max; groups],
                    time_constant_s,
                });
            }
        }
    }
    all
}
