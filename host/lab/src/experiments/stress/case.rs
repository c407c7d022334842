//! A case: what it is called, what it checks, and what was found.

use std::collections::BTreeMap;

use serde::Serialize;

use super::trial::{Trial, refusal};
use crate::bodies::Variant;
use crate::monitor::{Check, Failure, Monitor, Worst};
use chaincell_host::engine::Arithmetic;
use chaincell_host::error::Result;

/// How much is done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Scale {
    /// Smaller bodies, fewer ticks and seeds.
    pub quick: bool,
    /// The drift over 10^8 ticks.
    pub slow: bool,
}

impl Scale {
    /// Nodes along an edge of the box.
    #[must_use]
    pub fn nodes(self) -> u32 {
        if self.quick { 5 } else { 8 }
    }

    /// Ticks of a trial that takes `quick` of them at least.
    #[must_use]
    pub fn ticks(self, quick: u32) -> u32 {
        if self.quick { quick } else { 4 * quick }
    }
}

/// A case of the suite.
#[derive(Clone, Copy)]
pub struct Case {
    /// Its name.
    pub name: &'static str,
    /// What it does and checks, beyond what is checked in every tick.
    pub checks: &'static str,
    /// Does it.
    pub run: fn(Scale, &mut Findings) -> Result<()>,
}

/// A run of a trial under a variant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// The trial.
    pub trial: String,
    /// Scheme and numbers.
    pub variant: String,
    /// Part of the largest energy left at the end.
    pub energy_left: f64,
    /// Largest force \[N\].
    pub force_max_n: f64,
}

/// A failed check with its place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failed {
    /// Trial and variant.
    pub place: String,
    /// What failed, when, by how much.
    #[serde(flatten)]
    pub failure: Failure,
}

/// What a case has found so far.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Findings {
    /// How close all runs came to their bounds.
    #[serde(skip)]
    pub worst: Worst,
    /// Figures by name, units in the names; ratios are of a bound.
    pub figures: BTreeMap<String, f64>,
    /// Checks that failed.
    pub failures: Vec<Failed>,
    /// Bodies that number types do not take, with the reason.
    pub refused: Vec<String>,
    /// Every run.
    pub runs: Vec<Run>,
}

impl Findings {
    /// Plays a trial under every variant that moves its body.
    ///
    /// # Errors
    /// Interruption; what neither body nor settings explain.
    pub fn play(&mut self, trial: &Trial<'_>) -> Result<()> {
        let variants = match &trial.tools {
            Some(_) => Variant::of_shapes(),
            None => Variant::of_body(trial.body)?,
        };
        for variant in variants {
            let place = format!("{}, {variant}", trial.label);
            match refusal(trial.play(variant))? {
                Ok(None) => {}
                Ok(Some(monitor)) => self.note(&place, trial, variant, &monitor),
                Err(why) if variant.numbers == Arithmetic::F32 => {
                    self.fail(place, Check::Admission, why);
                }
                Err(why) => self.refuse(why),
            }
        }
        Ok(())
    }

    /// Notes how a trial ended under a variant.
    fn note(&mut self, place: &str, trial: &Trial<'_>, variant: Variant, monitor: &Monitor<'_>) {
        let worst = *monitor.worst();
        self.failed(place, monitor);
        self.worst = self.worst.or(worst);
        self.runs.push(Run {
            trial: trial.label.clone(),
            variant: variant.to_string(),
            energy_left: worst.left(),
            force_max_n: worst.force_max_n,
        });
        if trial.tools.is_some() {
            let known = self.figures.entry("ticks_without_certificate".to_owned()).or_default();
            *known += monitor.missing() as f64;
        }
    }

    /// Notes the failures that a monitor has seen.
    pub fn failed(&mut self, place: &str, monitor: &Monitor<'_>) {
        let failures = monitor.failures().iter().cloned();
        self.failures.extend(failures.map(|failure| Failed { place: place.to_owned(), failure }));
    }

    /// Notes what a number type refuses.
    pub fn refuse(&mut self, why: String) {
        if !self.refused.contains(&why) {
            self.refused.push(why);
        }
    }

    fn fail(&mut self, place: String, check: Check, what: String) {
        self.failures.push(Failed { place, failure: Failure { check, tick: 0, what } });
    }

    /// Notes a check that may fail.
    pub fn hold(
        &mut self,
        holds: bool,
        place: impl Into<String>,
        check: Check,
        what: impl FnOnce() -> String,
    ) {
        if !holds {
            self.fail(place.into(), check, what());
        }
    }

    /// Notes the larger of a figure and what is known of it.
    pub fn figure(&mut self, name: &str, value: f64) {
        let known = self.figures.entry(name.to_owned()).or_insert(value);
        *known = known.max(value);
    }
}

/// A case that was done.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Name of the case.
    pub name: &'static str,
    /// Whether every check held.
    pub ok: bool,
    /// What it does and checks.
    pub checks: &'static str,
    /// What was found.
    #[serde(flatten)]
    pub found: Findings,
}

impl Outcome {
    /// Of what a case has found.
    #[must_use]
    pub fn new(case: &Case, mut found: Findings) -> Self {
        let (worst, runs, figures) = (found.worst, &found.runs, &mut found.figures);
        if worst.ticks > 0 {
            let left = runs.iter().map(|run| run.energy_left).fold(0.0, f64::max);
            let of_worst = [
                ("runs", runs.len() as f64),
                ("ticks", worst.ticks as f64),
                ("energy_peak_j", worst.energy_peak_j),
                ("energy_left", left),
                ("force_max_n", worst.force_max_n),
                ("energy_over_bound", worst.energy_over_bound),
                ("force_over_bound", worst.force_over_bound),
                ("coordinate_over_k", worst.coordinate_over_k),
                ("rounding_over_allowance", worst.rounding_used),
            ];
            figures.extend(of_worst.map(|(name, value)| (name.to_owned(), value)));
        }
        figures.insert("refused".to_owned(), found.refused.len() as f64);
        Self { name: case.name, ok: found.failures.is_empty(), checks: case.checks, found }
    }

    /// The figure that came nearest to its bound, which is 1.
    #[must_use]
    pub fn nearest(&self) -> String {
        let of = [
            ("energy_over_bound", "E"),
            ("force_over_bound", "F"),
            ("coordinate_over_k", "x"),
            ("rounding_over_allowance", "r"),
        ];
        let known = |key: &str| self.found.figures.get(key).copied();
        let figures = of.iter().filter_map(|(key, name)| Some((name, known(key)?)));
        let nearest = figures.max_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map_or("-".to_owned(), |(name, value)| format!("{name} {value:.2}"))
    }
}
