//! Bound of a state's energy change due to rounding: the one definition for guards, contract and tests.
//!
//! With x the position of a cell, W its weight and e the sum of w d^2 over its links, in
//! internal units, and eps the spacing of `f32`, a state of energy E has the allowance
//!
//! ```text
//! 4 eps E + sqrt(S) / 2 + 2 sqrt(T) + M / 48 + R
//! M = sum of W (|x|^2 + 1) eps^2,   S = sum of W (|x|^2 + 1) e eps^2   over the cells
//! T = the largest term of S,   R = sum of w l0^2 eps^2   over the links
//! ```
//!
//! Cells with only slack links are left out. For nodal shapes e is the magnitude of eight times a cell's part
//! of the energy, which may be negative for a single cell.
//!
//! - The first part is the rounding of the squares and of their sum.
//! - A coordinate a is rounded by up to eps |a| / 2, which moves E by the residual r times the error and by
//!   the curvature. The errors of cells are independent, so the first part adds up like a random walk. |r|^2
//!   is at most W e / 4, so the second term is more than three times its standard deviation. The same term
//!   covers the rounding of the lengths of links, which are at most the sum of the |x| of both ends.
//! - If one link holds nearly all of the energy, its errors are no random walk. A difference of coordinates,
//!   its square and root, the bound and the published point round its length by up to 2.75 eps times the |x|
//!   of both ends together. 2 sqrt(T) and the part above cover that.
//! - The curvature is at most that of the Laplacian of weight w / 2 and only ever adds energy: M / 48 is the
//!   mean added energy if the last place of every coordinate is as coarse as possible.
//! - A link that is outside its band by less than 2 eps l0 counts as slack: R bounds the energy of all such
//!   links.
//!
//! A link counts with the weights at its own ends, by its energy: a stiff part that is slack gives a soft one
//! no allowance. The 1 covers links near the centre.
//!
//! A guard compares passes, in which the rounding of fixed cells and of slack links is the same: it sums over
//! the free cells only, without T. It takes half of the allowance for the energies that it compares. The
//! other half covers the rounding of the published point. The sums are computed only if an energy is above
//! the level, so a pass that lowers the energy does not pay for them.

use crate::energy::links::number::LinkNumber;
use crate::model::Model;
use crate::number::cell::{Cell, single};
use crate::number::sqrt::sqrt;

/// Spacing of `f32`, squared.
const EPSILON_SQUARED: f32 = f32::EPSILON * f32::EPSILON;

/// The sums that tell how far rounding may move the energy of a state.
///
/// ```
/// use chaincell_kernel::Rounding;
///
/// // A cell with eight links, one mean link length from the centre, that store e = 0.01.
/// let mut sums = Rounding::default();
/// sums.add_cell(Rounding::of_cell([1.0, 0.0, 0.0], 1.0 / 8.0, 0.01));
/// sums.add_link(1.0, 1.0);
/// let allowance = sums.allowance(0.01 / 8.0); // internal units, as the energy
/// assert!((1e-8..1e-6).contains(&allowance));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rounding {
    /// M = sum of W (|x|^2 + 1) eps^2.
    pub moment: f32,
    /// S = sum of W (|x|^2 + 1) e eps^2.
    pub stored: f32,
    /// T = the largest term of S; 0 in a pass.
    pub largest: f32,
    /// R = sum of w l0^2 eps^2; 0 in a pass.
    pub slack: f32,
}

impl Rounding {
    /// Adds a cell's sums.
    pub fn add_cell(&mut self, cell: Self) {
        self.moment += cell.moment;
        self.stored += cell.stored;
        self.largest = if cell.largest > self.largest { cell.largest } else { self.largest };
    }

    /// Adds the energy that a link of this weight and rest length may store while it counts as slack. In
    /// internal units.
    pub fn add_link(&mut self, weight: f32, rest_length: f32) {
        self.slack += weight * rest_length * rest_length * EPSILON_SQUARED;
    }

    /// The sums of a cell of weight W = 1 / `mobility` whose links store e = `wd2`; zero if they are slack.
    /// In internal units.
    #[must_use]
    pub fn of_cell([x, y, z]: [f32; 3], mobility: f32, wd2: f32) -> Self {
        if mobility > 0.0 && wd2 != 0.0 {
            let moment = (x * x + y * y + z * z + 1.0) * EPSILON_SQUARED / mobility;
            let stored = moment * wd2.abs();
            Self { moment, stored, largest: stored, slack: 0.0 }
        } else {
            Self::default()
        }
    }

    /// Upper bound for any state of energy E = `energy` in which no coordinate is beyond `reach`.
    pub(crate) fn at_most(model: &Model<'_>, reach: f32, energy: f32) -> Self {
        let cell = 2.0 * model.degree_bound * (3.0 * reach * reach + 1.0) * EPSILON_SQUARED;
        Self { moment: cell * model.cells() as f32, stored: 8.0 * cell * energy, ..Self::default() }
    }

    /// The sums of a pass at `at` with these residuals, over its free cells. A sleeping cell has no residual
    /// and adds nothing.
    #[cold]
    #[inline(never)]
    pub(crate) fn of_pass<N: LinkNumber>(
        mobility: &[f32],
        at: &[Cell<N>],
        residual: &[Cell<N>],
    ) -> Self {
        let mut sum = Self::default();
        // By index: a compiler unrolls a loop over iterators to several times its size.
        let mut cell = 0;
        while let (Some(at), Some(r), Some(&mobility)) =
            (at.get(cell), residual.get(cell), mobility.get(cell))
        {
            let of = Self::of_cell(single(at.xyz()), mobility, r.w().single());
            sum.moment += of.moment;
            sum.stored += of.stored;
            cell += 1;
        }
        sum
    }

    /// Bound of the energy change due to rounding of a state with the energy `energy`, in internal units.
    #[must_use]
    pub fn allowance(self, energy: f32) -> f32 {
        let positive = |x: f32| if x > 0.0 && x.is_finite() { x } else { 0.0 };
        4.0 * f32::EPSILON * positive(energy)
            + 0.5 * sqrt(positive(self.stored))
            + 2.0 * sqrt(positive(self.largest))
            + positive(self.moment) / 48.0
            + positive(self.slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EPS: f32 = f32::EPSILON;

    #[test]
    fn the_allowance_grows_with_the_distance_from_the_centre() {
        let near = Rounding::of_cell([0.0; 3], 0.1, 0.2);
        assert_eq!(near.moment, 10.0 * EPS * EPS);
        let far = Rounding::of_cell([-1e5, 0.0, 0.0], 0.1, 0.2);
        let (a, b) = (near.allowance(0.1), far.allowance(0.1));
        assert!(a > 4.0 * EPS * 0.1 && a < 20.0 * EPS && b > 2e4 * a, "{a:e} {b:e}");
    }

    #[test]
    fn slack_links_and_fixed_cells_add_nothing() {
        assert_eq!(Rounding::of_cell([1e6; 3], 0.1, 0.0), Rounding::default());
        assert_eq!(Rounding::of_cell([1e6; 3], 0.0, 1.0), Rounding::default());
        assert_eq!(Rounding::default().allowance(0.0), 0.0);
    }

    #[test]
    fn what_is_not_finite_allows_nothing() {
        let lost = Rounding {
            moment: f32::INFINITY,
            stored: f32::NAN,
            largest: f32::NAN,
            slack: f32::NAN,
        };
        assert_eq!(lost.allowance(f32::NEG_INFINITY), 0.0);
    }
}
