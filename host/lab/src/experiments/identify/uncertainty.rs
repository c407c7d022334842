//! What the data says of each parameter: intervals, and the directions that it leaves open.
//!
//! With the Jacobian J of the weighted residuals in the coordinates alpha / 0.1 and the logarithms of
//! all others, the covariance is s^2 (J'J)^-1 = s^2 V S^-2 V' with J = U S V', s^2 the sum of squares
//! per degree of freedom (Seber and Wild, Nonlinear Regression, 1989, section 5.1). A singular
//! value so small that its direction may vary by [`FACTOR`] and more is an open direction: the data
//! determines no parameter that it moves.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, SymmetricEigen};
use serde::Serialize;

use super::forward::Predicted;
use super::problem::Fit;
use super::unknown::Unknown;
use super::{Bounds, Parameters};
use chaincell_host::error::Result;

/// Step of a logarithm for central differences.
const STEP_LN: f64 = 0.05;
/// Least step of alpha.
const STEP_ALPHA: f64 = 2e-3;
/// Alpha that counts as much as a factor of e in the others.
const ALPHA_UNIT: f64 = 0.1;
/// A parameter is determined if its interval is narrower than this factor either way.
pub const FACTOR: f64 = 1.05;
/// An alpha is determined also if its interval is narrower than this either way.
pub const ALPHA_WIDTH: f64 = 0.001;
/// An alpha moves noticeably with an open direction from this part of it on.
const TAKES_PART: f64 = 0.2;
/// Least part of the sum of squares that a direction needs to be more than rounding.
const NOTHING: f64 = 1e-12;

/// A parameter with its interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// `stiffness_n_per_m`, `alpha`, `time_constant_s`, `young_pa`, `stiffening_pa`, `half_width`,
    /// `thickness_m`, `offset_m` or `toughness_j_per_m2`.
    pub parameter: &'static str,
    /// Group of nodes, or one of several bands; none for the whole body.
    pub group: Option<String>,
    /// Value found.
    pub value: f64,
    /// 95 % interval, cut at the bounds.
    pub interval: [f64; 2],
    /// Half the interval before it is cut, in percent of the value; none where it is endless.
    pub half_width_percent: Option<f64>,
    /// Where it was looked for.
    pub bounds: [f64; 2],
    /// Whether the value stands at a bound other than an alpha of 0.
    pub at_bound: bool,
    /// Whether the data determines it.
    pub determined: bool,
}

impl Estimate {
    /// Name with the group.
    pub fn name(&self) -> String {
        match &self.group {
            Some(group) => format!("{} of {group}", self.parameter),
            None => self.parameter.to_owned(),
        }
    }
}

/// Intervals of all parameters, and sentences about what stays open.
pub(super) fn judge(
    fit: &Fit<'_>,
    parameters: &Parameters,
    fitted: &Predicted,
) -> Result<(Vec<Estimate>, Vec<String>)> {
    let jacobian = jacobian(fit, parameters)?;
    let residuals = fit.residuals(fitted);
    let freedom = (residuals.len() - fit.unknowns.len()) as f64;
    let per_freedom = residuals.iter().map(|r| r * r).sum::<f64>() / freedom;
    let t = student(freedom);
    // Noise below what the forward problem is good for promises nothing.
    let wide = t * per_freedom.max(1.0).sqrt();
    let eigen = SymmetricEigen::new(jacobian.transpose() * &jacobian);
    let largest = eigen.eigenvalues.max();
    let directions: Vec<Direction> = (0..fit.unknowns.len())
        .map(|at| {
            let square = eigen.eigenvalues[at];
            let reach = if square > NOTHING * largest && square > 0.0 {
                wide / square.sqrt()
            } else {
                f64::INFINITY
            };
            Direction { reach, parts: eigen.eigenvectors.column(at).iter().copied().collect() }
        })
        .collect();
    let half = |at: usize| {
        let each = directions.iter().map(|direction| direction.of(at).powi(2));
        each.sum::<f64>().sqrt()
    };
    let estimates: Vec<Estimate> = (fit.unknowns.iter().enumerate())
        .map(|(at, &unknown)| estimate(fit, unknown, unknown.get(parameters), half(at)))
        .collect();
    let sentences = sentences(&directions, &fit.unknowns, &estimates);
    Ok((estimates, sentences))
}

/// A direction of the coordinates, with how far the data lets it go either way.
struct Direction {
    reach: f64,
    parts: Vec<f64>,
}

impl Direction {
    fn of(&self, at: usize) -> f64 {
        // Rounding in a direction without limit is no part of it.
        if self.parts[at].abs() < 1e-6 { 0.0 } else { self.reach * self.parts[at] }
    }
}

/// Two-sided 95 % quantile of Student's t (Abramowitz and Stegun 26.7.5, two terms).
fn student(freedom: f64) -> f64 {
    const Z: f64 = 1.959_964;
    let first = (Z.powi(3) + Z) / 4.0;
    let second = (5.0 * Z.powi(5) + 16.0 * Z.powi(3) + 3.0 * Z) / 96.0;
    Z + first / freedom + second / (freedom * freedom)
}

