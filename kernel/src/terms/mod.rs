//! The terms of the energy, what the tool does to it, and one pass over all of them.
//!
//! The energy is a sum of (w / 2) dist^2(G x, S): the distances of linear maps G of a few cells to
//! sets S. Half the squared distance to a set curves upwards by at most one, so L = sum of w G'G
//! bounds the curvature of the energy in every state; all that the schemes prove rests on that.
//!
//! - [`links`]: the links' bands (Eq. 5 to 13).
//! - `term`: what any other term does; the list of them is that of `model::terms`.
//! - [`held`]: a constraint, the cells that the tool holds.
//! - [`current`]: a load, the current into the contact cells.
//! - [`probe`]: which cells a sphere touches, and where it puts them.
//! - `residual`, `sliced`: one pass, cell by cell and eight cells side by side.

pub mod current;
pub mod held;
pub mod links;
pub(crate) mod number;
#[cfg(test)]
mod pin;
pub mod probe;
pub(crate) mod residual;
pub(crate) mod sliced;
pub(crate) mod term;
#[cfg(test)]
pub(crate) mod tests;
