//! A measured specimen: a soft sheet pulled in pure shear, beside nodal shapes of its published
//! modulus.
//!
//! The sheet is 40 mm wide, 10 mm long and 3 mm thick, held along both wide edges and pulled along
//! its length by 5 mm. Data and modulus: elejeune11/fitting-one-term-ogden-model (MIT), as
//! `tissue/` of the reference folder has them.

use std::path::Path;

use serde::Serialize;

use crate::charts::plot::{Axis, Chart, Style};
use chaincell_host::bake::tissue::{Band, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::input;
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{self as kernel, Network, Settings, ToolPose, Unloading};

/// Name of the CSV file.
pub const CSV: &str = "report_specimen.csv";
/// Name of the picture.
pub const PICTURE: &str = "report_specimen";
/// The data in the reference folder: displacement \[mm\] and force \[mN\].
const DATA: &str = "tissue/soft_specimen_pure_shear_mm_mN.txt";
/// The sheet, by nodes and their distance: 40 x 10 x 3 mm.
const SHEET: &str = "box:41x11x4x0.001";
/// Half the length of the sheet, less half an element \[m\].
const EDGE_M: f64 = 0.0045;
/// Published initial shear modulus, of their fit by finite elements \[Pa\].
const SHEAR_PA: f64 = 2249.0;
/// Poisson's ratio: nearly incompressible, as the specimen is.
const POISSON: f64 = 0.49;
/// A band fitted to this curve.
const FITTED: [Band; 1] = [Band { half_width: 0.15, modulus_pa: 1700.0 }];
/// How far the sheet is pulled \[m\], and in how many ticks.
const PULL_M: f64 = 0.005;
const TICKS: u32 = 500;
const SWEEPS: u16 = 8;

/// Force of the sheet at a displacement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpecimenRow {
    /// Displacement.
    pub pull_mm: f64,
    /// Measured force.
    pub measured_mn: f64,
    /// Nodal shapes of the published modulus.
    pub plain_mn: f64,
    /// The same with the stiffening fitted to this curve.
    pub stiffened_mn: f64,
}

fn data(reference: &Path) -> Result<Vec<[f64; 2]>> {
    let path = reference.join(DATA);
    let text = input::open(&path)
        .and_then(std::io::read_to_string)
        .map_err(|error| Error::input(format!("{}: {error}", path.display())))?;
    let rows = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    rows.map(|(at, line)| {
        let mut numbers = line.split_whitespace().map(|word| word.parse().ok());
        let row = numbers.next().flatten().zip(numbers.next().flatten());
        row.map(|(mm, mn)| [mm, mn])
            .ok_or_else(|| Error::input(format!("{}:{}: give two numbers", path.display(), at + 1)))
    })
    .collect()
}

/// Force of the sheet as it is pulled \[mm, mN\].
fn pull(stiffening: &[Band]) -> Result<Vec<[f64; 2]>> {
    let mesh = load(SHEET, &MeshOptions::default())?;
    let edge = |sign: f64| -> Vec<u32> {
        let is_there = |x: &[f64; 3]| sign * x[1] > EDGE_M;
        let nodes = mesh.nodes_m.iter().enumerate().filter(|(_, x)| is_there(x));
        nodes.map(|(node, _)| node as u32).collect()
    };
    let of = PerCell::Uniform;
    let tissue = Tissue::new(of(2.0 * SHEAR_PA * (1.0 + POISSON)), of(POISSON));
    // The sheet gets thinner than the band of stretches, which is for presses.
    let tissue = Some(Tissue { stiffening: stiffening.to_vec(), stretch_min: None, ..tissue });
    let image = bake(&mesh, &edge(-1.0), &BakeOptions { tissue, ..BakeOptions::default() })?;
    let model = kernel::Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
    let scheme = Scheme::Predict;
    let settings = Settings { unloading: Unloading::Off, ..scheme.settings(&model, SWEEPS) };
    let network = Network::new(model, settings).map_err(Error::check)?;
    let mut held: Vec<u16> =
        edge(1.0).into_iter().filter_map(|node| model.cell_of_input(node)).collect();
    held.sort_unstable();
    let mut engine = Engine::new(network, scheme, &held)?;
    let mut tick = |tick: u32| {
        let pull_m = PULL_M * f64::from(tick) / f64::from(TICKS);
        let position_m = [0.0, pull_m as f32, 0.0].into();
        let force_n = engine.tick(&ToolPose::at(position_m, 1)).force_n;
        [1e3 * pull_m, -1e3 * f64::from(force_n[1])]
    };
    Ok((0..=TICKS).map(&mut tick).collect())
}

