//! Error of the force at the sweeps of a session, against the same ticks with many more sweeps.
//!
//! A tick that is looked at is computed twice from the same state: with [`MANY`] sweeps, and, after the state
//! was restored, with those that the session made. The error is the distance between the two forces.
//!
//! **Bounded cost.** At most `LOOKS` ticks are looked at, spread evenly, and fewer on large bodies: as many
//! as make `CELL_SWEEPS` passes over a cell, but at least `LOOKS_LEAST`.

use std::fmt;

use chaincell_kernel::{Budget, Settings, TickOutput, ToolPose};
use nalgebra::Vector3;
use serde::Serialize;

use super::staged::Staged;
use super::tissue::TissueEngine;

/// Sweeps of the reference.
pub const MANY: u16 = 64;
/// Bounds of the number of ticks.
const LOOKS: u64 = 200;
const LOOKS_LEAST: u64 = 20;
/// Passes over a cell in all ticks of the reference.
const CELL_SWEEPS: u64 = 40_000_000;

/// Distance of the forces of a session from those of many sweeps, as shares of its largest force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ForceError {
    /// Sweeps of the reference.
    pub sweeps: u16,
    /// Ticks that were compared: those looked at in which a force acted.
    pub ticks: usize,
    /// Half of them are within.
    pub median: f64,
    /// 99 of 100 are.
    pub p99: f64,
}

impl fmt::Display for ForceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let (median, p99, sweeps) = (percent(self.median), percent(self.p99), self.sweeps);
        write!(f, "within {median} (median), {p99} (99 of 100 ticks) of {sweeps} sweeps")
    }
}

/// Errors of ticks by size; at least one.
#[derive(Debug, Clone)]
pub struct Errors(Vec<f64>);

impl Errors {
    /// Sorts errors; `None` without any.
    #[must_use]
    pub fn of(errors: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = errors.collect();
        sorted.sort_by(f64::total_cmp);
        (!sorted.is_empty()).then_some(Self(sorted))
    }

    /// Their number.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// The error within which this many of a hundred are; with 100 the largest one.
    #[must_use]
    pub fn within(&self, percent: usize) -> f64 {
        let last = self.0.len() - 1;
        self.0[(self.0.len() * percent / 100).min(last)]
    }
}

/// Compares some ticks of a tissue while they are played.
#[derive(Debug, Clone)]
pub struct Convergence {
    every: u64,
    ticks: u64,
    /// Forces of all tools, of the session and of many sweeps \[N\].
    pairs: Vec<[Vec<Vector3<f64>>; 2]>,
}

impl Convergence {
    /// For a session of `ticks` ticks on a body of `cells` cells.
    #[must_use]
    pub fn new(ticks: u64, cells: usize) -> Self {
        let affordable = CELL_SWEEPS / (u64::from(MANY) * (cells as u64).max(1));
        let looks = affordable.clamp(LOOKS_LEAST, LOOKS);
        Self { every: ticks.div_ceil(looks).max(1), ticks: 0, pairs: Vec::new() }
    }

    /// A tick of the tissue, like [`TissueEngine::tick_by`], compared if it is one of those looked at. The
    /// tissue's state is the same either way.
    pub fn tick(
        &mut self,
        tissue: &mut Staged<'_>,
        poses: &[ToolPose],
        budget: Budget<'_>,
    ) -> TickOutput {
        self.ticks += 1;
        let is_looked_at = self.ticks.is_multiple_of(self.every);
        let many = if is_looked_at { forces_of_many(tissue, poses) } else { None };
        let output = tissue.tick_by(poses, budget);
        if let Some(many) = many {
            self.pairs.push([forces(tissue, &output), many]);
        }
        output
    }

