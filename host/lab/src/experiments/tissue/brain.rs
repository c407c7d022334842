//! Human brain cortex in tension, compression and shear: one set of parameters for all three.
//!
//! Data: Budday and others 2017, as tabled in LivingMatterLab/CANN. The specimen is taken as a cube of
//! 5 mm with both ends glued to plates: the bottom is held and the tool holds the top.

use std::path::Path;

use serde::Serialize;

use super::read::table;
use super::{Section, parameters};
use crate::charts::plot::{Axis, Chart, Style};
use crate::experiments::identify::target::{Data, Target, rms};
use crate::experiments::identify::tool::Tool;
use crate::experiments::identify::{Bench, Bounds, Identified, Wanted, groups, identify};
use crate::experiments::report::tables::{Table, csv, percent};
use chaincell_host::bake::tissue::{Band, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell, bake};
use chaincell_host::engine::contact::contact_cells;
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::Model;

const DATA: &str = "tissue/brain_cortex.csv";
const HEADER: &str = "mode,stretch_or_shear,nominal_stress_kpa";
/// The cube, and a box around the nodes of its top.
const CUBE: &str = "box:6x6x6x0.001";
const TOP: &str = "cells:box:-1,1,-1,1,0.0049,0.0051";
const SIDE_M: f64 = 0.005;
const POISSON: f64 = 0.45;
/// Where the fit begins.
const YOUNG_PA: f64 = 2000.0;
const BAND: Band = Band { half_width: 0.05, modulus_pa: 5000.0 };
/// Every mode weighs the same: its error, in parts of its root mean square.
const ERROR: f64 = 0.05;

/// A way to deform the cube.
struct Mode {
    letter: &'static str,
    name: &'static str,
    /// Where the top goes.
    direction: [f64; 3],
    /// What is subtracted from the second column, and its sign along the direction.
    rest: f64,
    sign: f64,
}

const MODES: [Mode; 3] = [
    Mode { letter: "T", name: "tension", direction: [0.0, 0.0, 1.0], rest: 1.0, sign: 1.0 },
    Mode { letter: "C", name: "compression", direction: [0.0, 0.0, -1.0], rest: 1.0, sign: -1.0 },
    Mode { letter: "S", name: "shear", direction: [1.0, 0.0, 0.0], rest: 0.0, sign: 1.0 },
];

/// A measured point and what the fits give there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BrainRow {
    /// Tension, compression or shear.
    pub mode: &'static str,
    /// Strain or shear; negative in compression.
    pub strain: f64,
    /// Measured nominal stress.
    pub measured_kpa: f64,
    /// One set of parameters for all modes.
    pub fit_kpa: f64,
    /// Young's modulus alone.
    pub plain_kpa: f64,
}

/// The points of each mode.
fn measured(reference: &Path) -> Result<Option<Vec<Vec<BrainRow>>>> {
    let Some(table) = table(reference, DATA, HEADER)? else { return Ok(None) };
    let of_mode = |mode: &Mode| -> Result<Vec<BrainRow>> {
        let rows = table.iter().filter(|row| row.word(0) == mode.letter);
        rows.map(|row| {
            let strain = row.number(1)? - mode.rest;
            let (measured_kpa, fit_kpa, plain_kpa) = (row.number(2)?, 0.0, 0.0);
            Ok(BrainRow { mode: mode.name, strain, measured_kpa, fit_kpa, plain_kpa })
        })
        .collect()
    };
    MODES.iter().map(of_mode).collect::<Result<_>>().map(Some)
}

/// Force of a stress on the cube's face [N/kPa].
const FORCE_N_PER_KPA: f64 = 1e3 * SIDE_M * SIDE_M;

fn target(mode: &Mode, rows: &[BrainRow]) -> Target {
    let displacement_m = rows.iter().map(|row| mode.sign * row.strain * SIDE_M).collect();
    let force_n: Vec<f64> =
        rows.iter().map(|row| mode.sign * row.measured_kpa * FORCE_N_PER_KPA).collect();
    let deviation = Some(vec![ERROR * rms(&force_n); rows.len()]);
    let direction = Some(mode.direction);
    let data = Data::Press { displacement_m, force_n };
    Target { deviation, direction, ..Target::new(mode.name, data) }
}

/// Fits the cube to all modes at once.
fn fit(targets: &[Target], stiffening: Vec<Band>, wanted: Wanted) -> Result<Identified> {
    on_bench(targets, stiffening, wanted, |bench| identify(bench, &Bounds::default(), 0.0))
}

