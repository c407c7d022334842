//! A muscle compressed to 30 % at 5 % a second and held: links with one time constant.
//!
//! Data: skeletal muscle, as tabled in LivingMatterLab/CANN, Cauchy stress over time. Nodal shapes have
//! no time constant, so the specimen is a cube of links whose top the tool moves along the measured
//! stretch. Its Cauchy stress is taken back to a force as that of a body that keeps its volume.

use std::path::Path;

use serde::Serialize;

use super::read::table;
use super::{Section, parameters};
use crate::charts::plot::{Axis, Chart, Style};
use crate::experiments::identify::target::{Data, Target, rms};
use crate::experiments::identify::tool::Tool;
use crate::experiments::identify::{Bench, Bounds, Identified, Wanted, groups, identify};
use crate::experiments::report::tables::{Table, csv, percent};
use chaincell_host::bake::{BakeOptions, bake};
use chaincell_host::engine::contact::contact_cells;
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::Model;

const DATA: &str = "tissue/muscle_relaxation_f05.csv";
const HEADER: &str = "curve,time_s,stretch,cauchy_stress_kpa";
/// The cube, and a box around the nodes of its top.
const CUBE: &str = "box:5x5x5x0.0025";
const TOP: &str = "cells:box:-1,1,-1,1,0.0099,0.0101";
const SIDE_M: f64 = 0.01;
/// Times that the table shows \[s\].
const SHOWN_S: [f64; 6] = [6.05, 7.0, 12.1, 30.0, 86.0, 302.0];

/// A measured moment and what the fit gives there; stresses of the undeformed face, pressing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MuscleRow {
    /// Time since the ramp began.
    pub time_s: f64,
    /// Stretch.
    pub stretch: f64,
    /// Measured.
    pub measured_kpa: f64,
    /// Links with one time constant.
    pub fit_kpa: f64,
}

fn measured(reference: &Path) -> Result<Option<Vec<MuscleRow>>> {
    let Some(table) = table(reference, DATA, HEADER)? else { return Ok(None) };
    let rows = table.iter().map(|row| {
        let stretch = row.number(2)?;
        // The face of a body that keeps its volume grows as it gets shorter.
        let measured_kpa = -row.number(3)? / stretch;
        Ok(MuscleRow { time_s: row.number(1)?, stretch, measured_kpa, fit_kpa: 0.0 })
    });
    rows.collect::<Result<_>>().map(Some)
}

/// Force of a stress on the cube's face [N/kPa].
const FORCE_N_PER_KPA: f64 = 1e3 * SIDE_M * SIDE_M;

fn target(rows: &[MuscleRow]) -> Target {
    let column = |of: fn(&MuscleRow) -> f64| rows.iter().map(of).collect();
    let data = Data::Path {
        time_s: column(|row| row.time_s),
        displacement_m: column(|row| (1.0 - row.stretch) * SIDE_M),
        force_n: column(|row| row.measured_kpa * FORCE_N_PER_KPA),
    };
    Target::new("muscle", data)
}

fn fit(targets: &[Target]) -> Result<Identified> {
    let mesh = load(CUBE, &MeshOptions::default())?;
    let options = BakeOptions::default();
    let image = bake(&mesh, &mesh.default_fixed, &options)?;
    let model = Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
    let bench = Bench {
        mesh: &mesh,
        fixed: &mesh.default_fixed,
        options: &options,
        groups: &groups(&[], &mesh)?,
        tool: Tool::Held(&contact_cells(TOP, &model)?),
        direction: [0.0, 0.0, -1.0],
        targets,
        slab: None,
        wanted: Wanted::default(),
    };
    identify(&bench, &Bounds { alpha_max: 0.2, ..Bounds::default() }, 0.0)
}

/// Fits the muscle; none without its data.
///
/// # Errors
/// Data that cannot be read; what the fit refuses.
pub fn section(reference: &Path) -> Result<Option<Section>> {
    let Some(mut rows) = measured(reference)? else { return Ok(None) };
    let found = fit(&[target(&rows)])?;
    for (row, fit) in rows.iter_mut().zip(&found.fitted[0]) {
        row.fit_kpa = fit / FORCE_N_PER_KPA;
    }
    let head = format!(
        "## A muscle that relaxes\n\nCompressed by 30 % in 6 s, then held for 300 s, {} points \
         (skeletal muscle, as tabled in CANN). Assumed: a cube of 10 mm, both ends held, volume kept. \
         Links under rkl2, {CUBE}, one time constant. {} evaluations, {:.0} s.\n\n",
        rows.len(),
        found.evaluations,
        found.seconds
    );
    let text = format!("{head}{}{}", parameters(&found), misfits(&rows));
    Ok(Some(Section { name: "tissue_muscle", text, csv: csv(&rows), chart: chart(&rows) }))
}

