//! SOFA's cantilever under its own weight.
//!
//! `examples/Validation/cantilever_beam` (sofa-framework/sofa, LGPL 2.1; dimensions and numbers only): 20 x 20 x 200 mm
//! on a grid of 5 x 5 x 30 nodes, 2 MPa, Poisson's ratio 0.45, 1,100 kg/m^3, one end held, gravity across it. The
//! scenes have no expected value. Here it is the beam's: Timoshenko's at a hundredth of the weight, the elastica's
//! at all of it.

use serde::Serialize;

use super::body::{Elements, Grid};
use super::law::Moduli;
use chaincell_host::error::Result;

const OF: Moduli = Moduli { young_pa: 2e6, poisson: 0.45 };
/// Density \[kg/m^3\].
pub const DENSITY: f64 = 1100.0;
const SIDE_M: f64 = 0.02;
const LENGTH_M: f64 = 0.2;
const GRAVITY_M_PER_S2: f64 = 9.81;
/// Pieces of the elastica.
const PIECES: usize = 2000;
/// Halvings for its end.
const HALVINGS: usize = 60;

/// The cantilever on a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BeamRow {
    /// Nodes of the mesh.
    pub cells: usize,
    /// Mean edge \[m\].
    pub edge_m: f64,
    /// Share of its weight.
    pub weight: f64,
    /// How far the end goes down by the beam's theory \[m\].
    pub expected_m: f64,
    /// By nodal shapes \[m\].
    pub shapes_m: f64,
    /// By links \[m\].
    pub links_m: f64,
    /// By linear tetrahedra of Hooke's, where the displacement is small \[m\].
    pub tetrahedra_m: Option<f64>,
}

/// The deck's body.
pub fn grid(nodes: [usize; 3]) -> Result<Grid> {
    Grid::block(nodes, [SIDE_M, SIDE_M, LENGTH_M])
}

/// Moduli of the deck.
pub fn moduli() -> Moduli {
    OF
}

/// The beam on a grid, at a hundredth of its weight and at all of it.
pub fn rows(nodes: [usize; 3]) -> Result<Vec<BeamRow>> {
    let grid = grid(nodes)?;
    [0.01, 1.0].into_iter().map(|weight| row(&grid, weight)).collect()
}

fn row(grid: &Grid, weight: f64) -> Result<BeamRow> {
    let down_n_per_m3 = -weight * DENSITY * GRAVITY_M_PER_S2;
    let load = grid.clamped([0.0, down_n_per_m3, 0.0]);
    let end = grid.at_height(LENGTH_M);
    let sag_m = |elements: Elements| -> Result<f64> {
        let rest = grid.settle(elements, OF, &load, &grid.mesh.nodes_m)?;
        let each = end.iter().map(|&node| grid.mesh.nodes_m[node][1] - rest.at_m[node][1]);
        Ok(each.sum::<f64>() / end.len() as f64)
    };
    let small = weight < 0.1;
    Ok(BeamRow {
        cells: grid.mesh.nodes_m.len(),
        edge_m: grid.edge_m,
        weight,
        expected_m: if small { timoshenko_m(weight) } else { elastica_m(weight) },
        shapes_m: sag_m(Elements::Shapes)?,
        links_m: sag_m(Elements::Links)?,
        tetrahedra_m: small.then(|| sag_m(Elements::Tetrahedra)).transpose()?,
    })
}

/// Weight over bending stiffness \[1/m^3\].
fn slender(weight: f64) -> f64 {
    weight * DENSITY * GRAVITY_M_PER_S2 * SIDE_M.powi(2) / (OF.young_pa * SIDE_M.powi(4) / 12.0)
}

/// Sag of the end by bending and shear, small displacements; shear coefficient of a rectangle after Cowper.
pub fn timoshenko_m(weight: f64) -> f64 {
    let shear = 10.0 * (1.0 + OF.poisson) / (12.0 + 11.0 * OF.poisson);
    let sheared_m =
        weight * DENSITY * GRAVITY_M_PER_S2 * LENGTH_M.powi(2) / (2.0 * shear * OF.mu_pa());
    slender(weight) * LENGTH_M.powi(4) / 8.0 + sheared_m
}

