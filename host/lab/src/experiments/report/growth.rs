//! How the cost grows with the body: generated organs of many sizes.

use serde::Serialize;

use super::press::engine;
use super::scene::Scene;
use super::setting::Setting;
use super::settle;
use super::worst;
use chaincell_host::error::Result;

/// A size of the organ.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GrowthRow {
    /// Cells.
    pub cells: usize,
    /// Links.
    pub links: usize,
    /// A sweep of `track` in the worst state, median \[ns\].
    pub sweep_ns: u64,
    /// The plain per-cell loop in the same state, median \[ns\].
    pub scalar_ns: u64,
    /// Hats that the bake gives the body.
    pub hats: usize,
    /// A sweep with them, median \[ns\].
    pub hats_ns: u64,
    /// Sweeps in which a press of one cell by a mean link length settles, with hats.
    pub settle_sweeps: usize,
    /// Memory of the tissue a cell \[bytes\].
    pub ram_bytes_per_cell: f64,
    /// The model image a cell \[bytes\].
    pub flash_bytes_per_cell: f64,
}

/// Cost over the sizes.
#[derive(Debug, Clone, Serialize)]
pub struct Growth {
    /// One row a size.
    pub rows: Vec<GrowthRow>,
    /// Slope of the straight line through log(time of a sweep) over log(links): 1 is linear.
    pub slope: f64,
}

/// Measures organs of about `sizes` cells.
///
/// # Errors
/// As the generator and the engine.
pub fn run(
    sizes: &[usize],
    rounds: usize,
    mut after: impl FnMut() -> Result<()>,
) -> Result<Growth> {
    let mut rows = Vec::with_capacity(sizes.len());
    for &size in sizes {
        let scene = Scene::organ_of(size)?;
        let sweep = worst::sweep(&scene, rounds)?;
        let per_cell = |bytes: usize| bytes as f64 / sweep.cells as f64;
        rows.push(GrowthRow {
            cells: sweep.cells,
            links: sweep.links,
            sweep_ns: sweep.mixed.simd_ns,
            scalar_ns: sweep.mixed.scalar_ns,
            hats: scene.model()?.hats(),
            hats_ns: sweep.mixed.hats_ns,
            settle_sweeps: settle::sweeps(&scene, Setting::TRACK)?,
            ram_bytes_per_cell: per_cell(engine(&scene, Setting::TRACK, 1)?.ram_bytes()),
            flash_bytes_per_cell: per_cell(scene.image.as_bytes().len()),
        });
        after()?;
    }
    let points: Vec<[f64; 2]> =
        rows.iter().map(|row| [row.links as f64, row.sweep_ns as f64].map(f64::ln)).collect();
    Ok(Growth { slope: slope(&points), rows })
}

/// Slope of the least-squares line through points; 0 for fewer than two.
#[must_use]
pub fn slope(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = |at: usize| points.iter().map(|p| p[at]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    let product = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>();
    let square = points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>();
    if square > 0.0 { product / square } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_line_with_noise() {
        let points = [[0.0, 1.1], [1.0, 2.9], [2.0, 5.1], [3.0, 6.9]];
        assert!((slope(&points) - 1.96).abs() < 1e-12);
    }
}
