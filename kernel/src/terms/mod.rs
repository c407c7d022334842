//! The terms of the energy, what the tool does to it, and one pass over all of them.
//!
//! The energy is a sum of (w / 2) dist^2(G x, S): the distances of linear maps G of a few cells to
//! sets S. Half the squared distance to a set curves upwards by at most one, so L = sum of w G'G
//! bounds the curvature of the energy in every state; all that the schemes prove rests on that.
//!
//! - [`links`]: the links' bands (Eq. 5 to 13).
//! - `term`: what any other term does; the list of them is that of `model::terms`.
//! - [`state`]: what terms keep of each cell.
//! - [`held`]: a constraint, the cells that the tool holds.
//! - `current`: a load, the current into the contact cells.
//! - `nodal`: shapes of the tissue around each cell, in place of links.
//! - `stiffening`: bands on the links of such a body, which resist large strain.
//! - `inside`: whether a point lies in the tissue.
//! - `probe`: which cells a sphere touches, and where it puts them.
//! - [`rounding`]: how far rounding may move the energy.
//! - `surface`: a sphere that meets the triangles of the surface.
//! - `residual`, `sliced`: one pass, cell by cell and eight cells side by side.
//!
//! **Adding a term** takes a file here, a file in [`model`](crate::model), and its entry in the list
//! of `model::terms`. It brings:
//!
//! | what | where |
//! |---|---|
//! | its sections in the image, checked | `TermData::read`, `check` |
//! | its part of the bound L at a cell, which is part of the cell's mobility | `add_bound` |
//! | whether the rest shape is slack | `rests` |
//! | whether it keeps states of this body's cells, and stands in place of the links | `keeps`, `replaces_links` |
//! | what it keeps of a cell: its state at rest, its words | `Term::State`, `CellState` |
//! | a correction of residual and energy, held for a tick, and what it adds to the energy | `corrects`, `begin_tick` |
//! | a first pass: the state of a cell from any cells' positions, and of eight | `update`, `update_slice` |
//! | residual and energy of awake slices, cell by cell and eight side by side | `accumulate`, `slice` |
//! | residual, energy and rounding at one cell | `cell` |
//! | energy that a move of held cells changes, and a bound of that change | `touched`, `add_move` |
//!
//! The bake adds the term's part of L to the mobilities, to the largest step and to the matrix of
//! the coarse level; the kernel checks the first two. A slice sleeps where the term leaves the
//! fourth lanes of its residuals 0. What a term keeps of the cells lies in the tissue beside their
//! positions; a reset clears it, a discarded pass takes its changes back, the state hash and a saved
//! state contain its words. The list is resolved when the kernel is compiled: there is no dynamic
//! dispatch, and a term that is not in the list, or that keeps nothing, takes no memory and no time.
//! Pins, a term of the tests, are the example.

pub(crate) mod current;
pub mod held;
pub(crate) mod inside;
pub mod links;
#[cfg(feature = "nodal")]
pub(crate) mod nodal;
pub(crate) mod number;
#[cfg(test)]
pub(crate) mod pin;
pub(crate) mod probe;
pub(crate) mod residual;
pub mod rounding;
pub(crate) mod sliced;
pub mod state;
#[cfg(feature = "nodal")]
mod stiffening;
pub(crate) mod surface;
pub(crate) mod term;
#[cfg(test)]
pub(crate) mod tests;
