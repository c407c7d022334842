//! Tetrahedra that a blade may part, in an image, and the cells kept in reserve for their sides.
//!
//! A cut opens faces between tetrahedra. A cell whose tetrahedra then fall apart needs a further cell for each
//! further piece: these are the spare cells, the last ones of the body. As the image has them they are dormant:
//! no link names them, their mobility is 0 and their numbers exert no force, so nothing moves them from the
//! body's centre. They have no input id.
//!
//! The bound of every other cell holds however its tetrahedra are joined: with gradients g of the hat
//! functions, mu and lambda the means of a tetrahedron's cells and b that of their bands, it is the sum over a
//! cell's tetrahedra of (2 mu + 3 lambda + b) V times the sum of |`g_i` . `g_j`| over the corners j. In a body of links
//! the sum of a cell's weights holds: the tetrahedra at a link's edge share its weight, and every link is such an edge.
//! So does that of stiffening bands, which is added to the bound of the shapes.

use super::image::{CUTTING_VERSION, ModelError, Sections, TEARING_VERSION, cutting, kind};
use super::loose::Loose;
use super::range;
use super::tearing::TearLimit;
use crate::number::cell::{dot, sub};

/// Toughness \[J/m^2\], far beyond that of tissue.
const TOUGHNESS: core::ops::RangeInclusive<f32> = 0.01..=1.0e6;
/// Smallest volume of a tetrahedron [mean link lengths^3]: a row of a split divides by it.
const VOLUME_MIN: f32 = 1.0e-12;
/// Most groups of half-links in reserve.
const SPARE_GROUPS_MAX: usize = 1 << 20;

/// Corners of the face opposite to each corner of a tetrahedron of positive volume, outward.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The cells of the face opposite to a corner of a tetrahedron, outward.
pub(crate) fn of_face(corners: [u16; 4], opposite: usize) -> [u16; 3] {
    let face = FACES.get(opposite).copied().unwrap_or_default();
    face.map(|corner| corners.get(corner).copied().unwrap_or_default())
}

/// The tetrahedra of a body that a blade may part.
#[derive(Clone, Copy)]
pub(crate) struct Cuttable<'a> {
    /// Cells of each tetrahedron, of positive volume, in the mesh's order.
    pub corners: &'a [[u16; 4]],
    /// The range of each cell's tetrahedra in `stars`, cells + 1; empty for a spare cell.
    pub star_rows: &'a [u32],
    /// Tetrahedra at each cell, ascending.
    pub stars: &'a [u32],
    /// Number of spare cells, the last ones of the body.
    pub spare_cells: usize,
    /// Number of groups of eight half-links to keep in reserve.
    pub spare_groups: usize,
    /// Energy that a cut takes for each area, the largest of all cells' \[J/m^2\].
    pub toughness_j_per_m2: f32,
    /// The same of each cell but the spare ones; empty where all have the same.
    pub cell_toughness: &'a [f32],
    /// The limit at which the body tears by itself; `None` for one that does not.
    pub tear_limit: Option<TearLimit>,
    /// The fate of loose pieces.
    pub loose: Loose,
}

impl<'a> Cuttable<'a> {
    /// A body that cannot be cut.
    pub const NONE: Self = Self {
        corners: &[],
        star_rows: &[],
        stars: &[],
        spare_cells: 0,
        spare_groups: 0,
        toughness_j_per_m2: 0.0,
        cell_toughness: &[],
        tear_limit: None,
        loose: Loose::Leave,
    };

