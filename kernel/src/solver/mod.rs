//! The schemes that move the network's state, one file each.
//!
//! | scheme | question | order in time | cost of a sweep | memory besides the state | use it for |
//! |---|---|---|---|---|---|
//! | [`Track`] | where does the body settle under this tool? | none: static | a link pass, a pass over the cells, the coarse level | residual, 2 arrays, the coarse level's memory | forces that keep up with the hand; the default |
//! | [`Predict`] | the same, with the body's response to the held cells precomputed | none: static | as `Track`, and 9 multiplications per cell if the tool moves | residual, 5 arrays, the coarse level's memory | the same force in a quarter of the sweeps, if the tool holds cells and links have no slack |
//! | [`Euler`] | how does the body relax in time (the paper's Eq. 2)? | first | a link pass, a pass over the cells | residual | stress relaxation if the time of a tick is below the bound |
//! | [`Rkl2`] | the same | second | the same | residual, 3 arrays | stress relaxation beyond that bound; any motion that must be right in time |
//!
//! An array has 16 bytes per cell in `f32`, and the state is one such array.
//!
//! - **Bound of a step.** `Euler` is stable up to 2 C / b, b being the largest mean weight of two linked
//!   cells. [`Network::new`](crate::Network::new) refuses a larger step and reports the bound.
//! - **Time.** A step or a tick of dimensionless time h lasts h times the body's time constant.
//!   [`Settings::step`](crate::Settings::step) is a sweep of `Euler`,
//!   [`Settings::tick_time`](crate::Settings::tick_time) a tick of `Rkl2`. The static
//!   schemes have no time.
//! - **Guard.** `Track`, `Predict` and `Rkl2` compare the energy with the certified level
//!   and discard a pass whose energy exceeds it (flag 64). The moves of `Euler` cannot raise
//!   the energy, so it needs no guard.
//! - **Number types.** All schemes run in `f32`; `Track` (without its coarse level) and `Euler`
//!   also in fixed point.
//!
//! The files:
//!
//! - [`Track`], [`Euler`], [`Rkl2`]: the schemes; `predict`: [`Predict`], its fields and their solution.
//! - `scheme`, [`Dynamics`], `arrays`: a scheme's interface, its name and its memory.
//! - `level`, `guard`: the certified level, and the rounding of a computed energy.
//! - `conjugate`: step lengths of `track`; `super_step`: the super-steps of `rkl2`.
//! - `awake`: the parts of the body that a sweep updates.
//! - [`coarse`]: the coarse level.
//! - `loops`: the loops over the cells.

mod arrays;
pub(crate) mod awake;
pub mod coarse;
mod conjugate;
mod dynamics;
mod euler;
mod guard;
pub(crate) mod level;
pub(crate) mod loops;
mod predict;
mod rkl2;
pub(crate) mod scheme;
mod super_step;
mod track;

pub use arrays::{Blocks, CellArrays};
pub use dynamics::{Dynamics, NumberOf};
pub use euler::Euler;
pub use predict::Predict;
pub use rkl2::Rkl2;
pub use track::Track;
