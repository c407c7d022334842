//! The basis of the coarse level: trilinear hat functions over the rest shape, and the inverse of the
//! curvature bound in this basis, or of the elasticity of the rest shape. The bake computes all of it.

use core::ops::Range;

use super::image::{COARSE_MAX, ModelError, NO_FUNCTION, Sections, kind};
use super::parts::Parts;
use super::range;
use super::sides::{NO_SIDE, Sides};
use crate::number::two_float::{Eight, LANES};

/// 1 in a kernel that cuts, so that arrays of this length have no size in another.
const BUILT: usize = cfg!(feature = "cut") as usize;

/// The basis functions of a model.
#[derive(Clone, Copy)]
pub(crate) struct CoarseBasis<'a> {
    pub count: usize,
    /// Starts of the boxes' pairs.
    pub rows: &'a [u32],
    /// Basis functions at the corners of each box.
    pub corners: &'a [[u16; LANES]],
    /// Cells of each pair.
    pub cells: &'a [[u16; 2]],
    /// Weights of each pair at the corners of its box: corner k of the first cell and of the
    /// second, in turn.
    pub weights: &'a [[Eight; 2]],
    /// Position of each cell among the cells of the pairs.
    pub entry: &'a [u16],
    /// Rows of the inverse.
    pub inverse: &'a [Eight],
    /// The elastic level, if there is one; its inverse couples the axes.
    #[cfg(feature = "nodal")]
    elastic: Option<ElasticLevel<'a>>,
    /// The two-sided functions of a body that is cut.
    sides: [Sides<'a>; BUILT],
    /// The parts of the body.
    parts: Parts,
    /// True if the body has several parts, the cells of each box lie in one part, and the boxes are in the
    /// order of the parts.
    pub is_in_parts: bool,
}

/// The data of an [elastic level](crate::solver::coarse::elastic) besides the basis functions.
#[derive(Clone, Copy)]
pub(crate) struct ElasticLevel<'a> {
    /// The cell whose rotation each basis function takes.
    pub turns: &'a [u16],
    /// Length of the local part of each cell's direction, relative to r / W.
    pub factors: &'a [f32],
}

#[cfg(feature = "nodal")]
impl<'a> ElasticLevel<'a> {
    /// Reads the elastic level; `None` if the body is not made of nodal shapes.
    fn read(
        sections: &Sections<'a>,
        count: usize,
        cells: usize,
    ) -> Result<Option<Self>, ModelError> {
        if sections.optional::<u32>(kind::NODAL)?.is_none() {
            return Ok(None);
        }
        let turns = sections.sized(kind::COARSE_TURNS, count)?;
        Ok(Some(Self { turns, factors: sections.sized(kind::COARSE_FACTORS, cells)? }))
    }
}

impl<'a> CoarseBasis<'a> {
    /// Reads the basis of a body with this number of cells, with room for two-sided functions or without.
    pub fn read(
        sections: &Sections<'a>,
        cells: usize,
        has_sides: bool,
    ) -> Result<Option<Self>, ModelError> {
        let Some(count) = sections.optional::<u32>(kind::COARSE)? else { return Ok(None) };
        let count = match count {
            &[count] if (1..=COARSE_MAX as u32).contains(&count) => count as usize,
            _ => return Err(ModelError::Value(kind::COARSE, 0)),
        };
        let corners: &[[u16; LANES]] = sections.required(kind::COARSE_CORNERS)?;
        let pairs: &[[u16; 2]] = sections.required(kind::COARSE_CELLS)?;
        let rows = sections.sized(kind::COARSE_ROWS, corners.len() + 1)?;
        #[cfg(feature = "nodal")]
        let elastic = ElasticLevel::read(sections, count, cells)?;
        #[cfg(not(feature = "nodal"))]
        let elastic = None::<ElasticLevel<'_>>;
        let blocks = count.div_ceil(LANES);
        let parts =
            if elastic.is_some() { Parts::of_shapes(cells) } else { Parts::of_links(cells) };
        let has_sides = has_sides && elastic.is_some();
        let sides = [Sides::room(if has_sides { count } else { 0 }); BUILT];
        let inverse = if elastic.is_some() { 9 * LANES * blocks * blocks } else { count * blocks };
        Ok(Some(Self {
            count,
            rows,
            corners,
            cells: pairs,
            weights: sections.sized(kind::COARSE_WEIGHTS, pairs.len())?,
            entry: sections.sized(kind::COARSE_ENTRY, cells)?,
            inverse: sections.sized(kind::COARSE_INVERSE, inverse)?,
            #[cfg(feature = "nodal")]
            elastic,
            sides,
            parts,
            is_in_parts: parts.count() > 1 && is_in_parts(rows, pairs, parts),
        }))
    }

