//! A porcine liver under a ball of 4 mm, at 221 sites, down to 2 mm: the median curve.
//!
//! Data: vu-arma-dev/robot-palpation-data, `pig_liver_20150826_region1` (arXiv 1509.05830). Neither
//! thickness nor support nor speed nor where depth 0 lies are documented: the liver is taken as a slab
//! on a ground that holds it, every depth as an equilibrium, and fitted from depth 0 and with the
//! depth of first contact free.

use std::path::Path;

use serde::Serialize;

use super::read::table;
use super::{Section, parameters};
use crate::charts::plot::{Axis, Chart, Style};
use crate::experiments::identify::slab::Slab;
use crate::experiments::identify::target::{Data, Target};
use crate::experiments::identify::tool::Tool;
use crate::experiments::identify::{Bench, Bounds, Identified, Wanted, groups, identify};
use crate::experiments::report::tables::{Table, csv};
use chaincell_host::bake::tissue::{Band, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell, ProbeContact};
use chaincell_host::error::{Error, Result};

/// Median and quartiles over the sites.
const DATA: &str = "tissue/porcine_liver_region1_median.csv";
const HEADER: &str = "depth_mm,q25_n,median_n,q75_n,sites";
/// Where the thickness begins: 20 mm.
const SLAB: &str = "slab:0.04x0.02x0.001";
const RADIUS_M: f64 = 0.004;
const POISSON: f64 = 0.45;
/// Where the fit begins.
const YOUNG_PA: f64 = 3000.0;
const BAND: Band = Band { half_width: 0.1, modulus_pa: 10_000.0 };
/// Depth from which on the power of the depth is read off \[mm\].
const STEEP_MM: f64 = 1.4;

/// What was measured at a depth, and what the fits give there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LiverRow {
    /// Depth.
    pub depth_mm: f64,
    /// Quartile of the sites below the median.
    pub q25_mn: f64,
    /// Median of the sites.
    pub median_mn: f64,
    /// Quartile above it.
    pub q75_mn: f64,
    /// Modulus, stiffening, thickness and first contact fitted.
    pub fit_mn: f64,
    /// Modulus, stiffening and thickness fitted, first contact at depth 0.
    pub touching_mn: f64,
    /// Modulus alone, on a slab of 20 mm.
    pub plain_mn: f64,
}

/// The median curve with its quartiles.
struct Measured {
    rows: Vec<LiverRow>,
    sites: f64,
}

fn measured(reference: &Path) -> Result<Option<Measured>> {
    let Some(table) = table(reference, DATA, HEADER)? else { return Ok(None) };
    let mut sites = 0.0;
    let rows = table.iter().map(|row| {
        sites = row.number(4)?;
        let mn = |at| Ok::<_, Error>(1e3 * row.number(at)?);
        let (depth_mm, fit_mn, touching_mn, plain_mn) = (row.number(0)?, 0.0, 0.0, 0.0);
        Ok(LiverRow {
            depth_mm,
            q25_mn: mn(1)?,
            median_mn: mn(2)?,
            q75_mn: mn(3)?,
            fit_mn,
            touching_mn,
            plain_mn,
        })
    });
    let rows = rows.collect::<Result<_>>()?;
    Ok(Some(Measured { rows, sites }))
}

fn target(rows: &[LiverRow]) -> Target {
    let displacement_m = rows.iter().map(|row| 1e-3 * row.depth_mm).collect();
    let force_n = rows.iter().map(|row| 1e-3 * row.median_mn).collect();
    let quartiles = rows.iter().map(|row| [1e-3 * row.q25_mn, 1e-3 * row.q75_mn]);
    Target::new("liver", Data::Press { displacement_m, force_n }).with_quartiles(quartiles)
}

/// Fits a slab with these bands to the curve.
fn fit(targets: &[Target], stiffening: Vec<Band>, wanted: Wanted) -> Result<Identified> {
    let slab = Slab::parse(SLAB)?.ok_or_else(|| Error::check("no slab"))?;
    let mesh = slab.mesh()?;
    let of = PerCell::Uniform;
    let tissue = Some(Tissue { stiffening, ..Tissue::new(of(YOUNG_PA), of(POISSON)) });
    let probe_contact = ProbeContact::Surface;
    let options = BakeOptions { tissue, probe_contact, ..BakeOptions::default() };
    let bench = Bench {
        mesh: &mesh,
        fixed: &mesh.default_fixed,
        options: &options,
        groups: &groups(&[], &mesh)?,
        tool: Tool::Probe { radius_m: RADIUS_M, at_m: [0.0; 3] },
        direction: [0.0, 0.0, -1.0],
        targets,
        slab: Some(slab),
        wanted,
    };
    let bounds = Bounds {
        young_pa: [1e3, 1e5],
        stiffening_pa: [100.0, 1e7],
        thickness_m: [0.006, 0.06],
        ..Bounds::default()
    };
    identify(&bench, &bounds, 0.0)
}

