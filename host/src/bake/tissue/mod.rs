//! Tissue by Young's modulus and Poisson's ratio: nodal shapes in place of links.
//!
//! The kernel's module of that name describes the use of the numbers; this module computes them, with
//! the bound L of the energy's curvature (`curvature`) and the elasticity of the rest shape
//! (`elasticity`). `stiffening` adds bands to them, `relaxation` branches whose stress fades, `known`
//! has tissues by name, `table` reads and writes tables of them.

pub mod shape;

mod curvature;
mod elasticity;
mod known;
mod relaxation;
mod stiffening;
mod table;
#[cfg(test)]
mod tests;

use chaincell_kernel::image::{LAW_DET1, kind, nodal};
use chaincell_kernel::number::two_float::LANES;

use super::image::Sections;
use super::layout::{OrderedCells, holds_units};
use super::per_cell::PerCell;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
pub use known::{KnownTissue, relaxation};
pub use relaxation::{Branch, DEVICE_HZ, Moduli, Relaxation};
use shape::{Fault, Shape};
use stiffening::Stiffening;
pub use stiffening::{Band, BandSide};
pub use table::TableRow;

/// Beta in double precision.
const BETA: f64 = nodal::BETA as f64;

/// Default stretch at which the band of stretches begins.
pub const STRETCH_MIN: f64 = 0.7;
/// Stiffness of the band \[shear moduli\]; of tissue that relaxes long-term ones, but at least an instantaneous one.
const BAND: f64 = 8.0;

/// Properties of a tissue.
#[derive(Debug, Clone, PartialEq)]
pub struct Tissue {
    /// Young's modulus \[Pa\]; of tissue that relaxes the long-term one, unless it says otherwise.
    pub young_pa: PerCell,
    /// Poisson's ratio, from 0 to 0.495; of tissue that relaxes the instantaneous one.
    pub poisson: PerCell,
    /// The stretch below which it resists more, from 0.01 to 0.95; `None` for no such band.
    pub stretch_min: Option<f64>,
    /// Bands on the links, at most three, which resist large strain; they do not relax.
    pub stiffening: Vec<Band>,
    /// Branches whose stress fades; `None` for elastic tissue.
    pub relaxation: Option<Relaxation>,
    /// The row of a file from which values are, for refusals; `None` where there is none.
    pub row: Option<TableRow>,
}

impl Tissue {
    /// Elastic tissue with the default band of stretches and no stiffening.
    #[must_use]
    pub fn new(young_pa: PerCell, poisson: PerCell) -> Self {
        let (stretch_min, stiffening) = (Some(STRETCH_MIN), Vec::new());
        Self { young_pa, poisson, stretch_min, stiffening, relaxation: None, row: None }
    }

    /// Returns the name of an option for a refusal of its value; of a value from a file its place and column.
    pub(super) fn name(&self, option: &str) -> String {
        let of_row = self.row.as_ref().and_then(|row| row.name(option));
        of_row.unwrap_or_else(|| format!("`{option}`"))
    }

    /// Returns the instantaneous Young's modulus of each cell \[Pa\].
    pub(super) fn instant_pa(&self, body: &OrderedCells) -> Vec<f64> {
        let mut young = each(&self.young_pa, body);
        if let Some(relaxation) = &self.relaxation {
            for (young_pa, poisson) in young.iter_mut().zip(each(&self.poisson, body)) {
                *young_pa = relaxation.instant_pa(*young_pa, poisson);
            }
        }
        young
    }
}

/// The nodal shapes of a body: lengths in mean link lengths, stresses in the mean shear modulus.
pub(super) struct Shapes {
    shape: Shape,
    mu: Vec<f64>,
    lambda: Vec<f64>,
    stretch_min: f32,
    /// Stiffness of the band of stretches \[instantaneous shear moduli\]; 0 for no band.
    band: f64,
    stiffening: Stiffening,
    relaxation: Option<Relaxation>,
    /// At least the row sums of the magnitudes of the shapes' L, or its bound by tetrahedra.
    bound: Vec<f32>,
    /// The same for all of L: the cells' mobilities are the inverse.
    pub weights: Vec<f32>,
    /// `k_ref` \[N/m\]: the stress unit is twice this over a mean link length.
    pub stiffness_n_per_m: f32,
}

/// Returns the value of each cell.
fn each(value: &PerCell, body: &OrderedCells) -> Vec<f64> {
    match value {
        PerCell::Uniform(value) => vec![*value; body.rest.len()],
        PerCell::Each(values) => body.node.iter().map(|&node| values[node as usize]).collect(),
    }
}

/// Smallest and largest modulus of stiffening that the kernel accepts \[mean shear moduli\].
const STIFFENING: std::ops::RangeInclusive<f32> = 1.0e-6..=1.0e6;