    /// Returns true if the body can be cut.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        !self.corners.is_empty()
    }

    /// Returns the cells of each tetrahedron.
    pub fn corners(&self) -> &'a [[u16; 4]] {
        self.corners
    }

    /// Returns the number of spare cells.
    pub fn spare_cells(&self) -> usize {
        self.spare_cells
    }

    /// Returns the energy that a cut takes for each area, the largest of all cells' \[J/m^2\].
    pub fn toughness_j_per_m2(&self) -> f32 {
        self.toughness_j_per_m2
    }

    /// Returns the energy that a cut takes for each area at a cell of the image \[J/m^2\].
    pub fn cell_toughness_j_per_m2(&self, cell: usize) -> f32 {
        self.cell_toughness.get(cell).copied().unwrap_or(self.toughness_j_per_m2)
    }

    /// Returns the limit at which the body tears by itself.
    pub fn tear_limit(&self) -> Option<TearLimit> {
        self.tear_limit
    }

    /// Returns the cells of the face opposite to a corner of a tetrahedron, outward.
    pub fn face(&self, tetrahedron: usize, corner: usize) -> Option<[u16; 3]> {
        self.corners.get(tetrahedron).map(|corners| of_face(*corners, corner))
    }

    /// Returns the tetrahedra at a cell, ascending; none at a spare cell and beyond the last one.
    #[inline(always)]
    pub fn star(&self, cell: usize) -> &'a [u32] {
        self.stars.get(range(self.star_rows, cell)).unwrap_or(&[])
    }

    /// Returns what becomes of loose pieces.
    pub fn loose(&self) -> Loose {
        self.loose
    }

    /// Reads the sections of a body of `cells` cells, the spare ones among them.
    pub fn read(sections: &Sections<'a>, cells: usize) -> Result<Self, ModelError> {
        let Some(words) = sections.optional::<u32>(kind::CUTTING)? else { return Ok(Self::NONE) };
        let [version, spare_cells, spare_groups, toughness, tear @ ..] = words else {
            return Err(ModelError::SectionSize(kind::CUTTING));
        };
        let (version, loose) = (*version & 0xFFFF, Loose::read(*version >> 16));
        let loose = loose.ok_or(ModelError::Value(kind::CUTTING, cutting::VERSION as u32))?;
        let tear_limit = match (version, tear) {
            (CUTTING_VERSION, []) => None,
            (TEARING_VERSION, &[rule, stretch]) => Some(TearLimit::read(rule, stretch)?),
            (CUTTING_VERSION | TEARING_VERSION, _) => {
                return Err(ModelError::SectionSize(kind::CUTTING));
            }
            _ => return Err(ModelError::SectionVersion(kind::CUTTING)),
        };
        let corners: &[[u16; 4]] = sections.required(kind::CUT_CORNERS)?;
        let ends = corners.len().checked_mul(4).ok_or(ModelError::Layout)?;
        let rows = cells.checked_add(1).ok_or(ModelError::Layout)?;
        let cell_toughness = sections.optional::<f32>(kind::CUT_TOUGHNESS)?.unwrap_or(&[]);
        Ok(Self {
            corners,
            star_rows: sections.sized(kind::CUT_STAR_ROWS, rows)?,
            stars: sections.sized(kind::CUT_STARS, ends)?,
            spare_cells: *spare_cells as usize,
            spare_groups: *spare_groups as usize,
            toughness_j_per_m2: f32::from_bits(*toughness),
            cell_toughness,
            tear_limit,
            loose,
        })
    }

    /// Checks the sections against the rest positions of all cells, the spare ones among them.
    pub fn check(&self, rest: &[[f32; 3]]) -> Result<(), ModelError> {
        if !self.is_any() {
            // A body with the section has a tetrahedron.
            let is_absent = self.star_rows.is_empty();
            return if is_absent {
                Ok(())
            } else {
                Err(ModelError::SectionSize(kind::CUT_CORNERS))
            };
        }
        self.check_words(rest.len())?;
        let bodily = rest.len() - self.spare_cells;
        self.check_cell_toughness(bodily)?;
        for (number, corners) in self.corners.iter().enumerate() {
            check_tetrahedron(rest.get(..bodily).unwrap_or(&[]), number, *corners)?;
        }
        self.check_rows(bodily)?;
        (0..bodily).try_for_each(|cell| self.check_star(cell))
    }

    /// Checks the numbers of `CUTTING`: a body has more cells than spare ones.
    fn check_words(&self, cells: usize) -> Result<(), ModelError> {
        let bad = |word: usize| Err(ModelError::Value(kind::CUTTING, word as u32));
        if self.spare_cells >= cells {
            return bad(cutting::SPARE_CELLS);
        }
        if self.spare_groups > SPARE_GROUPS_MAX {
            return bad(cutting::SPARE_GROUPS);
        }
        if !TOUGHNESS.contains(&self.toughness_j_per_m2) {
            return bad(cutting::TOUGHNESS_J_PER_M2);
        }
        Ok(())
    }

    /// Checks the toughness of each cell, and that the largest is that of `CUTTING`.
    fn check_cell_toughness(&self, bodily: usize) -> Result<(), ModelError> {
        if self.cell_toughness.is_empty() {
            return Ok(());
        }
        if self.cell_toughness.len() != bodily {
            return Err(ModelError::SectionSize(kind::CUT_TOUGHNESS));
        }
        let mut largest = 0.0;
        for (cell, &toughness) in self.cell_toughness.iter().enumerate() {
            if !TOUGHNESS.contains(&toughness) {
                return Err(ModelError::Value(kind::CUT_TOUGHNESS, cell as u32));
            }
            largest = if toughness > largest { toughness } else { largest };
        }
        if largest == self.toughness_j_per_m2 {
            Ok(())
        } else {
            Err(ModelError::Value(kind::CUTTING, cutting::TOUGHNESS_J_PER_M2 as u32))
        }
    }

    /// Checks that the rows start at 0, never descend, end with the last one, and leave spare cells without a
    /// tetrahedron.
    fn check_rows(&self, bodily: usize) -> Result<(), ModelError> {
        let mut last = 0;
        for (cell, &start) in self.star_rows.iter().enumerate() {
            let is_first = cell > 0 || start == 0;
            let is_last = cell < bodily || start as usize == self.stars.len();
            if !(is_first && is_last) || start < last {
                return Err(ModelError::Index(kind::CUT_STAR_ROWS, cell as u32));
            }
            last = start;
        }
        Ok(())
    }

    /// Checks that a cell's tetrahedra ascend and have it as a corner. There are as many entries as corners, so
    /// that none is missing at another cell either.
    fn check_star(&self, cell: usize) -> Result<(), ModelError> {
        let first = range(self.star_rows, cell).start;
        let mut next = 0;
        for (place, &number) in (first..).zip(self.star(cell)) {
            let corners = self.corners.get(number as usize);
            let is_there = |corners: &[u16; 4]| corners.iter().any(|&id| usize::from(id) == cell);
            if u64::from(number) < next || !corners.is_some_and(is_there) {
                return Err(ModelError::Index(kind::CUT_STARS, place as u32));
            }
            next = u64::from(number) + 1;
        }
        // There is a tetrahedron at every cell.
        if next == 0 {
            return Err(ModelError::Index(kind::CUT_STAR_ROWS, cell as u32));
        }
        Ok(())
    }
}

/// Returns six times the volume of a tetrahedron [mean link lengths^3].
fn six_volumes([a, b, c, d]: [[f32; 3]; 4]) -> f32 {
    let [x, y, z] = [sub(b, a), sub(c, a), sub(d, a)];
    let cross = [y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]];
    dot(x, cross)
}

/// Checks that the corners of a tetrahedron are different cells of the body and span a positive volume.
fn check_tetrahedron(
    rest: &[[f32; 3]],
    number: usize,
    [a, b, c, d]: [u16; 4],
) -> Result<(), ModelError> {
    let at = |id: u16| rest.get(usize::from(id)).copied();
    let differ = ![b, c, d].contains(&a) && ![c, d].contains(&b) && c != d;
    let (Some(at_a), Some(at_b), Some(at_c), Some(at_d), true) =
        (at(a), at(b), at(c), at(d), differ)
    else {
        return Err(ModelError::Index(kind::CUT_CORNERS, number as u32));
    };
    if six_volumes([at_a, at_b, at_c, at_d]) >= 6.0 * VOLUME_MIN {
        Ok(())
    } else {
        Err(ModelError::Value(kind::CUT_CORNERS, number as u32))
    }
}