/// Does something with the cube on a bench.
fn on_bench<T>(
    targets: &[Target],
    stiffening: Vec<Band>,
    wanted: Wanted,
    work: impl FnOnce(&Bench<'_>) -> Result<T>,
) -> Result<T> {
    let mesh = load(CUBE, &MeshOptions::default())?;
    let of = PerCell::Uniform;
    let tissue = Some(Tissue { stiffening, ..Tissue::new(of(YOUNG_PA), of(POISSON)) });
    let options = BakeOptions { tissue, ..BakeOptions::default() };
    let image = bake(&mesh, &mesh.default_fixed, &options)?;
    let model = Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
    let bench = Bench {
        mesh: &mesh,
        fixed: &mesh.default_fixed,
        options: &options,
        groups: &groups(&[], &mesh)?,
        tool: Tool::Held(&contact_cells(TOP, &model)?),
        direction: [0.0, 0.0, 1.0],
        targets,
        slab: None,
        wanted,
    };
    work(&bench)
}

/// Fits the brain; none without its data.
///
/// # Errors
/// Data that cannot be read; what the fit refuses.
pub fn section(reference: &Path) -> Result<Option<Section>> {
    let Some(mut modes) = measured(reference)? else { return Ok(None) };
    let targets: Vec<Target> =
        MODES.iter().zip(&modes).map(|(mode, rows)| target(mode, rows)).collect();
    let plain = fit(&targets, Vec::new(), Wanted::default())?;
    let both = Wanted { stiffening: true, half_width: true, ..Wanted::default() };
    let found = fit(&targets, vec![BAND], both)?;
    for (at, (mode, rows)) in MODES.iter().zip(&mut modes).enumerate() {
        let kpa = |force_n: f64| mode.sign * force_n / FORCE_N_PER_KPA;
        for (row, (fit, plain)) in
            rows.iter_mut().zip(found.fitted[at].iter().zip(&plain.fitted[at]))
        {
            (row.fit_kpa, row.plain_kpa) = (kpa(*fit), kpa(*plain));
        }
    }
    let head = format!(
        "## Brain cortex in three modes\n\nTension, compression to 10 % and shear to 0.2 (Budday 2017, \
         as tabled in CANN). Assumed: a cube of 5 mm, both ends glued, equilibrium at each point, nu \
         {POISSON}. Nodal shapes, {CUBE}; every mode weighs the same. {} evaluations, {:.0} s.\n\n",
        found.evaluations, found.seconds
    );
    let text = format!("{head}{}{}", parameters(&found), misfits(&modes));
    let rows = modes.concat();
    Ok(Some(Section { name: "tissue_brain", text, csv: csv(&rows), chart: chart(&modes) }))
}

/// What a mode is off, in parts of its own root mean square.
fn misfit(rows: &[BrainRow], fit: impl Fn(&BrainRow) -> f64) -> f64 {
    let off: Vec<f64> = rows.iter().map(|row| fit(row) - row.measured_kpa).collect();
    let measured: Vec<f64> = rows.iter().map(|row| row.measured_kpa).collect();
    rms(&off) / rms(&measured)
}

fn misfits(modes: &[Vec<BrainRow>]) -> String {
    let last = |rows: &[BrainRow], of: fn(&BrainRow) -> f64| rows.last().map_or(f64::NAN, of);
    let table = Table::of(MODES.iter().zip(modes))
        .column("mode", |(mode, _)| mode.name)
        .column("misfit [%]", |(_, rows)| percent(misfit(rows, |row| row.fit_kpa)))
        .column("modulus alone [%]", |(_, rows)| percent(misfit(rows, |row| row.plain_kpa)))
        .column("measured at the end [kPa]", |(_, rows)| {
            format!("{:.3}", last(rows, |row| row.measured_kpa))
        })
        .column("fit there [kPa]", |(_, rows)| format!("{:.3}", last(rows, |row| row.fit_kpa)));
    format!("Misfit: root mean square, in parts of the mode's own.\n\n{}", table.table().markdown())
}

fn chart(modes: &[Vec<BrainRow>]) -> Chart {
    let mut chart = Chart::new(
        "Brain cortex: one set of parameters for three modes",
        Axis::linear("strain, or shear"),
        Axis::linear("nominal stress [kPa]"),
    );
    for (mode, rows) in MODES.iter().zip(modes) {
        let points = |of: fn(&BrainRow) -> f64| -> Vec<[f64; 2]> {
            rows.iter().map(|row| [row.strain, of(row)]).collect()
        };
        chart = chart
            .series(
                &format!("{}, measured", mode.name),
                Style::Markers,
                &points(|row| row.measured_kpa),
            )
            .series(&format!("{}, fit", mode.name), Style::Line, &points(|row| row.fit_kpa));
    }
    chart
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::identify::{Parameters, forward};

    /// One modulus and one band make all three modes, and the modulus comes back from them.
    #[test]
    fn one_set_of_parameters_makes_three_modes() {
        let row = |mode: &Mode, at: u8| BrainRow {
            mode: mode.name,
            strain: mode.sign * 0.03 * f64::from(at),
            measured_kpa: mode.sign,
            fit_kpa: 0.0,
            plain_kpa: 0.0,
        };
        let rows = |mode: &Mode| (1..=3).map(|at| row(mode, at)).collect::<Vec<_>>();
        let mut targets: Vec<Target> = MODES.iter().map(|mode| target(mode, &rows(mode))).collect();
        let of_truth = |bench: &Bench<'_>| {
            let truth = Parameters { young_pa: vec![700.0], ..bench.start() };
            forward::predict(bench, &truth)
        };
        let made = on_bench(&targets, vec![BAND], Wanted::default(), of_truth).unwrap();
        assert!(made[0][2] > 2.0 * made[2][2] && made[1][2] > 2.0 * made[2][2], "{made:?}");
        for (target, made) in targets.iter_mut().zip(made) {
            target.deviation = Some(vec![ERROR * rms(&made); made.len()]);
            let Data::Press { force_n, .. } = &mut target.data else { unreachable!() };
            *force_n = made;
        }
        let found = fit(&targets, vec![BAND], Wanted::default()).unwrap();
        assert!((found.estimates[0].value / 700.0 - 1.0).abs() < 0.02, "{found:#?}");
    }

    #[test]
    fn misfits_are_in_parts_of_the_mode() {
        let row = BrainRow {
            mode: "tension",
            strain: 0.1,
            measured_kpa: 2.0,
            fit_kpa: 1.0,
            plain_kpa: 2.0,
        };
        assert!((misfit(&[row, row], |row| row.fit_kpa) - 0.5).abs() < 1e-12);
        assert!(misfit(&[row], |row| row.plain_kpa) == 0.0);
    }
}
