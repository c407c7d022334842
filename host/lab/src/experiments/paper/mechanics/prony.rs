//! A Prony series through a relaxation: F(t) = `F_inf` + sum of `F_i` exp(-t / `tau_i`), no
//! amplitude below 0.
//!
//! For given times the amplitudes are a linear least-squares problem, solved over every subset of
//! the terms so that none is negative; what is left, the logarithms of the times, is searched by
//! Levenberg and Marquardt's method (variable projection: Golub and Pereyra 1973), Jacobian by
//! differences. The residual that is minimised is relative, F(t) / F - 1, so that every decade of
//! a decaying force counts.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{Matrix4, Vector4};
use nalgebra_034::storage::Owned;
use nalgebra_034::{DMatrix, DVector, Dyn};
use serde::Serialize;

use chaincell_host::error::{Error, Result};

/// Most exponential terms: with the constant they fill the matrices.
pub const TERMS_MAX: usize = 3;
/// Time constants on the grid that the search begins with.
const GRID: usize = 12;
/// Step of a time's logarithm for differences.
const STEP: f64 = 1e-4;

/// A fitted series.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Prony {
    /// What remains at last \[N\].
    pub f_inf_n: f64,
    /// Amplitudes, fastest first \[N\].
    pub f_n: Vec<f64>,
    /// Time constants, ascending \[s\].
    pub tau_s: Vec<f64>,
    /// Root mean square of the relative error over the samples.
    pub residual: f64,
    /// First and last time of the samples \[s\].
    pub window_s: [f64; 2],
}

impl Prony {
    /// The force at a time \[N\].
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let terms = self.f_n.iter().zip(&self.tau_s);
        self.f_inf_n + terms.map(|(f, tau)| f * (-t_s / tau).exp()).sum::<f64>()
    }
}

/// Times \[s\] and forces \[N\].
struct Samples<'a>(&'a [[f64; 2]]);

impl Samples<'_> {
    /// The best amplitudes for times, none negative, `F_inf` first; and the residuals.
    fn amplitudes(&self, tau_s: &[f64]) -> (Vector4<f64>, Vec<f64>) {
        let used = 1 + tau_s.len().min(TERMS_MAX);
        let basis = |t: f64, f: f64| {
            Vector4::from_fn(|at, _| match at.checked_sub(1).map(|term| tau_s.get(term)) {
                None => 1.0 / f,
                Some(Some(tau)) => (-t / tau).exp() / f,
                Some(None) => 0.0,
            })
        };
        let (mut gram, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for &[t, f] in self.0 {
            let b = basis(t, f);
            gram += b * b.transpose();
            right += b;
        }
        let count = self.0.len() as f64;
        let mut best = (Vector4::zeros(), count);
        for chosen in 1_u32..1 << used {
            let on = |at: usize| chosen >> at & 1 == 1;
            let reduced = Matrix4::from_fn(|i, j| match on(i) && on(j) {
                true => gram[(i, j)],
                false => f64::from(u8::from(i == j)),
            });
            let wanted = Vector4::from_fn(|i, _| if on(i) { right[i] } else { 0.0 });
            let Some(found) = reduced.cholesky().map(|factors| factors.solve(&wanted)) else {
                continue;
            };
            let square = count - 2.0 * found.dot(&right) + found.dot(&(gram * found));
            if found.iter().all(|&f| f >= 0.0) && square < best.1 {
                best = (found, square);
            }
        }
        // Once more sample by sample: the expanded square cancels where the fit is good.
        let residuals = self.0.iter().map(|&[t, f]| basis(t, f).dot(&best.0) - 1.0);
        (best.0, residuals.collect())
    }
}

/// A search under way.
struct Search<'a> {
    samples: Samples<'a>,
    ln_tau: DVector<f64>,
}

impl Search<'_> {
    fn residuals_at(&self, ln_tau: &DVector<f64>) -> DVector<f64> {
        let tau_s: Vec<f64> = ln_tau.iter().map(|ln| ln.exp()).collect();
        DVector::from_vec(self.samples.amplitudes(&tau_s).1)
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Search<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, ln_tau: &DVector<f64>) {
        self.ln_tau.copy_from(ln_tau);
    }

    fn params(&self) -> DVector<f64> {
        self.ln_tau.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.residuals_at(&self.ln_tau))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let columns: Vec<DVector<f64>> = (0..self.ln_tau.len())
            .map(|term| {
                let [low, high] = [-STEP, STEP].map(|step| {
                    let mut there = self.ln_tau.clone();
                    there[term] += step;
                    self.residuals_at(&there)
                });
                (high - low) / (2.0 * STEP)
            })
            .collect();
        Some(DMatrix::from_columns(&columns))
    }
}

