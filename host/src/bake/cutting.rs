//! A body that can be cut: its tetrahedra by cell, and the spare cells that take the further sides of a cut.
//!
//! The kernel's module `cuttable` describes the use of the sections, and of the bound that goes with them.

use chaincell_kernel::image::{CELLS_MAX, CUTTING_VERSION, TEARING_VERSION, cutting, kind};
use chaincell_kernel::number::two_float::LANES;
use chaincell_kernel::{Loose, TEAR_STRETCH, TearLimit};

use super::image::Sections;
use super::layout::OrderedCells;
use super::per_cell::PerCell;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::mesh::geometry::edges;

/// Default toughness \[J/m^2\]: livers measure 76 to 225, bovine ones 164 (C. Gokgol, C. Basdogan and D. Canadinc,
/// Medical Engineering and Physics 34, 2012, 882 to 891).
pub const TOUGHNESS_J_PER_M2: f64 = 160.0;
/// Default number of spare cells for each cell.
pub const CUT_SPARE: f64 = 0.1;

/// Fewest spare cells.
const SPARE_MIN: usize = 8;
/// Most spare cells for each cell.
const SPARE_MAX: f64 = 4.0;
/// The toughness that the kernel accepts \[J/m^2\].
pub(super) const TOUGHNESS: std::ops::RangeInclusive<f64> = 0.01..=1.0e6;
/// Smallest volume of a tetrahedron that a split divides by, above the kernel's own [mean link lengths^3].
const VOLUME_MIN: f64 = 1.0e-9;

/// Choice of a body that can be cut.
#[derive(Debug, Clone, PartialEq)]
pub struct Cuttable {
    /// Energy that a cut takes for each area \[J/m^2\], from 0.01 to 1e6; between nodes it changes along lines.
    pub toughness_j_per_m2: PerCell,
    /// Number of spare cells for each cell, from 0 to 4; there are eight at least.
    pub spare_share: f64,
    /// Limit at which the body tears by itself; a stretch is from 1.01 to 10. `None`: it does not.
    pub tear_limit: Option<TearLimit>,
    /// The fate of pieces that come loose; a body of links leaves them.
    pub loose: Loose,
}

impl Default for Cuttable {
    fn default() -> Self {
        Self {
            toughness_j_per_m2: PerCell::Uniform(TOUGHNESS_J_PER_M2),
            spare_share: CUT_SPARE,
            tear_limit: None,
            loose: Loose::Leave,
        }
    }
}

impl Cuttable {
    /// Checks the ranges but that of the toughness; an error names the option.
    pub(super) fn check(&self) -> Result<()> {
        let Self { spare_share: share, tear_limit, .. } = *self;
        if !(0.0..=SPARE_MAX).contains(&share) {
            let why = "must be from 0 to 4, a share of the cells";
            return Err(Error::input(format!("`cut_spare` {share}: {why}")));
        }
        if let Some(TearLimit::Stretch(stretch)) = tear_limit
            && !TEAR_STRETCH.contains(&stretch)
        {
            let why = "must be from 1.01 to 10, a stretch: 1.5 is a strain of 50 %";
            return Err(Error::input(format!("`tear_stretch` {stretch}: {why}")));
        }
        Ok(())
    }

    /// Returns the number of spare cells of a body of `cells` cells.
    ///
    /// # Errors
    /// More cells in all than a body may have.
    pub(super) fn spare_cells(&self, cells: usize) -> Result<usize> {
        let spare = ((cells as f64 * self.spare_share).ceil() as usize).max(SPARE_MIN);
        if cells + spare <= CELLS_MAX {
            return Ok(spare);
        }
        Err(Error::input(format!(
            "`cut_spare` {}: {cells} cells and {spare} spare ones are more than {CELLS_MAX}; take fewer, or a \
             coarser mesh",
            self.spare_share
        )))
    }

