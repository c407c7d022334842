//! Requirements of an energy term on a number type beyond arithmetic: the representation of a cell's energy.

use fixed::types::I8F24;

use crate::number::fixed_point::{Products, narrow};
use crate::number::two_float::{Lanes, TwoFloat};
use crate::number::{Number, Sum};

/// The fourth lane of a residual carries the sum of w d^2, or only shows that it is not 0.
pub trait TermNumber: Number {
    /// Separate count of energies, for numbers whose fourth lane cannot carry them.
    type Tally: Default + Copy;

    /// True if nodal shapes support this number type.
    const TAKES_SHAPES: bool = false;

    /// Value that the fourth lane of a residual gets for w d^2.
    fn mark(wd2: Self::Product) -> Self;
    /// Counts w d^2 of a link, which marks both its ends.
    fn count(tally: &mut Self::Tally, wd2: Self::Product);
    /// The sum of w d^2 over the cells, from the fourth lanes or from the tally.
    fn energy(lanes: &Self::WideSum, tally: Self::Tally) -> TwoFloat;
    /// A cell's part of that sum.
    fn energy_term(lane: Self) -> Self::Product;
}

impl TermNumber for f32 {
    type Tally = ();
    const TAKES_SHAPES: bool = true;

    #[inline(always)]
    fn mark(wd2: f32) -> Self {
        wd2
    }

    #[inline(always)]
    fn count((): &mut (), _wd2: f32) {}

    #[inline(always)]
    fn energy(lanes: &Lanes, (): ()) -> TwoFloat {
        lanes.total()
    }

    #[inline(always)]
    fn energy_term(lane: Self) -> f32 {
        lane
    }
}

/// The fourth lane is too short for energies: it is 0 only if the cell's sum of w d^2 is 0.
impl TermNumber for I8F24 {
    type Tally = Products;

    #[inline(always)]
    fn mark(wd2: i64) -> Self {
        narrow((wd2 >> 16).saturating_add(1))
    }

    /// Counts both ends of the link, as the fourth lanes would.
    #[inline(always)]
    fn count(tally: &mut Products, wd2: i64) {
        tally.0 = tally.0.wrapping_add(2 * i128::from(wd2));
    }

    fn energy(_lanes: &Products, tally: Products) -> TwoFloat {
        tally.total()
    }

    #[inline(always)]
    fn energy_term(_lane: Self) -> i64 {
        0
    }
}