/// Where the search begins: the best of the ascending time constants on a grid of the window, since
/// from evenly spaced ones alone it may end at a local minimum.
fn start(samples: &Samples<'_>, [from, to]: [f64; 2], terms: usize) -> DVector<f64> {
    let grid = |at: usize| from + (to - from) * at as f64 / GRID as f64;
    let mut best = (f64::INFINITY, DVector::zeros(terms));
    for chosen in (0_u32..1 << GRID).filter(|chosen| chosen.count_ones() as usize == terms) {
        let ln_tau = (0..GRID).filter(|at| chosen >> at & 1 == 1).map(|at| grid(at + 1));
        let ln_tau = DVector::from_iterator(terms, ln_tau);
        let tau_s: Vec<f64> = ln_tau.iter().map(|ln| ln.exp()).collect();
        let square = samples.amplitudes(&tau_s).1.iter().map(|residual| residual * residual).sum();
        if square < best.0 {
            best = (square, ln_tau);
        }
    }
    best.1
}

/// Fits a series of `terms` exponentials (1 to `TERMS_MAX`) to `samples` \[s, N\], ascending in
/// time, forces positive.
///
/// # Errors
/// Samples that are too few or not positive, too many terms.
pub fn fit(samples: &[[f64; 2]], terms: usize) -> Result<Prony> {
    let ends = samples.first().zip(samples.last()).map(|(a, b)| [a[0], b[0]]);
    let enough = samples.len() > 2 * (terms + 1) && (1..=TERMS_MAX).contains(&terms);
    let Some(window_s) =
        ends.filter(|_| enough && samples.iter().all(|s| s[0] > 0.0 && s[1] > 0.0))
    else {
        return Err(Error::check(format!(
            "a Prony series of {terms} terms: {} samples, not enough or not positive",
            samples.len()
        )));
    };
    let start = start(&Samples(samples), window_s.map(f64::ln), terms);
    let (found, _) =
        LevenbergMarquardt::new().minimize(Search { samples: Samples(samples), ln_tau: start });
    let mut tau_s: Vec<f64> = found.ln_tau.iter().map(|ln| ln.exp()).collect();
    tau_s.sort_by(f64::total_cmp);
    let (f, residuals) = Samples(samples).amplitudes(&tau_s);
    let squares: f64 = residuals.iter().map(|residual| residual * residual).sum();
    Ok(Prony {
        f_inf_n: f[0],
        f_n: f.iter().skip(1).take(terms).copied().collect(),
        tau_s,
        residual: (squares / samples.len() as f64).sqrt(),
        window_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn times() -> impl Iterator<Item = f64> {
        (0..120).map(|i| 1e-3 * 10_f64.powf(f64::from(i) / 30.0))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        /// A series with well separated times is found again.
        #[test]
        fn a_series_is_found_again(f_inf in 0.1_f64..2.0, f in prop::array::uniform2(0.2_f64..2.0),
                                   tau in 4e-3_f64..0.03, factor in 6.0_f64..40.0) {
            let made = Prony { f_inf_n: f_inf, f_n: f.to_vec(), tau_s: vec![tau, tau * factor],
                               residual: 0.0, window_s: [0.0; 2] };
            let samples: Vec<[f64; 2]> = times().map(|t| [t, made.at(t)]).collect();
            let found = fit(&samples, 2).unwrap();
            prop_assert!(found.residual < 1e-6, "{found:?}");
            prop_assert!((found.f_inf_n / f_inf - 1.0).abs() < 1e-4, "{found:?}");
            for (found, tau) in found.tau_s.iter().zip(&made.tau_s) {
                prop_assert!((found / tau - 1.0).abs() < 1e-3, "{found} {tau}");
            }
        }
    }

    #[test]
    fn a_series_whose_search_has_a_local_minimum_is_found_again() {
        let made = Prony {
            f_inf_n: 0.355,
            f_n: vec![1.817, 1.127],
            tau_s: vec![4.4977e-3, 2.9788e-2],
            residual: 0.0,
            window_s: [0.0; 2],
        };
        let samples: Vec<[f64; 2]> = times().map(|t| [t, made.at(t)]).collect();
        let found = fit(&samples, 2).unwrap();
        assert!(found.residual < 1e-6, "{found:?}");
    }

    #[test]
    fn diffusion_takes_more_than_one_term_and_no_amplitude_is_negative() {
        let samples: Vec<[f64; 2]> = times().map(|t| [t, 0.1 + (t / 1e-3).powf(-0.5)]).collect();
        let fits = [1, 2, 3].map(|terms| fit(&samples, terms).unwrap());
        assert!(fits[0].residual > 0.1 && fits[2].residual < 0.03, "{fits:?}");
        assert!(
            fits[0].residual > 2.0 * fits[1].residual && fits[1].residual > 2.0 * fits[2].residual
        );
        assert!(fits.iter().all(|fit| fit.f_inf_n >= 0.0 && fit.f_n.iter().all(|&f| f >= 0.0)));
        let one = Prony { f_n: vec![1.0], tau_s: vec![0.01], ..fits[0].clone() };
        let samples: Vec<[f64; 2]> = times().map(|t| [t, one.at(t)]).collect();
        assert!(fit(&samples, 3).unwrap().f_n.iter().all(|&f| f >= 0.0));
        assert!(fit(&samples[..4], 2).is_err() && fit(&samples, 4).is_err());
    }
}
