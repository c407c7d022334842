//! What a term beside the links does in a pass, and where the tool moves its cells.
//!
//! The list of the terms is that of `model::terms`. All of it is resolved when the kernel is
//! compiled: a term that is not in the list costs nothing.

use super::held::{Contact, Touched};
use super::number::TermNumber;
use crate::backend::f32x8::F32x8;
use crate::backend::slice_set::SliceSet;
use crate::model::terms::NoTerm;
use crate::number::cell::Cell;

/// What terms do to one cell, in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CellTerm {
    /// The residual, r = -dE/dP.
    pub residual: [f32; 3],
    /// The fourth lane of the residual; added over all cells, eight times the energy.
    pub wd2: f32,
    /// At least the sum of the weights times lengths that the residual was computed from: the
    /// rounding of the residual is a quarter of eps times it.
    pub length: f32,
}

/// A term beside the links. Positions are given as states and what makes outputs of them.
pub(crate) trait Term: Copy {
    /// Adds the term to the residuals of awake slices, cell by cell.
    fn accumulate<N: TermNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        output: &impl Fn([N; 3]) -> [N; 3],
    );
    /// Adds the term to the residuals of a slice whose states are within K; the same bits.
    fn slice<V: F32x8>(self, slice: usize, at: &[Cell], sum: &mut [V; 4]);
    /// Adds the term at a cell whose output is `here`.
    fn cell<N: TermNumber>(self, cell: usize, here: [N; 3], add: &mut impl FnMut(CellTerm));
    /// Adds what the term stores at the held cells.
    fn touched<N: TermNumber>(
        self,
        held: &[Contact<N>],
        output: &impl Fn(usize) -> [N; 3],
        sums: &mut Touched,
    );
    /// Adds w |D|^2, `squared` = |D|^2, for a cell that moves by D: the root of the energy rises by
    /// at most half the root of that sum over all cells that move.
    fn add_move(self, cell: usize, squared: f32, sum: f32) -> f32;
}

impl Term for NoTerm {
    #[inline(always)]
    fn accumulate<N: TermNumber>(
        self,
        _: &SliceSet,
        _: &[Cell<N>],
        _: &mut [Cell<N>],
        _: &mut N::Tally,
        _: &impl Fn([N; 3]) -> [N; 3],
    ) {
    }

    #[inline(always)]
    fn slice<V: F32x8>(self, _: usize, _: &[Cell], _: &mut [V; 4]) {}

    #[inline(always)]
    fn cell<N: TermNumber>(self, _: usize, _: [N; 3], _: &mut impl FnMut(CellTerm)) {}

    #[inline(always)]
    fn touched<N: TermNumber>(
        self,
        _: &[Contact<N>],
        _: &impl Fn(usize) -> [N; 3],
        _: &mut Touched,
    ) {
    }

    #[inline(always)]
    fn add_move(self, _: usize, _: f32, sum: f32) -> f32 {
        sum
    }
}

impl<A: Term, B: Term> Term for (A, B) {
    #[inline(always)]
    fn accumulate<N: TermNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        output: &impl Fn([N; 3]) -> [N; 3],
    ) {
        self.0.accumulate(awake, v, residual, tally, output);
        self.1.accumulate(awake, v, residual, tally, output);
    }

    #[inline(always)]
    fn slice<V: F32x8>(self, slice: usize, at: &[Cell], sum: &mut [V; 4]) {
        self.0.slice(slice, at, sum);
        self.1.slice(slice, at, sum);
    }

    #[inline(always)]
    fn cell<N: TermNumber>(self, cell: usize, here: [N; 3], add: &mut impl FnMut(CellTerm)) {
        self.0.cell(cell, here, add);
        self.1.cell(cell, here, add);
    }

    #[inline(always)]
    fn touched<N: TermNumber>(
        self,
        held: &[Contact<N>],
        output: &impl Fn(usize) -> [N; 3],
        sums: &mut Touched,
    ) {
        self.0.touched(held, output, sums);
        self.1.touched(held, output, sums);
    }

    #[inline(always)]
    fn add_move(self, cell: usize, squared: f32, sum: f32) -> f32 {
        self.1.add_move(cell, squared, self.0.add_move(cell, squared, sum))
    }
}