    /// The same basis with other cells in its boxes, which are then in no order of parts.
    #[cfg(feature = "cut")]
    pub fn with_cells(
        self,
        rows: &'a [u32],
        cells: &'a [[u16; 2]],
        weights: &'a [[Eight; 2]],
        entry: &'a [u16],
        factors: &'a [f32],
    ) -> Self {
        let elastic = self.elastic.map(|level| ElasticLevel { factors, ..level });
        Self { rows, cells, weights, entry, elastic, is_in_parts: false, ..self }
    }

    /// The same basis with these two-sided functions.
    #[cfg(feature = "cut")]
    pub fn with_sides(self, sides: Sides<'a>) -> Self {
        Self { sides: [sides], ..self }
    }

    /// Returns the two-sided functions of a body that is cut, if it has some.
    #[inline(always)]
    pub fn sides(&self) -> Option<&Sides<'a>> {
        self.sides.first().filter(|sides| !sides.cells.is_empty())
    }

    /// Returns the columns of Y of a body with two-sided functions.
    #[inline(always)]
    pub fn columns(&self) -> impl Iterator<Item = &'a [Eight]> {
        let columns = self.sides().map_or(&[][..], |sides| sides.columns);
        // A column has at least one block; `max` makes this known to the compiler.
        columns.chunks_exact((self.row_blocks() + self.side_blocks()).max(1))
    }

    /// Returns the number of blocks in a vector over all two-sided functions that there is room for, on all axes.
    #[inline(always)]
    pub fn side_blocks(&self) -> usize {
        self.sides.first().map_or(0, |sides| 3 * sides.blocks)
    }

    /// Returns the boxes of a part, for a body that [is in parts](Self::is_in_parts).
    pub fn boxes_of(&self, part: usize) -> Range<usize> {
        let Range { start, end } = self.parts.cells(part);
        let until = |cell: usize| {
            self.rows.partition_point(|&row| {
                self.cells.get(row as usize).is_some_and(|pair| usize::from(pair[0]) < cell)
            })
        };
        until(start)..until(end)
    }

    /// Returns the number of blocks in a vector over the basis functions.
    #[inline(always)]
    pub fn blocks(&self) -> usize {
        // A basis has at least one function; `max` makes this known to the compiler.
        self.count.div_ceil(LANES).max(1)
    }

    /// Padded length of a vector over the basis functions: of a row of the inverse, or of one axis in a row
    /// of an elastic level.
    pub fn stride(&self) -> usize {
        self.blocks() * LANES
    }

    /// Returns the elastic level; `None` in a kernel without nodal shapes.
    #[inline(always)]
    pub fn elastic(&self) -> Option<ElasticLevel<'a>> {
        #[cfg(feature = "nodal")]
        return self.elastic;
        #[cfg(not(feature = "nodal"))]
        None
    }

    /// Returns the number of blocks in a row of the inverse.
    #[inline(always)]
    pub fn row_blocks(&self) -> usize {
        if self.elastic().is_some() { 3 * self.blocks() } else { self.blocks() }
    }

    /// Returns an element of the inverse, 0 beyond its end.
    pub fn inverse_at(&self, row: usize, column: usize) -> f32 {
        let block = self.inverse.get(row * self.row_blocks() + column / LANES);
        block.and_then(|block| block.get(column % LANES)).copied().unwrap_or(0.0)
    }

    /// Returns a row of the inverse.
    pub fn inverse_row(&self, row: usize) -> &'a [f32] {
        let blocks = self.row_blocks();
        self.inverse.get(row * blocks..(row + 1) * blocks).unwrap_or(&[]).as_flattened()
    }

    /// Returns the weight of an entry at a corner of its box.
    pub fn weight(&self, entry: usize, corner: usize) -> f32 {
        let block = self.weights.get(entry / 2).and_then(|pair| pair.get(corner / 4));
        block.and_then(|block| block.get(corner % 4 * 2 + entry % 2)).copied().unwrap_or(0.0)
    }

    /// Returns a cell's two-sided functions with their weights, numbered from [`Self::stride`] on.
    #[inline(always)]
    pub fn sides_of(self, cell: usize) -> impl Iterator<Item = (usize, f32)> + use<'a> {
        let entry = self.entry.get(cell).map_or(0, |&entry| usize::from(entry));
        let pair = self.weights.get(entry / 2).copied().unwrap_or_default();
        let row = self.sides().map_or([NO_SIDE; LANES], |sides| sides.at(cell));
        let of_corners = row.into_iter().zip(weights(&pair, entry % 2 == 1));
        let stride = self.stride();
        let used = of_corners.filter(|&(side, _)| side != NO_SIDE);
        used.map(move |(side, weight)| (stride + usize::from(side), weight))
    }

    /// Returns a cell's row of P: its basis functions with their weights.
    pub fn row_of(self, cell: usize) -> impl Iterator<Item = (usize, f32)> + use<'a> {
        let entry = self.entry.get(cell).copied().filter(|&entry| entry != NO_FUNCTION);
        let parts = entry.and_then(|entry| {
            let entry = usize::from(entry);
            let at_box = self.rows.partition_point(|&start| start as usize <= entry / 2);
            Some((self.corners.get(at_box.checked_sub(1)?)?, entry))
        });
        parts.into_iter().flat_map(move |(corners, entry)| {
            let coarse_functions =
                corners.iter().enumerate().filter(|&(_, &function)| function != NO_FUNCTION);
            coarse_functions
                .map(move |(corner, &function)| (usize::from(function), self.weight(entry, corner)))
        })
    }
}

