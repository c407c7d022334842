//! Two-sided basis functions of a body that is cut, beside those of its image.
//!
//! A hat function reaches through a cut: it moves both sides of it together. On one of the sides a second function
//! takes its values there, and is 0 elsewhere. With B over the functions of the image, the inverse of the matrix of
//! both kinds is
//!
//! ```text
//! B + Y Y'
//! ```
//!
//! where B is 0 in the rows of the new functions. Y has a column for each of them and axis; see the module `cut`.

use super::image::NO_FUNCTION;
use crate::number::two_float::{Eight, LANES};

/// Index of no function, in the rows of [`Sides`].
pub(crate) const NO_SIDE: u8 = u8::MAX;
/// Most two-sided functions; of a level of fewer functions, as many as it has.
const SIDES_MAX: usize = 32;
/// A level of fewer basis functions has no two-sided ones: its sweeps reach across the body anyway.
const FEWEST: usize = 24;

/// Two-sided basis functions.
#[derive(Clone, Copy)]
pub(crate) struct Sides<'a> {
    /// Blocks of a vector over the functions for one axis; as many as there is room for.
    pub blocks: usize,
    /// The cell whose rotation each function takes.
    pub turns: &'a [u16],
    /// Cells under the functions.
    pub cells: &'a [u16],
    /// For every cell the function at each corner of its box.
    pub rows: &'a [[u8; LANES]],
    /// The columns of Y: first over the basis functions of the image, then over the two-sided ones.
    pub columns: &'a [Eight],
}

impl Sides<'_> {
    /// No functions, with room for those of a body that can be cut and has this number of basis functions.
    pub const fn room(basis_functions: usize) -> Self {
        Self {
            blocks: most(basis_functions) / LANES,
            turns: &[],
            cells: &[],
            rows: &[],
            columns: &[],
        }
    }

    /// The functions of a cell, by the corners of its box.
    #[inline(always)]
    pub fn at(&self, cell: usize) -> [u8; LANES] {
        self.rows.get(cell).copied().unwrap_or([NO_SIDE; LANES])
    }
}

/// Most two-sided functions of a body that can be cut and has this number of basis functions.
pub(crate) const fn most(basis_functions: usize) -> usize {
    match basis_functions {
        0..FEWEST => 0,
        FEWEST..SIDES_MAX => basis_functions.next_multiple_of(LANES),
        _ => SIDES_MAX,
    }
}

const _: () = assert!(SIDES_MAX < NO_SIDE as usize && SIDES_MAX < NO_FUNCTION as usize);
