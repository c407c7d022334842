//! Where the fit starts: the best of a fixed set of places.

use super::forward::Predicted;
use super::problem::Fit;
use super::tool::Tool;
use super::unknown::Unknown;
use super::{Parameters, Wanted};
use chaincell_host::error::Result;

/// Starts that are followed to their end.
const STARTS: usize = 2;
/// Alphas that starts are tried at, in parts of the bound.
const START_ALPHAS: [f64; 3] = [0.04, 0.15, 0.4];
/// A group's stiffness in starts, times that of the others.
const START_RATIOS: [f64; 2] = [0.2, 5.0];
/// Time constants that starts are tried at, in parts of the longest curve.
const START_TIMES: [f64; 3] = [0.002, 0.02, 0.2];
/// Moduli of stiffening bands in starts, times the given ones.
const START_BANDS: [f64; 3] = [0.2, 1.0, 5.0];
/// Their half-width in starts, in parts of the bounds.
const START_PARTS: [f64; 3] = [0.3, 0.55, 0.8];
/// Toughness in starts, times that with which the largest force cuts along the whole edge.
const START_TOUGHNESS: [f64; 7] = [0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0];

/// The best places of the fixed set, their moduli scaled to the forces measured.
pub(super) fn best(fit: &Fit<'_>) -> Result<Vec<Parameters>> {
    let places = places(fit);
    let found = fit.predict_all(&places)?;
    let mut tried: Vec<(f64, Parameters)> = places
        .into_iter()
        .zip(found)
        .map(|(mut place, mut found)| {
            let factor = scale(fit, &found);
            for &unknown in fit.unknowns.iter().filter(|unknown| unknown.is_modulus()) {
                let value = factor * unknown.get(&place);
                unknown.set(&mut place, value);
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
            for ((o, f), noise) in target.observed.iter().zip(values).zip(noise) {
                both += o * f / (noise * noise);
                square += f * f / (noise * noise);
            }
        }
    }
    if both > 0.0 && square > 0.0 { both / square } else { 1.0 }
}

/// Every combination of a few values of all that shapes a curve.
fn places(fit: &Fit<'_>) -> Vec<Parameters> {
    let mut all = ratios(fit);
    if fit.bench.options.tissue.is_some() {
        vary(&mut all, &bands(fit));
        return all;
    }
    let alphas = START_ALPHAS.map(|part| {
        let groups = (0..fit.bench.groups.len()).map(Unknown::Alpha);
        groups.map(|of| (of, part * of.bounds(fit.bounds)[1])).collect()
    });
    vary(&mut all, &[alphas.to_vec()]);
    let ends_s = fit.bench.targets.iter().filter_map(|target| target.time_s.last().copied());
    let longest_s = ends_s.fold(0.0, f64::max);
    if longest_s > 0.0 {
        let times = START_TIMES.map(|part| vec![(Unknown::Time, part * longest_s)]);
        vary(&mut all, &[times.to_vec()]);
    }
    all
}

/// The start as it was given, and with one group softer or stiffer than the others.
fn ratios(fit: &Fit<'_>) -> Vec<Parameters> {
    let start = fit.bench.start();
    let mut all = vec![start.clone()];
    let groups = 0..fit.bench.groups.len();
    for group in groups.clone().filter(|_| groups.len() > 1) {
        for ratio in START_RATIOS {
            let mut one = start.clone();
            let of_group = match fit.bench.options.tissue {
                Some(_) => Unknown::Young(group),
                None => Unknown::Stiffness(group),
            };
            of_group.set(&mut one, ratio * of_group.get(&start));
            all.push(one);
        }
    }
    all
}

/// Values that are set together.
type Values = Vec<(Unknown, f64)>;

/// The choices for stiffening, offset and toughness, where they are looked for; a thickness begins as
/// it is given.
fn bands(fit: &Fit<'_>) -> Vec<Vec<Values>> {
    let start = fit.bench.start();
    let Wanted { stiffening, half_width, offset, toughness, .. } = fit.bench.wanted;
    let numbers = 0..start.stiffening.len();
    let within = |unknown: Unknown, part: f64| {
        let [low, high] = unknown.bounds(fit.bounds);
        low * (high / low).powf(part)
    };
    let mut choices = Vec::new();
    if stiffening {
        let times = |factor: f64| {
            let all = numbers.clone().map(Unknown::Stiffening);
            all.map(|of| (of, factor * of.get(&start))).collect()
        };
        choices.push(START_BANDS.map(times).to_vec());
    }
    // Several widths begin as they are given.
    if half_width && start.stiffening.len() == 1 {
        let of = Unknown::HalfWidth(0);
        choices.push(START_PARTS.map(|part| vec![(of, within(of, part))]).to_vec());
    }
    if offset {
        choices.push(vec![vec![(Unknown::Offset, within(Unknown::Offset, START_PARTS[1]))]]);
    }
    if toughness && let Tool::Blade(edge, _) = fit.bench.tool {
        let forces_n = fit.bench.targets.iter().flat_map(|target| &target.observed);
        let largest_n = forces_n.fold(0.0, |most: f64, force| most.max(*force));
        let full_j_per_m2 = largest_n / (2.0 * f64::from(edge.half_m[0]));
        let [low, high] = Unknown::Toughness.bounds(fit.bounds);
        let of =
            |factor: f64| vec![(Unknown::Toughness, (factor * full_j_per_m2).clamp(low, high))];
        choices.push(START_TOUGHNESS.map(of).to_vec());
    }
    choices
}

/// Every place at every value of each choice.
fn vary(all: &mut Vec<Parameters>, choices: &[Vec<Values>]) {
    for choice in choices {
        let places = std::mem::take(all);
        for place in places {
            for values in choice {
                let mut one = place.clone();
                values.iter().for_each(|(unknown, value)| unknown.set(&mut one, *value));
                all.push(one);
            }
        }
    }
}