/// Checks that the kernel accepts these bands on a body of this mean shear modulus \[Pa\].
fn check_stiffening(tissue: &Tissue, unit_pa: f64) -> Result<()> {
    let is_beyond = |band: &&Band| !STIFFENING.contains(&((band.modulus_pa / unit_pa) as f32));
    let Some(&Band { half_width, modulus_pa, .. }) = tissue.stiffening.iter().find(is_beyond)
    else {
        return Ok(());
    };
    let [least, most] = [STIFFENING.start(), STIFFENING.end()].map(|x| f64::from(*x) * unit_pa);
    Err(Error::input(format!(
        "{}: modulus {modulus_pa} of half-width {half_width}: must be from {least:.3e} to \
         {most:.3e} [Pa] on this body, 1e-6 to 1e6 times its mean shear modulus",
        tissue.name("stiffening")
    )))
}

/// Returns the error of a mesh without shapes, with the ids of its nodes.
fn refused(fault: Fault, mesh: &Mesh, body: &OrderedCells) -> Error {
    Error::input(match fault {
        Fault::Tetrahedron(number) => {
            let nodes = mesh.tetrahedra[number];
            let [x, y, z] = mesh.nodes_m[nodes[0] as usize];
            format!(
                "`young_pa`: the tetrahedron of nodes {nodes:?}, at ({x:.6}, {y:.6}, {z:.6}) m, has no \
                 volume: remove flat tetrahedra or mesh again, or leave it out and bake links"
            )
        }
        Fault::Node(cell) => format!(
            "`young_pa`: node {} is in no tetrahedron: remove it, or leave `young_pa` out and bake links",
            body.node[cell]
        ),
    })
}

impl Shapes {
    /// Computes the shapes of a body made of `tissue`; of one that can be cut, with the bound that holds however
    /// its tetrahedra are joined.
    ///
    /// # Errors
    /// A mesh without tetrahedra, with flat ones, or with links that are not edges of tetrahedra.
    pub fn new(
        mesh: &Mesh,
        body: &OrderedCells,
        tissue: &Tissue,
        is_cuttable: bool,
    ) -> Result<Self> {
        if mesh.tetrahedra.is_empty() {
            return Err(Error::input(
                "`young_pa`: the mesh has no tetrahedra; take a mesh that has, or leave it out and \
                 bake links",
            ));
        }
        // Moduli of each cell.
        let cell = |node: u32| u32::from(body.cell_of[node as usize]);
        let tetrahedra: Vec<[u32; 4]> =
            mesh.tetrahedra.iter().map(|nodes| nodes.map(cell)).collect();
        let rest: Vec<[f64; 3]> = body.rest.iter().map(|x| x.map(f64::from)).collect();
        let (young, poisson) = (tissue.instant_pa(body), each(&tissue.poisson, body));
        let moduli = young.iter().zip(&poisson).map(|(young, nu)| {
            let mu = 0.5 * young / (1.0 + nu);
            (mu, 2.0 * mu * nu / (1.0 - 2.0 * nu))
        });
        let (mut mu, mut lambda): (Vec<f64>, Vec<f64>) = moduli.unzip();
        let unit_pa = mu.iter().sum::<f64>() / mu.len() as f64;
        // Units: the mean shear modulus is the unit of stress.
        let stiffness_n_per_m = (0.5 * unit_pa * f64::from(body.unit_m)) as f32;
        if !holds_units(body.unit_m, stiffness_n_per_m) {
            let pick = if stiffness_n_per_m > 1.0 { f64::max } else { f64::min };
            let young_pa = young.iter().copied().fold(young[0], pick);
            return Err(Error::input(format!(
                "{} {young_pa:e} with links of {} m: forces or energies leave the range of single \
                 precision; soft tissue has 1e2 to 1e6 Pa; check `unit_m` too",
                tissue.name("young_pa"),
                body.unit_m
            )));
        }
        let stored_pa = 2.0 * f64::from(stiffness_n_per_m) / f64::from(body.unit_m);
        mu.iter_mut().chain(&mut lambda).for_each(|modulus| *modulus /= stored_pa);
        // The shapes and the bands.
        let mean = |nodes: [u32; 4]| nodes.iter().map(|&i| mu[i as usize]).sum::<f64>() / 4.0;
        let shape = Shape::weighted(&rest, &tetrahedra, mean)
            .map_err(|fault| refused(fault, mesh, body))?;
        check_stiffening(tissue, stored_pa)?;
        let stiffening = Stiffening::new(&tissue.stiffening, stored_pa, &rest, &tetrahedra);
        let (bound, weights) = (Vec::new(), Vec::new());
        let stretch_min = tissue.stretch_min.unwrap_or(0.0) as f32;
        let relaxation = tissue.relaxation.clone();
        let ratio = relaxation.as_ref().map_or(0.0, Relaxation::ratio);
        let band = if stretch_min > 0.0 { (BAND / (1.0 + ratio)).max(1.0) } else { 0.0 };
        #[rustfmt::skip]
        let shapes = Self {
            shape, mu, lambda, stretch_min, band, stiffening, relaxation, bound, weights, stiffness_n_per_m,
        };
        shapes.check_links(body)?;
        // The bounds.
        let bound = if is_cuttable {
            shapes.tetrahedron_sums(&rest, &tetrahedra)
        } else {
            shapes.row_sums()
        };
        let mut weights = bound.clone();
        shapes.stiffening.add_weights(&mut weights);
        Ok(Self { bound, weights, ..shapes })
    }

