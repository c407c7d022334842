//! The fit: weighted least squares from several starts.
//!
//! Levenberg and Marquardt as in MINPACK (crate `levenberg-marquardt`), Jacobian by differences.
//! Every parameter is a smooth function of an unbounded coordinate ([`Unknown`]). With a band the
//! force sets in where the slack ends, so the residuals have kinks: the fit starts from
//! the best of a fixed set of places and the best end counts.

use std::sync::Mutex;
use std::time::Instant;

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_034::storage::Owned;
use nalgebra_034::{DMatrix, DVector, Dyn};
use serde::Serialize;

use super::forward::Predicted;
use super::problem::{Fit, difference};
use super::target::{Target, rms};
use super::uncertainty::{self, Estimate};
use super::unknown::{Unknown, check_ratios};
use super::{Bench, Bounds, Parameters, start};
use chaincell_host::error::{Error, Result};
use chaincell_host::terminal::Progress;

/// Step of the coordinates for differences.
const STEP: f64 = 0.01;
/// Noise before it is known, in parts of a target's root mean square.
const NOISE: f64 = 0.03;
/// Least noise in the same parts: what the forward problem itself is good for.
const NOISE_MIN: f64 = 1e-3;
/// Fewest rows that tell their own noise.
const ROWS_FOR_NOISE: usize = 5;
/// Most evaluations of a descent, for every coordinate and one more.
const PATIENCE: usize = 8;
/// Relative decrease that ends a descent.
const TOLERANCE: f64 = 1e-4;

/// How the fit went on one target.
#[derive(Debug, Clone, Serialize)]
pub struct Goodness {
    /// Name of the target.
    pub name: String,
    /// What it is.
    pub kind: &'static str,
    /// Unit of its numbers and of the errors here.
    pub unit: &'static str,
    /// Rows fitted.
    pub rows: usize,
    /// Rows held out.
    pub rows_held_out: usize,
    /// Root mean square of the measured numbers.
    pub rms_measured: f64,
    /// Root mean square residual of the rows fitted.
    pub rms_residual: f64,
    /// Root mean square residual of the rows held out.
    pub rms_residual_held_out: Option<f64>,
    /// Correlation of a residual with the next one, of a curve: far above 0 the model does not
    /// follow the curve, and the intervals are too narrow.
    pub correlation: Option<f64>,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Identified {
    /// The parameters.
    #[serde(skip)]
    pub parameters: Parameters,
    /// Each parameter with its interval.
    #[serde(rename = "parameters")]
    pub estimates: Vec<Estimate>,
    /// What the data leaves open, in sentences.
    pub undetermined: Vec<String>,
    /// How well each target is met.
    pub targets: Vec<Goodness>,
    /// Evaluations of the forward problem.
    pub evaluations: usize,
    /// Time of the fit \[s\].
    pub seconds: f64,
    /// What the targets would have measured.
    #[serde(skip)]
    pub fitted: Predicted,
    /// Which rows of each target were held out.
    #[serde(skip)]
    pub held_out: Vec<Vec<bool>>,
}

/// Follows the residuals downhill; where it ends, and half the sum of squares there.
fn descend(fit: &Fit<'_>, start: &Parameters) -> Result<(Parameters, f64)> {
    let x = DVector::from_vec(fit.coordinates(start));
    let mut descent = Descent { fit, x: x.clone(), at: None, failed: Mutex::new(None) };
    descent.set_params(&x);
    let method = LevenbergMarquardt::new().with_tol(TOLERANCE).with_patience(PATIENCE);
    let (descent, report) = method.minimize(descent);
    match descent.failed.into_inner() {
        Ok(Some(why)) => Err(why),
        _ => Ok((fit.parameters(descent.x.as_slice()), report.objective_function)),
    }
}

/// A descent under way.
struct Descent<'a> {
    fit: &'a Fit<'a>,
    x: DVector<f64>,
    at: Option<DVector<f64>>,
    failed: Mutex<Option<Error>>,
}

impl Descent<'_> {
    fn noted<T>(&self, result: Result<T>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(why) => {
                if let Ok(mut failed) = self.failed.lock() {
                    *failed = Some(why);
                }
                None
            }
        }
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Descent<'_> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.x.copy_from(x);
        let found = self.fit.predict(&self.fit.parameters(x.as_slice()));
        self.at = self.noted(found).map(|found| DVector::from_vec(self.fit.residuals(&found)));
    }

    fn params(&self) -> DVector<f64> {
        self.x.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.at.clone()
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let at = self.at.as_ref()?;
        let places: Vec<Parameters> = (0..self.x.len())
            .map(|column| {
                let mut x = self.x.clone();
                x[column] += STEP;
                self.fit.parameters(x.as_slice())
            })
            .collect();
        let found = self.noted(self.fit.predict_all(&places))?;
        let columns: Vec<DVector<f64>> = found
            .iter()
            .map(|found| (DVector::from_vec(self.fit.residuals(found)) - at) / STEP)
            .collect();
        Some(DMatrix::from_columns(&columns))
    }
}

