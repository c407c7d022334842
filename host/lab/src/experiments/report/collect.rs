//! The whole report: what is measured in which order, and what it gives.

use std::path::PathBuf;

use indicatif::ProgressBar;
use serde::Serialize;

use super::embedded;
use super::engine::link_sweep_ns;
use super::hand::{self, HandRow};
use super::motions::Motion;
use super::scene::Scene;
use super::tools::{self, ToolRow};
use chaincell_host::error::Result;
use chaincell_host::session::timing::machine::Machine;

/// What to measure.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Fewer scenes, sizes and rounds.
    pub quick: bool,
    /// Folder of the reference data with the real liver.
    pub reference: Option<PathBuf>,
}

/// All figures; what an interrupted report did not reach is absent.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// Fewer scenes, sizes and rounds.
    pub quick: bool,
    /// Whether the user ended it early: sections are missing.
    pub interrupted: bool,
    /// How long the measurements took \[s\].
    pub seconds: f64,
    /// Whether reference data was at hand.
    pub reference: bool,
    /// The machine.
    pub machine: Machine,
    /// Median sweep over the links of the first body, every link outside its band \[ns\].
    pub link_sweep_ns: u64,
    /// Held cells under a hand that moves.
    pub hand: Vec<HandRow>,
    /// Tools on a contact surface.
    pub tools: Vec<ToolRow>,
}

/// Straight in, two depths: the deeper one goes through the liver's snap.
const FAST: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 15.0 };
const FAST_DEEP: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 24.0 };
/// Straight in, as the table of microcontrollers has it.
const SLOW: Motion = embedded::MOTION;
/// The large organ up to the tick before its first snap.
const SHALLOW: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 6.9 };
/// Cells of the large organ, and of the only one of the quick form.
const LARGE_CELLS: usize = 16_500;
const QUICK_CELLS: usize = 300;
/// Times that a sweep is measured.
const ROUNDS: usize = 301;
const QUICK_ROUNDS: usize = 15;

/// The bodies with the cells that a hand holds, and their motions.
fn hands(options: &Options) -> Result<Vec<(Scene, &'static [Motion])>> {
    if options.quick {
        return Ok(vec![(Scene::organ_of(QUICK_CELLS)?, &[FAST, Motion::Circles])]);
    }
    let main = match &options.reference {
        Some(folder) => Scene::liver(folder, false)?,
        None => Scene::organ()?,
    };
    let large = Scene::organ_of(LARGE_CELLS)?;
    Ok(vec![(main, &[FAST_DEEP, FAST, SLOW, Motion::Circles]), (large, &[FAST, SHALLOW])])
}

/// Pieces of work, for the progress bar.
#[must_use]
pub fn pieces(options: &Options) -> u64 {
    let hands = if options.quick { 2 } else { 6 };
    (hands + tools::pieces(options.quick)) as u64
}

/// Measures everything into `report`; an error leaves what was measured so far there.
///
/// # Errors
/// Reference data that cannot be read, or the user's wish to stop.
pub fn collect(options: &Options, report: &mut Report, bar: &ProgressBar) -> Result<()> {
    report.quick = options.quick;
    report.reference = options.reference.is_some();
    report.machine = Machine::read();
    let rounds = if options.quick { QUICK_ROUNDS } else { ROUNDS };
    for (scene, motions) in hands(options)? {
        if report.link_sweep_ns == 0 {
            report.link_sweep_ns = link_sweep_ns(&scene, rounds)?;
        }
        for &motion in motions {
            report.hand.extend(hand::run(&scene, motion, &hand::SWEEPS, report.link_sweep_ns)?);
            bar.inc(1);
        }
    }
    tools::run(options.quick, |rows| {
        report.tools.extend(rows);
        bar.inc(1);
    })
}