    /// Returns the stiffness of a cell's band.
    fn band(&self, cell: usize) -> f64 {
        self.band * self.mu[cell]
    }

    /// Checks that the links are the edges of the tetrahedra, and not too many at a node.
    fn check_links(&self, body: &OrderedCells) -> Result<()> {
        let most = nodal::LINKS_MAX;
        if let Some(cell) = (0..body.rest.len()).find(|&cell| self.shape.of(cell).len() > most) {
            return Err(Error::input(format!(
                "`young_pa`: node {} has {} edges, at most {most}: refine the mesh around it",
                body.node[cell],
                self.shape.of(cell).len()
            )));
        }
        let is_edge = |&([i, j], _): &super::layout::Link| {
            let half = self.shape.of(i.into());
            half.binary_search_by_key(&u32::from(j), |half| half.to).is_ok()
        };
        if 2 * body.links.len() == self.shape.halves() && body.links.iter().all(is_edge) {
            return Ok(());
        }
        Err(Error::input(
            "`young_pa`: links that are no edges of tetrahedra; leave `rings` and `diagonals` out",
        ))
    }

    /// Adds the sections of all cells, of which those after the shapes' are spare; `slices` and `ids` are the starts
    /// and the other ends of the slices.
    pub fn push(&self, sections: &mut Sections, all_cells: usize, slices: &[u32], ids: &[u16]) {
        sections.push(kind::NODAL, &[LAW_DET1, self.stretch_min.to_bits()]);
        let cells = self.mu.len();
        let mut numbers = vec![[[0.0_f32; LANES]; nodal::CELL_ROWS]; all_cells.div_ceil(LANES)];
        for slice in &mut numbers {
            slice[nodal::VOLUME] = [1.0; LANES];
        }
        for cell in 0..cells {
            let mut put = |row: usize, value: f64| {
                // Adding +0.0 turns -0.0 into +0.0.
                numbers[cell / LANES][row][cell % LANES] = value as f32 + 0.0;
            };
            put(nodal::VOLUME, self.shape.volume_m3(cell));
            put(nodal::MU, self.mu[cell]);
            put(nodal::LAMBDA_3, 3.0 * self.lambda[cell]);
            put(nodal::BOUND, self.bound[cell].into());
            put(nodal::BAND, self.band(cell));
            for (axis, area) in self.shape.own(cell).into_iter().enumerate() {
                put(nodal::OWN + axis, area);
            }
        }
        for cell in cells..all_cells {
            for row in [nodal::MU, nodal::BOUND] {
                numbers[cell / LANES][row][cell % LANES] = nodal::MU_MIN;
            }
        }
        sections.push(kind::NODAL_CELLS, numbers.as_flattened().as_flattened());
        sections.push(kind::NODAL_SLOTS, self.slots(slices, ids).as_flattened().as_flattened());
        self.stiffening.push(sections, slices, ids);
        if let Some(relaxation) = &self.relaxation {
            relaxation.push(sections);
        }
    }

    /// Returns the numbers of the half-links, group by group.
    fn slots(&self, slices: &[u32], ids: &[u16]) -> Vec<[[f32; LANES]; nodal::SLOT_ROWS]> {
        let cells = self.mu.len();
        let mut slots = vec![[[0.0_f32; LANES]; nodal::SLOT_ROWS]; ids.len() / LANES];
        for (slice, groups) in slices.windows(2).enumerate() {
            for group in groups[0] as usize..groups[1] as usize {
                for lane in 0..LANES {
                    let (i, j) = (slice * LANES + lane, usize::from(ids[group * LANES + lane]));
                    if i >= cells || i == j {
                        continue;
                    }
                    let halves = self.shape.of(i);
                    let Ok(at) = halves.binary_search_by_key(&(j as u32), |half| half.to) else {
                        continue;
                    };
                    let half = &halves[at];
                    let mut put = |row: usize, value: f32| slots[group][row][lane] = value + 0.0;
                    for axis in 0..3 {
                        put(nodal::AREA + axis, half.area_m2[axis] as f32);
                    }
                    put(nodal::SPREAD, (2.0 * BETA * half.weight_m) as f32);
                }
            }
        }
        slots
    }
}