/// What a fit leaves, in parts of the largest measured stress.
fn misfit(rows: &[MuscleRow]) -> f64 {
    let off: Vec<f64> = rows.iter().map(|row| row.fit_kpa - row.measured_kpa).collect();
    rms(&off) / peak(rows)
}

fn peak(rows: &[MuscleRow]) -> f64 {
    rows.iter().fold(0.0, |most, row| row.measured_kpa.max(most))
}

/// The exponential with an offset of its own that is nearest to a falling curve: its time constant
/// \[s\], and what it leaves (root mean square, kPa).
fn exponential(points: &[[f64; 2]]) -> (f64, f64) {
    let span = points.last().zip(points.first()).map_or(1.0, |(last, first)| last[0] - first[0]);
    let tried = (0..=400).map(|at| {
        let constant_s = span * 10.0_f64.powf(-3.0 + 0.01 * f64::from(at));
        (constant_s, rest_of(points, constant_s))
    });
    tried.fold((f64::NAN, f64::INFINITY), |best, one| if one.1 < best.1 { one } else { best })
}

/// What is left of points after the line over e^(-t / constant) that is nearest to them.
fn rest_of(points: &[[f64; 2]], constant_s: f64) -> f64 {
    let at = |point: &[f64; 2]| (-(point[0] - points[0][0]) / constant_s).exp();
    let count = points.len() as f64;
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(&at), mean(&|point| point[1]));
    let both = mean(&|point| (at(point) - x) * (point[1] - y));
    let slope = both / mean(&|point| (at(point) - x).powi(2));
    mean(&|point| (point[1] - y - slope * (at(point) - x)).powi(2)).sqrt()
}

fn misfits(rows: &[MuscleRow]) -> String {
    let shortest = rows.iter().fold(f64::INFINITY, |least, row| row.stretch.min(least));
    let is_held = |row: &&MuscleRow| row.stretch <= shortest;
    let held: Vec<MuscleRow> = rows.iter().filter(is_held).copied().collect();
    let ramp: Vec<MuscleRow> = rows.iter().filter(|row| !is_held(row)).copied().collect();
    let points: Vec<[f64; 2]> = held.iter().map(|row| [row.time_s, row.measured_kpa]).collect();
    let (constant_s, left_kpa) = exponential(&points);
    let nearest = |at: f64| {
        let mut by = rows.to_vec();
        by.sort_by(|a, b| (a.time_s - at).abs().total_cmp(&(b.time_s - at).abs()));
        by.first().copied()
    };
    let table = Table::of(SHOWN_S.iter().filter_map(|&at| nearest(at)))
        .column("time [s]", |row| format!("{:.1}", row.time_s))
        .column("measured [kPa]", |row| format!("{:.2}", row.measured_kpa))
        .column("fit [kPa]", |row| format!("{:.2}", row.fit_kpa));
    format!(
        "{}Misfit, root mean square in parts of the peak: {} % of all, {} % of the ramp, {} % of the \
         hold. One exponential with an offset of its own, fitted to the hold alone, leaves {} % \
         ({constant_s:.1} s).\n\n",
        table.table().markdown(),
        percent(misfit(rows)),
        percent(rms(&off(&ramp)) / peak(rows)),
        percent(rms(&off(&held)) / peak(rows)),
        percent(left_kpa / peak(rows)),
    )
}

fn off(rows: &[MuscleRow]) -> Vec<f64> {
    rows.iter().map(|row| row.fit_kpa - row.measured_kpa).collect()
}

fn chart(rows: &[MuscleRow]) -> Chart {
    let points = |of: fn(&MuscleRow) -> f64| -> Vec<[f64; 2]> {
        rows.iter().map(|row| [row.time_s, of(row)]).collect()
    };
    Chart::new(
        "A muscle compressed by 30 % in 6 s and held",
        Axis::log10("time [s]"),
        Axis::linear("nominal stress, pressing [kPa]"),
    )
    .series("measured", Style::Markers, &points(|row| row.measured_kpa))
    .series("fit: links with one time constant", Style::Line, &points(|row| row.fit_kpa))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponential_comes_back_and_two_do_not() {
        let of = |second: f64| -> Vec<[f64; 2]> {
            let value = |t: f64| 1.0 + 2.0 * (-t / 5.0).exp() + second * (-t / 50.0).exp();
            (0..60).map(|at| [6.0 + f64::from(at), value(f64::from(at))]).collect()
        };
        let (constant_s, left) = exponential(&of(0.0));
        assert!((constant_s / 5.0 - 1.0).abs() < 0.02 && left < 0.01, "{constant_s} {left}");
        assert!(exponential(&of(2.0)).1 > 0.03);
    }
}
