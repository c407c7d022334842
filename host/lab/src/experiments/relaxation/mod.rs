//! Branches of relaxation from a measured curve, in one dimension.
//!
//! The law is Fung's quasi-linear one: an elastic response, linear with bands that stiffen it, fades by a Prony series
//! (module [`prony`](crate::reference::prony)). The fit takes the errors in shares of the response, Levenberg and
//! Marquardt in the logarithms of all values, from several starts.

pub mod curve;
mod options;

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_034::storage::Owned;
use nalgebra_034::{DMatrix, DVector, Dyn};
use serde::Serialize;

use crate::reference::prony::Prony;
use chaincell_host::bake::tissue::Branch;
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use curve::Curve;
use options::options;
pub use options::{rounded, rounded_parts};

/// Response below which errors are shares of this much of the largest one.
const FLOOR: f64 = 0.1;
/// Step of the logarithms for differences.
const STEP: f64 = 1e-4;
/// Standard deviations in half of a 95 % interval.
const WIDTH: f64 = 1.96;
/// Least error of a measured response, as a share of it.
const NOISE_MIN: f64 = 1e-3;
/// Largest factor from a value to an end of its interval in which it counts as identified.
const FACTOR: f64 = 2.0;
/// Where times are looked for: ends of their range as shares of the curve's length.
const STARTS: [[f64; 2]; 4] = [[1e-4, 0.3], [1e-3, 0.3], [1e-3, 3.0], [1e-2, 1.0]];
/// Largest logarithm of a value: farther away all are alike.
const LIMIT: f64 = 60.0;

/// A value that was found.
#[derive(Debug, Clone, Serialize)]
pub struct Value {
    /// Its name.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its 95 % interval, as far as errors are independent.
    pub interval: [f64; 2],
    /// The curve determines it within a factor of two.
    pub is_identified: bool,
}

/// What was found.
#[derive(Debug, Clone, Serialize)]
pub struct Found {
    /// Long-term modulus, in the unit.
    pub modulus: f64,
    /// Unit of the moduli: Pa, N or N/m.
    pub unit: &'static str,
    /// Half-width and modulus of each band.
    pub stiffening: Vec<[f64; 2]>,
    /// Shear modulus over the long-term one and time \[s\] of each branch.
    pub branches: Vec<[f64; 2]>,
    /// Every value with its interval.
    pub values: Vec<Value>,
    /// Root mean square error of the hold at the end, and the largest one, as shares of the response.
    pub hold_errors: Option<[f64; 2]>,
    /// Root mean square error before the hold, as a share of the largest response.
    pub rise_error: f64,
    /// Options of a bake of this tissue; `None` if a bake refuses them.
    pub bake: Option<String>,
    /// Why a bake refuses them.
    pub refusal: Option<String>,
}

/// How a law that was found meets a curve.
#[derive(Debug, Clone, Serialize)]
pub struct Predicted {
    /// The law's stress or force at each point, in the curve's unit.
    #[serde(skip)]
    pub response: Vec<f64>,
    /// Root mean square error, as a share of the largest response.
    pub error: f64,
    /// The largest response of the law over that of the curve, less 1.
    pub peak_error: f64,
    /// Root mean square error of the hold at the end, and the largest one, as shares of the response.
    pub hold_errors: Option<[f64; 2]>,
}

impl Found {
    /// Compares the law with a curve, of another rate or depth for instance.
    ///
    /// # Errors
    /// A curve of another unit.
    pub fn predict(&self, curve: &Curve) -> Result<Predicted> {
        if curve.unit != self.unit {
            return Err(Error::input(format!(
                "its modulus is in {}, that of the first curve in {}; give curves of the same columns",
                curve.unit, self.unit
            )));
        }
        let bands: Vec<[f64; 2]> = self
            .stiffening
            .iter()
            .map(|[width, modulus]| [*width, modulus / self.modulus])
            .collect();
        let branches =
            self.branches.iter().map(|&[ratio, time_s]| Branch { ratio, time_s }).collect();
        let found = response(curve, Prony { modulus: self.modulus, branches }, &bands);
        let felt = &curve.response;
        let errors: Vec<f64> = found.iter().zip(felt).map(|(found, felt)| found - felt).collect();
        Ok(Predicted {
            error: root_mean_square(&errors) / peak(felt),
            peak_error: peak(&found) / peak(felt) - 1.0,
            hold_errors: hold_errors(curve, &found),
            response: found,
        })
    }
}

