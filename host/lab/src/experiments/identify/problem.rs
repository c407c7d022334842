//! The problem of a fit: residuals of the rows that are fitted, at any parameters.

use super::forward::{Predicted, predict};
use super::target::Target;
use super::tool::Tool;
use super::unknown::Unknown;
use super::{Bench, Bounds, Parameters};
use chaincell_host::error::{Error, Result};
use chaincell_host::terminal::Progress;

/// Residuals of the rows that are fitted, with their weights.
pub(super) struct Fit<'a> {
    pub bench: &'a Bench<'a>,
    pub bounds: &'a Bounds,
    pub unknowns: Vec<Unknown>,
    pub held_out: Vec<Vec<bool>>,
    /// Standard deviation of each number of each target.
    pub noise: Vec<Vec<f64>>,
    /// Counts evaluations.
    pub bar: Progress,
}

impl Fit<'_> {
    /// The forward problem, counted.
    pub fn predict(&self, parameters: &Parameters) -> Result<Predicted> {
        let found = predict(self.bench, parameters);
        self.bar.step();
        found
    }

    /// (fit - measured) / noise of the rows fitted; those of a blade bounded in their effect.
    pub fn residuals(&self, predicted: &Predicted) -> Vec<f64> {
        let each = self.bench.targets.iter().zip(predicted).zip(&self.noise).zip(&self.held_out);
        let residuals = each.flat_map(|(((target, fit), noise), held)| {
            let off = difference(target, fit, held, false);
            off.into_iter()
                .zip(kept(noise, held, target.width(), false))
                .map(|(r, noise)| r / noise)
        });
        match self.bench.tool {
            Tool::Blade(..) => residuals.map(bounded).collect(),
            _ => residuals.collect(),
        }
    }

    /// Predictions at several places, on as many threads as the machine has.
    pub fn predict_all(&self, places: &[Parameters]) -> Result<Vec<Predicted>> {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let share = places.len().div_ceil(threads).max(1);
        std::thread::scope(|scope| {
            let work = |part: &[Parameters]| -> Result<Vec<_>> {
                part.iter().map(|place| self.predict(place)).collect()
            };
            let parts = places.chunks(share);
            let running: Vec<_> = parts.map(|part| scope.spawn(move || work(part))).collect();
            let mut found = Vec::with_capacity(places.len());
            for thread in running {
                let part = thread.join().map_err(|_| Error::check("a thread of the fit died"))?;
                found.extend(part?);
            }
            Ok(found)
        })
    }

    /// Parameters at coordinates.
    pub fn parameters(&self, x: &[f64]) -> Parameters {
        let mut parameters = self.bench.start();
        for (unknown, &x) in self.unknowns.iter().zip(x) {
            unknown.set(&mut parameters, unknown.value(self.bounds, x));
        }
        parameters
    }

    /// Coordinates of parameters.
    pub fn coordinates(&self, parameters: &Parameters) -> Vec<f64> {
        let each = self.unknowns.iter();
        each.map(|unknown| unknown.coordinate(self.bounds, unknown.get(parameters))).collect()
    }
}

/// A residual whose square grows as the residual where that is large. The force of a blade falls wherever cells
/// of the mesh split, so single rows are far off.
fn bounded(r: f64) -> f64 {
    let square = 2.0 * ((1.0 + r * r).sqrt() - 1.0);
    square.sqrt().copysign(r)
}

/// Fit less measured, of the rows held out or of the others.
pub(super) fn difference(target: &Target, fit: &[f64], held_out: &[bool], held: bool) -> Vec<f64> {
    let off: Vec<f64> = target.observed.iter().zip(fit).map(|(o, f)| f - o).collect();
    kept(&off, held_out, target.width(), held).collect()
}

/// The numbers of the rows held out, or of the others.
fn kept(numbers: &[f64], held_out: &[bool], width: usize, held: bool) -> impl Iterator<Item = f64> {
    let rows = numbers.iter().enumerate();
    rows.filter(move |(at, _)| held_out[at / width] == held).map(|(_, number)| *number)
}