/// The force at a displacement between two ticks.
fn force_mn(curve: &[[f64; 2]], pull_mm: f64) -> f64 {
    let at = pull_mm / (1e3 * PULL_M) * f64::from(TICKS);
    let first = (at.max(0.0) as usize).min(curve.len() - 2);
    let ([_, from], [_, to]) = (curve[first], curve[first + 1]);
    from + (at - first as f64) * (to - from)
}

/// The sheet beside its measured points; none where the folder does not have them.
///
/// # Errors
/// Data that cannot be read; what the bake or the kernel refuses.
pub fn run(reference: &Path) -> Result<Vec<SpecimenRow>> {
    if !reference.join(DATA).exists() {
        return Ok(Vec::new());
    }
    let (plain, stiffened) = (pull(&[])?, pull(&FITTED)?);
    let row = |[pull_mm, measured_mn]: [f64; 2]| SpecimenRow {
        pull_mm,
        measured_mn,
        plain_mn: force_mn(&plain, pull_mm),
        stiffened_mn: force_mn(&stiffened, pull_mm),
    };
    Ok(data(reference)?.into_iter().map(row).collect())
}

/// Root of the mean square of what a model is off \[mN\].
#[must_use]
pub fn rmse_mn(rows: &[SpecimenRow], model: impl Fn(&SpecimenRow) -> f64) -> f64 {
    let squares = rows.iter().map(|row| (model(row) - row.measured_mn).powi(2));
    (squares.sum::<f64>() / rows.len() as f64).sqrt()
}

/// The section; `picture` follows the text. Without rows a line that says so.
#[must_use]
pub fn markdown(rows: &[SpecimenRow], picture: &str) -> String {
    let head = "## A measured specimen\n\n";
    if rows.is_empty() {
        return format!(
            "{head}SKIPPED: no reference data with {DATA} was given (--reference).\n\n"
        );
    }
    let [band] = FITTED;
    format!(
        "{head}A soft sheet of 40 x 10 x 3 mm in pure shear, pulled by 5 mm along its length, {} \
         points (elejeune11/fitting-one-term-ogden-model). Nodal shapes: their modulus of {} Pa \
         (shear), nu {POISSON}, det1, no band of stretches, {SHEET}, `predict`, {SWEEPS} sweeps a \
         tick, {TICKS} ticks. Root mean square of what the force is off:\n\n\
         | model | RMSE \\[mN\\] |\n| --- | --- |\n\
         | the authors' own one-term Ogden fits | 9.9 and 8.7 |\n\
         | published modulus alone | {:.1} |\n\
         | with `--stiffening {}={}`, fitted to this curve | {:.1} |\n\n{picture}",
        rows.len(),
        SHEAR_PA,
        rmse_mn(rows, |row| row.plain_mn),
        band.half_width,
        band.modulus_pa,
        rmse_mn(rows, |row| row.stiffened_mn),
    )
}

/// Points that the picture shows: one of so many.
const EVERY: usize = 20;

/// Force over displacement.
#[must_use]
pub fn chart(rows: &[SpecimenRow]) -> Chart {
    let axes = (Axis::linear("displacement [mm]"), Axis::linear("force [mN]"));
    let points = |of: fn(&SpecimenRow) -> f64| -> Vec<[f64; 2]> {
        rows.iter().step_by(EVERY).map(|row| [row.pull_mm, of(row)]).collect()
    };
    Chart::new("A soft sheet in pure shear", axes.0, axes.1)
        .series("measured", Style::Markers, &points(|row| row.measured_mn))
        .series("nodal, published modulus", Style::Dashed, &points(|row| row.plain_mn))
        .series("nodal, stiffening fitted", Style::Line, &points(|row| row.stiffened_mn))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stiffening_follows_the_specimen() {
        let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE") else {
            println!("SKIPPED: CHAINCELL_REFERENCE names no folder of reference data");
            return;
        };
        let rows = run(Path::new(&folder)).unwrap();
        assert!(rows.len() > 1000);
        let (plain, stiffened) =
            (rmse_mn(&rows, |row| row.plain_mn), rmse_mn(&rows, |row| row.stiffened_mn));
        assert!(stiffened < 9.0 && (40.0..50.0).contains(&plain), "{plain} {stiffened}");
        assert!(markdown(&rows, "").contains("RMSE"));
    }

    #[test]
    fn without_reference_data_the_section_says_so() {
        assert!(markdown(&[], "").contains("SKIPPED"));
    }
}