/// Finds the parameters of a bench; of every target the part `hold_out` of its rows, evenly
/// spread, only judges the result. Deterministic. Cost: some hundred evaluations of the forward
/// problem.
pub fn identify(bench: &Bench<'_>, bounds: &Bounds, hold_out: f64) -> Result<Identified> {
    let start = Instant::now();
    check(bench, bounds, hold_out)?;
    let unknowns = Unknown::of(bench);
    let bar = Progress::new(60 * unknowns.len() as u64, "identify");
    let held_out: Vec<Vec<bool>> =
        bench.targets.iter().map(|target| spread(target.rows(), hold_out)).collect();
    let noise = bench.targets.iter().map(|target| spread_of(target, NOISE * target.scale()));
    let noise = noise.collect();
    let mut fit = Fit { bench, bounds, unknowns, held_out, noise, bar };
    let mut best: Option<(Parameters, f64)> = None;
    for start in start::best(&fit)? {
        let end = descend(&fit, &start)?;
        if best.as_ref().is_none_or(|best| end.1 < best.1) {
            best = Some(end);
        }
    }
    let (mut parameters, _) = best.ok_or_else(|| Error::check("no start for the fit"))?;
    fit.noise = noise_of(&fit, &fit.predict(&parameters)?);
    if bench.targets.len() > 1 {
        (parameters, _) = descend(&fit, &parameters)?;
    }
    let fitted = fit.predict(&parameters)?;
    let (estimates, undetermined) = uncertainty::judge(&fit, &parameters, &fitted)?;
    let evaluations = fit.bar.done() as usize;
    drop(fit.bar);
    Ok(Identified {
        targets: goodness(bench.targets, &fitted, &fit.held_out),
        parameters,
        estimates,
        undetermined,
        evaluations,
        seconds: start.elapsed().as_secs_f64(),
        fitted,
        held_out: fit.held_out,
    })
}

/// Refuses what [`identify`] would, before anything is computed.
pub fn check(bench: &Bench<'_>, bounds: &Bounds, hold_out: f64) -> Result<()> {
    bench.check()?;
    if !(0.0..=0.5).contains(&hold_out) {
        return Err(Error::input(format!("--hold-out {hold_out}: must be from 0 to 0.5")));
    }
    if bench.wanted.stiffening {
        check_ratios(bounds)?;
    }
    let fitted = |target: &Target| {
        let held_out = spread(target.rows(), hold_out).iter().filter(|held| **held).count();
        target.width() * (target.rows() - held_out)
    };
    let numbers: usize = bench.targets.iter().map(fitted).sum();
    let unknowns = Unknown::of(bench).len();
    if numbers <= unknowns {
        return Err(Error::input(format!(
            "--target: {numbers} numbers to fit {unknowns} parameters; give more rows, hold out \
             fewer, or name fewer groups"
        )));
    }
    Ok(())
}

/// Which of so many rows are held out: the part `share`, evenly spread.
fn spread(rows: usize, share: f64) -> Vec<bool> {
    let count = |row: usize| (row as f64 * share + 0.5).floor();
    (0..rows).map(|row| rows > 1 && count(row + 1) > count(row)).collect()
}

/// Standard deviation of each number of a target: its own, or the same for all.
fn spread_of(target: &Target, otherwise: f64) -> Vec<f64> {
    let same = || vec![otherwise; target.rows() * target.width()];
    target.deviation.clone().unwrap_or_else(same)
}

/// Standard deviation of each target's noise, from its residuals where the data has none.
fn noise_of(fit: &Fit<'_>, found: &Predicted) -> Vec<Vec<f64>> {
    let numbers = fit.residuals(found).len() as f64;
    // Every number takes its share of the unknowns.
    let freedom = 1.0 - fit.unknowns.len() as f64 / numbers;
    let each = fit.bench.targets.iter().zip(found).zip(&fit.held_out);
    each.map(|((target, values), held)| {
        let scale = target.scale();
        if target.rows() < ROWS_FOR_NOISE {
            return spread_of(target, NOISE * scale);
        }
        let off = rms(&difference(target, values, held, false)) / freedom.sqrt();
        spread_of(target, off.max(NOISE_MIN * scale))
    })
    .collect()
}

fn goodness(targets: &[Target], fitted: &Predicted, held_out: &[Vec<bool>]) -> Vec<Goodness> {
    let each = targets.iter().zip(fitted).zip(held_out);
    each.map(|((target, values), held)| {
        let residuals = difference(target, values, held, false);
        let judged = difference(target, values, held, true);
        let (kind, unit) = target.words();
        let rows_held_out = held.iter().filter(|held| **held).count();
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let next: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
        Goodness {
            name: target.name.clone(),
            kind,
            unit,
            rows: target.rows() - rows_held_out,
            rows_held_out,
            rms_measured: target.scale(),
            rms_residual: rms(&residuals),
            rms_residual_held_out: (rows_held_out > 0).then(|| rms(&judged)),
            correlation: (target.width() == 1 && target.rows() >= ROWS_FOR_NOISE && squares > 0.0)
                .then(|| next / squares),
        }
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_held_out_evenly() {
        let held = spread(20, 0.2);
        let rows: Vec<usize> = (0..20).filter(|&row| held[row]).collect();
        assert_eq!(rows, [2, 7, 12, 17]);
        assert!(spread(20, 0.0).iter().all(|held| !held) && spread(1, 0.5) == [false]);
    }
}
