//! Which organs fit a millisecond, with the error of their force.
//!
//! The instructions are the emulated core's. The error is this machine's, which computes the same
//! bits: the example `press_error` of `chaincell-lab` finds it.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

/// Instructions of a millisecond: 480 MHz at one instruction a cycle.
const PER_MILLISECOND: u64 = 480_000;
/// Largest error of the force that the headline admits.
const ERROR_MAX: f64 = 0.05;

/// Errors of the force at a number of sweeps, as `press_error` prints them.
#[derive(Debug, Clone, Deserialize)]
pub struct Errors {
    pub scheme: String,
    pub cells: usize,
    pub coarse_functions: usize,
    sweeps: u16,
    force: Force,
    snaps: Snaps,
}

#[derive(Debug, Clone, Deserialize)]
struct Force {
    median: f64,
    largest: f64,
    in_snaps: Option<f64>,
}

#[derive(Debug, Clone, Deserialize)]
struct Snaps {
    share: f64,
    too_many: bool,
}

/// One body with a number of sweeps a tick.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub scheme: String,
    pub cells: usize,
    pub links: usize,
    pub coarse_functions: usize,
    pub sweeps: u16,
    /// Instructions of a tick in the worst state.
    pub instructions: u64,
    /// Largest error of the force outside snaps, from tick 30 on.
    pub force_error_max: f64,
    pub force_error_median: f64,
    pub force_error_in_snaps: Option<f64>,
    /// Part of the ticks in snaps; where it is too large none is left out.
    pub snap_share: f64,
    pub too_many_snaps: bool,
}

impl Row {
    /// A row from instructions of a tick of one sweep and of every further sweep.
    pub fn new(links: usize, tick: u64, sweep: u64, errors: &Errors) -> Self {
        Self {
            scheme: errors.scheme.clone(),
            cells: errors.cells,
            links,
            coarse_functions: errors.coarse_functions,
            sweeps: errors.sweeps,
            instructions: tick + u64::from(errors.sweeps.saturating_sub(1)) * sweep,
            force_error_max: errors.force.largest,
            force_error_median: errors.force.median,
            force_error_in_snaps: errors.force.in_snaps,
            snap_share: errors.snaps.share,
            too_many_snaps: errors.snaps.too_many,
        }
    }

    fn fits(&self) -> bool {
        self.instructions <= PER_MILLISECOND && self.force_error_max <= ERROR_MAX
    }

    /// Head of the table.
    pub fn head() -> String {
        format!(
            "{:8} {:>6} {:>6} {:>5} {:>6} {:>13} {:>12} {:>10} {:>10} {:>8}  fits",
            "scheme",
            "cells",
            "links",
            "coarse_functions",
            "sweeps",
            "instructions",
            "force max %",
            "median %",
            "in snaps %",
            "snaps %"
        )
    }

    /// Its line.
    pub fn line(&self) -> String {
        let percent = |part: f64| format!("{:.2}", 100.0 * part);
        let kept = if self.too_many_snaps { " (kept)" } else { "" };
        format!(
            "{:8} {:6} {:6} {:5} {:6} {:13} {:>12} {:>10} {:>10} {:>8}  {}",
            self.scheme,
            self.cells,
            self.links,
            self.coarse_functions,
            self.sweeps,
            self.instructions,
            percent(self.force_error_max),
            percent(self.force_error_median),
            self.force_error_in_snaps.map_or("-".to_owned(), percent),
            percent(self.snap_share) + kept,
            if self.fits() { "yes" } else { "no" }
        )
    }
}

/// The largest organ that fits with its force.
pub fn headline(rows: &[Row]) -> String {
    let fitting = rows.iter().filter(|row| row.fits());
    let best = fitting.max_by_key(|row| (row.cells, std::cmp::Reverse(row.instructions)));
    let bound = format!(
        "force within {:.0} % at 50 mm/s in {PER_MILLISECOND} instructions",
        100.0 * ERROR_MAX
    );
    let Some(row) = best else { return format!("no organ measured has its {bound}") };
    let plural = if row.sweeps == 1 { "sweep" } else { "sweeps" };
    format!(
        "largest organ with its {bound}: {} cells, {} coarse functions, {}, {} {plural} a tick, {} instructions, \
         force within {:.2} %",
        row.cells,
        row.coarse_functions,
        row.scheme,
        row.sweeps,
        row.instructions,
        100.0 * row.force_error_max
    )
}

/// The errors of the organ of a size with a coarse level of a spacing.
///
/// # Errors
/// A program that is not there, fails, or prints something else.
pub fn errors(program: &Path, scheme: &str, cells: u32, spacing: &str) -> Result<Vec<Errors>> {
    let mut command = Command::new(program);
    let output = command.arg(format!("{scheme}:{cells}:{spacing}")).output();
    let output = output.with_context(|| program.display().to_string())?;
    let why = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{}: {why}", program.display());
    let said = String::from_utf8(output.stdout)?;
    Ok(said.lines().map(serde_json::from_str).collect::<Result<_, _>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(cells: usize, sweeps: u16, sweep: u64, largest: f64) -> Row {
        let force = Force { median: 0.5 * largest, largest, in_snaps: None };
        let snaps = Snaps { share: 0.0, too_many: false };
        Row::new(
            9,
            1000 + sweep,
            sweep,
            &Errors { scheme: "track".into(), cells, coarse_functions: 24, sweeps, force, snaps },
        )
    }

    #[test]
    fn the_headline_is_the_largest_organ_that_keeps_both_bounds() {
        assert_eq!(row(500, 4, 100_000, 0.01).instructions, 401_000);
        let rows = [
            row(300, 1, 100_000, 0.04),
            row(500, 2, 200_000, 0.049),
            row(500, 1, 200_000, 0.05),
            row(700, 1, 300_000, 0.051),
            row(900, 1, 479_001, 0.01),
        ];
        let said = headline(&rows);
        assert!(said.contains(" 500 cells") && said.contains(" 1 sweep a tick"), "{said}");
        assert!(headline(&rows[3..]).starts_with("no organ"));
        assert!(rows[2].line().ends_with("yes") && rows[3].line().ends_with("no"));
    }

    #[test]
    fn errors_are_read_as_they_are_printed() {
        let line = r#"{"scheme":"predict","cells":499,"coarse_functions":24,"sweeps":2,"force":{"median":0.01,"p90":0.02,
            "largest":0.03,"in_snaps":null},"snaps":{"ticks":[],"share":0.0,"too_many":false}}"#;
        let errors: Errors = serde_json::from_str(line).unwrap();
        let row = Row::new(2685, 300_000, 280_000, &errors);
        assert_eq!((row.cells, row.instructions, row.force_error_max), (499, 580_000, 0.03));
    }
}