/// Weights of a cell of a pair at the corners of its box.
#[inline(always)]
pub(crate) fn weights(pair: &[Eight; 2], second: bool) -> [f32; LANES] {
    let [low, high] = pair;
    let ([a, b, c, d, e, f, g, h], [i, j, k, l, m, n, o, p]) = (*low, *high);
    if second { [b, d, f, h, j, l, n, p] } else { [a, c, e, g, i, k, m, o] }
}

/// Returns true if the cells of each box lie in one part, and the boxes are in the order of the parts.
fn is_in_parts(rows: &[u32], pairs: &[[u16; 2]], parts: Parts) -> bool {
    let mut part = 0;
    (0..rows.len().saturating_sub(1)).all(|at_box| {
        let pairs = pairs.get(range(rows, at_box)).unwrap_or(&[]);
        let here = |part| {
            let of = parts.cells(part);
            pairs.as_flattened().iter().all(|&cell| of.contains(&usize::from(cell)))
        };
        while part < parts.count() && !here(part) {
            part += 1;
        }
        part < parts.count()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of cells for which parts begin at multiples of 2,048.
    const CELLS: usize = 16_384;
    const PARTS: Parts = Parts::of_links(CELLS);

    #[test]
    fn boxes_are_found_by_part_where_they_are_in_order() {
        // Part 0 has two boxes, part 1 none; an empty box follows, then one box each in parts 2 and 7.
        let (rows, pairs) =
            ([0, 1, 3, 3, 4, 5], [[0, 1], [5, 9], [2047, 2047], [4096, 6143], [14336, 16383]]);
        assert!(is_in_parts(&rows, &pairs, PARTS));
        let basis = CoarseBasis {
            count: 1,
            rows: &rows,
            corners: &[[NO_FUNCTION; LANES]; 5],
            cells: &pairs,
            weights: &[],
            entry: &[NO_FUNCTION; CELLS],
            inverse: &[],
            #[cfg(feature = "nodal")]
            elastic: None,
            sides: [Sides::room(0); BUILT],
            parts: PARTS,
            is_in_parts: true,
        };
        let boxes = [0, 1, 2, 3, 7].map(|part| basis.boxes_of(part));
        let pairs_of = boxes.map(|boxes| {
            boxes.flat_map(|at_box| range(&rows, at_box)).collect::<std::vec::Vec<_>>()
        });
        assert_eq!(
            pairs_of,
            [std::vec![0, 1, 2], std::vec![], std::vec![3], std::vec![], std::vec![4]]
        );
    }

    #[test]
    fn boxes_across_parts_or_out_of_their_order_are_seen() {
        assert!(!is_in_parts(&[0, 1], &[[2047, 2048]], PARTS));
        assert!(!is_in_parts(&[0, 1, 2], &[[2048, 2048], [0, 0]], PARTS));
        assert!(!is_in_parts(&[0, 1], &[[16_384, 0]], PARTS));
    }
}
