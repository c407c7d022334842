//! The public side of a scheme: its name and its memory.

use super::arrays::{Blocks, CellArrays};
use super::scheme::Scheme;
use crate::model::Model;

/// Number type in which a scheme computes cells and links.
pub type NumberOf<D> = <D as Scheme>::Number;

/// A scheme, with its own scalar state.
///
/// ```
/// # use chaincell_kernel::{Dynamics, Euler, NumberOf, Number, Predict, Tissue, Track};
/// assert_eq!((Euler::<f32>::NAME, NumberOf::<Euler>::NAME), ("euler", "f32"));
/// // 16 bytes a cell and array, and two arrays of every scheme: state and residual.
/// assert_eq!(16 * (2 + Track::<0>::ARRAYS), 64);
/// assert_eq!(16 * (2 + Predict::<0>::ARRAYS), 112);
/// assert!(Tissue::<512, Track>::RAM_BYTES < 64 * 512 + 16 * 64 + 2_300); // with 64 contact cells
/// ```
pub trait Dynamics: Scheme {
    /// Name as in the command's `--scheme`.
    const NAME: &'static str;
    /// The scheme at rest.
    const REST: Self;
    /// True if a tick may end after any sweep: the published state is certified after each, and sweeps are no
    /// time of the tissue.
    const IS_ANYTIME: bool = false;
    /// True if it supports bodies of nodal shapes.
    const TAKES_SHAPES: bool = false;
    /// True if it supports tools on a contact surface.
    const TAKES_SURFACES: bool = false;
    /// True if the error of its forces has been measured, see
    /// [`TissueMut::force_error_n`](crate::TissueMut::force_error_n).
    const TELLS_ERROR: bool = false;
    /// Number of cell arrays that the scheme needs besides state and residual.
    const ARRAYS: usize;
    /// Number of those that hold positions; the others hold prepared data for the chosen cells.
    const POINTS: usize = Self::ARRAYS;
    /// Those arrays for a number of cells.
    type Arrays<const CELLS: usize>: CellArrays<Self::Number>;
    /// Memory for a coarse level, see [`coarse_room`](crate::coarse_room).
    type Room: Blocks;
    /// The scheme without motion; its prepared data for the chosen cells stays.
    #[must_use]
    fn stilled(self) -> Self {
        Self::REST
    }
    /// The largest [`Settings::tick_time`](crate::Settings::tick_time) that a number of sweeps covers; for
    /// schemes without it the time that `euler` covers [dimensionless time].
    #[must_use]
    fn tick_time(model: &Model<'_>, sweeps: u16) -> f32 {
        f32::from(sweeps) * model.step_max()
    }
    /// Blocks of memory that a model needs with a number of contact cells.
    #[must_use]
    fn room_blocks(model: &Model<'_>, held: usize) -> usize {
        Self::room(model, held)
    }
    /// Blocks of memory that a model needs with tools.
    #[must_use]
    fn tool_blocks(model: &Model<'_>) -> usize {
        Self::tool_room(model)
    }
}