    /// Adds the sections; `slices` are the starts of the slices of all cells.
    ///
    /// # Errors
    /// A tetrahedron too flat for a split.
    pub(super) fn push(
        &self,
        sections: &mut Sections,
        mesh: &Mesh,
        body: &OrderedCells,
        slices: &[u32],
    ) -> Result<()> {
        let cell = |node: u32| body.cell_of[node as usize];
        let corners: Vec<[u16; 4]> = mesh.tetrahedra.iter().map(|nodes| nodes.map(cell)).collect();
        check_volumes(mesh, body, &corners)?;
        let (rows, stars) = stars(&corners, body.all_cells());
        sections.push(kind::CUT_CORNERS, corners.as_flattened());
        sections.push(kind::CUT_STAR_ROWS, &rows);
        sections.push(kind::CUT_STARS, &stars);
        // A spare slice may be as long as the longest, and any slice get a group more.
        let longest = slices.windows(2).map(|ends| ends[1] - ends[0]).max().unwrap_or(0);
        let spare_slices = body.spare.div_ceil(LANES) as u32;
        let mut words = vec![0; cutting::WORDS];
        words[cutting::VERSION] = CUTTING_VERSION;
        words[cutting::SPARE_CELLS] = body.spare as u32;
        words[cutting::SPARE_GROUPS] = spare_slices * longest + slices.len() as u32 - 1;
        // The toughness of each cell where they differ, and the largest.
        let each = |&node: &u32| self.toughness_j_per_m2.of_node(node) as f32;
        let toughness: Vec<f32> = body.node.iter().map(each).collect();
        let largest = toughness.iter().copied().fold(0.0, f32::max);
        words[cutting::TOUGHNESS_J_PER_M2] = largest.to_bits();
        if let Some(limit) = self.tear_limit {
            words[cutting::VERSION] = TEARING_VERSION;
            words.extend(match limit {
                TearLimit::Toughness => [cutting::BY_TOUGHNESS, 0],
                TearLimit::Stretch(stretch) => [cutting::BY_STRETCH, stretch.to_bits()],
            });
        }
        words[cutting::VERSION] |= self.loose.word() << 16;
        sections.push(kind::CUTTING, &words);
        if toughness.iter().any(|&toughness| toughness != largest) {
            sections.push(kind::CUT_TOUGHNESS, &toughness);
        }
        Ok(())
    }
}

/// Checks that the links of a body are the edges of its tetrahedra: the pieces of a cut share them by volume.
pub(super) fn check_links(mesh: &Mesh) -> Result<()> {
    let edges = edges(&mesh.tetrahedra);
    let Some([one, other]) = mesh.links.iter().find(|link| edges.binary_search(link).is_err())
    else {
        return Ok(());
    };
    Err(Error::input(format!(
        "`cuttable`: the link of nodes {one} and {other} is no edge of a tetrahedron, so no cut can part it: leave \
         `rings`, `diagonals` and other elements out"
    )))
}

/// Returns the tetrahedra at each cell, ascending, with their starts.
fn stars(corners: &[[u16; 4]], cells: usize) -> (Vec<u32>, Vec<u32>) {
    let mut rows = vec![0_u32; cells + 1];
    for &id in corners.as_flattened() {
        rows[usize::from(id) + 1] += 1;
    }
    for cell in 0..cells {
        rows[cell + 1] += rows[cell];
    }
    let mut next = rows.clone();
    let mut stars = vec![0; 4 * corners.len()];
    for (number, corners) in (0..).zip(corners) {
        for &id in corners {
            let place = &mut next[usize::from(id)];
            stars[*place as usize] = number;
            *place += 1;
        }
    }
    (rows, stars)
}

/// Refuses a tetrahedron whose volume a split could not divide by.
fn check_volumes(mesh: &Mesh, body: &OrderedCells, corners: &[[u16; 4]]) -> Result<()> {
    let rest: Vec<[f64; 3]> = body.rest.iter().map(|place| place.map(f64::from)).collect();
    let volume = |of: &[u16; 4]| super::tissue::shape::volume_m3(&rest, of.map(u32::from));
    let Some(flat) = corners.iter().position(|of| volume(of) < VOLUME_MIN) else { return Ok(()) };
    let nodes = mesh.tetrahedra[flat];
    let [x, y, z] = mesh.nodes_m[nodes[0] as usize];
    Err(Error::input(format!(
        "`cuttable`: the tetrahedron of nodes {nodes:?}, at ({x:.6}, {y:.6}, {z:.6}) m, is too flat to be cut: \
         mesh again, or leave it out"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_has_its_tetrahedra_in_ascending_order() {
        let (rows, stars) = stars(&[[0, 1, 2, 3], [4, 2, 1, 3], [0, 2, 4, 3]], 7);
        assert_eq!(rows, [0, 2, 4, 7, 10, 12, 12, 12]);
        assert_eq!(stars, [0, 2, 0, 1, 0, 1, 2, 0, 1, 2, 1, 2]);
    }

    #[test]
    fn spare_cells_are_a_share_of_the_cells_and_eight_at_least() {
        let of = |spare_share: f64| Cuttable { spare_share, ..Cuttable::default() };
        assert_eq!(of(0.1).spare_cells(5_773).unwrap(), 578);
        assert_eq!(of(0.1).spare_cells(12).unwrap(), 8);
        assert_eq!(of(0.0).spare_cells(65_527).unwrap(), 8);
        assert!(of(0.0).spare_cells(65_528).is_err());
    }
}