/// Central differences of the weighted residuals. A column whose second differences are as large
/// as the first is the forward problem's own noise, and 0.
fn jacobian(fit: &Fit<'_>, parameters: &Parameters) -> Result<DMatrix<f64>> {
    let mut places = Vec::new();
    let mut spans = Vec::new();
    for &unknown in &fit.unknowns {
        let value = unknown.get(parameters);
        let (three, span) = match unknown {
            Unknown::Alpha(_) => {
                let step = STEP_ALPHA.max(STEP_LN * value);
                let middle =
                    value.clamp(step, unknown.bounds(fit.bounds)[1].max(2.0 * step) - step);
                ([middle - step, middle, middle + step], 2.0 * step / ALPHA_UNIT)
            }
            _ => ([value * (-STEP_LN).exp(), value, value * STEP_LN.exp()], 2.0 * STEP_LN),
        };
        for value in three {
            let mut place = parameters.clone();
            unknown.set(&mut place, value);
            places.push(place);
        }
        spans.push(span);
    }
    let found = fit.predict_all(&places)?;
    let residuals: Vec<Vec<f64>> = found.iter().map(|found| fit.residuals(found)).collect();
    let rows = residuals.first().map_or(0, Vec::len);
    let mut jacobian = DMatrix::zeros(rows, spans.len());
    for (column, (three, span)) in residuals.chunks(3).zip(&spans).enumerate() {
        let [before, at, after] = three else { continue };
        let each = || before.iter().zip(at).zip(after);
        let first: f64 = each().map(|((b, _), a)| (a - b).powi(2)).sum();
        let second: f64 = each().map(|((b, m), a)| (a + b - 2.0 * m).powi(2)).sum();
        if first > second {
            for (row, ((b, _), a)) in each().enumerate() {
                jacobian[(row, column)] = (a - b) / span;
            }
        }
    }
    Ok(jacobian)
}

/// The interval of one parameter from its half-width in its coordinate.
fn estimate(fit: &Fit<'_>, unknown: Unknown, value: f64, half: f64) -> Estimate {
    let bounds = unknown.bounds(fit.bounds);
    let (ends, half_width, narrow) = if let Unknown::Alpha(_) = unknown {
        let half = ALPHA_UNIT * half;
        let narrow = half <= ALPHA_WIDTH || half <= (FACTOR - 1.0) * value;
        ([value - half, value + half], half / value, narrow)
    } else {
        ([value * (-half).exp(), value * half.exp()], half.exp() - 1.0, half <= FACTOR.ln())
    };
    let at_bound = is_at_bound(unknown, fit.bounds, value);
    Estimate {
        parameter: unknown.name(),
        group: unknown.owner(fit.bench),
        value,
        interval: ends.map(|end| end.clamp(bounds[0], bounds[1])),
        half_width_percent: Some(100.0 * half_width).filter(|percent| percent.is_finite()),
        bounds,
        at_bound,
        determined: narrow && !at_bound,
    }
}

fn is_at_bound(unknown: Unknown, bounds: &Bounds, value: f64) -> bool {
    let [low, high] = unknown.bounds(bounds);
    match unknown {
        Unknown::Alpha(_) => value > 0.99 * high,
        _ => value < 1.02 * low || value > 0.98 * high,
    }
}

/// What stays open, in words.
fn sentences(directions: &[Direction], unknowns: &[Unknown], all: &[Estimate]) -> Vec<String> {
    let mut said = Vec::new();
    let mut named = vec![false; all.len()];
    for direction in directions.iter().filter(|direction| direction.reach > FACTOR.ln()) {
        let parts: Vec<usize> = (0..all.len())
            .filter(|&at| direction.parts[at].abs() > TAKES_PART && !all[at].determined)
            .collect();
        parts.iter().for_each(|&at| named[at] = true);
        let names: Vec<String> = parts.iter().map(|&at| all[at].name()).collect();
        let same_way = parts.iter().all(|&at| {
            unknowns[at].is_modulus()
                && (direction.parts[at] / direction.parts[parts[0]] - 1.0).abs() < 0.1
        });
        match names.as_slice() {
            [] => {}
            [one] => said.push(format!("{one} is not determined by this data")),
            many if same_way => said.push(format!(
                "only the ratios of {} are determined by this data, not their scale: add a force",
                many.join(", ")
            )),
            many => said.push(format!(
                "{} are not determined by this data one by one: changes of one make up for the \
                 other",
                many.join(" and ")
            )),
        }
    }
    for (estimate, named) in all.iter().zip(named) {
        if estimate.at_bound {
            said.push(format!("{} stands at a bound: widen it", estimate.name()));
        } else if !estimate.determined && !named {
            said.push(format!("{} is not determined by this data", estimate.name()));
        }
    }
    let mut once = BTreeSet::new();
    said.retain(|sentence| once.insert(sentence.clone()));
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn students_quantile_is_that_of_the_tables() {
        for (freedom, table) in [(5.0, 2.571), (10.0, 2.228), (30.0, 2.042), (1e9, 1.960)] {
            assert!((student(freedom) - table).abs() < 0.025 * table, "{freedom}");
        }
        assert!(student(5.0) > student(10.0));
    }
}
