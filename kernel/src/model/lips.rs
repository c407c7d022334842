//! Sides of a cut that lie on each other: a term that exists in a body that is cut, and in no image.

use super::image::{ModelError, Sections};
use super::layout::Layout;
use super::range;
use super::terms::{Keeps, TermData};
use crate::number::two_float::LANES;

/// Two cells that were one, and the opened faces between them.
#[derive(Clone, Copy)]
pub(crate) struct Lip {
    /// The cells, ascending.
    pub cells: [u16; 2],
    /// Twice the stiffness; 0 for a place without a lip.
    pub weight: f32,
    /// Area of the faces at rest, a third for each corner, as a vector from the first cell's side to the second's.
    pub area: [f32; 3],
    /// Mean edge of the largest of the faces.
    pub edge: f32,
}

/// The numbers of a lip in memory: weight, area, edge.
pub(crate) type LipNumbers = [f32; 5];

impl Lip {
    /// The lip in a place; `None` if it is free.
    pub fn of(cells: &[u16; 2], &[weight, x, y, z, edge]: &LipNumbers) -> Option<Self> {
        (weight > 0.0).then_some(Self { cells: *cells, weight, area: [x, y, z], edge })
    }

    /// Its numbers.
    pub fn numbers(&self) -> LipNumbers {
        let ([x, y, z], Self { weight, edge, .. }) = (self.area, *self);
        [weight, x, y, z, edge]
    }
}

/// The lips of a body, at each of their cells.
#[derive(Clone, Copy)]
pub(crate) struct Lips<'a> {
    /// Cells of each lip.
    pub cells: &'a [[u16; 2]],
    /// Its numbers.
    pub numbers: &'a [LipNumbers],
    /// Normal of each in this tick, from the first cell's side to the second's, times the root of its share.
    pub normals: &'a [[f32; 3]],
    /// The range of each slice in `ends`, slices + 1; empty in a body without lips.
    pub rows: &'a [u32],
    /// For each cell of a lip twice the lip's place, plus 1 for its second cell; by slice.
    pub ends: &'a [u32],
}

/// A lip at one of its cells.
#[derive(Clone, Copy)]
pub(crate) struct End {
    pub lip: Lip,
    pub normal: [f32; 3],
    pub is_second: bool,
}

impl End {
    /// The cell.
    pub fn cell(&self) -> usize {
        let [first, second] = self.lip.cells;
        if self.is_second { second.into() } else { first.into() }
    }

    /// The lip's other cell.
    pub fn other(&self) -> usize {
        let [first, second] = self.lip.cells;
        if self.is_second { first.into() } else { second.into() }
    }
}

impl<'a> Lips<'a> {
    /// No lips.
    pub const NONE: Self = Self { cells: &[], numbers: &[], normals: &[], rows: &[], ends: &[] };

    /// Returns true if the body has lips.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        !self.ends.is_empty()
    }

    /// The lips at the cells of a slice, each cell's descending by place.
    pub fn of_slice(self, slice: usize) -> impl Iterator<Item = End> + use<'a> {
        let ends = self.ends.get(range(self.rows, slice)).unwrap_or(&[]);
        ends.iter().filter_map(move |&end| {
            let place = end as usize / 2;
            let lip = Lip::of(self.cells.get(place)?, self.numbers.get(place)?)?;
            let normal = *self.normals.get(place)?;
            Some(End { lip, normal, is_second: end % 2 == 1 })
        })
    }
}

impl Keeps for Lips<'_> {}

impl<'a> TermData<'a> for Lips<'a> {
    #[inline(always)]
    fn read(_: &Sections<'a>) -> Result<Self, ModelError> {
        Ok(Self::NONE)
    }

    #[inline(always)]
    fn check(&self, _: &Layout<'_>) -> Result<(), ModelError> {
        Ok(())
    }

    /// Nothing: a cut adds the lips' part to the mobilities itself.
    #[inline(always)]
    fn add_bound(&self, _: usize, sum: f32) -> f32 {
        sum
    }

    fn each_of_row(&self, cell: usize, visit: &mut impl FnMut(usize, f32)) {
        let here = self.of_slice(cell / LANES).filter(|end| end.cell() == cell);
        for end in here.filter(|end| end.normal != [0.0; 3]) {
            visit(cell, 0.5 * end.lip.weight);
            visit(end.other(), -0.5 * end.lip.weight);
        }
    }

    #[inline(always)]
    fn rests(&self, _: &Layout<'_>) -> bool {
        true
    }

    #[inline(always)]
    fn joins_unlinked(&self) -> bool {
        self.is_any()
    }
}