/// The response of a strip at every point of a curve; each band has its half-width and its modulus over the strip's.
fn response(curve: &Curve, strip: Prony, bands: &[[f64; 2]]) -> Vec<f64> {
    let elastic = |strain: f64| {
        let beyond = bands.iter().map(|[width, modulus]| modulus * (strain.abs() - width).max(0.0));
        strain + beyond.sum::<f64>().copysign(strain)
    };
    let points: Vec<[f64; 2]> =
        curve.points.iter().map(|&[time_s, strain]| [time_s, elastic(strain)]).collect();
    strip.path(&points)
}

/// Root mean square and largest error of the hold at the end of a curve, as shares of its response.
fn hold_errors(curve: &Curve, found: &[f64]) -> Option<[f64; 2]> {
    let from = curve.points.len() - curve.held;
    let pairs = found.iter().zip(&curve.response).skip(from);
    let shares: Vec<f64> = pairs.map(|(found, felt)| (found / felt - 1.0).abs()).collect();
    let worst = shares.iter().copied().fold(0.0, f64::max);
    (shares.len() > 1).then(|| [root_mean_square(&shares), worst])
}

/// A law whose values are logarithms: modulus, bands over it, ratios, times.
struct Descent<'a> {
    curve: &'a Curve,
    half_widths: &'a [f64],
    x: DVector<f64>,
}

/// Finds so many branches, and the modulus of bands of these half-widths, of a curve. Cost: milliseconds.
///
/// # Errors
/// More values than the curve has rows, a fit without an end, an interruption.
pub fn identify(curve: &Curve, branches: usize, half_widths: &[f64]) -> Result<Found> {
    let (rows, values) = (curve.points.len() - 1, 1 + half_widths.len() + 2 * branches);
    if rows <= values {
        return Err(Error::input(format!(
            "{rows} rows for {values} values; give a longer curve, fewer --branches or --half-widths none"
        )));
    }
    let mut best: Option<(f64, DVector<f64>)> = None;
    for range in STARTS {
        let x = start(curve, branches, half_widths, range);
        let (end, report) = LevenbergMarquardt::new().minimize(Descent { curve, half_widths, x });
        interrupt::check()?;
        let cost = report.objective_function;
        if cost.is_finite() && best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, end.x));
        }
    }
    let (_, x) = best.ok_or_else(|| Error::check("the fit found no end; check units and signs"))?;
    let mut found = Descent { curve, half_widths, x }.found();
    match options(&found) {
        Ok(options) => found.bake = Some(options),
        Err(why) => found.refusal = Some(why.to_string().replace('`', "")),
    }
    Ok(found)
}

/// Values to begin with: times spread over a range, branches as stiff as the rest.
fn start(curve: &Curve, branches: usize, half_widths: &[f64], range: [f64; 2]) -> DVector<f64> {
    let length_s = curve.points.last().map_or(1.0, |point| point[0]);
    let strain = curve.points.iter().fold(0.0_f64, |most, point| most.max(point[1]));
    let last = curve.response.last().copied().unwrap_or(1.0).abs().max(f64::MIN_POSITIVE);
    let mut x = vec![(last / strain).ln()];
    x.extend(half_widths.iter().map(|_| 0.0));
    x.extend((0..branches).map(|_| 0.0));
    let [low, high] = range.map(f64::ln);
    x.extend((0..branches).map(|branch| {
        let place = (branch as f64 + 0.5) / branches as f64;
        length_s.ln() + low + place * (high - low)
    }));
    DVector::from_vec(x)
}

