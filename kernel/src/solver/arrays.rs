//! Arrays whose sizes are part of a scheme's type.

use crate::number::Number;
use crate::number::cell::Cell;
use crate::number::two_float::Eight;

/// Arrays of cells whose number is part of the scheme's type.
pub trait CellArrays<N> {
    /// All +0.0.
    const ZERO: Self;
    /// The arrays as one slice.
    fn flat(&mut self) -> &mut [Cell<N>];
}

impl<N: Number, const CELLS: usize, const ARRAYS: usize> CellArrays<N>
    for [[Cell<N>; CELLS]; ARRAYS]
{
    const ZERO: Self = [[Cell::ZERO; CELLS]; ARRAYS];

    fn flat(&mut self) -> &mut [Cell<N>] {
        self.as_flattened_mut()
    }
}

/// Memory in blocks of eight `f32` whose size is part of the scheme's type.
pub trait Blocks {
    /// All +0.0.
    const ZERO: Self;
    /// The blocks as one slice.
    fn flat(&mut self) -> &mut [Eight];
}

impl<const BLOCKS: usize> Blocks for [Eight; BLOCKS] {
    const ZERO: Self = [[0.0; 8]; BLOCKS];

    fn flat(&mut self) -> &mut [Eight] {
        self
    }
}
