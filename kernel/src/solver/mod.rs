//! The schemes that move the network's state, one file each.
//!
//! - [`Track`], [`Euler`], [`Rkl1`], [`Rkl2`], [`GaussSeidel`]: the schemes.
//! - `scheme`, [`Dynamics`], `arrays`: what a scheme does, its name and its memory.
//! - `level`, `guard`: the certified level, and what rounding may do to a computed energy.
//! - `conjugate`: step lengths of `track`; `super_step`: what `rkl1` and `rkl2` share.
//! - `awake`: which parts of the body a sweep looks at.
//! - [`coarse`]: the coarse level.
//! - `loops`: the loops over the cells.

mod arrays;
pub(crate) mod awake;
pub mod coarse;
mod conjugate;
mod dynamics;
mod euler;
mod gauss_seidel;
mod guard;
pub(crate) mod level;
pub(crate) mod loops;
mod rkl1;
mod rkl2;
pub(crate) mod scheme;
mod super_step;
mod track;

pub use arrays::{Blocks, CellArrays};
pub use dynamics::{Dynamics, NumberOf};
pub use euler::Euler;
pub use gauss_seidel::GaussSeidel;
pub use rkl1::Rkl1;
pub use rkl2::Rkl2;
pub use track::Track;