impl Descent<'_> {
    fn count(&self) -> usize {
        (self.x.len() - 1 - self.half_widths.len()) / 2
    }

    /// The values at these logarithms.
    fn values(x: &DVector<f64>) -> Vec<f64> {
        x.iter().map(|x| x.clamp(-LIMIT, LIMIT).exp()).collect()
    }

    /// The branches among the values.
    fn branches(&self, values: &[f64]) -> Vec<Branch> {
        let (ratios, times) = values[1 + self.half_widths.len()..].split_at(self.count());
        let pairs = ratios.iter().zip(times);
        pairs.map(|(&ratio, &time_s)| Branch { ratio, time_s }).collect()
    }

    /// The response of the law at every point.
    fn response(&self, x: &DVector<f64>) -> Vec<f64> {
        let values = Self::values(x);
        let bands: Vec<[f64; 2]> = self
            .half_widths
            .iter()
            .zip(&values[1..])
            .map(|(&width, &modulus)| [width, modulus])
            .collect();
        let strip = Prony { modulus: values[0], branches: self.branches(&values) };
        response(self.curve, strip, &bands)
    }

    /// Differences as shares of the response; the point of rest has none.
    fn residuals_at(&self, x: &DVector<f64>) -> DVector<f64> {
        let peak = self.peak();
        let pairs = self.response(x).into_iter().zip(&self.curve.response).skip(1);
        let share = |(found, felt): (f64, &f64)| (found - felt) / felt.abs().max(FLOOR * peak);
        DVector::from_iterator(self.curve.points.len() - 1, pairs.map(share))
    }

    fn peak(&self) -> f64 {
        peak(&self.curve.response)
    }

    fn slopes(&self) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = (0..self.x.len())
            .map(|column| {
                let [ahead, behind] = [STEP, -STEP].map(|step| {
                    let mut x = self.x.clone();
                    x[column] += step;
                    self.residuals_at(&x)
                });
                (ahead - behind) / (2.0 * STEP)
            })
            .collect();
        DMatrix::from_columns(&columns)
    }

    /// Standard deviations of the logarithms; infinite where the curve does not tell.
    fn deviations(&self) -> Vec<f64> {
        let (residuals, slopes) = (self.residuals_at(&self.x), self.slopes());
        let freedom = (residuals.len() - self.x.len()) as f64;
        let variance = (residuals.norm_squared() / freedom).max(NOISE_MIN * NOISE_MIN);
        let inverse = (slopes.transpose() * slopes).try_inverse();
        (0..self.x.len())
            .map(|at| {
                let own = inverse.as_ref().map_or(f64::INFINITY, |inverse| inverse[(at, at)]);
                if own.is_finite() && own >= 0.0 { (variance * own).sqrt() } else { f64::INFINITY }
            })
            .collect()
    }

    fn found(&self) -> Found {
        // The branches in ascending time, each with the places of its values.
        let values = Self::values(&self.x);
        let branches = self.branches(&values);
        let (bands, count) = (self.half_widths.len(), self.count());
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| branches[a].time_s.total_cmp(&branches[b].time_s));
        let mut names = vec![("modulus".to_owned(), 0)];
        names.extend(
            (1..).zip(self.half_widths).map(|(at, width)| (format!("band beyond {width}"), at)),
        );
        for (branch, &at) in (1..).zip(&order) {
            names.push((format!("branch {branch}, ratio"), 1 + bands + at));
            names.push((format!("branch {branch}, time_s"), 1 + bands + count + at));
        }
        // Their intervals.
        let deviations = self.deviations();
        let value = |(name, at): (String, usize)| {
            let scale = if (1..=bands).contains(&at) { values[0] } else { 1.0 };
            let (value, factor) = (scale * values[at], (WIDTH * deviations[at]).exp());
            let interval = [value / factor, value * factor];
            Value { name, value, interval, is_identified: factor <= FACTOR }
        };
        Found {
            modulus: values[0],
            unit: self.curve.unit,
            stiffening: (self.half_widths.iter().zip(&values[1..]))
                .map(|(&width, modulus)| [width, values[0] * modulus])
                .collect(),
            branches: order.iter().map(|&at| [branches[at].ratio, branches[at].time_s]).collect(),
            values: names.into_iter().map(value).collect(),
            hold_errors: hold_errors(self.curve, &self.response(&self.x)),
            rise_error: self.rise_error(),
            bake: None,
            refusal: None,
        }
    }

    fn rise_error(&self) -> f64 {
        let rows = self.curve.points.len() - self.curve.held;
        let pairs = self.response(&self.x).into_iter().zip(&self.curve.response).take(rows);
        let errors: Vec<f64> = pairs.map(|(found, felt)| found - felt).collect();
        root_mean_square(&errors) / self.peak()
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Descent<'_> {
    type ParameterStorage = Owned<f64, Dyn>;
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.x.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.x.clone()
    }

    /// None ends the search.
    fn residuals(&self) -> Option<DVector<f64>> {
        (!interrupt::asked()).then(|| self.residuals_at(&self.x))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.slopes())
    }
}