    /// The errors; `None` if no force acted in any tick looked at.
    #[must_use]
    pub fn error(&self) -> Option<ForceError> {
        let size = |forces: &[Vector3<f64>]| forces.iter().map(Vector3::norm).fold(0.0, f64::max);
        let largest_n = self.pairs.iter().map(|[_, many]| size(many)).fold(0.0, f64::max);
        // The tool with the largest error counts.
        let acting = self.pairs.iter().filter(|[own, many]| size(own) + size(many) > 0.0);
        let errors = Errors::of(acting.map(|[own, many]| {
            let apart = own.iter().zip(many).map(|(own, many)| (own - many).norm());
            apart.fold(0.0, f64::max) / largest_n
        }))?;
        let (ticks, median, p99) = (errors.count(), errors.within(50), errors.within(99));
        median.is_finite().then_some(ForceError { sweeps: MANY, ticks, median, p99 })
    }
}

/// Forces of a tick with many sweeps \[N\]; the tissue is then as before. `None` where the tissue cannot be
/// saved, or its scheme does not take as many.
fn forces_of_many(tissue: &mut Staged<'_>, poses: &[ToolPose]) -> Option<Vec<Vector3<f64>>> {
    let saved = tissue.saved()?;
    tissue.engine_mut().choose(Settings { sweeps: MANY, ..saved.settings }).ok()?;
    let output = tissue.tick_by(poses, Budget::All);
    let many = forces(tissue, &output);
    tissue.restore(&saved).ok()?;
    Some(many)
}

/// Force of each tool in the last tick, or that of the held cells \[N\].
fn forces(tissue: &mut Staged<'_>, output: &TickOutput) -> Vec<Vector3<f64>> {
    match tissue.tools() {
        0 => vec![output.force_n.cast()],
        tools => {
            (0..tools).map(|tool| tissue.engine_mut().tool_output(tool).force_n.cast()).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::fixture::{engine, plane};

    /// A press of 40 ticks, 1 mm per tick. Returns the errors and the state hash.
    fn pressed(sweeps: u16, is_compared: bool) -> (Option<ForceError>, u64) {
        let image = plane();
        let mut engine = engine(&image);
        let settings = Settings { sweeps, ..*engine.network().settings() };
        engine.choose(settings).unwrap();
        let mut tissue = Staged::new(engine, None).unwrap();
        let mut convergence = Convergence::new(40, 441);
        for tick in 0..40_u8 {
            let pose = ToolPose::at(Vector3::new(0.0, 0.0, -1.0e-3 * f32::from(tick)), 1);
            match is_compared {
                true => convergence.tick(&mut tissue, &[pose], Budget::All),
                false => tissue.tick(&pose),
            };
        }
        (convergence.error(), tissue.state_hash())
    }

    #[test]
    fn fewer_sweeps_are_farther_from_many_and_the_state_is_the_same() {
        let [(one, hash), (four, _), (many, _)] = [1, 4, MANY].map(|of| pressed(of, true));
        let [one, four, many] = [one, four, many].map(Option::unwrap);
        assert_eq!(hash, pressed(1, false).1);
        assert!(one.median > 2.0 * four.median && four.median > 0.0, "{one:?} {four:?}");
        assert!(one.p99 >= one.median && one.ticks > 30 && one.p99 < 1.0, "{one:?}");
        assert_eq!((many.median, many.p99), (0.0, 0.0));
        assert_eq!(pressed(1, false).0, None);
    }

    #[test]
    fn the_number_of_ticks_is_bounded() {
        for (ticks, cells, most) in
            [(10, 1, 10), (10_000, 995, 200), (10_000, 16_500, 38), (3_600_000, 65_535, 20)]
        {
            let looks = ticks / Convergence::new(ticks, cells).every;
            assert!(looks <= most && looks > most / 2, "{ticks} ticks, {cells} cells: {looks}");
        }
    }

    #[test]
    fn the_error_is_said_in_percent() {
        let error = ForceError { sweeps: MANY, ticks: 200, median: 0.0091, p99: 0.03 };
        let text = "within 0.9 % (median), 3.0 % (99 of 100 ticks) of 64 sweeps";
        assert_eq!(error.to_string(), text);
    }
}