/// Fits the liver; none without its data. Takes minutes.
///
/// # Errors
/// Data that cannot be read; what the fit refuses.
pub fn section(reference: &Path) -> Result<Option<Section>> {
    let Some(Measured { mut rows, sites }) = measured(reference)? else { return Ok(None) };
    let targets = [target(&rows)];
    let plain = fit(&targets, Vec::new(), Wanted::default())?;
    let touching = Wanted { stiffening: true, half_width: true, thickness: true, offset: false };
    let held = fit(&targets, vec![BAND], touching)?;
    let found = fit(&targets, vec![BAND], Wanted { offset: true, ..touching })?;
    for (at, row) in rows.iter_mut().enumerate() {
        let mn = |of: &Identified| 1e3 * of.fitted[0][at];
        (row.fit_mn, row.touching_mn, row.plain_mn) = (mn(&found), mn(&held), mn(&plain));
    }
    let head = format!(
        "## Porcine liver under a ball\n\n{sites} sites, ball of 4 mm, 10 depths to 2 mm \
         (robot-palpation-data, region 1). Assumed: a slab of 40 x 40 mm on a ground that holds it, \
         no friction, equilibrium at each depth, nu {POISSON}. Nodal shapes, {SLAB}; every depth \
         weighs by its quartiles. {} evaluations, {:.0} s.\n\n",
        held.evaluations + found.evaluations,
        held.seconds + found.seconds
    );
    let text = format!(
        "{head}First contact free:\n\n{}First contact at depth 0:\n\n{}Modulus alone, 20 mm:\n\n{}{}{}",
        parameters(&found),
        parameters(&held),
        parameters(&plain),
        residuals(&rows),
        power(&rows)
    );
    Ok(Some(Section { name: "tissue_liver", text, csv: csv(&rows), chart: chart(&rows) }))
}

fn residuals(rows: &[LiverRow]) -> String {
    let of = |x: f64| format!("{x:.1}");
    let table = Table::of(rows)
        .column("depth [mm]", |row| row.depth_mm)
        .column("quartiles [mN]", |row| format!("{:.1} to {:.1}", row.q25_mn, row.q75_mn))
        .column("median [mN]", |row| of(row.median_mn))
        .column("fit less median [mN]", |row| format!("{:+.1}", row.fit_mn - row.median_mn))
        .column("in the quartiles", |row| {
            if (row.q25_mn..=row.q75_mn).contains(&row.fit_mn) { "yes" } else { "no" }
        })
        .column("contact at 0, less median [mN]", |row| {
            format!("{:+.1}", row.touching_mn - row.median_mn)
        })
        .column("modulus alone, less median [mN]", |row| {
            format!("{:+.1}", row.plain_mn - row.median_mn)
        });
    table.table().markdown()
}

/// Power of the depth over the steep end of a curve, by least squares in the logarithms.
fn steepness(rows: &[LiverRow], force: impl Fn(&LiverRow) -> f64) -> f64 {
    let steep = rows.iter().filter(|row| row.depth_mm > STEEP_MM);
    let points: Vec<[f64; 2]> = steep.map(|row| [row.depth_mm.ln(), force(row).ln()]).collect();
    let mean = |at: usize| points.iter().map(|p| p[at]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let both: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    both / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

fn power(rows: &[LiverRow]) -> String {
    format!(
        "Power of the depth beyond {STEEP_MM} mm: measured {:.2}, fit {:.2}, contact \
         at 0 {:.2}, modulus alone {:.2}.\n\n",
        steepness(rows, |row| row.median_mn),
        steepness(rows, |row| row.fit_mn),
        steepness(rows, |row| row.touching_mn),
        steepness(rows, |row| row.plain_mn),
    )
}

fn chart(rows: &[LiverRow]) -> Chart {
    let points = |of: fn(&LiverRow) -> f64| -> Vec<[f64; 2]> {
        rows.iter().map(|row| [row.depth_mm, of(row)]).collect()
    };
    // One series: what is no number interrupts the line.
    let quartiles =
        [points(|row| row.q25_mn), vec![[f64::NAN; 2]], points(|row| row.q75_mn)].concat();
    Chart::new(
        "Porcine liver under a ball of 4 mm",
        Axis::linear("depth [mm]"),
        Axis::linear("force [mN]"),
    )
    .series("measured, median of the sites", Style::Markers, &points(|row| row.median_mn))
    .series("measured, quartiles", Style::Dashed, &quartiles)
    .series("fit, first contact free", Style::Line, &points(|row| row.fit_mn))
    .series("fit, first contact at 0", Style::Line, &points(|row| row.touching_mn))
    .series("fit: modulus alone", Style::Line, &points(|row| row.plain_mn))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_is_read_off_the_steep_end() {
        let row = |depth_mm: f64| LiverRow {
            depth_mm,
            q25_mn: 0.0,
            median_mn: depth_mm.powf(2.4),
            q75_mn: 0.0,
            fit_mn: 2.0 * depth_mm.powf(1.5),
            touching_mn: 0.0,
            plain_mn: 0.0,
        };
        let rows: Vec<LiverRow> = [0.5, 1.0, 1.5, 1.75, 2.0].map(row).to_vec();
        assert!((steepness(&rows, |row| row.median_mn) - 2.4).abs() < 1e-9);
        assert!((steepness(&rows, |row| row.fit_mn) - 1.5).abs() < 1e-9);
    }
}
