//! What [`minimum`](super::minimum()) needs of a body.

use super::vectors::plus;

/// Cells whose positions are prescribed, each with its position.
pub type Held = [(usize, [f64; 3])];

/// A body with an energy E of its positions, in any units that fit together.
///
/// Positions and residuals are `[cell][axis]`, in the body's order of cells.
pub trait Elastic {
    /// The second derivative of E at some positions, in the form that [`Self::times`] takes.
    type Curvature;

    /// Which cells are held for ever.
    fn fixed(&self) -> &[bool];

    /// A length of the body's parts, as its mean link.
    fn length_unit(&self) -> f64;

    /// The size of a residual where a part is off by about its own length.
    fn residual_unit(&self) -> f64;

    /// A weight for each cell that bounds, or nearly so, the diagonal of the second derivative; a
    /// cell with none has no part in the energy.
    fn scale(&self) -> Vec<f64>;

    /// E, and into `residual` -grad E of every cell, fixed ones included.
    fn residual(&self, positions: &[[f64; 3]], residual: &mut [[f64; 3]]) -> f64;

    /// Second derivative of E; what acts only on cells that are not `free` may be left out.
    fn curvature(&self, positions: &[[f64; 3]], free: &[bool]) -> Self::Curvature;

    /// The second derivative times the field `v`, which is zero on cells that are not free; rows
    /// of those may hold anything.
    fn times(&self, curvature: &Self::Curvature, v: &[[f64; 3]], product: &mut [[f64; 3]]);

    /// Which cells may move: neither fixed nor held.
    fn free(&self, held: &Held) -> Vec<bool> {
        let mut free: Vec<bool> = self.fixed().iter().map(|fixed| !fixed).collect();
        for &(cell, _) in held {
            free[cell] = false;
        }
        free
    }

    /// Force of the body on the cells `of`: the sum of their residuals.
    fn force(&self, positions: &[[f64; 3]], of: &[usize]) -> [f64; 3] {
        let mut residual = vec![[0.0; 3]; positions.len()];
        self.residual(positions, &mut residual);
        of.iter().fold([0.0; 3], |sum, &cell| plus(sum, 1.0, residual[cell]))
    }
}
