//! "alpha is set according to the spring stiffness k": which alpha feels like which k.

use serde::Serialize;

use crate::experiments::paper::body::Source;
use crate::experiments::paper::mechanics::compress;
use chaincell_host::error::Result;

/// Depths at which the forces are compared, of the deepest.
const STEPS: u32 = 5;
const DEEPEST_M: f64 = 0.1;

/// Force at a depth with a band over that without.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Softness {
    /// Half-width of the band.
    pub alpha: f64,
    /// Depth \[m\].
    pub depth_m: f64,
    /// The stiffness k that gives this force at alpha 0, over the one in use: the force at alpha 0
    /// is proportional to k at every depth.
    pub stiffness_ratio: f64,
}

/// The ratios of the plane for every alpha and depth, alphas ascending from 0.
///
/// # Errors
/// As [`compress`].
pub fn softness(plane: &Source, alphas: &[f64]) -> Result<Vec<Softness>> {
    let elastic = compress(&plane.with_alpha(0.0)?, DEEPEST_M, STEPS)?;
    let mut all = Vec::new();
    for &alpha in alphas {
        let found = compress(&plane.with_alpha(alpha)?, DEEPEST_M, STEPS)?;
        for (at, elastic) in found.curve.iter().zip(&elastic.curve) {
            let stiffness_ratio = at.force_n.max(0.0) / elastic.force_n;
            all.push(Softness { alpha, depth_m: at.depth_m, stiffness_ratio });
        }
    }
    Ok(all)
}

/// Depths in a set, ascending.
#[must_use]
pub fn depths(all: &[Softness]) -> Vec<f64> {
    all.iter().take(STEPS as usize).map(|at| at.depth_m).collect()
}

/// The alpha that feels like `ratio` times the stiffness at a depth; none within the alphas.
#[must_use]
pub fn alpha_for(all: &[Softness], depth_m: f64, ratio: f64) -> Option<f64> {
    let at_depth: Vec<&Softness> = all.iter().filter(|at| at.depth_m == depth_m).collect();
    let pair = at_depth
        .windows(2)
        .find(|w| w[0].stiffness_ratio >= ratio && w[1].stiffness_ratio < ratio)?;
    let part =
        (pair[0].stiffness_ratio - ratio) / (pair[0].stiffness_ratio - pair[1].stiffness_ratio);
    Some(pair[0].alpha + part * (pair[1].alpha - pair[0].alpha))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_alpha_of_a_stiffness_lies_between_its_neighbours() {
        let at = |alpha, stiffness_ratio| Softness { alpha, depth_m: 0.05, stiffness_ratio };
        let all = [at(0.0, 1.0), at(0.1, 0.6), at(0.2, 0.2)];
        let half = alpha_for(&all, 0.05, 0.5).unwrap();
        assert!((half - 0.125).abs() < 1e-12, "{half}");
        assert!(alpha_for(&all, 0.05, 0.1).is_none() && alpha_for(&all, 0.06, 0.5).is_none());
    }
}