/// The largest size.
fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, value| most.max(value.abs()))
}

fn root_mean_square(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|x| x * x).sum();
    (squares / values.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// A press in a second and a hold, with errors of a share of the response.
    fn pressed(branches: &[(f64, f64)], error: f64) -> Curve {
        let branches = branches.iter().map(|&(ratio, time_s)| Branch { ratio, time_s }).collect();
        let strip = Prony { modulus: 2000.0, branches };
        let mut points = vec![[0.0, 0.0]];
        points.extend((1..=20).map(|at| [0.05 * f64::from(at), 0.005 * f64::from(at)]));
        points.extend((1..=60).map(|at| [1.0 + 0.02 * f64::from(at).powf(2.0), 0.1]));
        let mut response = strip.path(&points);
        for (at, felt) in response.iter_mut().enumerate() {
            *felt *= 1.0 + error * (12.9898 * at as f64).sin();
        }
        Curve { points, response, unit: "Pa", held: 61 }
    }

    #[test]
    fn the_values_of_a_made_curve_are_found_again() {
        let found = identify(&pressed(&[(2.0, 0.3), (1.0, 12.0)], 0.0), 2, &[]).unwrap();
        let near = |found: f64, wanted: f64| (found / wanted - 1.0).abs() < 1e-3;
        assert!(near(found.modulus, 2000.0), "{found:?}");
        for (found, wanted) in found.branches.iter().zip([[2.0, 0.3], [1.0, 12.0]]) {
            assert!(near(found[0], wanted[0]) && near(found[1], wanted[1]), "{found:?}");
        }
        assert!(found.values.iter().all(|value| value.is_identified), "{found:?}");
        assert!(found.hold_errors.unwrap()[1] < 1e-4 && found.rise_error < 1e-4);
    }

    #[test]
    fn what_the_curve_does_not_tell_is_said() {
        let curve = pressed(&[(2.0, 0.3)], 0.01);
        let one = identify(&curve, 1, &[]).unwrap();
        assert!(one.values.iter().all(|value| value.is_identified), "{one:?}");
        let three = identify(&curve, 3, &[]).unwrap();
        let open = three.values.iter().filter(|value| !value.is_identified).count();
        assert!(open >= 2, "{three:?}");
        let few = Curve { points: curve.points[..5].to_vec(), ..curve };
        let why = identify(&few, 2, &[]).unwrap_err().to_string();
        assert!(why.contains("4 rows for 5 values") && why.contains("--branches"), "{why}");
    }

    /// Two branches follow the hold of a muscle within 3 % rms, one does not.
    #[test]
    fn the_hold_of_a_muscle_needs_two_branches() {
        let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE") else {
            println!("SKIPPED the_hold_of_a_muscle: CHAINCELL_REFERENCE is not set");
            return;
        };
        let file = Path::new(&folder).join("tissue/muscle_relaxation_f05.csv");
        let muscle = curve::read(&file).unwrap();
        let hold = |branches| {
            let found = identify(&muscle, branches, &[0.15, 0.24]).unwrap();
            println!("{branches}: {found:?}");
            found.hold_errors.unwrap()[0]
        };
        let [one, two, three] = [1, 2, 3].map(hold);
        assert!(one > 0.08 && two < 0.03 && three < 0.02, "{one} {two} {three}");
    }
}