/// Sag of the end of an inextensible beam that bends as far as it does, and its shear at small displacements:
/// theta'' = -q (L - s) cos theta, theta(0) = 0, theta'(L) = 0, by halving theta'(0).
pub fn elastica_m(weight: f64) -> f64 {
    let slender = slender(weight);
    let [mut low, mut high] = [0.0, slender * LENGTH_M.powi(2)];
    let mut sag_m = 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let (bend, reached_m) = shoot(slender, middle);
        sag_m = reached_m;
        *(if bend > 0.0 { &mut high } else { &mut low }) = middle;
    }
    let bent_m = slender * LENGTH_M.powi(4) / 8.0;
    sag_m + timoshenko_m(weight) - bent_m
}

/// Curvature at the end and its sag \[m\], from a curvature at the held end, by the midpoint rule.
fn shoot(slender: f64, bend: f64) -> (f64, f64) {
    let step_m = LENGTH_M / PIECES as f64;
    let (mut turn, mut bend, mut sag_m) = (0.0_f64, bend, 0.0);
    for piece in 0..PIECES {
        let from_m = piece as f64 * step_m;
        let slope = |turn: f64, at_m: f64| -slender * (LENGTH_M - at_m) * turn.cos();
        let middle_turn = turn + 0.5 * step_m * bend;
        let middle_bend = bend + 0.5 * step_m * slope(turn, from_m);
        bend += step_m * slope(middle_turn, from_m + 0.5 * step_m);
        turn += step_m * middle_bend;
        sag_m += step_m * middle_turn.sin();
    }
    (bend, sag_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At a small weight both theories agree; at all of it the beam goes down less than in proportion.
    #[test]
    fn the_elastica_begins_as_the_beam() {
        let small = 1e-4;
        assert!((elastica_m(small) / timoshenko_m(small) - 1.0).abs() < 1e-6);
        let ratio = elastica_m(1.0) / timoshenko_m(1.0);
        assert!(ratio < 0.995 && ratio > 0.95, "{ratio}");
    }

    /// The energy of bending is half of the load's work where the displacement is small.
    #[test]
    fn the_beam_has_the_energy_of_its_work() {
        let slender = slender(1e-4);
        let step_m = LENGTH_M / PIECES as f64;
        let (mut stored, mut work) = (0.0, 0.0);
        for piece in 0..PIECES {
            let s = (piece as f64 + 0.5) * step_m;
            let bend = 0.5 * slender * (LENGTH_M - s).powi(2);
            let sag =
                slender * s * s * (6.0 * LENGTH_M.powi(2) - 4.0 * LENGTH_M * s + s * s) / 24.0;
            stored += 0.5 * step_m * bend * bend;
            work += step_m * slender * sag;
        }
        assert!((2.0 * stored / work - 1.0).abs() < 1e-4, "{stored} {work}");
        let (_, sag_m) = shoot(slender, 0.5 * slender * LENGTH_M.powi(2));
        assert!((sag_m / (slender * LENGTH_M.powi(4) / 8.0) - 1.0).abs() < 1e-5, "{sag_m}");
    }

    /// The beam is stiffer on a coarse grid, linear tetrahedra most of all.
    #[test]
    fn finer_beams_are_nearer() {
        let rows = [[3, 3, 13], [5, 5, 25]].map(|nodes| row(&grid(nodes).unwrap(), 0.01).unwrap());
        let ratios = rows.map(|row| {
            println!("{row:?}");
            [row.shapes_m, row.tetrahedra_m.unwrap()].map(|of_m| of_m / row.expected_m)
        });
        let [coarse, fine] = ratios;
        assert!(coarse[0] < fine[0] && fine[0] < 1.02, "{ratios:?}");
        assert!(coarse[1] < coarse[0] && fine[1] < fine[0], "{ratios:?}");
    }
}
